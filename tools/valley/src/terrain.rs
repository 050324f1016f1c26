//! The ground without anything on it: valley cross-section, mountains, erosion, cliffs.
//!
//! ```text
//! relief = cross-section(distance from the valley's centre line) · slow noise + fractal detail
//! relief = smooth maximum(relief, rim of mountains that hides the end of the world)
//! relief = droplets run down it, each taking up and dropping sediment by slope and speed
//! ground = floor(along the valley) + cliffs(relief)
//! ```
//!
//! Droplet erosion after H. T. Beyer, *Implementation of a method for hydraulic erosion* (bachelor's
//! thesis, TU München, 2015); here without evaporation, every droplet lives a fixed number of steps.

use glam::{DVec2, dvec2};

use crate::grid::{PIXELS, SIDE, SIZE, SPACING, around, centre, sample};
use crate::noise::{curve, fractal, mix, ridged, smooth, uniform};

const SEED: u64 = 0x4845_4447;

/// Valley coordinates: `along` metres downstream (azimuth 30°) and `across` metres to the left of that
/// direction, from the middle of the area.
pub fn valley_from_area(x: f64, y: f64) -> (f64, f64) {
    let (dx, dy) = (x - SIDE / 2.0, y - SIDE / 2.0);
    (0.5 * dx + 0.75f64.sqrt() * dy, -0.75f64.sqrt() * dx + 0.5 * dy)
}

/// Inverse of [`valley_from_area`].
pub fn area_from_valley(along: f64, across: f64) -> DVec2 {
    let (c, s) = (0.75f64.sqrt(), 0.5);
    dvec2(SIDE / 2.0 + s * along - c * across, SIDE / 2.0 + c * along + s * across)
}

/// Across-coordinate of the valley's centre line.
pub fn centre_line(along: f64) -> f64 {
    let bend = (along - 350.0).max(0.0);
    -270.0 + 95.0 * (along / 400.0 + 0.5).sin() - bend * bend / 2600.0
}

/// Half the width of the level floor.
pub fn half_width(along: f64) -> f64 {
    24.0 + 165.0 * smooth(1050.0, 500.0, (along + 130.0).abs()) * (1.0 + 0.15 * (along / 170.0).sin())
}

/// Height of the level floor above the sea; flat where the lake lies.
pub fn floor(along: f64) -> f64 {
    let fall = |reach: f64| 0.011 * reach;
    906.0 - fall(along.min(LAKE.0)) - fall((along - LAKE.1).max(0.0))
}

/// Begin and end of the lake along the valley.
pub const LAKE: (f64, f64) = (120.0, 380.0);

/// The bare ground and what it is made of.
pub struct Terrain {
    /// Height above the sea, metres.
    pub ground: Vec<f64>,
    /// Height above the valley's floor, metres.
    pub relief: Vec<f64>,
    /// Signed distance from the valley's centre line, metres, positive left (the cliffs' side).
    pub offset: Vec<f64>,
}

/// Builds the ground.
pub fn build() -> Terrain {
    let offset: Vec<f64> = (0..PIXELS).map(offset_at).collect();
    let mut relief: Vec<f64> = (0..PIXELS).map(|pixel| relief_at(pixel, offset[pixel])).collect();
    erode(&mut relief, 130_000);
    for pixel in 0..PIXELS {
        relief[pixel] = cliffs(pixel, relief[pixel], offset[pixel]);
    }
    let ground = (0..PIXELS)
        .map(|pixel| {
            let (x, y) = centre(pixel);
            let (along, _) = valley_from_area(x, y);
            let swell = 1.3 * fractal(x / 90.0, y / 90.0, 3, SEED + 90);
            floor(along) + relief[pixel] + swell
        })
        .collect();
    Terrain { ground, relief, offset }
}

fn offset_at(pixel: usize) -> f64 {
    let (x, y) = centre(pixel);
    let (along, across) = valley_from_area(x, y);
    let slope = (centre_line(along + 5.0) - centre_line(along - 5.0)) / 10.0;
    (across - centre_line(along)) / (1.0 + slope * slope).sqrt()
}

fn relief_at(pixel: usize, offset: f64) -> f64 {
    let (x, y) = centre(pixel);
    let (along, across) = valley_from_area(x, y);
    let beyond = (offset.abs() - half_width(along)).max(0.0);

    let side = if offset > 0.0 {
        let crest = 1.0 + 0.35 * fractal(along / 300.0, 3.7, 2, SEED + 1)
            - 0.36 * smooth(260.0, 0.0, (along - 230.0).abs());
        let knots = [
            [0.0, 0.0],
            [70.0, 11.0],
            [140.0, 40.0],
            [215.0, 95.0],
            [300.0, 150.0],
            [400.0, 205.0],
            [500.0, 185.0],
            [640.0, 132.0],
            [780.0, 140.0],
            [950.0, 250.0],
            [1250.0, 380.0],
        ]
        .map(DVec2::from);

        curve(&knots, beyond) * mix(1.0, crest, smooth(80.0, 300.0, beyond))
    } else {
        let knots = [
            [0.0, 0.0],
            [90.0, 7.0],
            [240.0, 34.0],
            [400.0, 84.0],
            [580.0, 150.0],
            [800.0, 235.0],
            [1200.0, 340.0],
        ]
        .map(DVec2::from);
        curve(&knots, beyond) * (1.0 + 0.25 * fractal(along / 330.0, across / 330.0, 2, SEED + 3))
    };

    let foot = if offset > 0.0 { 0.58 } else { 0.40 };
    // The last hundred metres fall away, so that the crest and not the edge is what one sees.
    let ragged = 0.05 * fractal(x / 160.0, y / 160.0, 4, SEED + 47);
    let behind_crest = 1.0 - 0.5 * smooth(0.88, 1.0, remoteness(x, y) + ragged);
    let relief = highest(side, rim(x, y, beyond, foot)) * behind_crest;
    let wildness = smooth(25.0, 230.0, relief);
    let spurs = if offset > 0.0 { 34.0 } else { 22.0 };
    let gullies = spurs * smooth(0.0, 90.0, relief) * fractal(x / 170.0, y / 170.0, 3, SEED + 10);
    let crags = 46.0 * wildness * ridged(x / 240.0, y / 240.0, 5, SEED + 20);
    let grain = (0.3 + 6.0 * wildness) * fractal(x / 38.0, y / 38.0, 4, SEED + 30);

    (relief + (gullies + crags + grain) * smooth(0.0, 30.0, relief)).max(0.0)
}

/// Mountains around the area, open only where the valley leaves through a gorge; they begin to rise at `foot`
/// of the way from the middle to the edge.
fn rim(x: f64, y: f64, beyond: f64, foot: f64) -> f64 {
    let wander = 0.13 * fractal(x / 520.0, y / 520.0, 4, SEED + 40);
    let peaks = 1.0 + 0.28 * fractal(x / 380.0, y / 380.0, 3, SEED + 45);
    395.0 * peaks * smooth(foot, 0.95, remoteness(x, y) + wander) * smooth(-20.0, 150.0, beyond)
}

/// 0 in the middle of the area, 1 at the middle of an edge, more in the corners.
fn remoteness(x: f64, y: f64) -> f64 {
    let unit = |v: f64| (v / (SIDE / 2.0) - 1.0).abs().powi(3);
    (unit(x) + unit(y)).cbrt()
}

/// Maximum with a rounded transition (4-norm); zero where both are.
fn highest(a: f64, b: f64) -> f64 {
    (a.max(0.0).powi(4) + b.max(0.0).powi(4)).sqrt().sqrt()
}

/// Steepens two bands of height into walls where the noise says so, mostly on the left side.
fn cliffs(pixel: usize, relief: f64, offset: f64) -> f64 {
    let (x, y) = centre(pixel);
    let wander =
        24.0 * fractal(x / 210.0, y / 210.0, 5, SEED + 50) + 15.0 * ridged(x / 48.0, y / 48.0, 3, SEED + 55);
    let here = fractal(x / 300.0, y / 300.0, 2, SEED + 60) + if offset > 0.0 { 0.75 } else { -0.55 };
    let wall = |bottom: f64, top: f64, height: f64| {
        let t = (height - bottom) / (top - bottom);
        if !(0.0..1.0).contains(&t) {
            return height;
        }
        let steep = 0.55 * smooth(0.36, 0.48, t) + 0.45 * smooth(0.56, 0.68, t);
        mix(bottom, top, mix(t, 0.75 * steep + 0.25 * t, smooth(0.0, 0.5, here)))
    };
    let lower = wall(62.0 + wander, 138.0 + wander, relief);
    wall(232.0 + wander, 312.0 + wander, lower).max(0.0)
}

/// Lets `drops` droplets run over the relief.
fn erode(relief: &mut [f64], drops: i64) {
    let mut brush = Brush::new(2.6);
    for drop in 0..drops {
        let x = SIDE * uniform(drop, 0, SEED + 70);
        let y = SIDE * uniform(drop, 1, SEED + 70);
        run(relief, &mut brush, x, y);
    }
}

struct Brush {
    /// Row, column and share of the pixels that a droplet wears down.
    cells: Vec<(isize, isize, f64)>,
}

impl Brush {
    fn new(radius: f64) -> Self {
        let reach = radius.ceil() as isize;
        let mut cells: Vec<_> = (-reach..=reach)
            .flat_map(|row| (-reach..=reach).map(move |column| (row, column)))
            .map(|(row, column)| (row, column, (radius - (row as f64).hypot(column as f64)).max(0.0)))
            .filter(|cell| cell.2 > 0.0)
            .collect();
        let total: f64 = cells.iter().map(|cell| cell.2).sum();
        cells.iter_mut().for_each(|cell| cell.2 /= total);
        Self { cells }
    }

    fn add(&self, relief: &mut [f64], x: f64, y: f64, amount: f64) {
        let Some(pixel) = around(x, y, 0.0).next() else { return };
        let (row, column) = ((pixel / SIZE) as isize, (pixel % SIZE) as isize);
        let inside = 0..SIZE as isize;
        for &(dr, dc, share) in &self.cells {
            if inside.contains(&(row + dr)) && inside.contains(&(column + dc)) {
                let height = &mut relief[(row + dr) as usize * SIZE + (column + dc) as usize];
                *height = (*height + amount * share).max(0.0);
            }
        }
    }
}

fn run(relief: &mut [f64], brush: &mut Brush, mut x: f64, mut y: f64) {
    let (mut dx, mut dy, mut speed, mut load) = (0.0, 0.0, 1.0, 0.0);
    for step in 0..64 {
        let here = sample(relief, x, y);
        let half = SPACING / 2.0;
        let gx = (sample(relief, x + half, y) - sample(relief, x - half, y)) / SPACING;
        let gy = (sample(relief, x, y + half) - sample(relief, x, y - half)) / SPACING;
        (dx, dy) = (0.1 * dx - 0.9 * gx, 0.1 * dy - 0.9 * gy);
        let length: f64 = f64::hypot(dx, dy);
        if length < 1e-9 || here <= 0.0 {
            return;
        }

        (dx, dy) = (dx / length, dy / length);
        let (nx, ny) = (x + dx * SPACING, y + dy * SPACING);
        if !(SPACING..SIDE - SPACING).contains(&nx) || !(SPACING..SIDE - SPACING).contains(&ny) {
            return;
        }

        let fall = here - sample(relief, nx, ny);
        let water = 1.0 - step as f64 / 64.0;
        let capacity = (fall.max(0.02) * speed * water * 2.2).min(6.0);
        if fall < 0.0 || load > capacity {
            let drop = if fall < 0.0 { load.min(-fall) } else { 0.25 * (load - capacity) };
            brush.add(relief, x, y, drop);
            load -= drop;
        } else {
            let take = (0.3 * (capacity - load)).min(fall);
            brush.add(relief, x, y, -take);
            load += take;
        }

        speed = (speed * speed + fall * 0.6).max(0.05).sqrt().min(4.0);
        (x, y) = (nx, ny);
    }
}
