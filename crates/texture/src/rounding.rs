//! Whole numbers in place of a tile's values, with sums that stay exactly zero.
//!
//! ```text
//! round each cell down
//! in each block:    add 1 to the cells with the greatest remainders until the sum is 0
//! in each row of blocks, while a row r has too much and another s too little:
//!     take 1 from a cell of r, give 1 to the cell of s in the same column      block and column keep their sums
//! the same for columns, along rows
//! ```
//!
//! Each exchange takes the pair of cells whose remainders speak for it most, so that no cell ends far from
//! its value.

use crate::cells::SIDE;

/// Rounds values whose sums over blocks, rows and columns are zero up to rounding: whole numbers whose sums
/// are zero exactly.
///
/// Values are those of 255 × 255 cells, row by row; blocks have `side` × `side` cells, and `side` divides
/// 255.
pub fn balanced(values: &[f64], side: usize) -> Vec<i32> {
    let mut steps: Vec<i32> = values.iter().map(|value| value.floor() as i32).collect();
    for block_row in 0..SIDE / side {
        for block_column in 0..SIDE / side {
            fill_block(values, &mut steps, block_row * side * SIDE + block_column * side, side);
        }
    }

    let rows = Lines { values, side, along: 1, across: SIDE };
    rows.balance(&mut steps);
    let columns = Lines { values, side, along: SIDE, across: 1 };
    columns.balance(&mut steps);
    steps
}

/// Rounds cells of a block up, those with the greatest remainders first, until its sum is zero.
fn fill_block(values: &[f64], steps: &mut [i32], first: usize, side: usize) {
    let mut cells: Vec<usize> =
        (0..side * side).map(|number| first + number / side * SIDE + number % side).collect();
    let missing = -cells.iter().map(|&cell| i64::from(steps[cell])).sum::<i64>();

    let remainder = |cell: usize| values[cell] - values[cell].floor();
    cells.sort_by(|&a, &b| remainder(b).total_cmp(&remainder(a)));
    for &cell in cells.iter().take(missing.max(0) as usize) {
        steps[cell] += 1;
    }
}

/// Rows or columns of a tile, whose sums become zero.
struct Lines<'a> {
    values: &'a [f64],
    /// Cells along the side of a block.
    side: usize,
    /// Step from a cell to the next of its line.
    along: usize,
    /// Step from a line to the next.
    across: usize,
}

impl Lines<'_> {
    fn balance(&self, steps: &mut [i32]) {
        for band in 0..SIDE / self.side {
            let lines = band * self.side..(band + 1) * self.side;
            let mut sums: Vec<i32> = lines.clone().map(|line| self.sum(steps, line)).collect();

            // Sums of a band add up to nothing, because its blocks do.
            while let (Some(rich), Some(poor)) =
                (sums.iter().position(|&sum| sum > 0), sums.iter().position(|&sum| sum < 0))
            {
                self.exchange(steps, lines.start + rich, lines.start + poor);
                sums[rich] -= 1;
                sums[poor] += 1;
            }
        }
    }

    fn sum(&self, steps: &[i32], line: usize) -> i32 {
        (0..SIDE).map(|place| steps[line * self.across + place * self.along]).sum()
    }

    /// Moves 1 from a line to another, where both cells are farthest from their values on the right sides.
    fn exchange(&self, steps: &mut [i32], rich: usize, poor: usize) {
        let cell = |line: usize, place: usize| line * self.across + place * self.along;
        let excess = |steps: &[i32], cell: usize| f64::from(steps[cell]) - self.values[cell];
        let gain = |place: usize| excess(steps, cell(rich, place)) - excess(steps, cell(poor, place));

        let best = (0..SIDE).max_by(|&a, &b| gain(a).total_cmp(&gain(b))).unwrap_or(0);
        steps[cell(rich, best)] -= 1;
        steps[cell(poor, best)] += 1;
    }
}
