//! Symmetric matrices of seven diagonals, and linear systems with them.

/// A symmetric, positive definite matrix of seven diagonals.
pub(super) struct Banded {
    /// Elements of each row: on the diagonal, and one, two and three columns before.
    rows: Vec<[f64; 4]>,
}

/// The factors L and D of a matrix L D Lᵀ of seven diagonals.
pub(super) struct Factors {
    /// Elements of each row: of D, and of L one, two and three columns before.
    rows: Vec<[f64; 4]>,
}

impl Banded {
    /// A matrix with nothing beside its diagonal.
    pub fn diagonal(elements: impl Iterator<Item = f64>) -> Self {
        Self { rows: elements.map(|element| [element, 0.0, 0.0, 0.0]).collect() }
    }

    /// Adds `factor · weights · weightsᵀ`, of up to four weights from row `first` on.
    pub fn add_square(&mut self, first: usize, weights: &[f64], factor: f64) {
        for (row, weight) in weights.iter().enumerate() {
            for before in 0..=row {
                self.rows[first + row][before] += factor * weight * weights[row - before];
            }
        }
    }

    pub fn factored(self) -> Factors {
        let mut rows = self.rows;
        for row in 0..rows.len() {
            let reach = row.min(3);

            // Elements of L times those of D.
            let mut scaled = [0.0; 4];
            for before in (1..=reach).rev() {
                let others = before + 1..=reach;
                let sum: f64 = others.map(|other| scaled[other] * rows[row - before][other - before]).sum();
                scaled[before] = rows[row][before] - sum;
            }

            for before in 1..=reach {
                let factor = scaled[before] / rows[row - before][0];
                rows[row][0] -= factor * scaled[before];
                rows[row][before] = factor;
            }
        }
        Factors { rows }
    }
}

impl Factors {
    /// Solves the system for a right side, in its place.
    pub fn solve(&self, values: &mut [f64]) {
        for row in 0..values.len() {
            let sum: f64 = (1..=row.min(3)).map(|before| self.rows[row][before] * values[row - before]).sum();
            values[row] -= sum;
        }
        for (value, row) in values.iter_mut().zip(&self.rows) {
            *value /= row[0];
        }
        for row in (0..values.len()).rev() {
            let after = (1..=3).filter(|after| row + after < values.len());
            let sum: f64 = after.map(|after| self.rows[row + after][after] * values[row + after]).sum();
            values[row] -= sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_fulfil_their_equations() {
        let size = 9;
        let mut matrix = Banded::diagonal((0..size).map(|row| 1.0 + 0.1 * row as f64));
        (0..size - 3).for_each(|first| matrix.add_square(first, &[1.0, -3.0, 3.0, -1.0], 2.0 + first as f64));
        (0..size - 2).for_each(|first| matrix.add_square(first, &[1.0, -2.0, 1.0], 5.0));
        let element = |row: usize, column: usize| {
            let (high, low) = (row.max(column), row.min(column));
            if high - low > 3 { 0.0 } else { matrix.rows[high][high - low] }
        };
        let wanted: Vec<f64> = (0..size).map(|row| (row * row) as f64 - 7.0).collect();
        let mut values: Vec<f64> = (0..size)
            .map(|row| (0..size).map(|column| element(row, column) * wanted[column]).sum())
            .collect();
        matrix.factored().solve(&mut values);
        for (value, wanted) in values.iter().zip(&wanted) {
            assert!((value - wanted).abs() < 1e-9, "{values:?}");
        }
    }
}
