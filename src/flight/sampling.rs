//! Times and accuracies of a track's fixes, and derivatives between them.

use super::track::Fix;

/// Interval, in median ones, from which on nothing is told about the flight between two fixes.
const GAP: f64 = 10.0;
/// Range of the errors of fixes against the usual one.
const UNSURE: [f64; 2] = [0.25, 20.0];

/// Times and accuracies of the fixes of a track.
#[derive(Debug, Clone)]
pub(super) struct Sampling {
    /// Seconds, increasing.
    times: Vec<f64>,
    /// Variance of each fix, where that of the usual one is 1.
    variances: Vec<f64>,
    /// Median interval, seconds; `None` for a single fix.
    interval: Option<f64>,
}

impl Sampling {
    pub fn new(fixes: &[Fix]) -> Self {
        let usual = median(fixes.iter().filter_map(|fix| fix.accuracy).filter(|accuracy| *accuracy > 0.0));
        let variance = |fix: &Fix| {
            let share = fix.accuracy.zip(usual).map_or(1.0, |(accuracy, usual)| accuracy / usual);
            share.clamp(UNSURE[0], UNSURE[1]).powi(2)
        };
        Self::of(fixes.iter().map(|fix| fix.time).collect(), fixes.iter().map(variance).collect())
    }

    fn of(times: Vec<f64>, variances: Vec<f64>) -> Self {
        let interval = median(times.windows(2).map(|pair| pair[1] - pair[0]));
        Self { times, variances, interval }
    }

    /// Every second, third … of the fixes, from the first on.
    pub fn every(&self, stride: usize) -> Self {
        let every = |values: &[f64]| values.iter().copied().step_by(stride).collect();
        Self::of(every(&self.times), every(&self.variances))
    }

    /// Variance of each fix, where that of the usual one is 1.
    pub fn variances(&self) -> &[f64] {
        &self.variances
    }

    /// Median interval, seconds; `None` for a single fix.
    pub fn interval(&self) -> Option<f64> {
        self.interval
    }

    /// Number of fixes.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    fn has_gap(&self, times: &[f64]) -> bool {
        let longest = self.interval.map_or(f64::INFINITY, |interval| GAP * interval);
        times.windows(2).any(|pair| pair[1] - pair[0] > longest)
    }
}

/// Median of values that are finite; `None` without any.
pub(super) fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    quantile(values.collect(), 0.5)
}

/// Value that a share of all, 0 to 1, is below; `None` without any.
pub(super) fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    let at = ((share * values.len() as f64) as usize).min(values.len().checked_sub(1)?);
    Some(*values.select_nth_unstable_by(at, f64::total_cmp).1)
}

/// Derivatives of order N − 1, each of a parabola or its like through N fixes at uneven times.
pub(super) struct Derivatives<const N: usize> {
    /// Weights of the fixes in each derivative, 1/s to the order's power.
    weights: Vec<[f64; N]>,
    /// Mean interval of the fixes of each, seconds; 0 across a gap.
    steps: Vec<f64>,
}

impl<const N: usize> Derivatives<N> {
    pub fn new(sampling: &Sampling) -> Self {
        let factorial: f64 = (1..N).map(|factor| factor as f64).product();
        let weights = |times: &[f64]| {
            std::array::from_fn(|fix| {
                let others = (0..N).filter(|other| *other != fix);
                factorial / others.map(|other| times[fix] - times[other]).product::<f64>()
            })
        };
        let step = |times: &[f64]| {
            if sampling.has_gap(times) { 0.0 } else { (times[N - 1] - times[0]) / (N - 1) as f64 }
        };
        Self {
            weights: sampling.times.windows(N).map(weights).collect(),
            steps: sampling.times.windows(N).map(step).collect(),
        }
    }

    /// Weights of the fixes in each derivative, from the first of its fixes on.
    pub fn weights(&self) -> &[[f64; N]] {
        &self.weights
    }

    /// Mean interval of the fixes of each, seconds; 0 across a gap.
    pub fn steps(&self) -> &[f64] {
        &self.steps
    }

    /// Returns the derivatives of the coordinates of all fixes along an axis.
    pub fn of<'a>(&'a self, fixes: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        // From a fix near by, so that large coordinates lose nothing and those that are equal give 0.
        let derivative = |(weights, fixes): (&[f64; N], &[f64])| {
            weights.iter().zip(fixes).map(|(weight, fix)| weight * (fix - fixes[0])).sum()
        };
        self.weights.iter().zip(fixes.windows(N)).map(derivative)
    }
}
