//! Boxes on the ground, and means over them from summed areas.

/// Shortest side of a box, cells.
const MIN_SIDE: f64 = 1.0 / 1024.0;

/// Box on the ground, in cells; a cell's lower corner is at whole numbers.
///
/// Sides may be in either order; one shorter than 1/1024 cell is taken for so long, about its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellBox {
    /// Western side.
    pub x0: f64,
    /// Eastern side.
    pub x1: f64,
    /// Southern side.
    pub y0: f64,
    /// Northern side.
    pub y1: f64,
}

impl CellBox {
    /// Area, square cells.
    pub fn area(self) -> f64 {
        let ordered = self.ordered();
        (ordered.x1 - ordered.x0) * (ordered.y1 - ordered.y0)
    }

    /// Box of the same size elsewhere.
    pub fn shifted(self, x: f64, y: f64) -> Self {
        Self { x0: self.x0 + x, x1: self.x1 + x, y0: self.y0 + y, y1: self.y1 + y }
    }

    /// Box about the same middle with no side shorter than so many cells.
    ///
    /// Means over boxes of at least one cell are means of the pattern as interpolated linearly between the
    /// middles of cells: what is nearer than a cell is wide has no blocks.
    #[must_use]
    pub fn at_least(self, cells: f64) -> Self {
        let wide = |a: f64, b: f64| {
            let (middle, half) = (0.5 * (a + b), 0.5 * (b - a).abs().max(cells));
            [middle - half, middle + half]
        };
        let ([x0, x1], [y0, y1]) = (wide(self.x0, self.x1), wide(self.y0, self.y1));
        Self { x0, x1, y0, y1 }
    }

    /// Box with its sides in order, none shorter than the shortest.
    pub(crate) fn ordered(self) -> Self {
        let [x0, x1] = widened(self.x0, self.x1);
        let [y0, y1] = widened(self.y0, self.y1);
        Self { x0, x1, y0, y1 }
    }

    /// Mean over the box of a pattern of constant cells, of whose summed areas each whole column and row is
    /// asked.
    ///
    /// Between whole numbers they are bilinear, which is exact. What is asked may be off by what depends on
    /// the column alone or on the row alone.
    pub(crate) fn mean_from_sums(self, sum: impl Fn(i64, i64) -> f64) -> f64 {
        let sum_to = |x: f64, y: f64| {
            let (column, row) = (x.floor(), y.floor());
            let (along, up) = (x - column, y - row);
            let across = |row| {
                let column = column as i64;
                (1.0 - along) * sum(column, row) + along * sum(column.wrapping_add(1), row)
            };
            let row = row as i64;
            (1.0 - up) * across(row) + up * across(row.wrapping_add(1))
        };
        let Self { x0, x1, y0, y1 } = self.ordered();
        (sum_to(x1, y1) - sum_to(x0, y1) - sum_to(x1, y0) + sum_to(x0, y0)) / ((x1 - x0) * (y1 - y0))
    }
}

/// Sides in order, at least the shortest apart.
fn widened(a: f64, b: f64) -> [f64; 2] {
    if (b - a).abs() >= MIN_SIDE {
        [a.min(b), a.max(b)]
    } else {
        let middle = 0.5 * (a + b);
        [middle - 0.5 * MIN_SIDE, middle + 0.5 * MIN_SIDE]
    }
}

/// Mean over a box, cell by cell, for tests.
#[cfg(test)]
pub(crate) fn brute_force(value: impl Fn(i64, i64) -> f64, over: CellBox) -> f64 {
    let share = |from: f64, to: f64, cell: i64| to.min(cell as f64 + 1.0) - from.max(cell as f64);
    let mut sum = 0.0;
    for row in over.y0.floor() as i64..over.y1.ceil() as i64 {
        let high = share(over.y0, over.y1, row);
        for column in over.x0.floor() as i64..over.x1.ceil() as i64 {
            sum += value(column, row) * share(over.x0, over.x1, column) * high;
        }
    }
    sum / over.area()
}
