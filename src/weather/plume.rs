//! Puffs of smoke and dust: balls of air that hides what is behind it, densest in their middle.
//!
//! ```text
//! density:  ρ(x) = ρ₀·exp(−|x − c|²/2σ²)
//! along a ray that passes the middle at distance d after t metres, and ends after R:
//!     depth = ρ₀σ√(2π) · exp(−d²/2σ²) · ½·(erf((R − t)/√2σ) + erf(t/√2σ))
//! ```
//!
//! What comes through is e^−depth (Beer and Lambert). Both factors of the integral are known for Gauss's ball, so that puffs end softly at
//! the ground, and an eye may be inside of one.

use std::ops::Range;

use glam::{DVec2, DVec3, Vec3};

use crate::earth::Curvature;
use crate::objects::Lens;

/// Standard deviations from its middle at which a puff ends.
const ENDS: f64 = 3.2;

/// A ball of hazy air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Puff {
    /// Centre, metres (x east, y north, z above the datum).
    pub centre: DVec3,
    /// Standard deviation of its density, metres, > 0.
    pub radius: f64,
    /// Optical depth through its middle, ≥ 0.
    pub depth: f32,
    /// Linear Rec. 709 reflectance of what it is made of, 0…1.
    pub albedo: Vec3,
}

/// A puff before an eye.
#[derive(Debug, Clone)]
pub struct SeenPuff {
    puff: Puff,
    /// Offset from the eye to the centre, metres.
    offset: DVec3,
    columns: Range<usize>,
    rows: Range<usize>,
}

impl SeenPuff {
    /// `puff` as `lens` sees it; `None`: it is not on its screen.
    pub fn new(puff: Puff, lens: &Lens<'_>, curvature: Curvature) -> Option<Self> {
        let eye = lens.camera.pose.eye;
        let drop = curvature.drop_at((puff.centre - eye).truncate().length());
        let offset = puff.centre - DVec3::Z * drop - eye;
        let reach = DVec3::splat(ENDS * puff.radius);
        let corners = (0..8).map(|corner| {
            let side = |bit: u32| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
            eye + offset + reach * DVec3::new(side(0), side(1), side(2))
        });
        let size = [lens.camera.width, lens.camera.height].map(|size| size as usize);
        let bounds = lens.bounds(corners).unwrap_or([DVec2::ZERO, DVec2::MAX]);
        // A float converts saturating.
        let range = |axis: usize| {
            let (from, to) = (bounds[0][axis].floor().max(0.0), bounds[1][axis].ceil().max(0.0));
            (from as usize).min(size[axis])..(to as usize).min(size[axis])
        };
        let (columns, rows) = (range(0), range(1));
        (!columns.is_empty() && !rows.is_empty()).then_some(Self { puff, offset, columns, rows })
    }

    /// Distance of its middle, metres.
    pub fn range(&self) -> f64 {
        self.offset.length()
    }

    /// Unit vector from the eye to its middle.
    pub fn direction(&self) -> DVec3 {
        self.offset.normalize_or(DVec3::Z)
    }

    /// Returns the albedo of its matter.
    pub fn albedo(&self) -> Vec3 {
        self.puff.albedo
    }

    /// Whether it may be in a pixel of some columns and rows.
    pub fn is_in(&self, columns: &Range<usize>, rows: &Range<usize>) -> bool {
        let meet = |a: &Range<usize>, b: &Range<usize>| a.start < b.end && b.start < a.end;
        meet(&self.columns, columns) && meet(&self.rows, rows)
    }

    /// Optical depth along unit `direction` from the eye up to `range` metres.
    pub fn depth(&self, direction: DVec3, range: f64) -> f32 {
        let along = self.offset.dot(direction);
        let square = self.offset.length_squared() - along * along;
        let per_radius = 1.0 / self.puff.radius;
        let across = square * per_radius * per_radius;
        if across > ENDS * ENDS || along < -ENDS * self.puff.radius {
            return 0.0;
        }
        let behind = erf(((range - along) * per_radius) as f32 * std::f32::consts::FRAC_1_SQRT_2);
        let before = erf((along * per_radius) as f32 * std::f32::consts::FRAC_1_SQRT_2);
        self.puff.depth * (-0.5 * across as f32).exp() * (0.5 * (behind + before)).max(0.0)
    }

    /// Numbers by which puffs are put in order, the nearest first; of those with the same ones order makes no difference.
    pub fn rank(&self) -> [u64; 9] {
        let Puff { radius, depth, albedo, .. } = self.puff;
        let [x, y, z] = self.offset.to_array();
        let [red, green, blue] = albedo.to_array().map(f64::from);
        // Ranges are positive, and rise with their bits.
        [self.range(), x, y, z, radius, f64::from(depth), red, green, blue].map(f64::to_bits)
    }
}

/// The error function (Abramowitz and Stegun 1964, eq. 7.1.26), within 1.5·10⁻⁷.
fn erf(x: f32) -> f32 {
    let (size, sign) = (x.abs(), x.signum());
    if size > 4.0 {
        return sign;
    }
    let t = 1.0 / (1.0 + 0.327_591_1 * size);
    let terms = [1.061_405_4, -1.453_152, 1.421_413_7, -0.284_496_74, 0.254_829_6];
    sign * (1.0 - terms.into_iter().fold(0.0, |sum, term| sum * t + term) * t * (-size * size).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{Attitude, Camera, Pose};

    fn camera() -> Camera {
        let pose = Pose { eye: DVec3::new(1000.0, 2000.0, 50.0), attitude: Attitude::default(), hfov: 60.0 };
        Camera::new(pose, 320, 200)
    }

    fn puff(north: f64, east: f64, radius: f64, depth: f32) -> Puff {
        let centre = DVec3::new(1000.0 + east, 2000.0 + north, 50.0);
        Puff { centre, radius, depth, albedo: Vec3::splat(0.5) }
    }

    #[test]
    fn depth_is_the_integral_of_density_along_the_ray() {
        let camera = camera();
        let lens = Lens::new(&camera);
        for (puff, range) in [
            (puff(60.0, 0.0, 5.0, 2.0), f64::INFINITY),
            (puff(60.0, 4.0, 5.0, 2.0), 62.0),
            (puff(60.0, 4.0, 5.0, 2.0), 55.0),
            (puff(3.0, -2.0, 6.0, 0.7), 10.0),
            (puff(-4.0, 1.0, 6.0, 0.7), 30.0),
        ] {
            let seen = SeenPuff::new(puff, &lens, Curvature::FLAT).unwrap();
            let direction = DVec3::new(0.05, 1.0, 0.02).normalize();
            let end = range.min(200.0);
            let steps = 40_000;
            let peak = f64::from(puff.depth) / (puff.radius * std::f64::consts::TAU.sqrt());

            let expected: f64 = (0..steps)
                .map(|step| end * (f64::from(step) + 0.5) / f64::from(steps))
                .map(|at| {
                    let off = camera.pose.eye + direction * at - puff.centre;
                    peak * (-0.5 * off.length_squared() / puff.radius.powi(2)).exp() * end / f64::from(steps)
                })
                .sum();

            let depth = f64::from(seen.depth(direction, range));
            assert!((depth - expected).abs() < 2.0e-4 * (1.0 + expected), "{puff:?}: {depth} {expected}");
        }
    }

    #[test]
    fn puffs_are_where_the_screen_shows_them() {
        let camera = camera();
        let lens = Lens::new(&camera);
        let seen = SeenPuff::new(puff(100.0, 20.0, 2.0, 1.0), &lens, Curvature::FLAT).unwrap();
        for row in 0..200 {
            for column in 0..320 {
                let direction =
                    lens.ray_at(DVec2::new(column as f64 + 0.5, row as f64 + 0.5)).unwrap().direction;
                let is_in = seen.is_in(&(column..column + 1), &(row..row + 1));
                assert!(is_in || seen.depth(direction, 1000.0) == 0.0, "{column} {row}");
            }
        }
        assert!(!seen.is_in(&(0..100), &(0..200)));
        assert!(
            SeenPuff::new(puff(-100.0, 0.0, 2.0, 1.0), &lens, Curvature::FLAT)
                .is_none_or(|behind| behind.depth(DVec3::Y, 1e3) == 0.0)
        );
        assert!(SeenPuff::new(puff(100.0, 200.0, 2.0, 1.0), &lens, Curvature::FLAT).is_none());
    }

    #[test]
    fn the_error_function_is_that_of_tables() {
        for (x, value) in [
            (0.0, 0.0),
            (0.5, 0.520_499_9),
            (1.0, 0.842_700_8),
            (2.0, 0.995_322_3),
            (-1.0, -0.842_700_8),
            (9.0, 1.0),
        ] {
            assert!((erf(x) - value).abs() < 3.0e-7, "{x}");
        }
    }
}
