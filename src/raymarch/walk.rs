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

/// The walk along one axis.
#[derive(Debug, Clone, Copy)]
struct Axis {
    cell: i64,
    step: i64,
    last: i64,
    eye: f64,
    range_per_unit: f64,
    /// Position of the next border, units; a sum of whole sides, so it is exact.
    border_units: f64,
    side_units: f64,
    /// Range of the next border, metres.
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
        let axis = |index: usize| {
            let lattice_position = point[index] / lattice.side - lattice.shift;
            let cell = (lattice_position.floor() as i64).clamp(first[index], last[index]);
            Axis::new(cell, [first[index], last[index]], lattice, ray.eye[index], ray.range_per_unit[index])
        };
        Self { axes: [axis(0), axis(1)], range: start, end, done: start > end }
    }
}

impl Axis {
    fn new(cell: i64, [first, last]: [i64; 2], lattice: Lattice, eye: f64, range_per_unit: f64) -> Self {
        let forward = range_per_unit > 0.0;
        let border_units = ((cell + i64::from(forward)) as f64 + lattice.shift) * lattice.side;
        let still = range_per_unit.is_infinite();
        Self {
            cell,
            step: if forward { 1 } else { -1 },
            last: if forward { last } else { first },
            eye,
            range_per_unit,
            border_units,
            side_units: lattice.side.copysign(range_per_unit),
            border: if still { f64::INFINITY } else { (border_units - eye) * range_per_unit },
        }
    }

    /// Moves on by one cell; false at the end of the lattice.
    #[inline]
    fn advance(&mut self) -> bool {
        if self.cell == self.last {
            return false;
        }
        self.cell += self.step;
        self.border_units += self.side_units;
        self.border = (self.border_units - self.eye) * self.range_per_unit;
        true
    }
}

impl Iterator for CellWalk {
    type Item = CellStep;

    #[inline]
    fn next(&mut self) -> Option<CellStep> {
        if self.done {
            return None;
        }
        let [x, y] = &mut self.axes;
        let cell = [x.cell, y.cell];
        let nearer = if x.border <= y.border { x } else { y };
        let border = nearer.border;
        let enter = self.range;
        if border >= self.end {
            self.done = true;
            return Some(CellStep { cell, enter, leave: self.end });
        }
        let leave = if border > enter { border } else { enter };
        self.range = leave;
        self.done = !nearer.advance();
        Some(CellStep { cell, enter, leave })
    }
}
