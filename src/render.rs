//! One frame: the picture of section 2 of the design, as code.
//!
//! ```text
//! camera ──▶ subimages ──march──▶ range ──filter──▶ surface samples ──sensor──▶ radiance
//!                                                                        │
//!                                        frame ◀── haze, sky ◀── merge ◀─┘
//! ```

use std::time::{Duration, Instant};

use glam::{DVec3, Vec3};

use crate::earth::Curvature;
use crate::error::{Error, Result};
use crate::frame::{Atmosphere, Frame};
use crate::raymarch::{Contact, LevelBands, Marcher, Surface, SurfaceFilter, SurfaceSample, march_column};
use crate::sensor::{Sun, VisualSensor};
use crate::space::{Camera, Footprint};
use crate::subimage::{Farm, Subimage};
use crate::voxel::{Header, PageSource};

/// How a frame is rendered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderOptions {
    /// Which surface is seen.
    pub surface: Surface,
    /// Meteorological visibility at the lowest ground of the area, metres, > 0.
    pub visibility: f64,
    /// Where the sun stands.
    pub sun: Sun,
    /// Factor on the range thresholds, > 0: 1 changes level where a voxel fills a pixel.
    pub detail: f64,
    /// How fast heights drop with ground distance; flat by default. [`Self::of`] chooses by the database.
    pub curvature: Curvature,
    /// The area repeats without end, eastward and northward.
    pub tile_world: bool,
}

/// Visibility of a clear day, metres.
const DEFAULT_VISIBILITY: f64 = 40_000.0;

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            surface: Surface::Smooth,
            visibility: DEFAULT_VISIBILITY,
            sun: Sun::default(),
            detail: 1.0,
            curvature: Curvature::FLAT,
            tile_world: false,
        }
    }
}

impl RenderOptions {
    /// The defaults for a database: a place on Earth is curved, local metres are flat.
    pub fn of(header: &Header) -> Self {
        let on_earth = header.metadata.crs_proj.is_some();
        let curvature = if on_earth { Curvature::standard() } else { Curvature::FLAT };
        Self { curvature, ..Self::default() }
    }

    /// Refuses values outside the ranges that the fields state, and poses that are no view.
    fn check(&self, camera: &Camera) -> Result<()> {
        camera.screen().check()?;
        let pose = camera.pose;
        let attitude = DVec3::new(pose.attitude.yaw, pose.attitude.pitch, pose.attitude.roll);
        let bend = self.curvature.inverse_diameter;
        let within = [
            (self.visibility > 0.0, "visibility must be more than 0 m"),
            (self.sun.elevation > 0.0 && self.sun.elevation <= 90.0, "the sun must stand 0 to 90° high"),
            (self.sun.azimuth.is_finite(), "the sun's azimuth must be finite"),
            (self.detail > 0.0 && self.detail.is_finite(), "detail must be more than 0"),
            (bend.is_finite() && bend >= 0.0, "the curvature's inverse diameter must be 0 or more"),
            (pose.eye.is_finite() && attitude.is_finite(), "the pose must be finite"),
            (camera.width > 0 && camera.height > 0, "a frame needs at least one pixel"),
        ];
        match within.iter().find(|(holds, _)| !holds) {
            Some((_, sentence)) => Err(Error::Configuration((*sentence).to_owned())),
            None => Ok(()),
        }
    }
}

/// Time that a frame took in each stage, summed over the workers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StageTimes {
    /// Finding the range of each pixel.
    pub march: Duration,
    /// Filtering the surface and applying the sensor.
    pub shade: Duration,
    /// Merging, haze and sky (wall time).
    pub image: Duration,
}

/// A frame and what it cost.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// The picture.
    pub frame: Frame,
    /// What each stage took.
    pub times: StageTimes,
}

/// Pixels of one subimage, `[column][row]`; `None` = sky, or no ray.
struct SubimagePixels {
    pixels: Vec<Option<(SurfaceSample, Vec3)>>,
    march: Duration,
    shade: Duration,
}

/// Renders what `camera` sees. The frame has the same bits for any number of workers.
///
/// # Errors
/// A page that is damaged; options or a pose outside their ranges.
pub fn render_frame<S: PageSource>(
    source: &S,
    camera: &Camera,
    options: &RenderOptions,
    farm: &Farm,
) -> Result<Rendered> {
    options.check(camera)?;
    let subimages =
        farm.render(camera.width, |subimage| render_subimage(source, camera, options, subimage))?;
    let mut times = StageTimes {
        march: subimages.iter().map(|subimage| subimage.march).sum(),
        shade: subimages.iter().map(|subimage| subimage.shade).sum(),
        image: Duration::ZERO,
    };
    let started = Instant::now();
    let mut frame = merge(camera, &subimages);
    let atmosphere = Atmosphere::new(options.visibility, source.header().height_range.0);
    add_air(&mut frame, &atmosphere, farm);
    times.image = started.elapsed();
    Ok(Rendered { frame, times })
}

fn render_subimage<S: PageSource>(
    source: &S,
    camera: &Camera,
    options: &RenderOptions,
    subimage: Subimage,
) -> Result<SubimagePixels> {
    let columns = subimage.first_column..subimage.first_column + subimage.columns;
    let started = Instant::now();
    let header = source.header();
    let mut marcher =
        Marcher::new(source, level_bands(header, camera, options), options.surface).curved(options.curvature);
    let mut filter = SurfaceFilter::new(source, camera.footprint());
    if options.tile_world {
        marcher = marcher.endless(far_limit(header, camera, options));
        filter = filter.endless();
    }
    let contacts: Vec<Vec<Option<Contact>>> =
        columns.clone().map(|column| march_column(&mut marcher, camera, column)).collect::<Result<_>>()?;
    let marched = Instant::now();

    let sensor = VisualSensor::new(options.sun);
    let mut pixels = Vec::with_capacity(contacts.len() * camera.height as usize);
    for (column, contacts) in columns.zip(&contacts) {
        for (row, contact) in contacts.iter().enumerate() {
            let ray = camera.ray(f64::from(column) + 0.5, row as f64 + 0.5);
            let (Some(contact), Some(ray)) = (contact, ray) else {
                pixels.push(None);
                continue;
            };
            let sample = filter.sample(&marcher.ray(ray.origin, ray.direction), contact)?;
            pixels.push(Some((sample, sensor.radiance(&sample))));
        }
    }
    Ok(SubimagePixels { pixels, march: marched - started, shade: marched.elapsed() })
}

/// The bands of distance in which `camera` sees each level.
pub fn level_bands(header: &Header, camera: &Camera, options: &RenderOptions) -> LevelBands {
    let clearance = camera.pose.eye.z - header.height_range.1;
    let (grid, count) = (&header.grid, header.level_count);
    match camera.footprint() {
        Footprint::Angle(angle) => LevelBands::new(grid, count, angle, clearance, options.detail),
        Footprint::Width(width) => LevelBands::uniform(grid, count, width, options.detail),
    }
}

/// Ground distance beyond which an area without end ([`RenderOptions::tile_world`]) is sky, metres: haze leaves less than
/// a thousandth of any ground there. In clear air it is infinite; the marcher then sets an end of its own.
pub fn far_limit(header: &Header, camera: &Camera, options: &RenderOptions) -> f64 {
    let (lowest, highest) = header.height_range;
    Atmosphere::new(options.visibility, lowest).reach(camera.pose.eye.z, highest)
}

/// Puts the subimages' columns side by side.
fn merge(camera: &Camera, subimages: &[SubimagePixels]) -> Frame {
    let mut frame = Frame::sky(camera.clone());
    let (width, height) = (camera.width as usize, camera.height as usize);
    let pixels = subimages.iter().flat_map(|subimage| &subimage.pixels);
    for (index, pixel) in pixels.enumerate() {
        let (column, row) = (index / height, index % height);
        if let Some((sample, radiance)) = pixel {
            let target = row * width + column;
            frame.colour[target] = radiance.to_array();
            frame.range[target] = sample.range as f32;
            frame.normal[target] = sample.normal.to_array();
            frame.level[target] = sample.level;
            frame.id[target] = Frame::pixel_id(sample.attributes);
        }
    }
    frame
}

/// Adds haze before the ground and fills the rest with sky; pixels without a ray stay black.
fn add_air(frame: &mut Frame, atmosphere: &Atmosphere, farm: &Farm) {
    let camera = &frame.camera;
    let range = &frame.range;
    let width = camera.width as usize;
    farm.rows(&mut frame.colour, width, |row, line| {
        for (column, colour) in line.iter_mut().enumerate() {
            let range = range[row * width + column];
            let Some(ray) = camera.ray(column as f64 + 0.5, row as f64 + 0.5) else { continue };
            let (eye, up) = (ray.origin.z, ray.direction.z as f32);
            let seen = if range.is_finite() {
                atmosphere.haze(Vec3::from_array(*colour), eye, up, range)
            } else {
                atmosphere.sky(eye, up)
            };
            *colour = seen.to_array();
        }
    });
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::space::{Attitude, Pose};
    use crate::voxel::{Grid, Metadata, build_in_memory};

    #[test]
    fn values_that_make_no_picture_are_refused() {
        let grid = Grid { nx: 2, ny: 2, spacing: 1.0, origin: DVec2::ZERO };
        let source = build_in_memory(grid, &[0.0; 4], &[[0; 3]; 4], None, &Metadata::default()).unwrap();
        let farm = Farm::new(1).unwrap();
        let sound = (DVec3::ONE, 60.0, RenderOptions::default());
        let frame = |(eye, hfov, options): (DVec3, f64, RenderOptions)| {
            let camera = Camera::new(Pose { eye, attitude: Attitude::default(), hfov }, 2, 2);
            render_frame(&source, &camera, &options, &farm)
        };
        assert!(frame(sound).is_ok());
        let low_sun = Sun { azimuth: 0.0, elevation: 0.0 };
        for broken in [
            (DVec3::NAN, 60.0, sound.2),
            (DVec3::ONE, 180.0, sound.2),
            (DVec3::ONE, 60.0, RenderOptions { sun: low_sun, ..sound.2 }),
            (DVec3::ONE, 60.0, RenderOptions { visibility: f64::NAN, ..sound.2 }),
            (DVec3::ONE, 60.0, RenderOptions { detail: 0.0, ..sound.2 }),
        ] {
            assert!(matches!(frame(broken), Err(Error::Configuration(_))), "{broken:?}");
        }
    }
}
