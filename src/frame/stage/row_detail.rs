//! Detail below the voxel in rows of sixteen planes.
//!
//! ```text
//! place      = eye + distance of the row's middle, along each plane
//! along      = distance between the row's edges, as the surface there slopes
//! across     = range · angle of a pixel
//! light of the row × (1 + deviation · mean of the tile over the box with the same second moments)
//! ```

use glam::DVec3;
use hedgehop_texture::{CELLS_PER_VOXEL, SIDE};

use crate::detail::{FADING, GroundTile};
use crate::raymarch::scan::PlaneGroup;
use crate::simd::{Each, Floats, LANES, Simd};

/// Cells of the tile per unit.
const CELLS: f64 = CELLS_PER_VOXEL as f64;

/// Greatest change of inverse depth over a row, relative to it.
const MOST_CHANGE: f32 = 1.0;

/// Least inverse depth, 1/metres: of rows that are hardly seen.
const LEAST_INVERSE: f32 = 1.0e-5;

/// Detail on the ground that planes see.
#[derive(Debug, Clone, Copy)]
pub struct RowDetail {
    tile: &'static GroundTile,
    /// 0: planes run along x, 1: along y.
    major: usize,
    /// The eye, cells from a corner of the tile.
    eye: [f32; 2],
    /// Cells along the major axis, with its sense, and along the minor one, per metre of depth.
    per_depth: [[f32; LANES]; 2],
    /// Cells that a pixel is wide per metre of range.
    per_range: f32,
    strength: f32,
}

/// Row of planes that asks for detail.
pub struct DetailedRow<V: Simd> {
    /// Inverse depth in its middle, 1/metres.
    pub inverse: V::F,
    /// Change of it from edge to edge, 1/metres.
    pub change: V::F,
    /// Range per depth.
    pub slant: V::F,
    /// Relative deviation of its light.
    pub deviation: V::F,
}

impl RowDetail {
    /// Detail for a group of planes from `eye` (units, units, metres), whose pixels are `angle` (radians) wide, on a grid of `spacing` metres. `strength` is a
    /// factor on amplitudes; `None`: there is none.
    pub fn new(group: &PlaneGroup, eye: DVec3, angle: f64, spacing: f64, strength: f64) -> Option<Self> {
        let tile = GroundTile::codes().filter(|_| strength > 0.0)?;
        let PlaneGroup { major, forward, minor, depth, .. } = group;
        let cells = |lane: usize, units: f64| (units * CELLS / f64::from(depth[lane])) as f32;
        Some(Self {
            tile,
            major: *major,
            eye: [eye.x, eye.y].each(|at| (at * CELLS).rem_euclid(SIDE as f64) as f32),
            per_depth: [
                std::array::from_fn(|lane| cells(lane, *forward)),
                std::array::from_fn(|lane| cells(lane, f64::from(minor[lane]))),
            ],
            per_range: (angle * CELLS / spacing) as f32,
            strength: strength as f32,
        })
    }

    /// Factor on the light of a row.
    #[inline(always)]
    pub fn factor<V: Simd>(&self, simd: V, row: &DetailedRow<V>) -> V::F {
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let depth = row.inverse.max(simd.splat(LEAST_INVERSE)).recip();
        let [major, minor] = [simd.load(&self.per_depth[0]) * depth, simd.load(&self.per_depth[1]) * depth];

        // Squares of the footprint along and across, and of its extent along the axes.
        let change = (row.change * depth).abs().min(simd.splat(MOST_CHANGE));
        let width = row.slant * depth * simd.splat(self.per_range);
        let (major_square, minor_square) = (major * major, minor * minor);
        let (along, across) = (change * change, width * width * (major_square + minor_square).recip());
        let squares =
            [along * major_square + across * minor_square, along * minor_square + across * major_square];

        let [x, y] = if self.major == 0 { [major, minor] } else { [minor, major] };
        let [wide, high] = if self.major == 0 { squares } else { [squares[1], squares[0]] };
        let centre = [x + simd.splat(self.eye[0]), y + simd.splat(self.eye[1])];
        let mean = self.tile.means(simd, centre, [wide, high]);

        let fading = fading(simd, width);
        let deviation = row.deviation * simd.splat(self.strength) * fading;
        deviation.mul_add(mean, one).max(zero)
    }
}

/// [`GroundTile::fading`] of footprints in cells.
#[inline(always)]
fn fading<V: Simd>(simd: V, width: V::F) -> V::F {
    let [from, to] = FADING.each(|voxels| (voxels * CELLS) as f32);
    let left = (simd.splat(to) - width) * simd.splat(1.0 / (to - from));
    left.max(simd.splat(0.0)).min(simd.splat(1.0))
}
