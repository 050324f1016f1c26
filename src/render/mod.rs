//! One frame: the picture of section 2 of the design, as code.
//!
//! ```text
//! camera ──▶ subimages ──march──▶ range ──filter──▶ surface samples ──sensor──▶ radiance
//!                                                                        │
//!                                        frame ◀── haze, sky ◀── merge ◀─┘
//! ```

mod clouds;
mod compose;
mod exposure;
mod lights;
mod limits;
mod matte;
mod merge;
mod page_planner;
mod plane_image;
mod planes;
mod plumes;
mod precipitation;
mod reference;
mod shadows;
mod spans;
#[cfg(test)]
mod spans_tests;
mod sunlit;
mod surface;
#[cfg(test)]
mod tests;
mod unserved;

pub use compose::Overlays;
pub use exposure::{Exposure, MOST_MOMENTS, Moment};
pub use limits::{far_limit, level_bands};
pub use page_planner::{FlightPlan, LivePlan};
pub use unserved::Unserved;

use std::sync::Arc;
use std::time::Duration;

use glam::DVec3;

use crate::earth::Curvature;
use crate::frame::{Atmosphere, Frame, Picture};
use crate::raymarch::Surface;
use crate::raymarch::scan::{Profile, TurnedPages};
use crate::scene::Weather;
use crate::sensor::radiance::Radiance;
use crate::sensor::{Facets, VisualSensor};
use crate::simd::Isa;
use crate::space::Camera;
use crate::subimage::Farm;
use crate::sunlight::{Brightness, Night, Shade, Shades, Sun};
use crate::voxel::{Header, PageNeeds, PageSource, Used};
use hedgehop_base::error::{Error, Result};

/// Settings of a rendering: surface, sun, light, weather, haze, engine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderOptions {
    /// Kind of surface that is drawn.
    pub surface: Surface,
    /// Meteorological visibility at the lowest ground of the area, metres, > 0.
    pub visibility: f64,
    /// Position of the sun.
    pub sun: Sun,
    /// Light besides that of the sun.
    pub night: Night,
    /// Ground lies in the shadow of ground.
    pub shadows: bool,
    /// Matter in the air besides haze.
    pub weather: Weather,
    /// Factor on the range thresholds, > 0: 1 changes level where a voxel fills a pixel. Scan planes also look the closer
    /// at steep ground.
    pub detail: f64,
    /// Drop of heights with ground distance; flat by default. [`Self::of`] chooses by the database.
    pub curvature: Curvature,
    /// The area repeats without end, eastward and northward.
    pub tile_world: bool,
    /// Marcher of the rays.
    pub engine: Engine,
    /// Frames say what share of each pixel bodies have ([`crate::frame::Aov::matte`]).
    pub matte: bool,
}

/// Algorithm that finds the surface a pixel sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Engine {
    /// The reference marcher: ray by ray, exact, any screen and surface.
    Reference,
    /// Scan planes: 40 (straight down) to more than a hundred times as fast; the smooth surface of an area that ends, on any screen with one eye; the
    /// reference marcher where they do not serve.
    #[default]
    Planes,
}

/// One part of so many of the memory for what is computed from pages holds heights, the others light: light takes longer, and paint that
/// may have to be read again.
const TURNED_SHARE: usize = 3;

/// And one part of so many shares of the sun, where there are shadows.
const SHADED_SHARE: usize = 8;

/// Bytes of shares of the sun that are kept unless told otherwise.
const SHADES: usize = 128 << 20;

/// Visibility of a clear day, metres.
const DEFAULT_VISIBILITY: f64 = 40_000.0;

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            surface: Surface::Smooth,
            visibility: DEFAULT_VISIBILITY,
            sun: Sun::default(),
            night: Night::default(),
            shadows: false,
            weather: Weather::default(),
            detail: 1.0,
            curvature: Curvature::FLAT,
            tile_world: false,
            engine: Engine::default(),
            matte: false,
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

    /// Whether there is a sun that throws shadows, if they are asked for.
    fn has_shadows(&self) -> bool {
        self.shadows && self.sun.is_up()
    }

    /// Returns the sensor that turns ground into light.
    fn sensor(&self) -> VisualSensor {
        VisualSensor::new(self.sun).covered(self.weather.ground)
    }

    /// Returns the brightness of the hour's light.
    pub fn brightness(&self) -> Brightness {
        Brightness::new(self.sun, self.night.lux)
    }

    /// Returns the shadows over a database with this header, within a budget in bytes; `None`: nothing lies in shadow.
    fn shades(&self, header: &Header, budget: usize) -> Option<Shades> {
        self.has_shadows().then(|| Shades::new(Shade::new(header, self.sun), budget))
    }

    /// The air over a database.
    pub fn atmosphere(&self, header: &Header) -> Atmosphere {
        // What hides adds up.
        let hides = self.weather.precipitation.map_or(0.0, |falls| 1.0 / falls.visibility());
        let visibility = 1.0 / (1.0 / self.visibility + hides);
        Atmosphere::new(visibility, header.height_range.0).with_weather(&self.weather, self.sun)
    }

    /// Refuses values outside the ranges that the fields state, and poses that are no view.
    fn check(&self, camera: &Camera) -> Result<()> {
        camera.screen().check()?;
        let pose = camera.pose;
        let attitude = DVec3::new(pose.attitude.yaw, pose.attitude.pitch, pose.attitude.roll);
        let bend = self.curvature.inverse_diameter;

        let within = [
            (self.visibility > 0.0, "visibility must be more than 0 m"),
            (self.sun.elevation.abs() <= 90.0, "the sun must stand -90 to 90° high"),
            (self.night.is_sound(), "the light of the night must be 0 to 1000 lx"),
            (self.sun.azimuth.is_finite(), "the sun's azimuth must be finite"),
            (self.weather.is_sound(), "the weather must be within the ranges of its fields"),
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

/// Time that a frame took in each stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StageTimes {
    /// Finding the range of each pixel, summed over the workers.
    pub march: Duration,
    /// Filtering the surface and applying the sensor, summed over the workers; of scan planes the whole image stage.
    pub shade: Duration,
    /// Merging, haze and sky of the reference marcher: wall time.
    pub image: Duration,
}

/// Counts of a picture's rays that see ground stored more coarsely than they ask for.
///
/// Rays are the pixels of the reference marcher, and of scan planes the rows of each plane, before these are taken to the screen.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Rays {
    /// All of them, those to the sky too.
    pub all: u64,
    /// Rays that meet a level that stands in for a finer one, whose page is absent.
    pub coarser: u64,
}

impl Rays {
    /// Share of the rays that meet a level that stands in, 0…1.
    pub fn coarser_share(&self) -> f64 {
        self.coarser as f64 / self.all.max(1) as f64
    }
}

impl std::ops::AddAssign for Rays {
    fn add_assign(&mut self, other: Self) {
        (self.all, self.coarser) = (self.all + other.all, self.coarser + other.coarser);
    }
}

/// Times and counts of one picture.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Account {
    /// Time of each stage.
    pub times: StageTimes,
    /// Fineness of the ground that was seen.
    pub rays: Rays,
}

/// A frame and what it cost.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// The picture.
    pub frame: Frame,
    /// Times and counts of the frame.
    pub account: Account,
}

/// Renders frames of one database, one after the other or several at once.
///
/// Keeps what frames share: the radiance of pages under the sun of the options.
#[derive(Debug)]
pub struct Renderer<'a, S> {
    source: &'a S,
    options: RenderOptions,
    isa: Isa,
    /// Since the flight's first fix, seconds.
    seconds: f64,
    /// Velocity of the eye, metres per second.
    velocity: DVec3,
    shared: Arc<SharedState>,
}

/// State that frames of one database share.
#[derive(Debug)]
struct SharedState {
    radiance: Radiance,
    turned: TurnedPages,
    screen: planes::LastScreen,
    plane_images: Used<plane_image::PlaneImage>,
    pictures: Used<Vec<u8>>,
    ranges: Used<Vec<f32>>,
    profiles: Used<Profile>,
    lighting: Used<planes::LightingScratch>,
    clouds: clouds::LastField,
    facets: Facets,
}

impl SharedState {
    /// Nothing yet.
    fn new(sensor: VisualSensor, radiance: Radiance, turned: TurnedPages) -> Self {
        Self {
            radiance,
            turned,
            screen: planes::LastScreen::default(),
            plane_images: Used::default(),
            pictures: Used::default(),
            ranges: Used::default(),
            profiles: Used::default(),
            lighting: Used::default(),
            clouds: clouds::LastField::default(),
            facets: Facets::new(sensor),
        }
    }
}

impl<'a, S: PageSource> Renderer<'a, S> {
    /// A renderer with the fastest instruction set of this machine.
    pub fn new(source: &'a S, options: &RenderOptions) -> Self {
        let shades = options.shades(source.header(), SHADES);
        let radiance = Radiance::new(options.sensor()).shaded(shades);
        let shared = Arc::new(SharedState::new(options.sensor(), radiance, TurnedPages::default()));
        Self { source, options: *options, isa: Isa::best(), seconds: 0.0, velocity: DVec3::ZERO, shared }
    }

    /// The same, keeping at most `bytes` of what is computed from pages, besides what the latest frames used.
    #[must_use]
    pub fn with_memory(self, bytes: usize) -> Self {
        let turned = bytes / TURNED_SHARE;
        let shaded = if self.options.has_shadows() { bytes / SHADED_SHARE } else { 0 };
        let radiance = Radiance::with_budget(self.options.sensor(), bytes - turned - shaded)
            .shaded(self.options.shades(self.source.header(), shaded));
        let shared = SharedState::new(self.options.sensor(), radiance, TurnedPages::new(turned));
        Self { shared: Arc::new(shared), ..self }
    }

    /// The same over another source of the same database, one that has some of its pages only, say; what is kept is shared.
    pub fn over<'b, T: PageSource>(&self, source: &'b T) -> Renderer<'b, T> {
        Renderer {
            source,
            options: self.options,
            isa: self.isa,
            seconds: self.seconds,
            velocity: self.velocity,
            shared: self.shared.clone(),
        }
    }

    /// The same with another instruction set; frames differ by rounding.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// The same, so many seconds after the flight's first fix: as far the wind has taken the clouds.
    #[must_use]
    pub fn at(&self, seconds: f64) -> Self {
        Self { seconds, ..self.over(self.source) }
    }

    /// The same for an eye that moves, metres per second (x east, y north, z up): how rain and snow come towards it.
    #[must_use]
    pub fn moving(&self, velocity: DVec3) -> Self {
        Self { velocity, ..self.over(self.source) }
    }

    /// Parts of pages that a picture of what `camera` sees may touch, in the order of need; none where the reference marcher renders. Bounds
    /// of coarse pages are read to know it.
    ///
    /// # Errors
    /// As of [`Self::frame`].
    pub fn foresee(&self, camera: &Camera, farm: &Farm) -> Result<PageNeeds> {
        self.options.check(camera)?;
        match self.planes(camera, farm)? {
            Some(view) => {
                let needs = planes::footprint(self, &view)?;
                Ok(match self.shared.radiance.shades() {
                    Some(shades) => page_planner::with_supports(self.source, &needs, shades.shade()),
                    None => needs,
                })
            }
            None => Ok(PageNeeds::default()),
        }
    }

    /// Takes back the memory of a picture that nobody needs any more, for a later one.
    pub fn recycle(&self, picture: Picture) {
        if self.options.engine == Engine::Planes {
            self.shared.pictures.give_back(picture.rgb);
        }
    }

    /// The engine that renders what `camera` sees: that of the options, or the reference where it does not serve.
    ///
    /// # Errors
    /// As of [`Farm::new`].
    pub fn engine_for(&self, camera: &Camera) -> Result<Engine> {
        let by_reference = self.options.engine == Engine::Reference || self.unserved(camera)?.is_some();
        Ok(if by_reference { Engine::Reference } else { Engine::Planes })
    }

    /// Why scan planes would not serve what `camera` sees; `None`: they would.
    ///
    /// # Errors
    /// As of [`Farm::new`].
    pub fn unserved(&self, camera: &Camera) -> Result<Option<Unserved>> {
        match Unserved::of(&self.options) {
            Some(why) => Ok(Some(why)),
            None => planes::PlaneView::unserved(camera, &self.shared.screen, &Farm::new(1)?),
        }
    }

    /// Whether the options are for scan planes.
    fn takes_planes(&self) -> bool {
        self.options.engine == Engine::Planes && Unserved::of(&self.options).is_none()
    }

    /// Chooses how scan planes see what the camera sees; `None` where they do not serve.
    fn planes<'c>(&self, camera: &'c Camera, farm: &Farm) -> Result<Option<planes::PlaneView<'c>>> {
        if !self.takes_planes() {
            return Ok(None);
        }
        planes::PlaneView::new(self.source.header(), camera, &self.shared.screen, farm)
    }
}

/// Renders what `camera` sees, once; a [`Renderer`] is faster for several frames.
///
/// # Errors
/// As of [`Renderer::frame`].
pub fn render_frame<S: PageSource>(
    source: &S,
    camera: &Camera,
    options: &RenderOptions,
    farm: &Farm,
) -> Result<Rendered> {
    Renderer::new(source, options).frame(camera, farm)
}

/// Renders with the reference marcher, which every faster path is held against: pixel by pixel, in double precision.
///
/// # Errors
/// As of [`Renderer::frame`].
pub fn render_reference<S: PageSource>(
    source: &S,
    camera: &Camera,
    options: &RenderOptions,
    farm: &Farm,
) -> Result<Rendered> {
    options.check(camera)?;
    let shades = options.shades(source.header(), SHADES);
    let rendered = reference::render(source, camera, options, shades.as_ref(), farm);
    source.intact()?;
    rendered
}
