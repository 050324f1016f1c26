//! A ray in the coordinates of the voxel grid.
//!
//! The Earth bends away under a straight ray. Marching bends the ray instead: relative to the database its height
//! is `z + slope·s + (ground cosine · s)² / 2R′` at range `s`, a parabola, while ground position stays linear.
//! Range is the length of the straight ray. With [`Curvature::FLAT`] all is as if there were no Earth, to the bit.

use glam::{DVec2, DVec3};

use crate::earth::Curvature;
use crate::voxel::Grid;

/// A ray in grid space: x and y in units (sides of a level-1 voxel) from the area's south-west
/// corner, z in metres above the datum; its parameter is range in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridRay {
    /// The eye, (units, units, metres).
    pub eye: DVec3,
    /// Change per metre of range, (units, units, metres).
    pub slope: DVec3,
    /// Metres of range per unit along x and y; infinite where the ray does not move along one.
    pub range_per_unit: DVec2,
    /// Ground distance per range: cosine of the elevation angle, 0…1.
    pub ground_cosine: f64,
    /// Height over the database gained per square of range, 1/metres, ≥ 0.
    pub bend: f64,
}

impl GridRay {
    /// A ray from a world point along a unit world direction, over flat ground.
    pub fn new(grid: &Grid, world_eye: DVec3, world_direction: DVec3) -> Self {
        let ground = (world_eye.truncate() - grid.origin) / grid.spacing;
        let slope = (world_direction.truncate() / grid.spacing).extend(world_direction.z);
        Self {
            eye: ground.extend(world_eye.z),
            slope,
            range_per_unit: slope.truncate().recip(),
            ground_cosine: world_direction.truncate().length(),
            bend: 0.0,
        }
    }

    /// The same ray over ground of this curvature.
    pub fn over(self, curvature: Curvature) -> Self {
        Self { bend: curvature.drop_at(self.ground_cosine), ..self }
    }

    /// Point at `range` metres.
    pub fn at(&self, range: f64) -> DVec3 {
        (self.eye + self.slope * range).truncate().extend(self.height_at(range))
    }

    /// Height at `range` metres, metres above the datum.
    pub fn height_at(&self, range: f64) -> f64 {
        let straight = self.eye.z + self.slope.z * range;
        // A vertical ray does not bend, not even over an infinite range.
        if self.bend == 0.0 { straight } else { straight + self.bend * range * range }
    }

    /// Change of height per metre of range at `range` metres.
    pub fn rise_at(&self, range: f64) -> f64 {
        self.slope.z + 2.0 * self.bend * range
    }

    /// Least height between two ranges, metres above the datum: at one of them, or where the parabola is lowest.
    pub fn lowest_between(&self, enter: f64, leave: f64) -> f64 {
        if self.bend > 0.0 {
            let lowest = -0.5 * self.slope.z / self.bend;
            return self.height_at(lowest.max(enter).min(leave));
        }
        self.height_at(enter).min(self.height_at(leave))
    }

    /// Ranges between which the ray is not above `height` metres, of any sign; `None` if it always is.
    pub fn under(&self, height: f64) -> Option<(f64, f64)> {
        let (above, rise) = (self.eye.z - height, self.slope.z);
        if self.bend == 0.0 {
            let crossing = (height - self.eye.z) / rise;
            return if rise < 0.0 {
                Some((crossing, f64::INFINITY))
            } else if rise > 0.0 {
                Some((f64::NEG_INFINITY, crossing))
            } else {
                (above <= 0.0).then_some((f64::NEG_INFINITY, f64::INFINITY))
            };
        }

        // Roots of a parabola that opens upward, without cancellation (Press et al., Numerical Recipes, §5.6).
        let discriminant = rise * rise - 4.0 * self.bend * above;
        if discriminant < 0.0 {
            return None;
        }

        let q = -0.5 * (rise + discriminant.sqrt().copysign(rise));
        let one = q / self.bend;
        let other = if q == 0.0 { one } else { above / q };

        Some((one.min(other), one.max(other)))
    }

    /// Ranges in metres between which the ray is over `0..=size` units and not above `ceiling`
    /// metres; `None` if it never is, at a range ≥ 0.
    pub fn clip(&self, size: DVec2, ceiling: f64) -> Option<(f64, f64)> {
        let under = self.under(ceiling)?;
        let mut interval = (under.0.max(0.0), under.1);
        for (eye, slope, low, high) in
            [(self.eye.x, self.slope.x, 0.0, size.x), (self.eye.y, self.slope.y, 0.0, size.y)]
        {
            if slope == 0.0 {
                if eye < low || eye > high {
                    return None;
                }
                continue;
            }
            let (to_low, to_high) = ((low - eye) / slope, (high - eye) / slope);
            interval = (interval.0.max(to_low.min(to_high)), interval.1.min(to_low.max(to_high)));
        }
        (interval.0 <= interval.1).then_some(interval)
    }
}
