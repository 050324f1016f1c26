//! Power of a pattern by frequency, direction and shift, for tests.

use crate::cells::{Cells, SIDE};
use crate::fourier::{Phasors, signed};

/// Octaves that are told apart, finest first: ¼ to ½ cycle a cell, and so on.
const OCTAVES: usize = 4;

/// Power of each of 255 × 255 frequencies, cycles along columns and rows, without the mean.
pub struct Spectrum {
    power: Vec<f64>,
}

impl Spectrum {
    pub fn of(cells: &Cells) -> Self {
        let mean = cells.mean();
        let values = cells.values().iter().map(|value| value - mean).collect();
        let Phasors { real, imaginary } = Phasors::of_real(values).frequencies();
        Self { power: real.iter().zip(&imaginary).map(|(re, im)| re * re + im * im).collect() }
    }

    /// Power at a frequency, cycles of the pattern's side along columns and rows.
    pub fn power(&self, column: i64, row: i64) -> f64 {
        let side = SIDE as i64;
        self.power[row.rem_euclid(side) as usize * SIDE + column.rem_euclid(side) as usize]
    }

    /// Mean power of each octave as a share of that of white noise.
    pub fn octave_densities(&self) -> [f64; OCTAVES] {
        let total: f64 = self.power.iter().sum::<f64>() / (SIDE * SIDE - 1) as f64;
        std::array::from_fn(|octave| mean(self.of_octave(octave).map(|(_, power)| power)) / total)
    }

    /// Greatest ratio of mean powers of two of eight sectors of directions, in each octave, dB.
    pub fn sector_spreads_db(&self) -> [f64; OCTAVES] {
        let spread = |octave| {
            let sector = |number: u32| {
                let range = f64::from(number) * 22.5..f64::from(number + 1) * 22.5;
                mean(
                    self.of_octave(octave)
                        .filter(|(turned, _)| range.contains(turned))
                        .map(|(_, power)| power),
                )
            };
            let powers: Vec<f64> = (0..8).map(sector).collect();
            let most = powers.iter().copied().fold(0.0, f64::max);
            let least = powers.iter().copied().fold(f64::INFINITY, f64::min);
            10.0 * (most / least.max(most * 1e-12)).log10()
        };
        std::array::from_fn(spread)
    }

    /// Correlation of the pattern with itself, shifted by whole cells, row by row.
    pub fn correlations(&self) -> Vec<f64> {
        let real = Phasors::of_real(self.power.clone()).frequencies().real;
        real.iter().map(|value| value / real[0]).collect()
    }

    /// Greatest correlation of the pattern with itself, shifted by at least `cells` and at most half its
    /// side.
    pub fn worst_correlation_beyond(&self, cells: f64) -> f64 {
        let shift = |place: usize| place.min(SIDE - place) as f64;
        let far = |number: usize| shift(number % SIDE).hypot(shift(number / SIDE)) >= cells;
        let correlations = self.correlations();
        correlations
            .iter()
            .enumerate()
            .filter(|&(number, _)| far(number))
            .fold(0.0, |worst, (_, value)| worst.max(value.abs()))
    }

    /// Directions, degrees 0 to 180, and powers of an octave's frequencies.
    fn of_octave(&self, octave: usize) -> impl Iterator<Item = (f64, f64)> {
        let range = 0.5_f64.powi(octave as i32 + 2)..0.5_f64.powi(octave as i32 + 1);
        self.power.iter().enumerate().filter_map(move |(number, &power)| {
            let (x, y) = (signed(number % SIDE) / SIDE as f64, signed(number / SIDE) / SIDE as f64);
            range.contains(&x.hypot(y)).then(|| (y.atan2(x).to_degrees().rem_euclid(180.0), power))
        })
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}
