//! Smooth positions that fit the fixes of a track.
//!
//! ```text
//! minimise  Σ |x − p|² / σ²  +  S Σ τ |x″|² / Q₂  +  S Σ τ |x‴|² / Q₃     p fixes, x smoothed, τ seconds between fixes
//! Q         ← means of τ |x″|² and τ |x‴|² around                        again and again, from where little is smoothed
//! ```
//!
//! A smoother of differences (Whittaker 1923; Eilers 2003) that is as stiff as the flight is steady, found by reweighting
//! (Candès, Wakin and Boyd 2008). Of a turn of radius A it keeps the share a for which a = 1 / (1 + 2 S σ² / (a A)²): nearly
//! all of what is several σ wide, at whatever speed. What swings by less is noise, and goes; straight flight is averaged
//! over minutes. Q₃ has an upper bound, too: what takes but a few fixes is never flown.

use super::banded::Banded;
use super::noise::noise;
use super::sampling::{Derivatives, Sampling};

/// The longest period, in fix intervals, that numbers of double precision bear.
pub(super) const MOST_INTERVALS: f64 = 600.0;
/// Recordings with longer intervals, in seconds, are waypoints.
const DENSE: f64 = 2.0;
/// Fewer fixes tell no noise from motion.
const ENOUGH: usize = 12;
/// Greatest noise of receivers, metres: what looks like more is flown.
const MOST_NOISE: f64 = 5.0;
/// Farthest that a fix is moved, in its σ.
pub(super) const REACH: f64 = 6.0;
/// S above.
const SHARE: f64 = 0.5;
/// Period of swings, in fix intervals, that lose half where the search begins.
const FIRST: f64 = 6.0;
/// Periods of swings that lose half where nothing but noise is found: seconds, and fix intervals at most.
const LAST: [f64; 2] = [150.0, 600.0];
/// Period of swings that lose half in any case, so that what else is wrong shakes no picture: fix intervals, and seconds at
/// most. Of a turn of 30 m at 12 m/s that takes a thousandth.
const ALWAYS: [f64; 2] = [5.0, 8.0];
/// Half of the stretch that Q is a mean over: seconds, and derivatives at least.
const AROUND: (f64, usize) = (3.0, 6);
/// Rounds of reweighting at most, and the relative change of Q that ends them.
const ROUNDS: usize = 30;
const SETTLED: f64 = 0.01;
/// Greatest weight of a derivative against a fix: more, and rounding shows.
const STIFFEST: f64 = 1.0e13;

/// Takes noise out of the coordinates of dense fixes, metres: `[axis][fix]`. Returns its σ along an axis, metres; `None`
/// where nothing was smoothed.
pub(super) fn without_noise(sampling: &Sampling, axes: &mut [Vec<f64>]) -> Option<f64> {
    let interval = sampling.interval().filter(|interval| *interval <= DENSE)?;
    let sigma = noise(sampling, axes).min(MOST_NOISE);
    if sampling.len() < ENOUGH || sigma == 0.0 {
        return None;
    }

    let fit = TrackFit::new(sampling, interval);
    let last = LAST[0].min(LAST[1] * interval);
    let always = ALWAYS[1].min(ALWAYS[0] * interval);
    let [mut found, least, most] =
        [FIRST * interval, last, always].map(|period| fit.intensities_of(period, sigma));
    let mut smoothed = axes.to_vec();
    for _ in 0..ROUNDS {
        smoothed = fit.smoothed(axes, &found, SHARE * sigma * sigma);
        let before = std::mem::replace(&mut found, fit.intensities(&smoothed, &least));
        found.limit_jerks(SHARE * most.jerks[0]);
        if found.change(&before) < SETTLED {
            break;
        }
    }

    // Along each axis by itself: what is that far off is no longer noise.
    for (fixes, smoothed) in axes.iter_mut().zip(smoothed) {
        for ((fix, smoothed), variance) in fixes.iter_mut().zip(smoothed).zip(sampling.variances()) {
            let reach = REACH * sigma * variance.sqrt();
            *fix += (smoothed - *fix).clamp(-reach, reach);
        }
    }

    Some(sigma)
}

/// Takes out of the coordinates of fixes, metres, `[axis][fix]`, what swings faster than a period, seconds, at most
/// [`MOST_INTERVALS`] of their intervals. Of what swings in just that time it takes half.
pub(super) fn slower_than(period: f64, sampling: &Sampling, axes: &mut [Vec<f64>]) {
    let Some(interval) = sampling.interval() else { return };
    let fit = TrackFit::new(sampling, interval);
    let intensities = Intensities { accelerations: Vec::new(), ..fit.intensities_of(period, 1.0) };
    let smoothed = fit.smoothed(axes, &intensities, 1.0);
    axes.iter_mut().zip(smoothed).for_each(|(fixes, smoothed)| *fixes = smoothed);
}

/// Derivatives of a track that its fit keeps small.
struct TrackFit<'a> {
    sampling: &'a Sampling,
    /// Median interval, seconds.
    interval: f64,
    accelerations: Derivatives<3>,
    jerks: Derivatives<4>,
}

/// Q₂ and Q₃ around each derivative; none for derivatives that may be large.
struct Intensities {
    accelerations: Vec<f64>,
    jerks: Vec<f64>,
}

impl Intensities {
    /// Lets no jerk be more likely than by an intensity.
    fn limit_jerks(&mut self, most: f64) {
        self.jerks.iter_mut().for_each(|jerk| *jerk = jerk.min(most));
    }

    /// Largest relative change against those before.
    fn change(&self, before: &Self) -> f64 {
        let found = self.accelerations.iter().chain(&self.jerks);
        let before = before.accelerations.iter().chain(&before.jerks);
        found.zip(before).map(|(found, before)| (found / before - 1.0).abs()).fold(0.0, f64::max)
    }
}

impl<'a> TrackFit<'a> {
    fn new(sampling: &'a Sampling, interval: f64) -> Self {
        Self {
            sampling,
            interval,
            accelerations: Derivatives::new(sampling),
            jerks: Derivatives::new(sampling),
        }
    }

    /// Intensities by which swings of a period, seconds, lose half of their amplitude, by each kind of derivative alone.
    fn intensities_of(&self, period: f64, sigma: f64) -> Intensities {
        let rate = std::f64::consts::TAU / period;
        let intensity = |power: i32| sigma * sigma * self.interval * rate.powi(power);
        Intensities {
            accelerations: vec![intensity(4); self.accelerations.steps().len()],
            jerks: vec![intensity(6); self.jerks.steps().len()],
        }
    }

    /// Intensities, not below the least, of a smoothed track.
    fn intensities(&self, axes: &[Vec<f64>], least: &Intensities) -> Intensities {
        let around = AROUND.1.max((AROUND.0 / self.interval).ceil() as usize);
        Intensities {
            accelerations: means(&self.accelerations, axes, around, &least.accelerations),
            jerks: means(&self.jerks, axes, around, &least.jerks),
        }
    }

    /// Returns the coordinates, `[axis][fix]`, that minimise the sum; `factor` is S σ².
    fn smoothed(&self, axes: &[Vec<f64>], intensities: &Intensities, factor: f64) -> Vec<Vec<f64>> {
        let accelerations = stiffness(&self.accelerations, &intensities.accelerations, factor);
        let jerks = stiffness(&self.jerks, &intensities.jerks, factor);
        let mut matrix = Banded::diagonal(self.sampling.variances().iter().map(|variance| 1.0 / variance));
        add(&mut matrix, &self.accelerations, &accelerations);
        add(&mut matrix, &self.jerks, &jerks);
        let factors = matrix.factored();

        // Corrections are solved for, which are small, so that a steady flight stays where it is.
        let smoothed = axes.iter().map(|fixes| {
            let mut corrections = vec![0.0; fixes.len()];
            pull(&mut corrections, &self.accelerations, &accelerations, fixes);
            pull(&mut corrections, &self.jerks, &jerks, fixes);
            factors.solve(&mut corrections);
            let corrected = fixes.iter().zip(corrections);
            corrected
                .map(|(fix, correction)| if correction.is_finite() { fix + correction } else { *fix })
                .collect()
        });
        smoothed.collect()
    }
}

/// Means of the squares of derivatives over so many to either side, times their intervals.
fn means<const N: usize>(
    derivatives: &Derivatives<N>,
    axes: &[Vec<f64>],
    around: usize,
    least: &[f64],
) -> Vec<f64> {
    let count = derivatives.steps().len();
    let mut squares = vec![0.0; count];
    for fixes in axes {
        squares.iter_mut().zip(derivatives.of(fixes)).for_each(|(square, value)| *square += value * value);
    }
    let mut sums = vec![0.0; count + 1];
    for (at, (step, square)) in derivatives.steps().iter().zip(&squares).enumerate() {
        sums[at + 1] = sums[at] + step * square;
    }

    let mean = |at: usize| {
        let (first, end) = (at.saturating_sub(around), (at + around + 1).min(count));
        ((sums[end] - sums[first]) / (end - first) as f64).max(least[at])
    };
    (0..count).map(mean).collect()
}

/// Weights of the squares of derivatives in the sum that is minimised, where that of the usual fix is 1.
fn stiffness<const N: usize>(derivatives: &Derivatives<N>, intensities: &[f64], factor: f64) -> Vec<f64> {
    let of = |((step, weights), intensity): ((&f64, &[f64; N]), &f64)| {
        let square: f64 = weights.iter().map(|weight| weight * weight).sum();
        (factor * step / intensity).min(STIFFEST / square)
    };
    derivatives.steps().iter().zip(derivatives.weights()).zip(intensities).map(of).collect()
}

/// Adds the squares of derivatives to a matrix.
fn add<const N: usize>(matrix: &mut Banded, derivatives: &Derivatives<N>, stiffness: &[f64]) {
    for (first, (weights, stiffness)) in derivatives.weights().iter().zip(stiffness).enumerate() {
        matrix.add_square(first, weights, *stiffness);
    }
}

/// Adds the force by which stiff derivatives pull each fix.
fn pull<const N: usize>(forces: &mut [f64], derivatives: &Derivatives<N>, stiffness: &[f64], fixes: &[f64]) {
    let weights = derivatives.weights().iter().zip(stiffness);
    for (first, ((weights, stiffness), value)) in weights.zip(derivatives.of(fixes)).enumerate() {
        for (force, weight) in forces[first..].iter_mut().zip(weights) {
            *force -= stiffness * value * weight;
        }
    }
}

#[cfg(test)]
mod tests;
