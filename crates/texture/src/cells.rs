//! A pattern's values in 255 × 255 cells, beyond which it repeats.

/// Cells along each side of a pattern: the period of a code of degree 8, and 17 voxels of 15 cells.
pub const SIDE: usize = 255;

/// Values of 255 × 255 cells, row by row; column and row are the steps along the ground's x and y.
#[derive(Debug, Clone, PartialEq)]
pub struct Cells {
    values: Vec<f64>,
}

impl Cells {
    /// Asks a value of each column and row, 0 to 254.
    pub fn of(value: impl Fn(i64, i64) -> f64) -> Self {
        let side = 0..SIDE as i64;
        Self {
            values: side
                .clone()
                .flat_map(|row| side.clone().map(move |column| (column, row)))
                .map(|(column, row)| value(column, row))
                .collect(),
        }
    }

    /// Value of any cell of the plane.
    pub fn at(&self, column: i64, row: i64) -> f64 {
        self.values[wrapped(row) * SIDE + wrapped(column)]
    }

    /// All values, row by row.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Mean of all cells.
    pub fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len() as f64
    }

    /// Standard deviation over all cells.
    pub fn deviation(&self) -> f64 {
        let mean = self.mean();
        (self.values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / self.values.len() as f64)
            .sqrt()
    }

    /// Means over the squares of `side` × `side` cells that begin at each cell.
    pub fn averaged(&self, side: usize) -> Self {
        // Rows averaged along themselves and turned over, twice.
        let along = |cells: &Self| {
            let mut turned = vec![0.0; SIDE * SIDE];
            for (row, values) in cells.values.chunks_exact(SIDE).enumerate() {
                let again = values.repeat(1 + side.div_ceil(SIDE));
                for (column, window) in again.windows(side).take(SIDE).enumerate() {
                    turned[column * SIDE + row] = window.iter().sum::<f64>() / side as f64;
                }
            }
            Self { values: turned }
        };
        along(&along(self))
    }

    /// Values of both, joined cell by cell.
    pub fn joined(&self, other: &Self, join: impl Fn(f64, f64) -> f64) -> Self {
        Self { values: self.values.iter().zip(&other.values).map(|(&a, &b)| join(a, b)).collect() }
    }
}

/// Place of a row or column of the plane within the pattern.
fn wrapped(place: i64) -> usize {
    place.rem_euclid(SIDE as i64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_repeat_and_average() {
        let cells = Cells::of(|column, row| (column * 3 + row * row) as f64);
        assert_eq!(cells.at(-1, 256), cells.at(254, 1));
        assert_eq!(cells.at(254, 1), 254.0 * 3.0 + 1.0);

        let square: f64 = (0..3)
            .flat_map(|row| (0..3).map(move |column| (column, row)))
            .map(|(column, row)| cells.at(253 + column, 7 + row))
            .sum();
        assert!((cells.averaged(3).at(253, 7) - square / 9.0).abs() < 1e-9);
        assert!((cells.averaged(SIDE).at(9, 9) - cells.mean()).abs() < 1e-6);
    }
}
