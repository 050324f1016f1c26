//! Takes the jitter of a receiver out of recorded fixes.
//!
//! For each fix: a parabola in time, fitted by weighted least squares to the fixes within three σ (Gaussian weights;
//! Savitzky and Golay 1964 for uneven times). A parabola keeps turns and accelerations; σ of one and a half fix intervals
//! leaves of white noise about half. No fix moves by more than [`REACH`], so that a corner that was really flown stays.

use glam::{DMat3, DVec3};

/// Farthest that a fix is moved, metres: what a receiver errs from one second to the next.
const REACH: f64 = 3.0;
/// Recordings with longer intervals, in seconds, are waypoints and stay as they are.
const DENSE: f64 = 2.0;
/// Standard deviation of the weights, in fix intervals.
const SIGMA_INTERVALS: f64 = 1.5;
/// Fewer fixes lie on a parabola anyway.
const ENOUGH: usize = 4;
/// On each side of a fix; evenly spaced, five lie within three σ.
const MOST_NEIGHBOURS: usize = 32;

/// Median interval, seconds; `None` for a single fix.
pub(super) fn median_interval(times: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    (!steps.is_empty()).then(|| *steps.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Smoothed positions, if the fixes are dense and enough; `interval` is their median interval, seconds.
pub(super) fn smoothed(times: &[f64], points: &[DVec3], interval: f64) -> Option<Vec<DVec3>> {
    if interval > DENSE || points.len() < ENOUGH {
        return None;
    }
    let sigma = SIGMA_INTERVALS * interval;
    Some((0..points.len()).map(|index| smoothed_fix(times, points, index, sigma)).collect())
}

fn smoothed_fix(times: &[f64], points: &[DVec3], index: usize, sigma: f64) -> DVec3 {
    let (time, point) = (times[index], points[index]);
    let first =
        times.partition_point(|&other| other < time - 3.0 * sigma).max(index.saturating_sub(MOST_NEIGHBOURS));
    let end = times.partition_point(|&other| other <= time + 3.0 * sigma).min(index + MOST_NEIGHBOURS);
    if end - first < ENOUGH {
        return point;
    }

    // Normal equations of Σ w (c0 + c1 u + c2 u² − p)² with p relative to the fix itself.
    let mut moments = [0.0; 5];
    let mut sums = [DVec3::ZERO; 3];
    for (&other, &position) in times[first..end].iter().zip(&points[first..end]) {
        let u = (other - time) / sigma;
        let mut power = (-0.5 * u * u).exp();
        for (degree, moment) in moments.iter_mut().enumerate() {
            *moment += power;
            if let Some(sum) = sums.get_mut(degree) {
                *sum += power * (position - point);
            }
            power *= u;
        }
    }

    let [m0, m1, m2, m3, m4] = moments;
    let normal = DMat3::from_cols_array(&[m0, m1, m2, m1, m2, m3, m2, m3, m4]);
    let solve = normal.inverse().x_axis; // the matrix is symmetric: first column = first row
    let shift = sums[0] * solve.x + sums[1] * solve.y + sums[2] * solve.z;

    if shift.is_finite() { point + shift.clamp_length_max(REACH) } else { point }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_stays_and_noise_shrinks() {
        let times: Vec<f64> = (0..60).map(|i| f64::from(i) + 0.1 * f64::from(i % 3)).collect();
        let truth = |t: f64| DVec3::new(4e5 + 30.0 * t, 5e6 + 0.5 * t * t, 200.0 - 0.1 * t * t);
        let exact: Vec<DVec3> = times.iter().map(|&t| truth(t)).collect();
        for (before, after) in exact.iter().zip(smoothed(&times, &exact, 1.0).unwrap()) {
            assert!((*before - after).length() < 1e-6);
        }
        let noise = |i: usize| 2.0 * (((i * 7919) % 101) as f64 / 50.0 - 1.0);
        let noisy: Vec<DVec3> = exact
            .iter()
            .enumerate()
            .map(|(i, &p)| p + DVec3::new(noise(i), noise(i + 31), noise(i + 57)))
            .collect();
        let error = |points: &[DVec3]| {
            points.iter().zip(&exact).map(|(a, b)| (*a - *b).length_squared()).sum::<f64>().sqrt()
        };
        let (raw, fitted) = (error(&noisy), error(&smoothed(&times, &noisy, 1.0).unwrap()));
        assert!(fitted < 0.75 * raw, "{fitted} of {raw}");
    }

    #[test]
    fn waypoints_and_corners_stay() {
        let far: Vec<f64> = (0..10).map(|i| 30.0 * f64::from(i)).collect();
        assert!(smoothed(&far, &vec![DVec3::ZERO; 10], 30.0).is_none());
        let times: Vec<f64> = (0..21).map(f64::from).collect();
        let corner: Vec<DVec3> =
            times.iter().map(|&t| DVec3::new(50.0 * t.min(10.0), 50.0 * (t - 10.0).max(0.0), 0.0)).collect();
        for (before, after) in corner.iter().zip(smoothed(&times, &corner, 1.0).unwrap()) {
            assert!((*before - after).length() <= REACH * (1.0 + 1e-12));
        }
    }
}
