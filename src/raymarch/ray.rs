//! A ray in the coordinates of the voxel grid.

use glam::{DVec2, DVec3};

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
}

impl GridRay {
    /// A ray from a world point along a unit world direction.
    pub fn new(grid: &Grid, world_eye: DVec3, world_direction: DVec3) -> Self {
        let ground = (world_eye.truncate() - grid.origin) / grid.spacing;
        let slope = (world_direction.truncate() / grid.spacing).extend(world_direction.z);
        Self {
            eye: ground.extend(world_eye.z),
            slope,
            range_per_unit: slope.truncate().recip(),
            ground_cosine: world_direction.truncate().length(),
        }
    }

    /// Point at `range` metres.
    pub fn at(&self, range: f64) -> DVec3 {
        self.eye + self.slope * range
    }

    /// Height at `range` metres, metres above the datum.
    pub fn height_at(&self, range: f64) -> f64 {
        self.eye.z + self.slope.z * range
    }

    /// Ranges in metres between which the ray is over `0..=size` units and not above `ceiling`
    /// metres; `None` if it never is, at a range ≥ 0.
    pub fn clip(&self, size: DVec2, ceiling: f64) -> Option<(f64, f64)> {
        let mut interval = (0.0_f64, f64::INFINITY);
        for (eye, slope, low, high) in [
            (self.eye.x, self.slope.x, 0.0, size.x),
            (self.eye.y, self.slope.y, 0.0, size.y),
            (self.eye.z, self.slope.z, f64::NEG_INFINITY, ceiling),
        ] {
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
