//! Placements of shapes: the list of all that is placed over voxels, and the one place where it becomes solids.
//!
//! A shape is laid over whole voxels in one of eight ways, so that one of them serves any number of placements; what a page needs of each are
//! these few numbers.

use super::shape::{Shape, laid};
use crate::features::{PlacedSolid, Solid};
use crate::warp::Rect;
use hedgehop::voxel::Symmetry;

/// A shape that stands somewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placement {
    /// Number of the shape.
    pub shape: u32,
    /// The voxel that the shape's voxel (0, 0) is laid on, eastward and northward from the grid's origin.
    pub voxel: [i64; 2],
    /// Symmetry by which it is laid.
    pub symmetry: Symmetry,
    /// Height of its foot, metres above the database's datum.
    pub foot_m: f64,
}

/// Raises the solids of placements over a block: the only place where placements become solids.
pub(super) fn raise<'s>(
    placements: &[Placement],
    shape: impl Fn(u32) -> &'s Shape,
    rect: Rect,
    out: &mut Vec<PlacedSolid>,
) {
    for placement in placements {
        let of = shape(placement.shape);
        let (low, high) = placement.bounds(of);
        let range = |axis: usize, from: u32, to: u32| {
            low[axis].max(i64::from(from))..=high[axis].min(i64::from(to) - 1)
        };
        for y in range(1, rect.y0, rect.y1) {
            for x in range(0, rect.x0, rect.x1) {
                let from = placement.symmetry.turn_back([x - placement.voxel[0], y - placement.voxel[1]]);
                let index = rect.index(x as u32, y as u32);
                out.extend(of.over(from).iter().map(|solid| placement.lifted(solid).over(index)));
            }
        }
    }
}

impl Placement {
    /// Least and greatest voxel that it covers.
    pub fn bounds(&self, shape: &Shape) -> ([i64; 2], [i64; 2]) {
        let last = [shape.first[0] + shape.columns as i64 - 1, shape.first[1] + shape.rows as i64 - 1];
        let [a, b] = [shape.first, last].map(|corner| self.symmetry.turn(corner));
        let corner = |axis: usize, choose: fn(i64, i64) -> i64| self.voxel[axis] + choose(a[axis], b[axis]);
        ([corner(0, i64::min), corner(1, i64::min)], [corner(0, i64::max), corner(1, i64::max)])
    }

    /// A solid of its shape where it stands.
    fn lifted(&self, solid: &Solid) -> Solid {
        let solid = laid(self.symmetry, solid);
        let low_m = solid.low_m.map(|low| low + self.foot_m);
        Solid { low_m, high_m: solid.high_m + self.foot_m, ..solid }
    }
}
