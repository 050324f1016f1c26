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
    for (octave, pattern) in patterns.iter().enumerate() {
        let side = 1_usize << octave.min(8);
        if 2 * side >= SIDE {
            break;
        }

        let band = smoothed(pattern, side).joined(&smoothed(pattern, 2 * side), |fine, coarse| fine - coarse);

        let deviation = band.deviation();
        if deviation > 0.0 {
            sum = sum.joined(&band, |sum, value| sum + value / deviation);
        }
    }
    sum
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
