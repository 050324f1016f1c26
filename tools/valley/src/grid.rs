//! The raster that everything is drawn on, and the lines that cross it.

use glam::DVec2;

/// Columns and rows.
pub const SIZE: usize = 1024;
/// Side of a pixel, metres.
pub const SPACING: f64 = 2.5;
/// Side of the area, metres.
pub const SIDE: f64 = SIZE as f64 * SPACING;
/// Pixels.
pub const PIXELS: usize = SIZE * SIZE;

/// Centre of a pixel, metres east and north of the area's south-west corner; pixels run east, then south.
pub fn centre(pixel: usize) -> (f64, f64) {
    let (row, column) = (pixel / SIZE, pixel % SIZE);
    ((column as f64 + 0.5) * SPACING, SIDE - (row as f64 + 0.5) * SPACING)
}

/// Bilinear value at a place, clamped to the outermost centres.
pub fn sample(values: &[f64], x: f64, y: f64) -> f64 {
    let limit = (SIZE - 1) as f64;
    let u = (x / SPACING - 0.5).clamp(0.0, limit);
    let v = ((SIDE - y) / SPACING - 0.5).clamp(0.0, limit);
    let (column, row) = ((u as usize).min(SIZE - 2), (v as usize).min(SIZE - 2));
    let (tu, tv) = (u - column as f64, v - row as f64);
    let at = |c: usize, r: usize| values[r * SIZE + c];
    let north = at(column, row) * (1.0 - tu) + at(column + 1, row) * tu;
    let south = at(column, row + 1) * (1.0 - tu) + at(column + 1, row + 1) * tu;
    north * (1.0 - tv) + south * tv
}

/// Steepness (rise over run) at every pixel, by central differences.
pub fn steepness(values: &[f64]) -> Vec<f64> {
    (0..PIXELS)
        .map(|pixel| {
            let (row, column) = (pixel / SIZE, pixel % SIZE);
            let (west, east) = (column.saturating_sub(1), (column + 1).min(SIZE - 1));
            let (north, south) = (row.saturating_sub(1), (row + 1).min(SIZE - 1));
            let dx = (values[row * SIZE + east] - values[row * SIZE + west]) / (east - west) as f64;
            let dy = (values[south * SIZE + column] - values[north * SIZE + column]) / (south - north) as f64;
            dx.hypot(dy) / SPACING
        })
        .collect()
}

/// Positions of the pixels whose centres lie within `reach` metres of a place.
pub fn around(x: f64, y: f64, reach: f64) -> impl Iterator<Item = usize> {
    let clamp = |value: f64| value.clamp(0.0, SIZE as f64) as usize;
    let columns = clamp((x - reach) / SPACING)..clamp((x + reach) / SPACING + 1.0);
    let rows = clamp((SIDE - y - reach) / SPACING)..clamp((SIDE - y + reach) / SPACING + 1.0);
    rows.flat_map(move |row| columns.clone().map(move |column| row * SIZE + column))
}

/// Nearness of every pixel to a line.
pub struct Near {
    /// Distance to the line, metres; infinite where it is farther than the reach.
    pub distance: Vec<f64>,
    /// Index of the nearest vertex, with fraction.
    pub along: Vec<f64>,
}

/// Measures every pixel within `reach` metres against the line through `vertices`.
pub fn near(vertices: &[DVec2], reach: f64) -> Near {
    let mut near = Near { distance: vec![f64::INFINITY; PIXELS], along: vec![0.0; PIXELS] };
    for (k, pair) in vertices.windows(2).enumerate() {
        let [DVec2 { x: ax, y: ay }, DVec2 { x: bx, y: by }] = [pair[0], pair[1]];
        let (dx, dy) = (bx - ax, by - ay);
        let length = dx.hypot(dy);
        for pixel in around((ax + bx) / 2.0, (ay + by) / 2.0, reach + length / 2.0) {
            let (x, y) = centre(pixel);
            let t = (((x - ax) * dx + (y - ay) * dy) / (length * length)).clamp(0.0, 1.0);
            let distance = (x - ax - t * dx).hypot(y - ay - t * dy);
            if distance <= reach && distance < near.distance[pixel] {
                near.distance[pixel] = distance;
                near.along[pixel] = k as f64 + t;
            }
        }
    }
    near
}

/// Points about `step` metres apart on a smooth line (Catmull and Rom 1974, uniform: for knots that are about evenly spaced) through `knots`.
pub fn spline(knots: &[DVec2], step: f64) -> Vec<DVec2> {
    let last = knots.len() - 1;
    let mut points = Vec::new();
    for k in 0..last {
        let (p0, p1, p2, p3) = (knots[k.saturating_sub(1)], knots[k], knots[k + 1], knots[(k + 2).min(last)]);
        let count = ((p2.x - p1.x).hypot(p2.y - p1.y) / step).ceil().max(1.0) as usize;
        for i in 0..count {
            let t = i as f64 / count as f64;
            let blend = |a: f64, b: f64, c: f64, d: f64| {
                b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
            };
            points.push(DVec2 { x: blend(p0.x, p1.x, p2.x, p3.x), y: blend(p0.y, p1.y, p2.y, p3.y) });
        }
    }
    points.push(knots[last]);
    points
}
