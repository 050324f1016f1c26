//! The reference marcher's frame: what the engine is held against, and what renders where it does not reach.

use std::time::{Duration, Instant};

use glam::Vec3;

use super::account::{Account, Rays, Rendered, StageTimes};
use super::limits::{far_limit, level_bands};
use super::options::RenderOptions;
use crate::detail::{Displacement, Synthesis};
use crate::frame::Frame;
use crate::raymarch::{Contact, Marcher, SurfaceFilter, SurfaceSample, march_column};
use crate::space::Camera;
use crate::subimage::{Farm, Subimage};
use crate::sunlight::Shades;
use crate::voxel::PageSource;
use crate::weather::Atmosphere;
use hedgehop_base::error::Result;

/// Ground as it is seen: shadows and detail on it, and its displacement.
#[derive(Clone, Copy, Default)]
pub(super) struct SeenGround<'l> {
    /// `None`: nothing lies in shadow.
    pub(super) shades: Option<&'l Shades>,
    /// `None`: there is no detail below the voxel.
    pub(super) synthesis: Option<&'l Synthesis>,
    /// `None`: it lies as its posts say.
    pub(super) displacement: Option<&'l Displacement>,
}

/// Pixels of one subimage, `[column][row]`.
struct SubimagePixels {
    pixels: Vec<Pixel>,
    rays: Rays,
    march: Duration,
    shade: Duration,
}

/// Surface, layers and light of a pixel.
#[derive(Default)]
struct Pixel {
    /// The ground, and its radiance; `None` = sky, or no ray.
    ground: Option<(SurfaceSample, Vec3)>,
    /// Layers before the surface, nearest first.
    front: Vec<Layer>,
}

/// Something that hides a share of what is behind it.
struct Layer {
    sample: SurfaceSample,
    radiance: Vec3,
    opacity: f32,
}

/// Renders with the reference marcher: any screen, any surface, pixel by pixel in double precision.
///
/// # Errors
/// A page that is damaged.
pub(super) fn render(
    source: &dyn PageSource,
    camera: &Camera,
    options: &RenderOptions,
    seen: SeenGround<'_>,
    farm: &Farm,
) -> Result<Rendered> {
    let subimages =
        farm.render(camera.width, |subimage| render_subimage(source, camera, options, seen, subimage))?;
    let mut times = StageTimes {
        march: subimages.iter().map(|subimage| subimage.march).sum(),
        shade: subimages.iter().map(|subimage| subimage.shade).sum(),
        image: Duration::ZERO,
    };
    let started = Instant::now();
    let mut frame = merge(camera, &subimages);
    let atmosphere = options.atmosphere(source.header());
    add_air(&mut frame, &atmosphere, options.brightness().tint(), farm);
    add_solids(&mut frame, &subimages, &atmosphere, options.brightness().tint());
    times.image = started.elapsed();
    let mut rays = Rays::default();
    subimages.iter().for_each(|subimage| rays += subimage.rays);
    Ok(Rendered { frame, account: Account { times, rays } })
}

fn render_subimage(
    source: &dyn PageSource,
    camera: &Camera,
    options: &RenderOptions,
    seen: SeenGround<'_>,
    subimage: Subimage,
) -> Result<SubimagePixels> {
    let columns = subimage.first_column..subimage.first_column + subimage.columns;
    let started = Instant::now();
    let header = source.header();
    let SeenGround { shades, synthesis, displacement } = seen;
    let mut marcher = marcher(source, camera, options).displaced(displacement);
    let mut filter = SurfaceFilter::new(source, camera.footprint()).shaded(shades).detailed(synthesis);
    if options.tile_world {
        filter = filter.endless();
    }

    let contacts: Vec<Vec<Option<Contact>>> =
        columns.clone().map(|column| march_column(&mut marcher, camera, column)).collect::<Result<_>>()?;
    let marched = Instant::now();

    let sensor = options.sensor();
    let mut pixels = Vec::with_capacity(contacts.len() * camera.height as usize);
    let stands_in = |contact: &&Contact| contact.level > contact.wanted;
    let coarser = contacts.iter().flatten().flatten().filter(stands_in).count() as u64;
    let rays = Rays { all: contacts.iter().map(|column| column.len() as u64).sum(), coarser };
    let mut hits = Vec::new();

    for (column, contacts) in columns.zip(&contacts) {
        for (row, contact) in contacts.iter().enumerate() {
            let ray = camera.ray(f64::from(column) + 0.5, row as f64 + 0.5);
            let Some(ray) = ray.filter(|_| contact.is_some() || header.has_spans) else {
                pixels.push(Pixel::default());
                continue;
            };

            let ray = marcher.ray(ray.origin, ray.direction);
            let mut pixel = Pixel::default();
            marcher.solids(&ray, contact.as_ref(), &mut hits)?;
            for hit in &hits {
                let sample = filter.sample_solid(&ray, hit)?;
                let radiance = sensor.of_solid(&sample);
                pixel.front.push(Layer { sample, radiance, opacity: hit.opacity as f32 });
            }

            if let Some(contact) = contact {
                let mut sample = filter.sample(&ray, contact)?;
                sample.attributes.flags |= filter.stand_in(&ray, contact)?;
                pixel.ground = Some((sample, sensor.radiance(&sample)));
            }

            pixels.push(pixel);
        }
    }

    Ok(SubimagePixels { pixels, rays, march: marched - started, shade: marched.elapsed() })
}

/// Builds the marcher of the ground that a camera sees.
pub(super) fn marcher<'a>(
    source: &'a dyn PageSource,
    camera: &Camera,
    options: &RenderOptions,
) -> Marcher<'a> {
    let header = source.header();
    let bands = level_bands(header, camera, options);
    let marcher = Marcher::new(source, bands, options.surface).curved(options.curvature);
    if options.tile_world { marcher.endless(far_limit(header, camera, options)) } else { marcher }
}

/// Puts the subimages' columns side by side.
fn merge(camera: &Camera, subimages: &[SubimagePixels]) -> Frame {
    let mut frame = Frame::sky(camera.clone());
    let (width, height) = (camera.width as usize, camera.height as usize);
    let pixels = subimages.iter().flat_map(|subimage| &subimage.pixels);
    for (index, pixel) in pixels.enumerate() {
        let (column, row) = (index / height, index % height);
        if let Some((sample, radiance)) = &pixel.ground {
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

/// Puts what stands on the ground before it, each with the air before itself; what hides half of a pixel is what the frame says of it.
fn add_solids(frame: &mut Frame, subimages: &[SubimagePixels], atmosphere: &Atmosphere, tint: Vec3) {
    let (width, height) = (frame.camera.width as usize, frame.camera.height as usize);
    let pixels = subimages.iter().flat_map(|subimage| &subimage.pixels).enumerate();
    for (index, pixel) in pixels.filter(|(_, pixel)| !pixel.front.is_empty()) {
        let (column, row) = (index / height, index % height);
        let Some(ray) = frame.camera.ray(column as f64 + 0.5, row as f64 + 0.5) else { continue };
        let target = row * width + column;
        let (mut light, mut left) = (Vec3::ZERO, 1.0);

        for Layer { sample, radiance, opacity } in &pixel.front {
            let direction = ray.direction.as_vec3();
            let seen = atmosphere.haze(*radiance, ray.origin.z, direction, sample.range as f32);
            light += tint * seen * (left * opacity);
            let before = left;
            left *= 1.0 - opacity;
            if before > 0.5 && left <= 0.5 {
                frame.range[target] = sample.range as f32;
                frame.normal[target] = sample.normal.to_array();
                frame.level[target] = 0;
                frame.id[target] = Frame::pixel_id(sample.attributes);
            }
        }

        frame.colour[target] = (light + Vec3::from_array(frame.colour[target]) * left).to_array();
    }
}

/// Adds haze before the ground and fills the rest with sky, all as bright as the hour's `tint`; pixels without a ray stay black.
fn add_air(frame: &mut Frame, atmosphere: &Atmosphere, tint: Vec3, farm: &Farm) {
    let camera = &frame.camera;
    let range = &frame.range;
    let width = camera.width as usize;
    farm.rows(&mut frame.colour, width, |row, line| {
        for (column, colour) in line.iter_mut().enumerate() {
            let range = range[row * width + column];
            let Some(ray) = camera.ray(column as f64 + 0.5, row as f64 + 0.5) else { continue };
            let (eye, direction) = (ray.origin.z, ray.direction.as_vec3());
            let seen = if range.is_finite() {
                atmosphere.haze(Vec3::from_array(*colour), eye, direction, range)
            } else {
                atmosphere.sky(eye, direction)
            };
            *colour = (tint * seen).to_array();
        }
    });
}
