//! Stepping along a ray from cell border to cell border; knows nothing of what the cells hold.
//!
//! Borders are addressed by integers and their ranges come from one formula, so that neighbouring
//! cells, and cells of different levels, agree on them to the last bit, and every step makes
//! progress (Hughes patent, "stepping by integer boundaries"; Amanatides and Woo, *A fast voxel
//! traversal algorithm for ray tracing*, 1987).

use super::GridRay;

/// One cell on the way, and the ranges between which the ray is in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellStep {
    /// Cell column and row.
    pub cell: [i64; 2],
    /// Range at which the ray enters, metres.
    pub enter: f64,
    /// Range at which it leaves, metres, ≥ `enter`.
    pub leave: f64,
}

/// Cells of a square lattice along a ray, in order. Cell `i` of an axis covers
/// `side · [i + shift, i + 1 + shift)` units.
#[derive(Debug, Clone)]
pub struct CellWalk {
    axes: [Axis; 2],
    range: f64,
    end: f64,
    done: bool,
}

#[derive(Debug, Clone, Copy)]
struct Axis {
    cell: i64,
    step: i64,
    last: i64,
    side: f64,
    shift: f64,
    eye: f64,
    range_per_unit: f64,
    border: f64,
}

/// A lattice of cells: their side in units, and by how many cells it is shifted.
#[derive(Debug, Clone, Copy)]
pub struct Lattice {
    /// Side of a cell, units.
    pub side: f64,
    /// Shift of the whole lattice, cells.
    pub shift: f64,
}

impl CellWalk {
    /// The cells `first..=last` (per axis) that `ray` crosses between the ranges `start` and `end`.
    pub fn new(
        ray: &GridRay,
        lattice: Lattice,
        first: [i64; 2],
        last: [i64; 2],
        start: f64,
        end: f64,
    ) -> Self {
        let point = ray.at(start);
        let axis = |eye: f64, range_per_unit: f64, position: f64, first: i64, last: i64| {
            let mut axis = Axis {
                cell: ((position / lattice.side - lattice.shift).floor() as i64).clamp(first, last),
                step: if range_per_unit > 0.0 { 1 } else { -1 },
                last: if range_per_unit > 0.0 { last } else { first },
                side: lattice.side,
                shift: lattice.shift,
                eye,
                range_per_unit,
                border: f64::INFINITY,
            };
            axis.border = axis.border_range();
            axis
        };
        Self {
            axes: [
                axis(ray.eye.x, ray.range_per_unit.x, point.x, first[0], last[0]),
                axis(ray.eye.y, ray.range_per_unit.y, point.y, first[1], last[1]),
            ],
            range: start,
            end,
            done: start > end,
        }
    }
}

impl Axis {
    /// Range at which the ray leaves the current cell along this axis.
    fn border_range(&self) -> f64 {
        if self.range_per_unit.is_infinite() {
            return f64::INFINITY;
        }
        let ahead = i64::from(self.step > 0);
        (((self.cell + ahead) as f64 + self.shift) * self.side - self.eye) * self.range_per_unit
    }

    /// Moves on by one cell; false at the end of the lattice.
    fn advance(&mut self) -> bool {
        if self.cell == self.last {
            return false;
        }
        self.cell += self.step;
        self.border = self.border_range();
        true
    }
}

impl Iterator for CellWalk {
    type Item = CellStep;

    fn next(&mut self) -> Option<CellStep> {
        if self.done {
            return None;
        }
        let [x, y] = &mut self.axes;
        let cell = [x.cell, y.cell];
        let border = x.border.min(y.border);
        let enter = self.range;
        let leave = border.clamp(enter, self.end);
        self.range = leave;
        self.done = border >= self.end || !if x.border <= y.border { x.advance() } else { y.advance() };
        Some(CellStep { cell, enter, leave })
    }
}
