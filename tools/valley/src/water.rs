//! The river and the lake that it runs through.

use crate::grid::{Near, PIXELS, centre, near};
use crate::noise::{fractal, mix, smooth};
use crate::terrain::{LAKE, Terrain, area_from_valley, centre_line, floor, half_width, valley_from_area};

/// Water of the valley: lake and river.
pub struct Water {
    /// Distance outside the water's edge, metres; negative in the water; infinite far away.
    pub outside: Vec<f64>,
    /// The same of the lake alone, roughly in metres.
    pub beside_lake: Vec<f64>,
}

/// Level of the water at a place along the valley, metres above the sea.
pub fn level(along: f64) -> f64 {
    floor(along) - 2.2
}

/// Across-coordinate of the river's middle.
pub fn river_line(along: f64) -> f64 {
    let swing = 0.34 * half_width(along) * (along / 88.0 + 1.2 * (along / 205.0).sin()).sin();
    centre_line(along) + swing * mix(1.0, 0.3, smooth(60.0, 10.0, (along + 95.0).abs()))
}

/// Cuts the river and the lake into the ground.
pub fn carve(terrain: &mut Terrain) -> Water {
    let line: Vec<_> = (-250..=250)
        .map(|k| 6.0 * f64::from(k))
        .map(|along| area_from_valley(along, river_line(along)))
        .collect();
    let river = near(&line, 60.0);
    let beside_lake: Vec<f64> = (0..PIXELS).map(beside_lake_at).collect();
    let outside: Vec<f64> =
        (0..PIXELS).map(|pixel| beside_river_at(pixel, &river).min(beside_lake[pixel])).collect();

    for (pixel, &shore) in outside.iter().enumerate() {
        let (x, y) = centre(pixel);
        let level = level(valley_from_area(x, y).0);
        if shore <= 0.0 {
            terrain.ground[pixel] = level;
            terrain.relief[pixel] = 0.0;
        } else if shore < 40.0 {
            let bank = level + 0.35 + 0.08 * shore;
            let reach = 7.0 + 5.0 * fractal(x / 60.0, y / 60.0, 2, 501);
            terrain.ground[pixel] = mix(bank, terrain.ground[pixel], smooth(0.3 * reach, 1.6 * reach, shore));
        }
    }

    Water { outside, beside_lake }
}

fn beside_river_at(pixel: usize, river: &Near) -> f64 {
    let (x, y) = centre(pixel);
    let half = 8.5 + 4.0 * fractal(x / 75.0, y / 75.0, 3, 510);
    river.distance[pixel] - half
}

fn beside_lake_at(pixel: usize) -> f64 {
    let (x, y) = centre(pixel);
    let (along, across) = valley_from_area(x, y);
    let middle = (LAKE.0 + LAKE.1) / 2.0;
    let (du, dv) = (along - middle, across - centre_line(middle) + 0.12 * (along - middle));
    let radius =
        ((du / 108.0).powi(2) + (dv / 72.0).powi(2)).sqrt() + 0.34 * fractal(x / 95.0, y / 95.0, 4, 520);
    (radius - 1.0) * 80.0
}
