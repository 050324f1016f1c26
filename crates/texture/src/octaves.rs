//! Octaves of a pattern, each as strong as the next.
//!
//! ```text
//! band k = smoothed over 2^k cells − smoothed over 2^(k + 1) cells      of a pattern of its own, at unit deviation
//! sum of all bands
//! ```
//!
//! Pictures of real ground hold about as much in one octave as in the next, so that hidden octaves go on
//! flat.

use crate::cells::{Cells, SIDE};

/// Sum of one octave of each pattern, finest first, all equally strong: a spectrum that is flat per octave.
///
/// The k-th of the patterns, which are best white and must not depend on each other, gives wavelengths of
/// 2^(k + 1) to 2^(k + 2) cells. What is constant or longer than the tile gives nothing.
pub fn broad_band(patterns: &[Cells]) -> Cells {
    let mut sum = Cells::of(|_, _| 0.0);
    for (number, pattern) in patterns.iter().enumerate() {
        let side = 1_usize << number.min(8);
        if 2 * side >= SIDE {
            break;
        }

        let band = octave(pattern, side);
        let deviation = band.deviation();
        if deviation > 0.0 {
            sum = sum.joined(&band, |sum, value| sum + value / deviation);
        }
    }
    sum
}

/// One octave of a pattern: wavelengths of 2 to 4 times `side` cells.
pub fn octave(pattern: &Cells, side: usize) -> Cells {
    smoothed(pattern, side).joined(&smoothed(pattern, 2 * side), |fine, coarse| fine - coarse)
}

/// Gives cells back what a cubic between pixels of `side` cells has taken from waves of two to four pixels.
///
/// The cubic of Catmull and Rom leaves 0.49, 0.84 and 0.94 of waves of two, three and four pixels; with the
/// difference from two smoothings over a pixel added, they have 0.79, 1.10 and 1.12.
pub fn sharpened(cells: &Cells, side: usize) -> Cells {
    if !(2..=SIDE / 2).contains(&side) {
        return cells.clone();
    }
    cells.joined(&smoothed(cells, side), |value, smooth| 2.0 * value - smooth)
}

/// Means over squares of `side` cells, twice in opposite directions: about each cell's own centre, and
/// rounder than squares.
fn smoothed(pattern: &Cells, side: usize) -> Cells {
    let twice = pattern.averaged(side).averaged(side);
    let back = side as i64 - 1;
    Cells::of(|column, row| twice.at(column - back, row - back))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::XorPattern;
    use crate::spectrum::Spectrum;

    #[test]
    fn waves_of_few_pixels_come_back() {
        // Pixels of 5 cells; waves of 15, 51 and 255 cells along columns.
        let wave = |count: f64| {
            Cells::of(|column, _| (column as f64 * count * std::f64::consts::TAU / SIDE as f64).cos())
        };
        let gains =
            [17.0, 5.0, 1.0].map(|count| sharpened(&wave(count), 5).deviation() / wave(count).deviation());
        let cubic = [0.838, 0.998, 1.0];
        for (gain, cubic) in gains.into_iter().zip(cubic) {
            assert!((0.99..1.12).contains(&(gain * cubic)), "{gains:?}");
        }
        assert_eq!(sharpened(&wave(5.0), 1), wave(5.0));
    }

    #[test]
    fn octaves_are_equally_strong_and_have_no_direction() {
        let patterns: Vec<Cells> = (0..5).map(|seed| XorPattern::seeded(seed).cells()).collect();
        let spectrum = Spectrum::of(&broad_band(&patterns));

        // An octave down has a quarter of the frequencies, so that its density is four times as great.
        let densities = spectrum.octave_densities();
        for pair in densities.windows(2) {
            let step = 10.0 * (pair[1] / pair[0] / 4.0).log10();
            assert!(step.abs() < 1.0, "{step} dB an octave: {densities:?}");
        }
        let spreads = spectrum.sector_spreads_db();
        assert!(spreads.iter().all(|&spread| spread < 2.0) && spreads[1] < 1.0, "{spreads:?} dB");
    }
}
