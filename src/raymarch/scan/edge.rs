//! The area's edge: half a voxel behind its outermost lines, up to which the surface goes on level.
//!
//! ```text
//! the last line lies ahead  → it is read, also if it is none of the stride's
//! nothing is known there    → the surface begins where planes are: all that they see of the area may lie behind it
//! from there to the edge      heights are the last line's, where planes are beside it
//! ```

use super::blocks::LineBlock;
use super::cell_way::near_parts;
use super::lines::Lines;
use super::march::Planes;
use super::profile::{NO_SLOPE, Post, SampleLine};
use super::steep::MOST_STEEP_PARTS;
use super::strides::Stride;
use crate::simd::{Floats, Mask, Simd};
use crate::voxel::{BARE, Grid};
use hedgehop_base::error::Result;

/// Distances that differ by less than this, in sides of a voxel, are one and the same line.
const SAME: f64 = 1.0e-3;

/// Major distance at which no plane is over the area any more, per that at which the last one leaves it.
const BEYOND: f32 = 1.0001;

impl<'a, V: Simd> Planes<'_, 'a, V> {
    /// Goes to the area's last line, if strides left it out, and begins behind it if nothing is known yet. `None`: no plane sees anything behind it.
    #[cold]
    pub(super) fn march_last_line(&mut self, stride: Stride) -> Result<Option<(Lines<'a>, LineBlock)>> {
        let mut stride = Stride { lines: 1, ..stride };
        while stride.level < self.march.level_count || stride.level == BARE {
            let block = self.way.last_line(stride);
            let slack = SAME * f64::from(Grid::side_units(stride.level));
            if self.way.distance(stride.level, block.first) > f64::from(self.reached) + slack {
                self.march_block(&block)?;
            }
            if self.reached >= self.farthest || !self.is_begun && self.is_hidden(&block)? {
                return Ok(None);
            }
            let posts = self.posts(stride.level, [self.reached.into(), self.farthest.into()]);
            let pages = &mut self.march.pages;
            if let Some(lines) = Lines::find(pages, None, stride.level, self.group.major, block.first, posts)?
            {
                if !self.is_begun {
                    self.prime(&LineBlock { first: block.first + block.step, ..block })?;
                }
                return Ok(Some((lines, block)));
            }
            stride = Stride { level: stride.coarser(), stands_in: true, ..stride };
        }

        Ok(None)
    }

    /// Takes in the surface behind the last line.
    #[inline(always)]
    pub(super) fn pass_last_line(&mut self, lines: &Lines<'a>, block: &LineBlock) {
        let level = block.stride.level;
        let (from, to) = (self.reached, self.farthest * BEYOND);
        let mut parts = 1.0_f32;
        if self.is_steep(&self.behind(lines, block, to), 1.0) {
            parts = MOST_STEEP_PARTS;
        }
        if self.is_near(level) {
            parts = parts.max(near_parts(level, to));
        }
        let parts = parts as i32;
        for part in 1..=parts {
            let share = part as f32 / parts as f32;
            self.reach(self.behind(lines, block, (to - from).mul_add(share, from)));
        }
    }

    /// The surface at a major distance behind a line: as high as the line, and of its colour.
    #[inline(always)]
    fn behind(&self, lines: &Lines<'a>, block: &LineBlock, distance: f32) -> Post<V> {
        let at = self.simd.splat(distance);
        let codes = self.ground.codes(lines, block.stride.level, block.first, at);
        let span = self.profile.last_line().span;
        let mark = SampleLine { distance, span, ..self.mark(block, block.first) };
        let z = self.displaced(mark.level, self.ground.height(codes, at), at);
        self.ground.post(z, mark)
    }

    /// Whether some plane enters or leaves the area between here and a major distance.
    #[inline(always)]
    pub(super) fn is_at_edge(&self, distance: f32) -> bool {
        self.reached < self.inner[0] || distance > self.inner[1]
    }

    /// Slopes at a major distance, none beside the area.
    #[inline(always)]
    pub(super) fn over_area(&self, slope: V::F, distance: f32) -> V::F {
        if distance >= self.inner[0] && distance <= self.inner[1] {
            return slope;
        }
        slope.select(self.is_over_area(distance), self.simd.splat(NO_SLOPE))
    }

    /// Planes that are over the area at a major distance.
    #[inline(always)]
    pub(super) fn is_over_area(&self, distance: f32) -> V::M {
        let at = self.simd.splat(distance);
        self.over[0].le(at) & at.le(self.over[1])
    }

    /// Carries planes that enter or leave the area before a post to its edge: the surface goes straight there.
    #[cold]
    pub(super) fn pass_edges(&mut self, post: &Post<V>) {
        let [_, inverse] = self.profile.last(self.simd);
        let from =
            Post { slope: self.last, inverse, line: SampleLine { distance: self.reached, ..post.line } };
        let (before, after) = (self.is_over_area(self.reached), self.is_over_area(post.line.distance));
        let [enter, leave] = self.over;
        let (here, there) = (self.simd.splat(self.reached), self.simd.splat(post.line.distance));
        // Over a corner planes do both.
        let corner = !before & !after & here.lt(enter) & enter.lt(leave) & leave.lt(there);
        for (planes, edge) in [(after & !before | corner, enter), (before & !after | corner, leave)] {
            if planes.any() {
                self.join(self.edge(planes, edge, &from, post));
            }
        }
    }

    /// Returns the posts of `planes` on the area's edge between two posts; the others stay at `from` meanwhile.
    #[inline(always)]
    fn edge(&self, planes: V::M, distance: V::F, from: &Post<V>, to: &Post<V>) -> Post<V> {
        let simd = self.simd;
        let inverse = (self.ground.depth * distance.max(simd.splat(f32::MIN_POSITIVE))).recip();
        let share = (distance - simd.splat(from.line.distance))
            * simd.splat(1.0 / (to.line.distance - from.line.distance));
        let (near, far) = (from.slope / from.inverse, to.slope / to.inverse);
        let slope = ((far - near).mul_add(share, near) * inverse).max(simd.splat(NO_SLOPE));
        let [stays, stays_at] = self.profile.last(simd);
        Post { slope: slope.select(planes, stays), inverse: inverse.select(planes, stays_at), line: to.line }
    }
}
