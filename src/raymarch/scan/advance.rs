//! Advance from line to line: posts that come into sight, and lines that must be read more densely.

use super::blocks::{LineBlock, LinesBetween};
use super::cell_way::{CellWay, MOST_NEAR_PARTS, near_parts};
use super::ground::PlaneGround;
use super::lines::Lines;
use super::march::Planes;
use super::profile::{Post, ProfileEnd, SampleLine};
use super::strides::Stride;
use crate::simd::{Floats, Mask, Simd};
use hedgehop_base::error::Result;

/// An advance past posts with neither rim nor edge about, into the end of a profile.
pub(super) struct PlainAdvance<'p, V: Simd> {
    end: ProfileEnd<'p>,
    /// Greatest slope so far, and the slope at `reached`, as tangents.
    pub horizon: V::F,
    pub last: V::F,
    /// Major distance up to which it has come, units.
    pub reached: f32,
}

impl<'p, V: Simd> PlainAdvance<'p, V> {
    /// Begins where a march is.
    #[inline(always)]
    pub fn new(end: ProfileEnd<'p>, horizon: V::F, last: V::F, reached: f32) -> Self {
        Self { end, horizon, last, reached }
    }

    /// Goes to a post.
    #[inline(always)]
    pub fn reach(&mut self, post: &Post<V>) {
        self.end.add(post, self.horizon.lt(post.slope).any());
        self.horizon = self.horizon.max(post.slope);
        self.last = post.slope;
        self.reached = self.reached.max(post.line.distance);
    }

    /// Follows the bilinear surface to the line at the end of a way.
    #[inline(always)]
    pub fn follow(&mut self, ground: &PlaneGround<V>, lines: &Lines<'_>, way: &CellWay<V>) {
        for part in 1..=way.inner_parts() {
            self.reach(&way.post(ground, lines, part));
        }
    }

    /// Leaves the posts in the profile, and returns `horizon`, `last` and `reached`.
    #[inline(always)]
    pub fn finish(self) -> (V::F, V::F, f32) {
        self.end.finish();
        (self.horizon, self.last, self.reached)
    }
}

impl<'a, V: Simd> Planes<'_, 'a, V> {
    /// Goes to a line.
    #[inline(always)]
    pub(super) fn step(
        &mut self,
        lines: &Lines<'a>,
        block: &LineBlock,
        post: &Post<V>,
        near: bool,
    ) -> Result<()> {
        let rim = self.is_at_rim(post.slope);
        let mut post = *post;
        if block.stride.lines > 1 {
            if rim || self.is_steep(&post, 1.0) {
                post.line.span = self.divide(lines, block, &post, rim)? as u8;
            }
        } else {
            let steep = self.is_steep(&post, 1.0);
            if steep || near {
                self.follow(lines, &post, steep, rim);
            }
        }
        self.pass(lines, post, rim);
        Ok(())
    }

    /// A line of a block's level and stride.
    #[inline(always)]
    pub(super) fn mark(&self, block: &LineBlock, line: i64) -> SampleLine {
        let Stride { level, lines, stands_in, .. } = block.stride;
        let distance = self.way.distance(level, line) as f32;
        SampleLine { line, distance, share: 1.0, level, span: lines as u8, begins: false, stands_in }
    }

    /// Returns the mark at which the march begins at a major distance.
    pub(super) fn first_line(&self, block: &LineBlock, distance: f64) -> SampleLine {
        let (line, share) = self.way.line_at(block.stride.level, distance);
        let (distance, share) = (distance as f32, share as f32);
        SampleLine { distance, share, begins: true, ..self.mark(block, line) }
    }

    /// The surface along a line.
    #[inline(always)]
    pub(super) fn line(&self, lines: &Lines<'a>, block: &LineBlock, line: i64, span: u32) -> Post<V> {
        self.ground.line(lines, SampleLine { span: span as u8, ..self.mark(block, line) })
    }

    /// Reads lines between the last and the next one where the surface rises steeply, all of them at the `rim` of a void: how many
    /// lines they are apart.
    #[inline(always)]
    fn divide(&mut self, lines: &Lines<'a>, block: &LineBlock, post: &Post<V>, rim: bool) -> Result<i64> {
        let every = i64::from(block.stride.lines);
        let parts = if rim { every } else { self.steep.divisions(self.simd, self.stretch(post), every) };
        let between = self.way.between(block, post.line.line, parts, self.reached);
        let apart = between.step.abs();
        if between.count == 0 {
            return Ok(apart);
        }

        if lines.have(between.first) {
            self.read_between(lines, block, between, rim);
            return Ok(apart);
        }

        let level = block.stride.level;
        let nearest = self.way.distance(level, between.first);
        let posts = self.posts(level, [nearest, post.line.distance.into()]);
        if let Some(lines) =
            Lines::find(&mut self.march.pages, None, level, self.group.major, between.first, posts)?
        {
            self.read_between(&lines, block, between, rim);
        }

        Ok(apart)
    }

    /// Reads lines before one of a block.
    #[inline(always)]
    fn read_between(&mut self, lines: &Lines<'a>, block: &LineBlock, between: LinesBetween, rim: bool) {
        let LinesBetween { first, step, count } = between;
        for part in 0..count {
            let post = self.line(lines, block, first + step * part, step.unsigned_abs() as u32);
            self.pass(lines, post, rim);
        }
    }

    /// Returns the tangents between which planes see the stretch to a post rise.
    #[inline(always)]
    pub(super) fn stretch(&self, post: &Post<V>) -> [V::F; 2] {
        [self.horizon.max(self.last), post.slope]
    }

    /// Whether what is in sight of the stretch to a post rises more than `times` as high as it may.
    #[inline(always)]
    pub(super) fn is_steep(&self, post: &Post<V>, times: f32) -> bool {
        self.steep.is_passed(self.simd, self.stretch(post), times)
    }

    /// Follows the bilinear surface from the last line to the next one.
    #[inline(always)]
    fn follow(&mut self, lines: &Lines<'a>, post: &Post<V>, steep: bool, rim: bool) {
        let simd = self.simd;
        let mut parts = near_parts(post.line.level, post.line.distance);
        if steep {
            parts = parts.max(self.steep.parts(simd, self.stretch(post)));
        }

        // Planes leave the area, and enter it, at distances that all have in common: horizons are found by many parts.
        let at_edge = self.is_at_edge(post.line.distance);
        if at_edge {
            parts = MOST_NEAR_PARTS;
        }

        let way = CellWay::new(&self.ground, lines, self.reached, post.line, parts);
        if rim || at_edge {
            let way = way.even(simd);
            for part in 1..=way.inner_parts() {
                let post = way.post(&self.ground, lines, part);
                self.pass(lines, post, rim);
            }
            return;
        }

        let end = self.profile.end(way.inner_parts() as usize);
        let mut advance = PlainAdvance::<V>::new(end, self.horizon, self.last, self.reached);
        advance.follow(&self.ground, lines, &way);
        (self.horizon, self.last, self.reached) = advance.finish();
    }

    /// Takes in the surface from where the march is to a post; none beside the area.
    #[inline(always)]
    pub(super) fn reach(&mut self, post: Post<V>) {
        let mut seen = post;
        if self.is_at_edge(post.line.distance) {
            self.pass_edges(&post);
            seen.slope = self.over_area(post.slope, post.line.distance);
        }
        self.join(seen);
        self.last = post.slope;
        self.reached = post.line.distance;
    }

    #[inline(always)]
    pub(super) fn join(&mut self, post: Post<V>) {
        self.profile.add(&post, self.horizon.lt(post.slope).any());
        self.horizon = self.horizon.max(post.slope);
    }
}
