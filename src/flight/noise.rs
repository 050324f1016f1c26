//! Size of a receiver's noise, as the fixes of a track tell it.
//!
//! What flies is smooth from one fix to the next and noise is not: of both, the ninth difference of fixes leaves noise and
//! next to nothing of motion. Its size is a quantile, which corners and outliers do not move. Receivers smooth what they
//! write: differences of every second fix tell of noise that lasts, too; what is far more is motion.

use super::sampling::{Derivatives, Sampling, quantile};

/// Share of normally distributed values that are nearer to the mean than a standard deviation.
const WITHIN_SIGMA: f64 = 0.6827;
/// Share of differences that must tell something: a receiver that stands writes the same place again and again.
const TELLING: f64 = 0.15;
/// Least noise, metres: less shakes no picture.
const LEAST: f64 = 0.02;
/// Noise that lasts longer than from one fix to the next, against that which does not.
const LASTING: f64 = 2.5;

/// Returns the standard deviation of the usual fix along an axis, metres, of coordinates `[axis][fix]`; 0 where the fixes
/// tell none, or next to none.
pub(super) fn noise(sampling: &Sampling, axes: &[Vec<f64>]) -> f64 {
    let quick = noise_between(sampling, axes);
    if quick < LEAST {
        return 0.0;
    }
    let halves: Vec<Vec<f64>> = axes.iter().map(|fixes| fixes.iter().copied().step_by(2).collect()).collect();
    noise_between(&sampling.every(2), &halves).clamp(quick, LASTING * quick)
}

/// Noise that lasts from one fix to the next.
fn noise_between(sampling: &Sampling, axes: &[Vec<f64>]) -> f64 {
    let differences = Derivatives::<10>::new(sampling);
    let length = |(weights, variances): (&[f64; 10], &[f64])| {
        let squares = weights.iter().zip(variances).map(|(weight, variance)| weight * weight * variance);
        squares.sum::<f64>().sqrt()
    };
    let fixes = differences.weights().iter().zip(sampling.variances().windows(10));
    let lengths: Vec<f64> = fixes.map(length).collect();

    let is_within = |at: &usize| differences.steps()[*at] > 0.0;
    let within = (0..lengths.len()).filter(is_within).count() * axes.len();
    let mut telling = Vec::with_capacity(within);
    for fixes in axes {
        let moves = |at: &usize| fixes[*at..*at + 10].windows(2).any(|pair| pair[0] != pair[1]);
        let values: Vec<f64> = differences.of(fixes).collect();
        let told = (0..lengths.len()).filter(is_within).filter(moves);
        telling.extend(told.map(|at| (values[at] / lengths[at]).abs()));
    }

    if (telling.len() as f64) < TELLING * within as f64 {
        return 0.0;
    }
    quantile(telling, WITHIN_SIGMA).unwrap_or(0.0)
}
