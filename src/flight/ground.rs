//! Keeps a flight above the ground between its fixes.
//!
//! ```text
//! subdivide the path, at most SPACING apart
//! lift(t)  = max(0, ground(t) + least height(t) − z(t))
//! lift'(t) = mean over ±EASE of (max over ±EASE of lift)
//! ```
//!
//! The mean of a sliding maximum of the same width is nowhere below the function itself (each maximum that is averaged
//! has seen it), so the flight clears the ground and still rises and sinks gently. The least height is the clearance that
//! the user asks for, and between two fixes above ground the height above ground interpolated between them.

use glam::{DVec2, DVec3};

use super::spline::Spline;

/// Distance at which the ground below the path is looked up, metres.
const SPACING: f64 = 10.0;
/// Most looks between two fixes.
const MOST_PER_INTERVAL: f64 = 64.0;
/// Seconds before and after an obstacle over which the flight rises and sinks.
const EASE: f64 = 2.0;

/// A path that was lifted.
pub(super) struct Lifted {
    pub spline: Spline,
    /// Largest lift, metres.
    pub most: f64,
}

/// Lifts `spline` where it is too low. `least` is the height above ground (metres) that each fix asks for, if any; it
/// holds between two fixes that both have one. `None`: nothing is too low.
pub(super) fn lift(
    spline: &Spline,
    least: &[Option<f64>],
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
    let eased = eased(&times, &lifts);
    let raised = points.iter().zip(&eased).map(|(&point, &lift)| point + DVec3::Z * lift).collect();
    Some(Lifted { spline: Spline::through(times, raised), most })
}

/// Times of the fixes and between them, with the least height at each.
fn subdivide(spline: &Spline, least: &[Option<f64>]) -> (Vec<f64>, Vec<Option<f64>>) {
    let mut times = Vec::new();
    let mut heights = Vec::new();
    for (pair, ends) in spline.times().windows(2).zip(least.windows(2)) {
        let step = pair[1] - pair[0];
        let length = (spline.position(pair[1]) - spline.position(pair[0])).truncate().length();
        let parts = (length / SPACING).ceil().clamp(1.0, MOST_PER_INTERVAL) as u32;
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

fn eased(times: &[f64], lifts: &[f64]) -> Vec<f64> {
    let window = |index: usize| {
        let first = times.partition_point(|&time| time < times[index] - EASE);
        let end = times.partition_point(|&time| time <= times[index] + EASE);
        first..end
    };
    let highest: Vec<f64> =
        (0..times.len()).map(|index| lifts[window(index)].iter().fold(0.0_f64, |most, &lift| most.max(lift))).collect();
    (0..times.len())
        .map(|index| {
            let around = window(index);
            highest[around.clone()].iter().sum::<f64>() / around.len() as f64
        })
        .collect()
}
