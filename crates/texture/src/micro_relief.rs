//! MicroRelief whose slopes vary as a pattern does, and how the sun lights it.
//!
//! ```text
//! h(k) = d(k) / |k|                                    what is bright stands out
//! −∂h/∂s = −i (k·s / |k|) d(k)                         s: towards the sun
//! lit = cos φ · d − sin φ · √2 · ∂h/∂s                 in octaves as strong as those of d
//!
//! heights = h of waves no longer than a voxel          tops and hollows rounded, mean 0 over each voxel
//! ```
//!
//! A slope along one direction has, of a pattern without direction, half of its power in every octave: hence √2. Where the sun stands low, the light of a
//! rough surface is its slope towards it (Kube and Pentland 1988, *On the imaging of fractal surfaces*).

use std::f64::consts::TAU;

use crate::cells::{Cells, SIDE};
use crate::fourier::{Phasors, signed};
use crate::tile::CELLS_PER_VOXEL;

/// Cycles of the side of waves that are as long as a voxel.
const PER_VOXEL: f64 = (SIDE / CELLS_PER_VOXEL) as f64;

/// Standard deviations of height at which tops and hollows are rounded off.
const ROUND: f64 = 1.5;

/// A pattern, and the slopes of relief that is as rough.
#[derive(Debug, Clone, PartialEq)]
pub struct MicroRelief {
    pattern: Cells,
    /// Fall of the surface eastward and northward, as strong as the pattern in every octave.
    falls: [Cells; 2],
}

impl MicroRelief {
    /// Finds the relief of a pattern, whose mean counts for nothing.
    pub fn new(pattern: Cells) -> Self {
        let mut waves = Phasors::of_real(pattern.values().to_vec()).frequencies();
        for (at, (re, im)) in waves.real.iter_mut().zip(&mut waves.imaginary).enumerate() {
            let [x, y] = [at % SIDE, at / SIDE].map(signed);
            let length = x.hypot(y);
            if length == 0.0 {
                (*re, *im) = (0.0, 0.0);
                continue;
            }
            // Falls are real: the eastward ones in the real part, the northward ones in the imaginary part; −i (x + i y) / |k| = (y − i x) / |k|.
            let [a, b] = [y, -x].map(|part| std::f64::consts::SQRT_2 * part / length);
            (*re, *im) = (*re * a - *im * b, *re * b + *im * a);
        }

        let Phasors { real, imaginary } = waves.of_frequencies();
        Self { pattern, falls: [cells(&real), cells(&imaginary)] }
    }

    /// Heights of the surface in waves no longer than a voxel: mean 0 over each of its voxels, without a step where they meet.
    pub fn heights(&self) -> Cells {
        let mut waves = Phasors::of_real(self.pattern.values().to_vec()).frequencies();
        for (at, (re, im)) in waves.real.iter_mut().zip(&mut waves.imaginary).enumerate() {
            let [x, y] = [at % SIDE, at / SIDE].map(signed);
            let length = x.hypot(y);
            // Means of whole rows and columns are left out, too.
            let share = if length < PER_VOXEL || x == 0.0 || y == 0.0 { 0.0 } else { PER_VOXEL / length };
            (*re, *im) = (*re * share, *im * share);
        }
        let heights = cells(&waves.of_frequencies().real);

        let unit = (ROUND * heights.deviation()).recip();
        let rounded = heights.joined(&heights, |height, _| (unit * height).tanh());

        // A bump over each voxel, which is 0 at its edges, takes the mean that rounding left.
        let means = rounded.averaged(CELLS_PER_VOXEL);
        Cells::of(|column, row| {
            let [x, y] = [column, row].map(|at| at % CELLS_PER_VOXEL as i64);
            let bump = [x, y].map(|at| 1.0 - ((at as f64 + 0.5) / CELLS_PER_VOXEL as f64 * TAU).cos());
            rounded.at(column, row) - means.at(column - x, row - y) * bump[0] * bump[1]
        })
    }

    /// The pattern itself.
    pub fn pattern(&self) -> &Cells {
        &self.pattern
    }

    /// The pattern under a lamp towards `direction` (east, north; its length does not count), of whose light relief changes so much, radians: 0 for none, π/2 for
    /// relief alone.
    pub fn lit(&self, direction: [f64; 2], share: f64) -> Cells {
        let length = direction[0].hypot(direction[1]).max(f64::MIN_POSITIVE);
        let (sin, cos) = share.sin_cos();
        let [east, north] = direction.map(|part| sin * part / length);
        let [eastward, northward] = &self.falls;
        let fall = eastward.joined(northward, |x, y| east * x + north * y);
        self.pattern.joined(&fall, |value, fall| cos * value + fall)
    }
}

/// Cells of such values, row by row.
fn cells(values: &[f64]) -> Cells {
    Cells::of(|column, row| values[row as usize * SIDE + column as usize])
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, SQRT_2};

    use super::*;
    use crate::octaves::broad_band;
    use crate::pattern::XorPattern;
    use crate::spectrum::Spectrum;

    /// A wave of so many cycles eastward and northward, at a phase.
    fn wave([x, y]: [f64; 2], phase: f64) -> Cells {
        Cells::of(|column, row| ((x * column as f64 + y * row as f64) / SIDE as f64 * TAU + phase).cos())
    }

    fn furthest(one: &Cells, other: &Cells) -> f64 {
        one.values().iter().zip(other.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn waves_are_bright_on_the_side_of_the_sun() {
        // The crest of cos x falls eastward on its eastern side, where sin x is bright.
        for cycles in [[7.0, 0.0], [0.0, 7.0], [5.0, -12.0]] {
            let relief = MicroRelief::new(wave(cycles, 0.0));
            let length = f64::hypot(cycles[0], cycles[1]);
            let lit = relief.lit(cycles, FRAC_PI_2);
            let expected = wave(cycles, -FRAC_PI_2);
            assert!(furthest(&lit, &expected.joined(&expected, |a, _| SQRT_2 * a)) < 1e-9, "{cycles:?}");
            // Sunlight along the crests shows nothing.
            let along = relief.lit([-cycles[1] / length, cycles[0] / length], FRAC_PI_2);
            assert!(along.deviation() < 1e-9);
            // Overhead it shows the pattern.
            assert_eq!(furthest(&relief.lit(cycles, 0.0), relief.pattern()), 0.0);
        }
    }

    #[test]
    fn octaves_stay_as_strong_under_any_sun() {
        let octaves: Vec<Cells> = (0..4).map(|seed| XorPattern::seeded(seed).cells()).collect();
        let pattern = broad_band(&octaves);
        let relief = MicroRelief::new(pattern.clone());
        let before = Spectrum::of(&pattern).octave_densities();
        for degrees in (0..360).step_by(45) {
            let azimuth = f64::from(degrees).to_radians();
            let lit = relief.lit([azimuth.sin(), azimuth.cos()], 0.6);
            assert!((lit.deviation() / pattern.deviation() - 1.0).abs() < 0.03);
            for (now, then) in Spectrum::of(&lit).octave_densities().into_iter().zip(before) {
                assert!((10.0 * (now / then).log10()).abs() < 0.6, "{degrees}°: {now} for {then}");
            }
        }
    }

    #[test]
    fn heights_keep_means_of_voxels_without_steps_between_them() {
        let octaves: Vec<Cells> = (0..4).map(|seed| XorPattern::seeded(seed).cells()).collect();
        let heights = MicroRelief::new(broad_band(&octaves)).heights();
        let voxels = heights.averaged(CELLS_PER_VOXEL);
        let side = CELLS_PER_VOXEL as i64;
        for (column, row) in (0..17).flat_map(|column| (0..17).map(move |row| (column * side, row * side))) {
            assert!(voxels.at(column, row).abs() < 1e-9);
        }

        // From a voxel to the next heights differ by no more than within one.
        let change = |is_edge: bool| {
            let places = (0..SIDE as i64).flat_map(|row| (0..SIDE as i64).map(move |column| (column, row)));
            let own = places.filter(|(column, _)| (column % side == side - 1) == is_edge);
            let squares = own.map(|(x, y)| (heights.at(x + 1, y) - heights.at(x, y)).powi(2));
            let (sum, count) = squares.fold((0.0, 0.0), |(sum, count), square| (sum + square, count + 1.0));
            f64::sqrt(sum / count)
        };
        assert!((change(true) / change(false) - 1.0).abs() < 0.1, "{} {}", change(true), change(false));

        // No peak is more than thrice the deviation.
        let peak = heights.values().iter().fold(0.0_f64, |peak, height| peak.max(height.abs()));
        assert!(peak < 3.0 * heights.deviation(), "{}", peak / heights.deviation());
    }
}
