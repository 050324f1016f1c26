//! Square cells along a plane.

/// One cell on the way, and the major distances between which the plane is in it, units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Step {
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
    type Item = Step;

    #[inline(always)]
    fn next(&mut self) -> Option<Step> {
        if self.at >= self.end {
            return None;
        }
        // Both axes side by side: which one it is follows no pattern that a processor could foresee, and an index waits for memory.
        let [across, up] = self.border;
        let turns = up < across;
        let [first, second] = [!turns, turns];
        let (cell, enter) = (self.cell, self.at);
        let leave = (if turns { up } else { across }).min(self.end).max(enter);
        let by = |axis: usize, is: bool| if is { self.step[axis] } else { 0 };
        let ahead = |axis: usize, is: bool| if is { self.per_cell[axis] } else { 0.0 };
        let next = [cell[0] + by(0, first), cell[1] + by(1, second)];
        self.border = [across + ahead(0, first), up + ahead(1, second)];
        let [[west, east], [south, north]] = self.limits;
        // Below the first is far above the last, without a sign.
        let is_within = |at: i64, first: i64, last: i64| (at - first) as u64 <= (last - first) as u64;
        let is_within = is_within(next[0], west, east) & is_within(next[1], south, north);
        self.at = if leave < self.end && !is_within { self.end } else { leave };
        self.cell = next;
        Some(Step { cell, enter, leave })
    }
}
