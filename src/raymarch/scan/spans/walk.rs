//! Square cells along a plane.

use crate::simd::Each;

/// One cell on the way, and the major distances between which the plane is in it, units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct VoxelStep {
    pub cell: [i64; 2],
    pub enter: f64,
    pub leave: f64,
}

/// Cells along a plane in order (Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing", 1987).
#[derive(Debug)]
pub(super) struct Walk {
    cell: [i64; 2],
    /// Distance of the next border of each axis, and from one to the next.
    border: [f64; 2],
    per_cell: [f64; 2],
    step: [i64; 2],
    limits: [[i64; 2]; 2],
    at: f64,
    end: f64,
}

impl Walk {
    /// Cells of side `side`, first and last of each axis in `limits`, along `eye + way · distance` between two distances.
    #[inline(always)]
    pub fn new(eye: [f64; 2], way: [f64; 2], side: f64, limits: [[i64; 2]; 2], [at, end]: [f64; 2]) -> Self {
        let (mut cell, mut border, mut per_cell, mut step) =
            ([0; 2], [f64::INFINITY; 2], [f64::INFINITY; 2], [0; 2]);
        for axis in 0..2 {
            let [first, last] = limits[axis];
            let place = (eye[axis] + way[axis] * at) / side;
            // On a border it is the cell that the plane enters.
            let index = if way[axis] < 0.0 { place.ceil() as i64 - 1 } else { place.floor() as i64 };
            cell[axis] = index.clamp(first, last);
            if way[axis] != 0.0 {
                let ahead = cell[axis] + i64::from(way[axis] > 0.0);
                border[axis] = (ahead as f64 * side - eye[axis]) / way[axis];
                per_cell[axis] = side / way[axis].abs();
                step[axis] = if way[axis] > 0.0 { 1 } else { -1 };
            }
        }
        Self { cell, border, per_cell, step, limits, at, end }
    }
}

impl Iterator for Walk {
    type Item = VoxelStep;

    #[inline(always)]
    fn next(&mut self) -> Option<VoxelStep> {
        if self.at >= self.end {
            return None;
        }
        // Both axes side by side: which one it is follows no pattern that a processor could foresee, and an index waits for memory.
        let [across, up] = self.border;
        let crosses = [up >= across, up < across];
        let (cell, enter) = (self.cell, self.at);
        let leave = across.min(up).min(self.end).max(enter);
        self.cell = [0, 1].each(|axis| cell[axis] + if crosses[axis] { self.step[axis] } else { 0 });
        self.border =
            [0, 1].each(|axis| self.border[axis] + if crosses[axis] { self.per_cell[axis] } else { 0.0 });
        let is_within = [0, 1].each(|axis| {
            let [first, last] = self.limits[axis];
            (self.cell[axis] >= first) & (self.cell[axis] <= last)
        });
        self.at = if leave < self.end && !(is_within[0] & is_within[1]) { self.end } else { leave };
        Some(VoxelStep { cell, enter, leave })
    }
}
