//! The road along the valley and across it on an embankment, the village's lanes, and tracks up the slope and to the farm.

use glam::DVec2;

use crate::grid::{Near, PIXELS, SIDE, around, centre, near, sample, spline};
use crate::noise::smooth;
use crate::sites;
use crate::terrain::{Terrain, area_from_valley, centre_line, floor, valley_from_area};
use crate::water::{self, Water};

/// Bridges reach so far beyond the water's edge that the dams at their ends end before it, metres.
const BEYOND: f64 = 14.0;

/// A made way.
pub struct Road {
    /// Vertices, metres in the area, about 4 m apart.
    pub line: Vec<DVec2>,
    /// Distance of every pixel within 60 m.
    pub near: Near,
    /// Half the width of the surface, metres.
    pub half: f64,
    /// Asphalt; else gravel.
    pub paved: bool,
}

/// Lays a road through knots: metres along the valley, and left of its centre line.
fn road(knots: &[[f64; 2]], half: f64, paved: bool) -> Road {
    let knots: Vec<_> =
        knots.iter().map(|&[along, offset]| area_from_valley(along, centre_line(along) + offset)).collect();
    through(&knots, half, paved)
}

fn through(knots: &[DVec2], half: f64, paved: bool) -> Road {
    let line = spline(knots, 4.0);
    Road { near: near(&line, 60.0), line, half, paved }
}

/// Lays the track from the nearest vertex of the main road to the farm.
fn farm_track(main: &Road) -> Road {
    let far = |place: DVec2| {
        let away = place - sites::FARM_TRACK[0];
        away.x.hypot(away.y)
    };
    let mut knots = sites::FARM_TRACK.to_vec();
    knots[0] = main.line.iter().copied().fold(main.line[0], |a, b| if far(b) < far(a) { b } else { a });
    through(&knots, 1.8, false)
}

/// The main road first, then the lanes of the village, the tracks last.
pub fn lay_out() -> Vec<Road> {
    let main = [
        [-1700.0, -21.0],
        [-1300.0, -21.0],
        [-1000.0, -48.0],
        [-800.0, -120.0],
        [-600.0, -148.0],
        [-450.0, -150.0],
        [-330.0, -140.0],
        [-220.0, -135.0],
        [-150.0, -112.0],
        [-110.0, -60.0],
        [-88.0, 10.0],
        [-62.0, 85.0],
        [-20.0, 150.0],
        [60.0, 188.0],
        [180.0, 196.0],
        [330.0, 160.0],
        [520.0, 122.0],
        [700.0, 62.0],
        [900.0, 26.0],
        [1200.0, 30.0],
        [1600.0, 30.0],
    ];

    let upper = [
        [-470.0, -154.0],
        [-440.0, -205.0],
        [-360.0, -222.0],
        [-270.0, -215.0],
        [-200.0, -185.0],
        [-172.0, -124.0],
    ];

    let lower = [[-400.0, -143.0], [-370.0, -100.0], [-300.0, -85.0], [-225.0, -92.0], [-175.0, -123.0]];
    let cross = [[-300.0, -85.0], [-315.0, -138.0], [-330.0, -220.0], [-310.0, -300.0]];
    let track = [
        [-310.0, -300.0],
        [-250.0, -370.0],
        [-290.0, -450.0],
        [-380.0, -500.0],
        [-360.0, -580.0],
        [-230.0, -640.0],
    ];

    let main = road(&main, 4.2, true);
    let farm = farm_track(&main);
    vec![
        main,
        road(&upper, 2.9, true),
        road(&lower, 2.9, true),
        road(&cross, 2.7, true),
        road(&track, 2.2, false),
        farm,
    ]
}

/// Levels the ground under the roads: cut and fill at slopes of 1 : 1.5, walls beside water.
pub fn grade(terrain: &mut Terrain, water: &Water, roads: &[Road]) {
    for (number, road) in roads.iter().enumerate() {
        let heights = profile(terrain, road, number == 0);
        for pixel in 0..PIXELS {
            let beside = road.near.distance[pixel] - road.half - 1.0;
            if !beside.is_finite() || (water.outside[pixel] <= 0.0 && beside > 0.0) {
                continue;
            }
            let k = (road.near.along[pixel] as usize).min(heights.len() - 2);
            let t = road.near.along[pixel] - k as f64;
            let level = heights[k] * (1.0 - t) + heights[k + 1] * t;
            let slack = beside.max(0.0) / 1.5;
            terrain.ground[pixel] = terrain.ground[pixel].clamp(level - slack, level + slack);
        }
    }
}

/// Indices of the vertices from which to which a road lies on bridges: they begin and end [`BEYOND`] from the water's edge.
pub fn bridges(road: &Road, water: &Water) -> Vec<(usize, usize)> {
    let outside = |k: usize| {
        let DVec2 { x, y } = road.line[k];
        let inside = (0.0..SIDE).contains(&x) && (0.0..SIDE).contains(&y);
        let pixel = around(x, y, 0.0).next().filter(|_| inside);
        pixel.map_or(f64::INFINITY, |pixel| water.outside[pixel])
    };
    let mut spans: Vec<(usize, usize)> = Vec::new();
    for k in (0..road.line.len()).filter(|&k| outside(k) <= 0.0) {
        let from = (0..k).rev().find(|&k| outside(k) > BEYOND).unwrap_or(0);
        let to = (k..road.line.len()).find(|&k| outside(k) > BEYOND).unwrap_or(road.line.len() - 1);
        if spans.last() != Some(&(from, to)) {
            spans.push((from, to));
        }
    }
    spans
}

/// The ground below bridges: the water, and banks instead of the dams that the drawing has there.
pub fn open_bridges(ground: &mut [f64], natural: &[f64], water: &Water, roads: &[Road]) {
    for road in roads {
        for (from, to) in bridges(road, water) {
            for &DVec2 { x, y } in &road.line[from..=to] {
                for pixel in around(x, y, road.half + 16.0) {
                    let (px, py) = centre(pixel);
                    let level = water::level(valley_from_area(px, py).0);
                    let bank = level + 0.5 + 0.75 * water.outside[pixel].max(0.0);
                    let open = if water.outside[pixel] <= 0.0 { level } else { bank.max(natural[pixel]) };
                    ground[pixel] = ground[pixel].min(open);
                }
            }
        }
    }
}

fn profile(terrain: &Terrain, road: &Road, embanked: bool) -> Vec<f64> {
    let ground = road.line.iter().map(|&DVec2 { x, y }| {
        let (along, across) = valley_from_area(x, y);
        let lift = smooth(-135.0, -85.0, across - centre_line(along))
            * smooth(150.0, 95.0, across - centre_line(along));
        let crossing =
            if embanked && (-200.0..40.0).contains(&along) { floor(along) + 5.5 * lift } else { f64::MIN };
        sample(&terrain.ground, x, y).max(crossing)
    });
    let mut heights: Vec<f64> = ground.collect();
    for _ in 0..3 {
        heights = (0..heights.len())
            .map(|k| {
                let window = &heights[k.saturating_sub(7)..(k + 8).min(heights.len())];
                window.iter().sum::<f64>() / window.len() as f64
            })
            .collect();
    }
    heights
}

/// Counts a road's vertices, from the first, that lie on ground no steeper along it than `most`, over 12 m.
pub fn gentle(road: &Road, bare: &[f64], most: f64) -> usize {
    let heights: Vec<f64> = road.line.iter().map(|&DVec2 { x, y }| sample(bare, x, y)).collect();
    let length = |pair: &[DVec2]| (pair[1].x - pair[0].x).hypot(pair[1].y - pair[0].y);
    let steep = |k: &usize| {
        let run: f64 = road.line[*k..*k + 4].windows(2).map(length).sum();
        (heights[k + 3] - heights[*k]).abs() > most * run
    };
    (0..heights.len() - 3).find(steep).map_or(heights.len(), |k| k + 1)
}

/// Distance of a pixel outside the nearest of the roads' edges.
pub fn outside<'a>(roads: impl IntoIterator<Item = &'a Road>, pixel: usize) -> f64 {
    roads.into_iter().map(|road| road.near.distance[pixel] - road.half).fold(f64::INFINITY, f64::min)
}

/// Returns the distance of a pixel from the village's middle: 0 there, 1 at the rim of its ellipse, more outside.
pub fn village_radius(pixel: usize) -> f64 {
    let (x, y) = centre(pixel);
    let (along, across) = valley_from_area(x, y);
    (((along + 310.0) / 190.0).powi(2) + ((across - centre_line(along) + 155.0) / 95.0).powi(2)).sqrt()
}
