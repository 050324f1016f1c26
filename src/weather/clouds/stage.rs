//! Clouds over what was rendered of one view.

use glam::{DVec2, Vec3};

use super::field;
use crate::objects::Lens;
use crate::simd::Isa;
use crate::space::{Camera, Screen};
use crate::sunlight::{Daylight, Sun};
use crate::weather::clouds::CloudField;
use crate::weather::clouds::cover::CloudCover;
use crate::weather::glow::sunlight;
use crate::weather::{Atmosphere, AtmosphereLanes, Clouds};

/// Angle between rays of the lattice, radians, and the most pixels between them.
const LATTICE: f64 = 0.0045;
const MOST_PIXELS: f64 = 8.0;

/// Share of the light on ground that clouds may keep from it under a high sun: the sun's, but for what they scatter downward.
const SHADOWED: f32 = 0.55;

/// Cells of the lattice in a band of rows.
const BAND_CELLS: usize = 8;

/// Clouds over what was rendered of one view.
pub struct CloudStage<'c> {
    pub(super) isa: Isa,
    pub(super) camera: &'c Camera,
    pub(super) cover: CloudCover<'c>,
    pub(super) air: AtmosphereLanes,
    /// Factor on light, by channel: how bright the hour is.
    pub(super) tint: [f32; 3],
    lens: Lens<'c>,
    /// Pixels from one ray of the lattice to the next.
    pub(super) cell: usize,
}

/// Air over the ground of an area.
#[derive(Debug, Clone, Copy)]
pub struct AirOverGround<'a> {
    /// State of the air.
    pub atmosphere: &'a Atmosphere,
    /// Height of the highest ground, metres above the datum.
    pub highest: f64,
}

impl<'c> CloudStage<'c> {
    /// `clouds`, of which `field` has the voxels, `seconds` into a flight, through the air over ground; `None` on orthographic screens, which show the ground from outside of all weather.
    pub fn new(
        isa: Isa,
        camera: &'c Camera,
        field: &'c CloudField,
        clouds: &Clouds,
        sun: Sun,
        air: AirOverGround<'_>,
        seconds: f64,
    ) -> Option<Self> {
        if let Screen::Orthographic { .. } = camera.screen() {
            return None;
        }

        let eye = camera.pose.eye;
        let place = field.place(eye.truncate(), clouds, seconds);
        let strength = Daylight::new(sun).strength();

        let cover = CloudCover {
            field,
            eye: [place.x as f32, place.y as f32],
            heights: [(clouds.base - eye.z) as f32, (clouds.top - eye.z) as f32],
            per_voxel: 1.0 / field.voxel as f32,
            per_depth: 1.0 / (clouds.top - clouds.base) as f32,
            extinction: field::extinction(clouds),
            sunlight: (sunlight(sun) * strength).to_array(),
            shadowed: SHADOWED * strength,
            to_sun: sun.direction().to_array(),
            shadows: field::toward(sun).to_array(),
        };

        let cell = (LATTICE / camera.pixel_angle()).clamp(1.0, MOST_PIXELS) as usize;
        let AirOverGround { atmosphere, highest } = air;
        let air = AtmosphereLanes::new(atmosphere, eye.z, clouds.top.max(highest));
        Some(Self { isa, camera, cover, air, tint: [1.0; 3], lens: Lens::new(camera), cell })
    }

    /// The same by the light of an hour, `tint` times that of day by channel.
    #[must_use]
    pub fn tinted(self, tint: Vec3) -> Self {
        Self { tint: tint.to_array(), ..self }
    }

    /// Rows of a band.
    pub fn band_rows(&self) -> usize {
        BAND_CELLS * self.cell
    }

    /// Unit direction of a position of the screen, pixels; `None` where the screen has no picture.
    pub(super) fn direction(&self, column: f64, row: f64) -> Option<Vec3> {
        self.lens.ray_at(DVec2::new(column, row)).map(|ray| ray.direction.as_vec3())
    }
}
