//! The flight: down the valley over the river, past the village, across the road, in a wide bend to the left past the lake.
//!
//! Height: the highest surface within [`BESIDE`] of every point of the line, plus a clearance; then the maximum
//! over [`AHEAD`] before and behind; then averaged over no more than that, which cannot fall below the first.

use std::fmt::Write;

use glam::{DVec2, DVec3};

use crate::geotiff::ORIGIN;
use crate::grid::{around, spline};
use crate::noise::mix;
use crate::terrain::{area_from_valley, centre_line};

/// Metres per second.
const SPEED: f64 = 38.0;
/// Metres between points of the line while it is being made.
const STEP: f64 = 5.0;
/// Seconds between rows of the file.
const INTERVAL: f64 = 0.5;
/// Half the width of the swath that must be cleared, metres.
const BESIDE: f64 = 35.0;
/// Points before and behind that a height holds for.
const AHEAD: usize = 34;
/// Points before and behind that each rounding of the line takes in.
const ROUND: usize = 30;
/// Degrees above the horizon that the nose points to: below it, so that more is seen of the ground than of the sky.
const PITCH: f64 = -6.0;
/// Least height above everything in the swath, metres.
pub const CLEARANCE: f64 = 37.0;

/// Places of the flight half a second apart: metres in the area, metres above the sea.
pub fn fly(surface: &[f64]) -> Vec<DVec3> {
    let line = even(&spline(&knots(), 1.0), STEP);
    let (xs, ys): (Vec<f64>, Vec<f64>) = line.into_iter().map(|place| (place.x, place.y)).unzip();

    // The spline's curvature jumps at its knots, and bank follows curvature.
    let rounded: Vec<_> =
        smoothed(&xs, ROUND).into_iter().zip(smoothed(&ys, ROUND)).map(|(x, y)| DVec2 { x, y }).collect();
    let line = even(&rounded, STEP);
    let floor: Vec<f64> =
        line.iter().map(|place| highest_around(surface, place.x, place.y) + CLEARANCE).collect();
    let held: Vec<f64> =
        (0..floor.len()).map(|k| window(&floor, k, AHEAD).iter().copied().fold(f64::MIN, f64::max)).collect();
    let heights = smoothed(&held, AHEAD / 2);
    let stride = SPEED * INTERVAL / STEP;

    (0..)
        .map(|row| f64::from(row) * stride)
        .take_while(|&at| at <= (line.len() - 1) as f64)
        .map(|at| {
            let k = (at as usize).min(line.len() - 2);
            let t = at - k as f64;
            DVec3 {
                x: mix(line[k].x, line[k + 1].x, t),
                y: mix(line[k].y, line[k + 1].y, t),
                z: mix(heights[k], heights[k + 1], t),
            }
        })
        .collect()
}

/// Values within `reach` of the k-th.
fn window(values: &[f64], k: usize, reach: usize) -> &[f64] {
    &values[k.saturating_sub(reach)..(k + reach + 1).min(values.len())]
}

/// Two running means of `reach` each, windows shrinking towards the ends.
fn smoothed(values: &[f64], reach: usize) -> Vec<f64> {
    let mean = |values: &[f64]| -> Vec<f64> {
        (0..values.len())
            .map(|k| {
                let part = window(values, k, reach.min(k).min(values.len() - 1 - k));
                part.iter().sum::<f64>() / part.len() as f64
            })
            .collect()
    };
    mean(&mean(values))
}

fn knots() -> Vec<DVec2> {
    let valley = |along: f64, offset: f64| area_from_valley(along, centre_line(along) + offset);
    vec![
        valley(-760.0, 20.0),
        valley(-620.0, 15.0),
        valley(-480.0, -10.0),
        valley(-340.0, -30.0),
        valley(-200.0, -30.0),
        valley(-60.0, -10.0),
        valley(80.0, 20.0),
        valley(220.0, 90.0),
        valley(320.0, 170.0),
    ]
}

/// Points of a line at even distances.
fn even(line: &[DVec2], step: f64) -> Vec<DVec2> {
    let mut points = vec![line[0]];
    let mut walked = 0.0;
    for pair in line.windows(2) {
        let way = pair[1] - pair[0];
        let length = way.x.hypot(way.y);
        while points.len() as f64 * step <= walked + length {
            let t = (points.len() as f64 * step - walked) / length;
            points.push(pair[0] + t * way);
        }
        walked += length;
    }
    points
}

/// The highest surface within the swath.
pub fn highest_around(surface: &[f64], x: f64, y: f64) -> f64 {
    around(x, y, BESIDE).map(|pixel| surface[pixel]).fold(f64::MIN, f64::max)
}

/// The file's text: seconds, easting, northing, height above the sea, pitch.
pub fn to_csv(places: &[DVec3]) -> String {
    let mut text = String::from("t,x_m,y_m,alt_msl_m,pitch_deg\n");
    for (row, DVec3 { x, y, z: height }) in places.iter().enumerate() {
        let time = row as f64 * INTERVAL;
        writeln!(text, "{time:.1},{:.2},{:.2},{height:.2},{PITCH}", ORIGIN.x + x, ORIGIN.y + y)
            .expect("writing to a string cannot fail");
    }
    text
}
