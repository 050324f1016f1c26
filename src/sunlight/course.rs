//! Course of the sun's rays over the posts of a level.

use std::ops::Range;

use super::Sun;
use crate::voxel::{Grid, Header, PAGE_SIDE, PageId, RADIX};

/// Half the sun's width, degrees.
pub const SUN_SEMIDIAMETER: f64 = 0.2666;

/// Least and greatest height of a rim of the sun, degrees: one that sets shines level.
const RIMS: [f64; 2] = [0.005, 89.9];

/// Rows of a level from which a shadow may come, in levels that have a coarser one. That far away the half-shadow of a sharp edge is 4.2 voxels wide, so
/// that the next level shows no less of it.
const REACH: i64 = 448;

/// The sun's way over a database. Rows are posts side by side across it, and strands run along it: strand `k` crosses row `n` at
/// post `k + lean·n` of that row.
#[derive(Debug, Clone)]
pub(super) struct Course {
    grid: Grid,
    level_count: u8,
    /// Axis across rows: 0 eastward, 1 northward.
    pub major: usize,
    /// 1: the sun stands where rows have higher numbers; −1: lower ones.
    pub towards: i64,
    /// Posts aside from one row to the next, −1…1.
    pub lean: f64,
    /// Length of a strand from row to row, voxels.
    stride: f64,
    /// Falls of rays from the sun's upper and lower rim, metres per metre.
    falls: [f64; 2],
    /// Fall of rays from the sun's middle.
    fall: f64,
    /// Height of the highest ground above the lowest, metres.
    relief: f64,
}

/// A stretch of the way on one level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Leg {
    pub level: u8,
    /// Row, also between two, at which it ends.
    pub end: f64,
    /// Nearest of its rows; the first is the farthest from the sun.
    pub near: i64,
    pub count: i64,
    /// First of its strands.
    pub first: i64,
    pub strands: usize,
}

impl Course {
    pub fn new(header: &Header, sun: Sun) -> Self {
        let (sin, cos) = sun.azimuth.to_radians().sin_cos();
        let along = [sin, cos];
        let major = usize::from(cos.abs() >= sin.abs());
        let lean = along[1 - major] / along[major];
        let fall = |degrees: f64| degrees.clamp(RIMS[0], RIMS[1]).to_radians().tan();
        Self {
            grid: header.grid,
            level_count: header.level_count,
            major,
            towards: if along[major] > 0.0 { 1 } else { -1 },
            lean,
            stride: lean.hypot(1.0),
            falls: [SUN_SEMIDIAMETER, -SUN_SEMIDIAMETER].map(|rim| fall(sun.elevation + rim)),
            fall: fall(sun.elevation),
            relief: header.height_range.high - header.height_range.low,
        }
    }

    /// Metres that rays of the sun's upper and lower rim fall from row to row.
    pub fn falls(&self, level: u8) -> [f32; 2] {
        self.falls.map(|fall| (fall * self.stride * self.grid.side(level)) as f32)
    }

    /// Metres along the ground from row to row.
    pub fn way(&self, level: u8) -> f32 {
        (self.stride * self.grid.side(level)) as f32
    }

    /// Returns how much more a ray of the sun's upper rim falls than one of its lower, metres per metre.
    pub fn spread(&self) -> f32 {
        (self.falls[0] - self.falls[1]) as f32
    }

    /// Metres that a ray falls over a voxel.
    pub fn fall_over_voxel(&self, level: u8) -> f32 {
        (self.fall * self.grid.side(level)) as f32
    }

    /// Posts of a level, by axis.
    pub fn dims(&self, level: u8) -> [i64; 2] {
        let (nx, ny) = self.grid.dims(level);
        [i64::from(nx), i64::from(ny)]
    }

    /// Whole posts aside of a strand's number at a row, and the rest, 0…1.
    pub fn aside(&self, row: i64) -> (i64, f32) {
        let aside = self.lean * row as f64;
        (aside.floor() as i64, (aside - aside.floor()) as f32)
    }

    /// Strands that cross `rows` of `posts`, and those beside them.
    pub fn strands(&self, rows: &Range<i64>, posts: &Range<i64>) -> (i64, usize) {
        let asides = [rows.start, rows.end - 1].map(|row| self.lean * row as f64);
        let first = (posts.start as f64 - asides[0].max(asides[1])).floor() as i64;
        let last = (posts.end as f64 - 1.0 - asides[0].min(asides[1])).floor() as i64;
        (first, (last + 2 - first) as usize)
    }

    /// The way that leads to `strands` of a level at row `end` (between two rows), the last stretch of it first.
    pub fn legs(&self, level: u8, end: f64, first: i64, strands: usize) -> Vec<Leg> {
        let mut legs = Vec::new();
        let mut left = self.relief / self.falls[1];
        let mut leg = Leg { level, end, near: 0, count: 0, first, strands };
        loop {
            let row = self.stride * self.grid.side(leg.level);
            let rows = self.dims(leg.level)[self.major];
            leg.near = if self.towards > 0 { leg.end.ceil() as i64 } else { leg.end.floor() as i64 };
            let there = if self.towards > 0 { rows - leg.near } else { leg.near + 1 };

            // A float converts saturating.
            let wanted = there.min((left / row).ceil() as i64);
            if wanted <= 0 {
                return legs;
            }

            let is_coarsest = leg.level + 1 == self.level_count;
            leg.count = if is_coarsest { wanted } else { wanted.min(REACH) };
            legs.push(leg);
            if leg.count == wanted {
                return legs;
            }

            left -= row * leg.count as f64;
            leg = self.coarser(&leg);
        }
    }

    /// Finds where the stretch before `leg` ends, one level coarser.
    fn coarser(&self, leg: &Leg) -> Leg {
        let end = coarser_post(leg.begin(self.towards));
        let strand = |number: i64| self.coarser_strand(leg, number).floor() as i64;
        let last = leg.first + leg.strands as i64 - 1;
        let first = strand(leg.first);
        let strands = (strand(last) + 2 - first) as usize;
        Leg { level: leg.level + 1, end, near: 0, count: 0, first, strands }
    }

    /// The strand, also between two, of the next coarser level that goes on towards the sun where one of a leg begins.
    pub fn coarser_strand(&self, leg: &Leg, number: i64) -> f64 {
        let begin = leg.begin(self.towards);
        coarser_post(number as f64 + self.lean * begin) - self.lean * coarser_post(begin)
    }

    /// Pages on which a leg's rows lie.
    pub fn pages(&self, leg: &Leg, mut put: impl FnMut(PageId)) {
        let side = i64::from(PAGE_SIDE);
        let dims = self.dims(leg.level);
        let rows = leg.rows(self.towards);
        let mut from = rows.start;
        while from < rows.end {
            let page = from.div_euclid(side);
            let until = rows.end.min((page + 1) * side);
            let asides = [from, until - 1].map(|row| self.aside(row).0);
            let low = leg.first + asides[0].min(asides[1]);
            let high = leg.first + asides[0].max(asides[1]) + leg.strands as i64;
            let (low, high) = (low.max(0), high.min(dims[1 - self.major] - 1));
            for across in low.div_euclid(side)..=high.div_euclid(side) {
                let [px, py] = if self.major == 0 { [page, across] } else { [across, page] };
                put(PageId { level: leg.level, px: px as u32, py: py as u32 });
            }
            from = until;
        }
    }
}

impl Leg {
    /// Row, between two, at which it begins on the side of the sun.
    fn begin(&self, towards: i64) -> f64 {
        self.near as f64 + (self.count as f64 - 0.5) * towards as f64
    }

    fn rows(&self, towards: i64) -> Range<i64> {
        if towards > 0 {
            self.near..self.near + self.count
        } else {
            self.near + 1 - self.count..self.near + 1
        }
    }
}

/// Converts a place in posts of a level to posts of the next coarser one.
fn coarser_post(post: f64) -> f64 {
    (post + 0.5) / f64::from(RADIX) - 0.5
}
