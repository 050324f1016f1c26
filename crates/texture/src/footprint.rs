//! Footprint of a pixel on the ground, and how it is averaged: by tonal groups as in the study, or by exact
//! boxes.
//!
//! ```text
//! N = area/ΔX, M = area/(ΔY·N)                  cells; sides of groups and their number, each rounded, at least 1
//! free in Y (ΔX ≥ ΔY): groups one after the other along X, the rest of ΔX left over at both ends alike;
//!                      the place of each in Y is that of the footprint's centreline at its middle
//! free in X:           the transpose
//! exact:               slices of the footprint along the longer side, each as a box of the same area and centroid
//! ```
//!
//! Source: study of cyclic codes for surface texture (AFHRL on ACTES); it does not say how N and M are
//! rounded. Slices are ours.

use crate::cell_box::CellBox;

/// Parallelogram that a pixel covers on the ground, in cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    /// Centre, x and y.
    pub centre: [f64; 2],
    /// Edges: the ground's change for a pixel along and down the screen, x and y of each.
    pub edges: [[f64; 2]; 2],
}

/// Axis along which groups or slices follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stacking {
    /// Along x; each is free to move in y.
    FreeY,
    /// Along y; each is free to move in x.
    FreeX,
}

/// Tonal groups that stand for a footprint.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TonalGroups {
    /// Cells along the side of each, N.
    pub side: u32,
    /// First column and row of each, M of them.
    pub corners: Vec<[i64; 2]>,
}

/// Part of a footprint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slice {
    /// Box of the same area and centroid.
    pub over: CellBox,
    /// Share of the footprint's area.
    pub share: f64,
}

impl Footprint {
    /// Area, square cells.
    pub fn area(&self) -> f64 {
        let [[ux, uy], [vx, vy]] = self.edges;
        (ux * vy - uy * vx).abs()
    }

    /// Extents along x and y, cells.
    pub fn extents(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.edges[0][axis].abs() + self.edges[1][axis].abs())
    }

    /// Axis along which the footprint is longer.
    pub fn stacking(&self) -> Stacking {
        let [x, y] = self.extents();
        if x >= y { Stacking::FreeY } else { Stacking::FreeX }
    }

    /// Tonal groups by the study's rule.
    pub fn groups(&self) -> TonalGroups {
        if self.stacking() == Stacking::FreeX {
            let mut groups = self.transposed().groups();
            groups.corners.iter_mut().for_each(|corner| corner.reverse());
            return groups;
        }
        let [width, height] = self.extents();
        let side = (self.area() / width).round().max(1.0);
        let count = (self.area() / (height * side)).round().max(1.0);

        // Centreline: mean y of the footprint at each x.
        let [[ux, uy], [vx, vy]] = self.edges;
        let slope = (ux * uy + vx * vy) / (ux * ux + vx * vx);
        let first = self.centre[0] - 0.5 * count * side;
        let corner = |number: i64| {
            let x = first + number as f64 * side;
            let middle = self.centre[1] + slope * (x + 0.5 * side - self.centre[0]);
            [x.round() as i64, (middle - 0.5 * side).round() as i64]
        };
        TonalGroups { side: side as u32, corners: (0..count as i64).map(corner).collect() }
    }

    /// Slices along the longer side, at least one; slices of no area are left out.
    ///
    /// One is exact if the footprint lies along the axes; others need more, the more they are turned.
    pub fn slices(&self, count: u32) -> Vec<Slice> {
        if self.stacking() == Stacking::FreeX {
            let slices = self.transposed().slices(count).into_iter();
            let turned = |over: CellBox| CellBox { x0: over.y0, x1: over.y1, y0: over.x0, y1: over.x1 };
            return slices.map(|slice| Slice { over: turned(slice.over), ..slice }).collect();
        }
        let [width, _] = self.extents();
        let (first, step) = (self.centre[0] - 0.5 * width, width / f64::from(count.max(1)));
        let slice = |number: u32| {
            let x0 = first + f64::from(number) * step;
            let part = clipped(&clipped(&self.corners(), x0, 1.0), x0 + step, -1.0);
            let (area, middle) = area_and_middle(&part)?;
            let half = 0.5 * area / step;
            let over = CellBox { x0, x1: x0 + step, y0: middle - half, y1: middle + half };
            Some(Slice { over, share: area / self.area() })
        };
        (0..count.max(1)).filter_map(slice).collect()
    }

    /// Place at shares of both edges from the centre, each −½ to ½ within the footprint.
    pub fn at(&self, shares: [f64; 2]) -> [f64; 2] {
        [0, 1]
            .map(|axis| self.centre[axis] + shares[0] * self.edges[0][axis] + shares[1] * self.edges[1][axis])
    }

    fn corners(&self) -> [[f64; 2]; 4] {
        [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|shares| self.at(shares))
    }

    fn transposed(&self) -> Self {
        let [[ux, uy], [vx, vy]] = self.edges;
        Self { centre: [self.centre[1], self.centre[0]], edges: [[uy, ux], [vy, vx]] }
    }
}

/// Part of a convex polygon on one side of a line of constant x: the greater with `sign` 1, the lesser with
/// −1.
fn clipped(polygon: &[[f64; 2]], x: f64, sign: f64) -> Vec<[f64; 2]> {
    let inside = |point: [f64; 2]| sign * (point[0] - x);
    let mut part = Vec::new();
    for (number, &from) in polygon.iter().enumerate() {
        let to = polygon[(number + 1) % polygon.len()];
        let (a, b) = (inside(from), inside(to));
        if a >= 0.0 {
            part.push(from);
        }
        if a * b < 0.0 {
            part.push([x, from[1] + (to[1] - from[1]) * a / (a - b)]);
        }
    }
    part
}

/// Area of a convex polygon and the y of its centroid; `None` if it has no area.
fn area_and_middle(polygon: &[[f64; 2]]) -> Option<(f64, f64)> {
    let origin = *polygon.first()?;
    let (mut twice, mut moment) = (0.0, 0.0);
    for pair in polygon[1..].windows(2) {
        let [a, b] = [pair[0], pair[1]].map(|point| [point[0] - origin[0], point[1] - origin[1]]);
        let cross = a[0] * b[1] - a[1] * b[0];
        twice += cross;
        moment += cross * (a[1] + b[1]) / 3.0;
    }
    (twice.abs() > 1e-12).then(|| (0.5 * twice.abs(), origin[1] + moment / twice))
}

#[cfg(test)]
#[path = "footprint_tests.rs"]
mod tests;
