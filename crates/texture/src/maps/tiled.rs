//! Ground maps that repeat after 255 cells, for tiles.
//!
//! ```text
//! axis k: u = a_k·x + b_k·y mod 255, a_k and b_k whole numbers        about 30° apart, 5 units to a cell
//! tone  = Σ table_k(⌊u/5⌋)                                           51 zones, about a cell wide
//! cell  = mean of 4 × 4 samples
//! ```
//!
//! Angles are only near those of [`super::SixMaps`], and where the ridges of two maps meet within the tile it
//! resembles itself: correlations of single shifts reach 0.6.

use std::f64::consts::TAU;

use hedgehop_base::chance::Random;

use super::quantity::{LinearFunction, QuantityMode, QuantityTexture};
use crate::cells::{Cells, SIDE};

/// Units along each axis for each cell along x and y.
const AXES: [[i64; 2]; 6] = [[5, 1], [4, 3], [2, 5], [-1, 5], [-3, 4], [-5, 2]];

/// Units of a zone.
const ZONE_UNITS: f64 = 5.0;

/// Waves of each quantity along x and y of a tile: shorter than a voxel, so that its mean leaves them.
const QUANTITY_WAVES: [[i64; 2]; 3] = [[23, 4], [-5, 22], [13, -19]];

/// Values of sawteeth, which repeat.
const QUANTITY_RANGE: f64 = 1024.0;

/// Strength of a sinusoid to that of the maps beside it.
const WAVE_BOOST: f64 = 16.0;

/// Samples along a cell's side.
const SAMPLES: i64 = 4;

/// Six maps of tones by chance.
pub fn tiled_maps(seed: u64) -> Cells {
    let mut random = Random::stream(seed, 6);
    let zones = SIDE / ZONE_UNITS as usize;
    let tables = AXES.map(|_| (0..zones).map(|_| random.unit() - 0.5).collect::<Vec<f64>>());
    sampled(|x, y| {
        let map = |(table, [a, b]): (&Vec<f64>, [i64; 2])| {
            let units = (a as f64 * x + b as f64 * y).rem_euclid(SIDE as f64);
            table[(units / ZONE_UNITS) as usize % zones]
        };
        tables.iter().zip(AXES).map(map).sum()
    })
}

/// Waves a number of cells apart, 2 to 127, with a little of the maps.
pub fn tiled_waves(wavelength: f64, seed: u64) -> Cells {
    let across = tiled_wave_vector(wavelength);
    let wave = sampled(|x, y| (TAU * (across[0] as f64 * x + across[1] as f64 * y) / SIDE as f64).sin());
    let maps = tiled_maps(seed);
    let (of_wave, of_maps) = (WAVE_BOOST / wave.deviation(), 1.0 / maps.deviation());
    wave.joined(&maps, |wave, map| of_wave * wave + of_maps * map)
}

/// Whole waves along x and y of a tile whose length is nearest to a number of cells; not along an axis, which
/// would leave nothing.
pub fn tiled_wave_vector(wavelength: f64) -> [i64; 2] {
    let waves = SIDE as f64 / wavelength;
    // About 1 : 4, so that crests run across columns.
    let up = (waves * 0.24).round().max(1.0);
    let along = (waves * waves - up * up).max(1.0).sqrt().round();
    [along as i64, up as i64]
}

/// Quantities of a mode; a seed moves them.
pub fn tiled_quantity(mode: QuantityMode, seed: u64) -> Cells {
    let mut random = Random::stream(seed, 16);
    let functions = QUANTITY_WAVES.map(|waves| {
        let [x, y] = waves.map(|waves| waves as f64 * QUANTITY_RANGE / SIDE as f64);
        LinearFunction { x, y, offset: (random.unit() * QUANTITY_RANGE).floor() }
    });
    let memory = std::array::from_fn(|_| random.unit());
    let texture = QuantityTexture { functions, threshold: 255, memory };
    sampled(|x, y| texture.tones(mode, x, y).iter().sum::<f64>() / 3.0)
}

/// Means over cells of a function of the ground.
fn sampled(tone: impl Fn(f64, f64) -> f64) -> Cells {
    let within = |cell: i64, sample: i64| cell as f64 + (sample as f64 + 0.5) / SAMPLES as f64;
    Cells::of(|column, row| {
        let samples = (0..SAMPLES * SAMPLES)
            .map(|number| tone(within(column, number % SAMPLES), within(row, number / SAMPLES)));
        samples.sum::<f64>() / (SAMPLES * SAMPLES) as f64
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Spectrum;

    #[test]
    fn waves_of_a_tile_peak_at_their_wavelength() {
        for wavelength in [4.0, 6.0, 9.5, 20.0] {
            let spectrum = Spectrum::of(&tiled_waves(wavelength, 3));
            let mut peak = (0.0, 0.0);
            for (row, column) in (-127..=127).flat_map(|row| (0..=127).map(move |column| (row, column))) {
                let power = spectrum.power(column, row);
                if power > peak.0 {
                    peak = (power, SIDE as f64 / (column as f64).hypot(row as f64));
                }
            }
            assert!((peak.1 / wavelength - 1.0).abs() < 0.05, "{} for {wavelength}", peak.1);
        }
    }

    #[test]
    fn maps_of_a_tile_repeat_and_resemble_themselves_little() {
        let spectrum = Spectrum::of(&tiled_maps(1));
        let worst = spectrum.worst_correlation_beyond(8.0);
        assert!(worst < 0.6, "{worst}");
        let correlations = spectrum.correlations();
        let high = correlations.iter().filter(|value| value.abs() > 0.2).count();
        assert!(high < 65_025 / 20, "{high} shifts above a fifth");
    }

    #[test]
    fn functions_of_quantities_repeat_with_the_tile() {
        for mode in [QuantityMode::Sawtooth, QuantityMode::StripesXor, QuantityMode::SawtoothOfSum] {
            let cells = tiled_quantity(mode, 2);
            // Neighbours across the seam are as alike as elsewhere.
            let jumps = |column: i64| {
                (0..255).map(|row| (cells.at(column, row) - cells.at(column + 1, row)).powi(2)).sum::<f64>()
            };
            let inside = (0..254).map(jumps).fold(0.0, f64::max);
            assert!(jumps(254) <= 1.2 * inside, "{mode:?}");
        }
    }
}
