//! Keeps a flight above the ground between its fixes.
//!
//! ```text
//! subdivide the path, at most SPACING apart
//! lift(t)  = max(0, ground(t) + least height(t) − z(t)), and as much as at the two neighbours
//! lift'(t) = mean over ±EASE of (max over ±EASE of lift)
//! ```
//!
//! The mean of a sliding maximum of the same width is nowhere below the function itself (each maximum that is averaged
//! has seen it), so the flight clears the ground and still rises and sinks gently. The least height is the clearance that
//! the user asks for, and between two fixes above ground the height above ground interpolated between them.

use std::collections::VecDeque;
use std::ops::Range;

use glam::{DVec2, DVec3};

use super::spline::Spline;

/// Distance at which the ground below the path is looked up, metres; longer in paths of more than [`MOST_LOOKS`].
const SPACING: f64 = 5.0;
/// Most looks in addition to one per fix.
const MOST_LOOKS: f64 = 200_000.0;
/// Seconds before and after an obstacle over which the flight rises and sinks, as it is shown.
const EASE: f64 = 2.0;

/// A path that was lifted.
pub(super) struct Lifted {
    pub spline: Spline,
    /// Largest lift, metres.
    pub most: f64,
}

/// Lifts `spline` where it is too low. `least` is the height above ground (metres) that each fix asks for, if any; it
/// holds between two fixes that both have one; `pace` is how many seconds of flight are shown as one. `None`: nothing is
/// too low.
pub(super) fn lift(
    spline: &Spline,
    least: &[Option<f64>],
    pace: f64,
    ground: &dyn Fn(DVec2) -> Option<f64>,
) -> Option<Lifted> {
    let (times, least) = subdivide(spline, least);
    let points: Vec<DVec3> = times.iter().map(|&time| spline.position(time)).collect();
    let lifts: Vec<f64> = points
        .iter()
        .zip(&least)
        .map(|(point, least)| {
            // Outside the area there is nothing to hit.
            let surface = least.and_then(|least| ground(point.truncate()).map(|height| height + least));
            surface.map_or(0.0, |surface| (surface - point.z).max(0.0))
        })
        .collect();
    let most = lifts.iter().fold(0.0_f64, |most, &lift| most.max(lift));
    if most == 0.0 {
        return None;
    }
    let eased = eased(&times, &widened(&lifts), EASE * pace);
    let raised = points.iter().zip(&eased).map(|(&point, &lift)| point + DVec3::Z * lift).collect();
    Some(Lifted { spline: Spline::through(times, raised), most })
}

/// Times of the fixes and between them, with the least height at each.
fn subdivide(spline: &Spline, least: &[Option<f64>]) -> (Vec<f64>, Vec<Option<f64>>) {
    let mut times = Vec::new();
    let mut heights = Vec::new();
    let length = |pair: &[f64]| (spline.position(pair[1]) - spline.position(pair[0])).truncate().length();
    let total: f64 = spline.times().windows(2).map(length).sum();
    let spacing = SPACING.max(total / MOST_LOOKS);

    for (pair, ends) in spline.times().windows(2).zip(least.windows(2)) {
        let step = pair[1] - pair[0];
        let parts = (length(pair) / spacing).ceil().clamp(1.0, MOST_LOOKS) as u32;
        for part in 0..parts {
            let u = f64::from(part) / f64::from(parts);
            let time = pair[0] + u * step;
            if times.last().is_some_and(|&last| time <= last) {
                continue; // the interval is too short for a double to divide
            }
            times.push(time);
            let between = ends[0].zip(ends[1]).map(|(a, b)| a + u * (b - a));
            heights.push(if part == 0 { ends[0] } else { between });
        }
    }

    times.extend(spline.times().last());
    heights.extend(least.last().copied());
    (times, heights)
}

/// Each lift is at least that of its neighbours, so that it holds on the way to them too.
fn widened(lifts: &[f64]) -> Vec<f64> {
    let around = |index: usize| &lifts[index.saturating_sub(1)..lifts.len().min(index + 2)];
    (0..lifts.len()).map(|index| around(index).iter().fold(0.0_f64, |most, &lift| most.max(lift))).collect()
}

fn eased(times: &[f64], lifts: &[f64], reach: f64) -> Vec<f64> {
    let windows = windows(times, reach);
    let highest = sliding_maximum(lifts, &windows);
    let mut sums = vec![0.0];
    for (index, high) in highest.iter().enumerate() {
        sums.push(sums[index] + high);
    }
    windows.iter().map(|window| (sums[window.end] - sums[window.start]) / window.len() as f64).collect()
}

/// The indices within `reach`, seconds, of each time; both ends only grow.
fn windows(times: &[f64], reach: f64) -> Vec<Range<usize>> {
    times
        .iter()
        .map(|&time| {
            let first = times.partition_point(|&other| other < time - reach);
            first..times.partition_point(|&other| other <= time + reach)
        })
        .collect()
}

/// Maximum in each window, in linear time: the queue holds indices whose values fall.
fn sliding_maximum(values: &[f64], windows: &[Range<usize>]) -> Vec<f64> {
    let mut queue = VecDeque::new();
    let mut next = 0;
    let mut maxima = Vec::with_capacity(values.len());
    for window in windows {
        while next < window.end {
            while queue.back().is_some_and(|&last: &usize| values[last] <= values[next]) {
                queue.pop_back();
            }
            queue.push_back(next);
            next += 1;
        }
        while queue.front().is_some_and(|&first| first < window.start) {
            queue.pop_front();
        }
        maxima.push(queue.front().map_or(0.0, |&first| values[first]));
    }
    maxima
}
