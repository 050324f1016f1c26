//! Advance from line to line: posts that come into sight, and lines that must be read more densely.

use super::blocks::LineBlock;
use super::ground::{Crease, PlaneGround};
use super::lines::Lines;
use super::march::{MarchField, Planes};
use super::profile::{Post, SampleLine};
use super::strides::Stride;
use crate::simd::{Each, Floats, Mask, Simd, Sixteen};
use crate::voxel::Grid;
use hedgehop_base::error::Result;

/// Parts of a near stretch, times its distance in lines; the error falls with their square.
pub(super) const NEAR_PARTS: f32 = 64.0;
/// Most parts of a stretch between lines, near or steep.
pub(super) const MOST_NEAR_PARTS: f32 = 16.0;
pub(super) const MOST_STEEP_PARTS: f32 = 32.0;

/// Rows that a stretch may rise over, and radians, before the lines between its ends, or the surface between neighbouring ones, are looked at: lines
/// are several pixels apart, which is a greater share of range the wider pixels are. From 0.7 mrad a pixel on radians are what counts.
const STEEP_ROWS: f32 = 2.3;
const STEEP_ANGLE: f32 = 0.0016;

/// The way through the cells between two neighbouring lines.
struct CellWay<V: Simd> {
    /// Line at its end, and major distance at which it begins, units.
    line: SampleLine,
    from: f32,
    /// Distance from line to line, units.
    side: f32,
    /// Shares of the way after which half of its parts end, and how many that are.
    crease: V::F,
    halves: i32,
}

impl<V: Simd> CellWay<V> {
    /// The bilinear surface at the end of one of its parts, counted from 1.
    #[inline(always)]
    fn post(&self, ground: &PlaneGround<V>, lines: &Lines<'_>, part: i32) -> Post<V> {
        let (simd, SampleLine { level, line, distance: to, .. }) = (ground.simd, self.line);
        let way = part as f32 / self.halves as f32;
        let beyond = simd.splat((way - 1.0).max(0.0));
        let (near, far) = (simd.splat(self.from), simd.splat(to));
        let at = self.crease.mul_add(simd.splat(way.min(1.0)) - beyond, beyond).mul_add(far - near, near);

        let share = (at - far).mul_add(simd.splat(1.0 / self.side), simd.splat(1.0));
        let z = ground.surface(lines, level, line, at, share);
        let inverse = ground.per_depth * at.recip();
        let distance = self.from + (to - self.from) * 0.5 * way;
        let line = SampleLine { distance, share: 1.0 - (to - distance) / self.side, ..self.line };
        Post { slope: ground.slope(z, inverse), inverse, line }
    }
}

impl MarchField {
    /// Tangents that a stretch may rise over before the surface between its ends is looked at: anywhere, and at level sight, from
    /// where it grows as the tangent of an angle does.
    pub(super) fn steep_rises(&self) -> [f32; 2] {
        let [lowest, highest] = self.tangents;
        let flattest = 0.0_f32.max(lowest).min(highest);
        let [row, angle] = self.row.each(|row| STEEP_ROWS * row);
        let steep = [row.min(STEEP_ANGLE * flattest.mul_add(flattest, 1.0)), angle.min(STEEP_ANGLE)];
        steep.each(|rise| rise / self.detail)
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
                self.follow(lines, block.stride.level, &post, steep, rim);
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
        let mark = SampleLine { span: span as u8, ..self.mark(block, line) };
        let at = self.simd.splat(mark.distance);
        lines.prefetch(self.simd, (line - lines.first[0]) as i32);
        self.post(self.ground.height(self.ground.codes(lines, mark.level, line, at), at), mark)
    }

    /// Reads lines between the last and the next one where the surface rises steeply, all of them at the `rim` of a void: how many
    /// lines they are apart.
    #[inline(always)]
    fn divide(&mut self, lines: &Lines<'a>, block: &LineBlock, post: &Post<V>, rim: bool) -> Result<i64> {
        let line = post.line.line;
        let every = i64::from(block.stride.lines);
        let parts = if rim || self.is_steep(post, 2.0) { every } else { 2 };
        let step = block.step.signum() * every / parts;

        // After a change of stride some of them may lie before the last one.
        let reached = f64::from(self.reached);
        let mut between = parts - 1;
        while between > 0 && self.way.distance(block.stride.level, line - step * between) <= reached {
            between -= 1;
        }
        if between == 0 {
            return Ok(step.abs());
        }

        let nearest = line - step * between;
        if lines.have(nearest) {
            self.read_between(lines, block, [line, step, between], rim);
            return Ok(step.abs());
        }

        let level = block.stride.level;
        let posts = self.posts(level, [self.way.distance(level, nearest), post.line.distance.into()]);
        if let Some(lines) =
            Lines::find(&mut self.march.pages, None, level, self.group.major, nearest, posts)?
        {
            self.read_between(&lines, block, [line, step, between], rim);
        }

        Ok(step.abs())
    }

    /// Reads `count` (1 to 3) lines before a line, `step` apart.
    #[inline(always)]
    fn read_between(
        &mut self,
        lines: &Lines<'a>,
        block: &LineBlock,
        [line, step, count]: [i64; 3],
        rim: bool,
    ) {
        let span = step.unsigned_abs() as u32;
        // All first: reads that wait for nothing overlap.
        let mut slopes = [Sixteen::default(); 3];
        for part in 0..count {
            let post = self.line(lines, block, line - step * (count - part), span);
            post.slope.store(&mut slopes[part as usize].0);
        }
        for part in 0..count {
            let line = line - step * (count - part);
            let post = Post {
                line: SampleLine { span: span as u8, ..self.mark(block, line) },
                ..self.stored(block, line, &slopes[part as usize])
            };
            self.pass(lines, post, rim);
        }
    }

    /// Whether what is in sight of the stretch to a post rises more than `times` as high as it may.
    #[inline(always)]
    pub(super) fn is_steep(&self, post: &Post<V>, times: f32) -> bool {
        let simd = self.simd;
        let begin = self.horizon.max(self.last);
        let [least, level] = [simd.splat(times * self.steep[0]), simd.splat(times * self.steep[1])];
        // Of the stretch's tangents the flattest.
        let flattest = begin.max(simd.splat(0.0) - post.slope).max(simd.splat(0.0));
        let steep = least.max((flattest * flattest).mul_add(level, level));
        steep.lt(post.slope - begin).any()
    }

    /// Follows the bilinear surface from the last line to the next one.
    #[inline(always)]
    fn follow(&mut self, lines: &Lines<'a>, level: u8, post: &Post<V>, steep: bool, rim: bool) {
        let side = Grid::side_units(level) as f32;
        let [from, to] = [self.reached, post.line.distance];
        let mut parts = (NEAR_PARTS * side / to).clamp(1.0, MOST_NEAR_PARTS);

        if steep {
            let mut least = 2.0;
            while least < MOST_STEEP_PARTS && self.is_steep(post, least) {
                least *= 2.0;
            }
            parts = parts.max(least);
        }

        // Planes leave the area, and enter it, at distances that all have in common: horizons are found by many parts.
        let at_edge = self.is_at_edge(to);
        if at_edge {
            parts = MOST_NEAR_PARTS;
        }

        // Where a plane crosses a column of posts the surface has a crease, which may be a horizon: half of the parts end there.
        let simd = self.simd;
        let Crease { crosses, share, .. } =
            self.ground.crease(lines, level, [simd.splat(from), simd.splat(to)]);
        let half = simd.splat(0.5);
        let crease = if rim || at_edge { half } else { share.select(crosses, half) };
        let halves = (parts as i32 / 2).max(i32::from(crosses.any()));
        let way = CellWay { line: post.line, from, side, crease, halves };

        if rim || at_edge {
            for part in 1..2 * halves {
                let post = way.post(&self.ground, lines, part);
                self.pass(lines, post, rim);
            }
            return;
        }

        let (mut horizon, mut last, mut reached) = (self.horizon, self.last, from);
        let mut end = self.profile.end(2 * halves as usize);
        for part in 1..2 * halves {
            let post = way.post(&self.ground, lines, part);
            end.add(&post, horizon.lt(post.slope).any());
            horizon = horizon.max(post.slope);
            (last, reached) = (post.slope, post.line.distance);
        }
        end.finish();
        (self.horizon, self.last, self.reached) = (horizon, last, reached);
    }

    /// The surface at height `z` above the eye along a line.
    #[inline(always)]
    pub(super) fn post(&self, z: V::F, mark: SampleLine) -> Post<V> {
        let inverse = self.ground.per_depth * self.simd.splat(1.0 / mark.distance.max(f32::MIN_POSITIVE));
        Post { slope: self.ground.slope(z, inverse), inverse, line: mark }
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
