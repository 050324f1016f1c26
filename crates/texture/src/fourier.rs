//! Frequencies of a pattern of 255 × 255 cells.
//!
//! ```text
//! X(k) = Σ x(n) exp(−2πi n·k / 255)      rows, then columns
//! n = 17 a + 15 b,  k ≡ a′ (mod 15), ≡ b′ (mod 17)   ⇒   n·k / 255 ≡ a·a′ / 15 + b·b′ / 17      (mod 1)
//! ```
//!
//! As 15 and 17 have no divisor in common, a row is a table of 15 × 17 places: 15 + 17 products a place instead of 255 (Good 1958,
//! *The interaction algorithm and practical Fourier analysis*).

use std::f64::consts::TAU;

use crate::cells::SIDE;

/// Factors of the side.
const FACTORS: [usize; 2] = [15, 17];

const _: () = assert!(FACTORS[0] * FACTORS[1] == SIDE);

/// Complex numbers at 255 × 255 places, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Phasors {
    /// Real parts.
    pub real: Vec<f64>,
    /// Imaginary parts.
    pub imaginary: Vec<f64>,
}

impl Phasors {
    /// Numbers without imaginary parts.
    pub fn of_real(real: Vec<f64>) -> Self {
        let imaginary = vec![0.0; real.len()];
        Self { real, imaginary }
    }

    /// Returns their frequencies: cycles of the side along columns and rows, negative ones from the end.
    pub fn frequencies(self) -> Self {
        let row = RowTransform::new();
        self.along_rows(&row).transposed().along_rows(&row).transposed()
    }

    /// Returns the numbers whose frequencies these are.
    pub fn of_frequencies(self) -> Self {
        // Real and imaginary parts exchanged run the other way.
        let Self { real: imaginary, imaginary: real } = self;
        let Self { real: mut imaginary, imaginary: mut real } = Self { real, imaginary }.frequencies();
        for part in real.iter_mut().chain(&mut imaginary) {
            *part /= (SIDE * SIDE) as f64;
        }
        Self { real, imaginary }
    }

    fn along_rows(mut self, transform: &RowTransform) -> Self {
        let rows = self.real.chunks_exact_mut(SIDE).zip(self.imaginary.chunks_exact_mut(SIDE));
        for (real, imaginary) in rows {
            transform.apply([real, imaginary]);
        }
        self
    }

    fn transposed(self) -> Self {
        let turned = |part: &[f64]| {
            (0..SIDE * SIDE).map(|number| part[number % SIDE * SIDE + number / SIDE]).collect()
        };
        Self { real: turned(&self.real), imaginary: turned(&self.imaginary) }
    }
}

/// Signed cycles of a row's or column's number.
pub fn signed(frequency: usize) -> f64 {
    if frequency > SIDE / 2 { frequency as f64 - SIDE as f64 } else { frequency as f64 }
}

/// Transform of one row.
struct RowTransform {
    /// Unit phasors of both factors, `[power][cosine, −sine]`.
    waves: [Vec<[f64; 2]>; 2],
    /// Place in a row of each place of the table, row by row.
    from: Vec<usize>,
    /// Frequency of each place of the table.
    to: Vec<usize>,
}

impl RowTransform {
    fn new() -> Self {
        let [first, second] = FACTORS;
        let places = || (0..first).flat_map(move |a| (0..second).map(move |b| (a, b)));
        let wave = |length: usize, power: usize| {
            let angle = power as f64 / length as f64 * TAU;
            [angle.cos(), -angle.sin()]
        };
        Self {
            waves: FACTORS.map(|length| (0..length).map(|power| wave(length, power)).collect()),
            from: places().map(|(a, b)| (second * a + first * b) % SIDE).collect(),
            to: places().filter_map(|(a, b)| (0..SIDE).find(|k| (k % first, k % second) == (a, b))).collect(),
        }
    }

    fn apply(&self, [real, imaginary]: [&mut [f64]; 2]) {
        let [first, second] = FACTORS;
        let table: Vec<[f64; 2]> = self.from.iter().map(|&at| [real[at], imaginary[at]]).collect();

        // Along the table's rows, then along its columns.
        let mut along = Vec::with_capacity(SIDE);
        for row in table.chunks_exact(second) {
            along.extend((0..second).map(|k| self.sum(1, k, |n| row[n])));
        }
        for (place, &to) in self.to.iter().enumerate() {
            let column = place % second;
            let [re, im] = self.sum(0, place / second, |n| along[n * second + column]);
            (real[to], imaginary[to]) = (re, im);
        }
        debug_assert_eq!(self.to.len(), first * second);
    }

    /// Sum of a factor's values times phasors of a frequency.
    fn sum(&self, factor: usize, frequency: usize, value: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
        let length = FACTORS[factor];
        (0..length).fold([0.0; 2], |[re, im], n| {
            let ([a, b], [c, s]) = (value(n), self.waves[factor][n * frequency % length]);
            [re + a * c - b * s, im + a * s + b * c]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::XorPattern;

    #[test]
    fn frequencies_are_those_of_the_definition() {
        let values = XorPattern::seeded(3).cells().values().to_vec();
        let found = Phasors::of_real(values.clone()).frequencies();
        for (column, row) in [(0, 0), (1, 0), (0, 1), (17, 15), (254, 128), (100, 201)] {
            let (mut re, mut im) = (0.0, 0.0);
            for (number, value) in values.iter().enumerate() {
                let turns = (number % SIDE * column + number / SIDE * row) as f64 / SIDE as f64;
                re += value * (turns * TAU).cos();
                im -= value * (turns * TAU).sin();
            }
            let at = row * SIDE + column;
            assert!((found.real[at] - re).abs() < 1e-5 && (found.imaginary[at] - im).abs() < 1e-5);
        }
    }

    #[test]
    fn numbers_come_back_from_their_frequencies() {
        let values = XorPattern::seeded(4).cells().values().to_vec();
        let back = Phasors::of_real(values.clone()).frequencies().of_frequencies();
        let furthest = |found: &[f64], wanted: &dyn Fn(usize) -> f64| {
            found.iter().enumerate().map(|(at, value)| (value - wanted(at)).abs()).fold(0.0, f64::max)
        };
        assert!(furthest(&back.real, &|at| values[at]) < 1e-9);
        assert!(furthest(&back.imaginary, &|_| 0.0) < 1e-9);
    }
}
