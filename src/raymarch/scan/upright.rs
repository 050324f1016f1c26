//! The planes and rows that a planar screen needs.
//!
//! Vertical planes through the eye meet a planar screen in lines through one point, the nadir's image. Turned
//! upright (roll taken out, pitch kept) they meet each row of the screen at equal distances: with
//! `x`, `y` on the upright screen (pixels from its centre, y up, focal length f, pitch p)
//!
//! ```text
//! w = cos p − y/f · sin p                    horizontal depth per depth along the optical axis
//! a = x/f / w                                tangent of the plane's angle to the heading
//! t = (y/f · cos p + sin p) / w              tangent of the elevation, times 1/√(1 + a²) of it
//! ```
//!
//! so that a plane is an `a` and a row is a `t`, whatever the pitch: the rows of the march are those of the upright
//! screen, planes need interpolation along one axis only, and roll turns the picture as a whole (the
//! patent's image stage).

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::{PlaneGroup, RowCoordinate};
use crate::simd::{Each, Floats, LANES, Simd, Sixteen};
use crate::space::{Attitude, Camera, Screen};
use crate::voxel::Grid;

/// Least share of horizontal depth in depth: steeper views need too many planes.
const LEAST_HORIZONTAL: f64 = 0.25;

/// Most that `a` may grow from one plane to the next: sixteen planes then span less than 30°, and run along one axis.
const WIDEST_STEP: f64 = 1.0 / 32.0;

/// Roll that moves no pixel by more than this, in pixels, is none.
const LEVEL: f64 = 1.0e-3;

/// Tangent of the roll up to which a cubic along the screen's columns shows what one along rows and planes does: within 0.2 dB of the truth. At 45° it costs
/// 1.4 dB.
const MOST_SLANT: f64 = 0.5;

/// Rows and planes beyond the screen's edge that interpolation may touch.
const MARGIN: f64 = 1.5;

/// A planar screen as scan planes see it.
#[derive(Debug, Clone, PartialEq)]
pub struct Upright {
    focal: f64,
    /// Sine and cosine of pitch and of roll.
    pitch: [f64; 2],
    roll: [f64; 2],
    /// The heading, and to its right: ground metres per metre of depth.
    ahead: DVec2,
    right: DVec2,
    /// Screen's centre, pixels.
    centre: DVec2,
    /// `a` of plane 0, and from one plane to the next.
    plane: [f64; 2],
    /// `y` of row 0, pixels.
    row: f64,
    /// Planes, a multiple of the lanes, and rows.
    pub size: [usize; 2],
    /// Corners of the screen, as (a, t), in order around it.
    corners: [DVec2; 4],
}

/// Directions of sixteen pixels, and their places in the plane image.
pub struct UprightGaze<V: Simd> {
    /// `a`: to the right per metre of depth.
    pub across: V::F,
    /// `t`: up per metre of depth.
    pub tangent: V::F,
    /// Plane, fractional; centres at integers.
    pub plane: V::F,
    /// Row, fractional; centres at integers.
    pub row: V::F,
}

impl Upright {
    /// Builds the planes of a planar screen; `None` for another, or where planes would crowd: a view too steep.
    pub fn new(camera: &Camera) -> Option<Self> {
        let Screen::Planar { .. } = camera.screen() else { return None };
        let Attitude { yaw, pitch, roll } = camera.pose.attitude;
        let (yaw, pitch, roll) =
            (yaw.to_radians().sin_cos(), pitch.to_radians().sin_cos(), roll.to_radians().sin_cos());
        let focal = camera.focal_px();
        let centre = DVec2::new(f64::from(camera.width), f64::from(camera.height)) * 0.5;

        // Trajectories leave a roll of 10⁻¹⁵ where there is none.
        let is_level = roll.1 > 0.0 && roll.0.abs() * centre.length() < LEVEL;
        let roll = if is_level { (0.0, 1.0) } else { roll };
        let turn = |x: f64, y: f64| DVec2::new(x * roll.1 + y * roll.0, y * roll.1 - x * roll.0);
        let outline = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| turn(x * (centre.x + MARGIN), y * (centre.y + MARGIN)));
        let horizontal = |y: f64| pitch.1 - y / focal * pitch.0;
        let least = outline.iter().map(|at| horizontal(at.y)).fold(f64::INFINITY, f64::min);
        let reach = outline.iter().map(|at| at.length()).fold(0.0, f64::max);
        if least < LEAST_HORIZONTAL * (1.0 + (reach / focal).powi(2)).sqrt().min(2.0) {
            return None;
        }

        let corners = outline.map(|at| {
            let depth = horizontal(at.y);
            DVec2::new(at.x / focal / depth, (at.y / focal * pitch.1 + pitch.0) / depth)
        });
        let fold = |values: [f64; 4]| {
            values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &value| {
                [low.min(value), high.max(value)]
            })
        };
        let rows = fold(outline.map(|at| at.y));
        let across = fold(corners.map(|corner| corner.x));

        // Planes are a pixel apart at the horizon, or at the row of the screen that is nearest to it.
        let nearest = (-focal * pitch.0 / pitch.1).clamp(rows[0], rows[1]);
        let step = (1.0 / (focal * horizontal(nearest))).min(WIDEST_STEP);

        // Rows lie where those of the screen do, or its columns if it is rolled that far.
        let phase = 0.5 - if roll.1.abs() >= roll.0.abs() { centre.y } else { centre.x };
        let first = if is_level { phase } else { (rows[0] - phase).floor() + phase };
        let last = if is_level { centre.y - 0.5 } else { (rows[1] - phase).ceil() + phase };
        let planes = ((across[1] - across[0]) / step).ceil() as usize + 1;

        Some(Self {
            focal,
            pitch: [pitch.0, pitch.1],
            roll: [roll.0, roll.1],
            ahead: DVec2::new(yaw.0, yaw.1),
            right: DVec2::new(yaw.1, -yaw.0),
            centre,
            plane: [across[0], step],
            row: first,
            size: [planes.next_multiple_of(LANES), (last - first).round() as usize + 1],
            corners,
        })
    }

    /// Tangents of elevation of the rows' lower edges, rising, and of the last one's upper edge.
    pub fn edges(&self) -> Vec<f32> {
        (0..=self.size[1]).map(|row| self.tangent(row as f64 - 0.5) as f32).collect()
    }

    /// Tangents of elevation of the rows' middles, rising.
    pub fn centres(&self) -> Vec<f32> {
        (0..self.size[1]).map(|row| self.tangent(row as f64) as f32).collect()
    }

    /// Rows by the tangent of elevation.
    pub fn row_coordinate(&self, edges: &[f32]) -> RowCoordinate {
        RowCoordinate::projective(self.pitch, self.focal, (self.row - 0.5) / self.focal, edges)
    }

    fn tangent(&self, row: f64) -> f64 {
        let [sin, cos] = self.pitch;
        let y = (self.row + row) / self.focal;
        (y * cos + sin) / (cos - y * sin)
    }

    /// Converts rises for each unit of the tangent to rises for each row, of the planes of a group that are filled.
    pub fn per_row(&self, index: usize, [_, along]: [&mut [Sixteen]; 2]) {
        let [first, per_row] = self.horizontal().each(f64::from);
        for (row, lanes) in self.rows(index).zip(along) {
            let horizontal = first + row as f64 * per_row;
            let tangents = (1.0 / (self.focal * horizontal * horizontal)) as f32;
            lanes.0.iter_mut().for_each(|lane| *lane *= tangents);
        }
    }

    /// Horizontal depth per depth along the optical axis: of row 0, and from one row to the next.
    pub fn horizontal(&self) -> [f32; 2] {
        let per_row = -self.pitch[0] / self.focal;
        [(self.pitch[1] + self.row * per_row) as f32, per_row as f32]
    }

    /// Groups of sixteen planes.
    pub fn groups(&self) -> usize {
        self.size[0] / LANES
    }

    /// The planes of a group, from `eye` (units).
    pub fn group(&self, index: usize, grid: &Grid, eye: DVec3, inverse_diameter: f64) -> PlaneGroup {
        let directions = std::array::from_fn(|lane| {
            let a = self.plane[0] + (index * LANES + lane) as f64 * self.plane[1];
            self.ahead + self.right * a
        });
        PlaneGroup::new(grid, eye.truncate(), &directions, inverse_diameter)
    }

    /// 1 + a² of the planes of a group: squared ground distance per squared depth.
    pub fn squares(&self, index: usize) -> [f32; LANES] {
        std::array::from_fn(|lane| {
            let a = self.plane[0] + (index * LANES + lane) as f64 * self.plane[1];
            (1.0 + a * a) as f32
        })
    }

    /// Rows of a group that some pixel of the screen needs.
    pub fn rows(&self, index: usize) -> Range<usize> {
        let at = |plane: f64| self.plane[0] + plane * self.plane[1];
        let strip = [at((index * LANES) as f64 - MARGIN), at(((index + 1) * LANES) as f64 + MARGIN)];
        let mut extent = [f64::INFINITY, f64::NEG_INFINITY];
        let mut add = |t: f64| extent = [extent[0].min(t), extent[1].max(t)];

        for (index, from) in self.corners.iter().enumerate() {
            let to = self.corners[(index + 1) % self.corners.len()];
            if (strip[0]..=strip[1]).contains(&from.x) {
                add(from.y);
            }
            for edge in strip {
                let share = (edge - from.x) / (to.x - from.x);
                if (0.0..=1.0).contains(&share) {
                    add(from.y + share * (to.y - from.y));
                }
            }
        }

        if extent[0] > extent[1] {
            return 0..0;
        }

        let row = |t: f64| {
            let [sin, cos] = self.pitch;
            // t of y, solved for y.
            self.focal * (t * cos - sin) / (cos + t * sin) - self.row
        };
        let first = (row(extent[0]) - MARGIN).floor().max(0.0) as usize;
        let end = (row(extent[1]) + MARGIN).ceil().max(0.0) as usize + 1;

        first.min(self.size[1])..end.min(self.size[1])
    }

    /// Whether rows of the screen are rows of the plane image.
    pub fn is_level(&self) -> bool {
        self.roll == [0.0, 1.0]
    }

    /// Whether the plane image may be read down the screen's columns: they are nearly upright in it.
    pub fn is_read_by_columns(&self) -> bool {
        self.roll[0].abs() <= MOST_SLANT * self.roll[1]
    }

    /// Width of the screen, columns.
    pub fn width(&self) -> usize {
        (2.0 * self.centre.x) as usize
    }

    /// Returns planes, fractional, where columns of a rolled screen cross a row of the plane image: from one column to the next, and in the screen's middle.
    /// Columns do not run along rows.
    pub fn crossings(&self, row: i32) -> [f64; 2] {
        let [sin, cos] = self.roll;
        let up = self.row + f64::from(row);
        // On the upright screen: across = x / cos + up · tan.
        let per_across = 1.0 / (self.plane[1] * (self.focal * self.pitch[1] - up * self.pitch[0]));
        [per_across / cos, up * (sin / cos) * per_across - self.plane[0] / self.plane[1]]
    }

    /// Returns rows of the plane image, fractional, along a row of the screen: from one column to the next, and in the screen's middle.
    pub fn slant(&self, row: f64) -> [f64; 2] {
        let [sin, cos] = self.roll;
        [-sin, (self.centre.y - row) * cos - self.row]
    }

    /// Returns the direction of a row of an unrolled screen, and its place in the plane image; `None` if the screen is rolled.
    pub fn level_row(&self, row: f64) -> Option<LevelRow> {
        if !self.is_level() {
            return None;
        }
        let up = self.centre.y - row;
        let [sin, cos] = self.pitch;
        let horizontal = cos - up / self.focal * sin;
        let across = 1.0 / (self.focal * horizontal);
        let per_plane = 1.0 / self.plane[1];
        Some(LevelRow {
            across: across as f32,
            tangent: ((up / self.focal * cos + sin) / horizontal) as f32,
            planes: [across * per_plane, -self.plane[0] * per_plane],
            row: ((up - self.row).round() as usize).min(self.size[1] - 1),
        })
    }

    /// Pixels of row `row`, from its upper edge, at columns `x`, from the screen's middle; both in pixels.
    #[inline(always)]
    pub fn look<V: Simd>(&self, simd: V, x: V::F, row: f32) -> UprightGaze<V> {
        let down = simd.splat((self.centre.y - f64::from(row)) as f32);
        let (sin, cos) = (simd.splat(self.roll[0] as f32), simd.splat(self.roll[1] as f32));
        let across = x.mul_add(cos, down * sin);
        let up = x.neg_mul_add(sin, down * cos);
        let [sin, cos] = self.pitch;
        let per_focal = 1.0 / self.focal;
        let horizontal = up.neg_mul_add(simd.splat((sin * per_focal) as f32), simd.splat(cos as f32)).recip();
        let across = across * simd.splat(per_focal as f32) * horizontal;
        let tangent = up.mul_add(simd.splat((cos * per_focal) as f32), simd.splat(sin as f32)) * horizontal;
        let plane = (across - simd.splat(self.plane[0] as f32)) * simd.splat((1.0 / self.plane[1]) as f32);
        UprightGaze { across, tangent, plane, row: up - simd.splat(self.row as f32) }
    }
}

/// A row of an unrolled screen: what follows from a pixel's column is linear in it.
#[derive(Debug, Clone, Copy)]
pub struct LevelRow {
    /// `a` from one column to the next; it is 0 in the screen's middle.
    pub across: f32,
    /// Tangent of elevation.
    pub tangent: f32,
    /// Planes, fractional: from one column to the next, and in the screen's middle.
    pub planes: [f64; 2],
    /// Row of the plane image.
    pub row: usize,
}
