//! Vertical planes through the eye, sixteen at a time.

use glam::DVec2;

use crate::simd::LANES;
use crate::voxel::Grid;

/// Sixteen neighbouring vertical planes.
///
/// Positions are in units from the area's south-west corner; the *major axis* is the one along which
/// the planes run most, and distances along it, in units, are what the march counts in.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneGroup {
    /// 0: the planes run along x, 1: along y.
    pub major: usize,
    /// +1 or −1: sense along the major axis.
    pub forward: f64,
    /// Units along the minor axis per unit of major distance.
    pub minor: [f32; LANES],
    /// Depth per unit of major distance, metres.
    pub depth: [f32; LANES],
    /// Curvature's drop per squared unit of major distance, metres.
    pub drop: [f32; LANES],
    /// Major distances between which each plane lies over the area, units; the first is after the second
    /// where it never does.
    pub over: [[f32; LANES]; 2],
    /// Ground distance per unit of major distance of the middle plane, metres.
    pub ground: f64,
}

impl PlaneGroup {
    /// Planes from `eye` (units) along `directions`, in order and within 45° of the middle one: ground metres per metre of depth; what depth is, is up
    /// to the caller. `inverse_diameter` is 1/(2R′) of the Earth, 1/metres, 0 for a flat one.
    pub fn new(grid: &Grid, eye: DVec2, directions: &[DVec2; LANES], inverse_diameter: f64) -> Self {
        let middle = directions[LANES / 2];
        let major = usize::from(middle.y.abs() > middle.x.abs());
        let forward = middle[major].signum();
        let size = DVec2::new(f64::from(grid.nx), f64::from(grid.ny));
        // Metres of ground per unit of major distance.
        let per_unit = directions.map(|direction| direction * (grid.spacing / (direction[major] * forward)));
        let minor = per_unit.map(|ground| (ground[1 - major] / grid.spacing) as f32);
        let drop = per_unit.map(|ground| (ground.length_squared() * inverse_diameter) as f32);
        let mut depth = [0.0; LANES];
        let mut over = [[0.0; LANES]; 2];
        for lane in 0..LANES {
            depth[lane] = (grid.spacing / (directions[lane][major] * forward)) as f32;
            let (enter, leave) = clip(eye, per_unit[lane] / grid.spacing, size);
            over[0][lane] = enter as f32;
            over[1][lane] = leave as f32;
        }
        Self { major, forward, minor, depth, drop, over, ground: per_unit[LANES / 2].length() }
    }

    /// The same planes over a grid of which a unit has so many of these.
    pub fn in_cells(&self, side: f64) -> Self {
        let by = side as f32;
        Self {
            depth: self.depth.map(|depth| depth * by),
            drop: self.drop.map(|drop| drop * by * by),
            over: self.over.map(|over| over.map(|at| at / by)),
            ground: self.ground * side,
            ..self.clone()
        }
    }

    /// Units eastward and northward per unit of major distance of a plane.
    pub fn way(&self, lane: usize) -> [f64; 2] {
        let minor = f64::from(self.minor[lane]);
        if self.major == 0 { [self.forward, minor] } else { [minor, self.forward] }
    }

    /// Returns the change of a plane's units eastward and northward per metre of depth to the next plane.
    pub fn beside(&self, lane: usize) -> [f32; 2] {
        let ahead = |lane: usize| self.way(lane).map(|way| way / f64::from(self.depth[lane]));
        let from = lane.min(LANES - 2);
        let (from, to) = (ahead(from), ahead(from + 1));
        [0, 1].map(|axis| (to[axis] - from[axis]) as f32)
    }
}

/// Distances ≥ 0 between which `eye + slope · distance` lies in `0..=size`.
fn clip(eye: DVec2, slope: DVec2, size: DVec2) -> (f64, f64) {
    let mut over = (0.0_f64, f64::INFINITY);
    for axis in 0..2 {
        if slope[axis] == 0.0 {
            if eye[axis] < 0.0 || eye[axis] > size[axis] {
                return (f64::INFINITY, 0.0);
            }
            continue;
        }
        let (a, b) = (-eye[axis] / slope[axis], (size[axis] - eye[axis]) / slope[axis]);
        over = (over.0.max(a.min(b)), over.1.min(a.max(b)));
    }
    over
}
