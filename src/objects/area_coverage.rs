//! The exact share of each pixel of a square that lies in a polygon.
//!
//! ```text
//! each edge, row by row of pixels: its height in the row goes to the pixel that it crosses, by the area to its right, and the rest to the next one
//! sums along rows → shares
//! ```
//!
//! Fonts are drawn so (Levien, font-rs, 2016). Nothing is sampled: shares of a polygon of any size and place are exact but for rounding.

use std::ops::Range;

use glam::DVec2;

use super::view::SQUARE;

/// Sums of a row: one more than pixels, and one for what lies to the right of all.
const STRIDE: usize = SQUARE + 2;

/// Polygons in a square of pixels, one at a time.
#[derive(Debug)]
pub(super) struct Coverage {
    size: [usize; 2],
    sums: Vec<f32>,
    /// Rows and columns that hold something.
    rows: Range<usize>,
    columns: Range<usize>,
}

impl Coverage {
    /// A square of so many columns and rows, [`SQUARE`] at most.
    pub fn new(columns: usize, rows: usize) -> Self {
        Self { size: [columns, rows], sums: vec![0.0; STRIDE * rows], rows: 0..0, columns: 0..0 }
    }

    /// Puts a polygon into it, whose points are pixels from the square's upper left corner; the rows that it is in.
    pub fn put(&mut self, points: &[DVec2]) -> Range<usize> {
        self.sums[STRIDE * self.rows.start..STRIDE * self.rows.end].fill(0.0);
        let ends = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (low, high) = points.iter().fold(ends, |(low, high), at| (low.min(*at), high.max(*at)));
        // A float converts saturating.
        let range = |low: f64, high: f64, size: usize| {
            let end = (high.ceil() as usize).min(size);
            (low.floor() as usize).min(end)..end
        };
        self.columns = range(low.x, high.x, self.size[0]);
        self.rows = range(low.y, high.y, self.size[1]);
        let next = points.iter().cycle().skip(1);
        points.iter().zip(next).for_each(|(from, to)| self.edge(*from, *to));
        self.rows.clone()
    }

    /// Columns of a row, and the shares of their pixels, 0…1; of all others the share is 0.
    pub fn shares(&self, row: usize) -> impl Iterator<Item = (usize, f32)> {
        let columns = self.columns.clone();
        let sums = &self.sums[STRIDE * row + columns.start..STRIDE * row + columns.end];
        let shares = sums.iter().scan(0.0_f32, |sum, step| {
            *sum += step;
            Some(sum.abs().min(1.0))
        });
        columns.zip(shares)
    }

    fn edge(&mut self, from: DVec2, to: DVec2) {
        let (upper, lower, sign) = if from.y <= to.y { (from, to, 1.0) } else { (to, from, -1.0) };
        let (top, bottom) = (upper.y.max(0.0), lower.y.min(self.size[1] as f64));
        if top >= bottom {
            return;
        }
        let slope = (lower.x - upper.x) / (lower.y - upper.y);
        let x = |y: f64| upper.x + (y - upper.y) * slope;
        let (mut y, mut row) = (top, top as usize);
        while y < bottom {
            let next = (row as f64 + 1.0).min(bottom);
            self.stretch(row, [x(y), x(next)], (next - y) * sign);
            (y, row) = (next, row + 1);
        }
    }

    /// Adds an edge that goes from one place of a row to another, and `height` down, rows.
    fn stretch(&mut self, row: usize, ends: [f64; 2], height: f64) {
        let width = self.size[0] as f64;
        let (left, right) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let sums = &mut self.sums[STRIDE * row..STRIDE * (row + 1)];

        let mut add = |from: f64, to: f64, height: f64| {
            let pixel = from as usize;
            let inside = height * (0.5 * (from + to) - pixel as f64);
            sums[pixel] += (height - inside) as f32;
            sums[pixel + 1] += inside as f32;
        };
        // All pixels lie to the right of what is left of the square.
        if right <= 0.0 {
            return add(0.0, 0.0, height);
        }
        if left >= width {
            return;
        }

        let per_column = if right > left { height / (right - left) } else { 0.0 };
        let (mut at, end) = (left.max(0.0), right.min(width));
        if left < 0.0 {
            add(0.0, 0.0, -left * per_column);
        }
        if end <= at.floor() + 1.0 {
            let inside = if left < 0.0 || right > width { (end - at) * per_column } else { height };
            return add(at, end, inside);
        }

        while at < end {
            let next = (at.floor() + 1.0).min(end);
            add(at, next, (next - at) * per_column);
            at = next;
        }
    }
}

/// Finds the part of a polygon that lies in the pixel with this upper left corner, from which its points count; `spare` is memory.
pub(super) fn clip(points: &[DVec2], corner: DVec2, part: &mut Vec<DVec2>, spare: &mut Vec<DVec2>) {
    part.clear();
    part.extend(points.iter().map(|point| *point - corner));
    for side in 0..4 {
        let inside = |point: DVec2| if side & 2 == 0 { point[side & 1] } else { 1.0 - point[side & 1] };
        let Some(mut last) = part.last().copied() else { return };
        spare.clear();
        for point in part.iter().copied() {
            let (before, own) = (inside(last), inside(point));
            if (before < 0.0) != (own < 0.0) {
                spare.push(last.lerp(point, before / (before - own)));
            }
            if own >= 0.0 {
                spare.push(point);
            }
            last = point;
        }
        std::mem::swap(part, spare);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area of a polygon by the products of its points.
    fn area(points: &[DVec2]) -> f64 {
        let next = points.iter().cycle().skip(1);
        0.5 * points.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>().abs()
    }

    #[test]
    fn shares_are_areas() {
        let mut coverage = Coverage::new(20, 32);
        let (mut part, mut spare) = (Vec::new(), Vec::new());
        let mut edges = 0;
        for step in 0..200 {
            let at = |by: f64| (f64::from(step) * by).fract();
            let middle = DVec2::new(34.0 * at(0.618) - 7.0, 44.0 * at(0.414) - 6.0);
            let corners = 3 + step % 7;
            let radius = [0.2, 3.0, 30.0][step as usize % 3] * (0.3 + at(0.73));
            let turn = if step % 5 == 0 { 0.0 } else { at(0.27) };
            let corner = |index: i32| {
                let angle = std::f64::consts::TAU * (f64::from(index) / f64::from(corners) + turn);
                middle + radius * DVec2::from_angle(if step % 2 == 0 { angle } else { -angle })
            };
            let points: Vec<_> = (0..corners).map(corner).collect();
            let rows = coverage.put(&points);

            for row in 0..32 {
                let mut shares = [0.0; 20];
                coverage.shares(row).for_each(|(column, share)| shares[column] = share);
                for (column, share) in shares.into_iter().enumerate() {
                    clip(&points, DVec2::new(column as f64, row as f64), &mut part, &mut spare);
                    let exact = area(&part);
                    assert!(
                        (f64::from(share) - exact).abs() < 1e-5,
                        "{step}, {column} {row}: {share} {exact}"
                    );
                    assert!(exact < 1e-9 || rows.contains(&row));
                    edges += i32::from(exact > 0.0 && exact < 1.0);
                }
            }
        }

        assert!(edges > 5000, "{edges}");
    }
}
