//! Settings of a rendering, and the ranges that they may have.

use glam::DVec3;

use crate::detail::{SunAngles, Synthesis};
use crate::earth::Curvature;
use crate::raymarch::{SPAN_PIXELS, Surface};
use crate::sensor::VisualSensor;
use crate::space::Camera;
use crate::sunlight::{Brightness, Night, Shade, Shades, Sun};
use crate::voxel::Header;
use crate::weather::{Atmosphere, CLEAR_VISIBILITY, Weather};
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
    /// Weather, but for the visibility of haze.
    pub weather: Weather,
    /// Factor on the range thresholds, > 0: 1 changes level where a voxel fills a pixel. Scan planes also look the closer
    /// at steep ground.
    pub detail: f64,
    /// Factor on the amplitude of detail that is made up below the finest voxel, ≥ 0; 0: there is none.
    pub detail_synthesis: f64,
    /// Pixels that a voxel fills at least where what stands on the ground is seen as spans, ≥ 0.25; further away it is part of the surface. 0.25, the default, keeps shapes and
    /// walls of houses wherever level 1 is seen; with 2.5 they melt ten times as near, and frames of villages take half to two thirds as long.
    pub far_spans: f64,
    /// Drop of heights with ground distance; flat by default. [`Self::of`] chooses by the database.
    pub curvature: Curvature,
    /// The area repeats without end, eastward and northward.
    pub tile_world: bool,
    /// Marcher of the rays.
    pub engine: Engine,
    /// Frames say what share of each pixel bodies have ([`crate::frame::Aov::matte`]).
    pub matte: bool,
    /// Frames say how much of each pixel's light is made up ([`crate::frame::Aov::synthesis`]).
    pub tells_synthesis: bool,
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

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            surface: Surface::Smooth,
            visibility: CLEAR_VISIBILITY,
            sun: Sun::default(),
            night: Night::default(),
            shadows: false,
            weather: Weather::default(),
            detail: 1.0,
            detail_synthesis: 1.0,
            far_spans: SPAN_PIXELS,
            curvature: Curvature::FLAT,
            tile_world: false,
            engine: Engine::default(),
            matte: false,
            tells_synthesis: false,
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
    pub(super) fn has_shadows(&self) -> bool {
        self.shadows && self.sun.is_up()
    }

    /// Returns the sensor that turns ground into light.
    pub(super) fn sensor(&self) -> VisualSensor {
        VisualSensor::new(self.sun).covered(self.weather.ground)
    }

    /// Returns the brightness of the hour's light.
    pub fn brightness(&self) -> Brightness {
        Brightness::new(self.sun, self.night.lux)
    }

    /// Finds the detail below the finest voxels of a database with this header; `None`: there is none. Blocks are voxels as they are.
    ///
    /// # Errors
    /// The pattern that the database asks for has nothing below the voxel.
    pub(super) fn synthesis(&self, header: &Header) -> Result<Option<Synthesis>> {
        let factor = if self.surface == Surface::Blocks { 0.0 } else { self.detail_synthesis };
        let Sun { azimuth, elevation } = self.sun;
        Synthesis::of(header, factor, SunAngles { azimuth, elevation })
    }

    /// Returns the shadows over a database with this header, within a budget in bytes; `None`: nothing lies in shadow.
    pub(super) fn shades(&self, header: &Header, budget: usize) -> Option<Shades> {
        self.has_shadows().then(|| Shades::new(Shade::new(header, self.sun), budget))
    }

    /// The air over a database.
    pub fn atmosphere(&self, header: &Header) -> Atmosphere {
        // Extinctions of haze and precipitation add up.
        let hides = self.weather.precipitation.map_or(0.0, |falls| 1.0 / falls.visibility());
        let visibility = 1.0 / (1.0 / self.visibility + hides);
        Atmosphere::new(visibility, header.height_range.low).with_weather(&self.weather, self.sun)
    }

    /// Refuses values outside the ranges that the fields state, and poses that are no view.
    pub(super) fn check(&self, camera: &Camera) -> Result<()> {
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
            (
                self.detail_synthesis >= 0.0 && self.detail_synthesis.is_finite(),
                "detail synthesis must be 0 or more",
            ),
            (
                self.far_spans >= SPAN_PIXELS && self.far_spans.is_finite(),
                "far spans must end where a voxel fills 0.25 pixels or more",
            ),
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
