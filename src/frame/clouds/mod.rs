//! A layer of clouds: semitransparent voxels between the eye and what was rendered.
//!
//! ```text
//! once:       densities of the voxels, and the light of the sun in each                              field
//! each band of the screen's rows:
//!     each point of a lattice, some pixels apart:  through the layer by steps, front to back         march
//!         light += what comes through · (1 − e^−depth) · light there, seen through the air before
//!         what comes through · e^−depth; both kept after every step
//!     each pixel:                                                                                    band
//!         ground: its light, less what clouds keep of the sun's
//!         nearer than the layer: as it is; behind it: the lattice's last step
//!         within it: the lattice's steps at as many metres into the layer
//! ```
//!
//! Semitransparent voxels that a ray goes through are the patent's third state (Hughes 1994). Clouds are smooth, so that a ray every few pixels
//! tells of those between; where they end at ground is told by each pixel's own range, so that ridges stay sharp. Light
//! is scattered once, and what is scattered often is a share of light that fades more slowly (Wrenninge, Kulla and Lundqvist 2013, *Oz: The
//! Great and Volumetric*). Nothing is random: voxels stand still in the wind, and steps depend on the ray alone.

mod band;
mod field;
mod march;
mod noise;
#[cfg(test)]
mod tests;

pub use band::CloudLattice;
pub use field::CloudField;

use glam::{DVec2, Vec3};

use super::Atmosphere;
use super::glow::sunlight;
use super::stage::{Air, Pixels};
use crate::objects::Lens;
use crate::scene::Clouds;
use crate::simd::Isa;
use crate::space::{Camera, Screen};
use crate::sunlight::{Daylight, Sun};

/// Steps of a ray through the layer.
const STEPS: usize = 48;

/// Angle between rays of the lattice, radians, and the most pixels between them.
const LATTICE: f64 = 0.0045;
const MOST_PIXELS: f64 = 8.0;

/// Share of the light on ground that clouds may keep from it under a high sun: the sun's, but for what they scatter downward.
const SHADOWED: f32 = 0.55;

/// Cells of the lattice in a band of rows.
const BAND_CELLS: usize = 8;

/// The layer about an eye.
struct CloudCover<'c> {
    field: &'c CloudField,
    /// Place of the eye among the voxels, eastward and northward.
    eye: [f32; 2],
    /// Base and top above the eye, metres.
    heights: [f32; 2],
    /// Voxels per metre eastward and northward, and layers' depths per metre upward.
    per_voxel: f32,
    per_depth: f32,
    /// Extinction where clouds are densest, 1/metres.
    extinction: f32,
    /// Linear Rec. 709, 1 for white; 0 by night.
    sunlight: [f32; 3],
    /// Share of the light on ground that clouds may keep from it.
    shadowed: f32,
    /// Unit vector to the sun, and the direction that shadows follow.
    to_sun: [f32; 3],
    shadows: [f32; 3],
}

/// Clouds over what was rendered of one view.
pub struct CloudStage<'c> {
    isa: Isa,
    camera: &'c Camera,
    cover: CloudCover<'c>,
    air: Air,
    /// Factor on light, by channel: how bright the hour is.
    tint: [f32; 3],
    lens: Lens<'c>,
    /// Pixels from one ray of the lattice to the next.
    cell: usize,
}

impl<'c> CloudStage<'c> {
    /// `clouds`, of which `field` has the voxels, `seconds` into a flight, through `atmosphere` over ground not higher than `highest` metres above
    /// the datum; `None` on orthographic screens, which show the ground from outside of all weather.
    pub fn new(
        isa: Isa,
        camera: &'c Camera,
        (field, clouds): (&'c CloudField, &Clouds),
        sun: Sun,
        (atmosphere, highest): (&Atmosphere, f64),
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
        let air = Air::new(atmosphere, eye.z, clouds.top.max(highest));
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

    /// Puts clouds into a band that begins at a multiple of [`Self::band_rows`]; `range` of its pixels is metres, infinite for the sky. `lattice` is scratch memory.
    pub fn fill(&self, lattice: &mut CloudLattice, first: usize, light: Pixels<'_>, range: &[f32]) {
        self.isa.run(band::CloudFilling { stage: self, lattice, first, light, range });
    }

    /// Unit direction of a position of the screen, pixels; `None` where the screen has no picture.
    fn direction(&self, column: f64, row: f64) -> Option<Vec3> {
        self.lens.ray_at(DVec2::new(column, row)).map(|ray| ray.direction.as_vec3())
    }
}
