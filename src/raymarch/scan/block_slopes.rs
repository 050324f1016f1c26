//! The surface along all lines of a block, and the march over those that no void and no edge is near: most of them.
//!
//! ```text
//! slopes of all lines                                       reads that wait for nothing overlap
//! none is above a horizon        → the block is passed over
//! for each line of the block:
//!     it is steep                → the lines between, or the surface before it
//!     above a horizon            → a segment ends here
//!     the horizon rises to it
//! ```

use super::advance::PlainAdvance;
use super::blocks::{LineBlock, Way};
use super::cell_way::{CellWay, near_parts};
use super::lines::Lines;
use super::march::{MOST_LINES, Planes};
use super::profile::{NO_SLOPE, Post, SampleLine};
use super::steep::MOST_STEEP_PARTS;
use crate::simd::{Floats, Ints, Mask, Simd, Sixteen};
use crate::voxel::{Grid, HeightCode};
use hedgehop_base::error::Result;

/// Slopes of the surface along the lines of a block.
pub(super) struct BlockSlopes<V: Simd> {
    /// Major distances of the lines, units, and one by them.
    distance: [f32; MOST_LINES],
    per_distance: [f32; MOST_LINES],
    /// Slopes along them.
    slope: [Sixteen; MOST_LINES],
    /// Greatest slope of each plane.
    pub highest: V::F,
    /// Whether all planes have a surface along all of the lines.
    pub is_whole: bool,
}

impl<V: Simd> BlockSlopes<V> {
    /// Nothing yet, along the lines of `block`.
    #[inline(always)]
    fn new(simd: V, way: &Way, block: &LineBlock) -> Self {
        let side = f64::from(Grid::side_units(block.stride.level));
        let (first, step) =
            (way.distance(block.stride.level, block.first), side * f64::from(block.stride.lines));
        let mut distance = [1.0; MOST_LINES];
        for (index, distance) in distance.iter_mut().enumerate() {
            *distance = (first + index as f64 * step) as f32;
        }
        Self {
            distance,
            per_distance: distance.map(|distance| 1.0 / distance),
            slope: [Sixteen::default(); MOST_LINES],
            highest: simd.splat(NO_SLOPE),
            is_whole: false,
        }
    }

    /// The slope along one line.
    #[inline(always)]
    pub fn slope(&self, index: i64) -> &Sixteen {
        &self.slope[index as usize]
    }
}

impl<'a, V: Simd> Planes<'_, 'a, V> {
    /// Finds the slopes of the surface along the lines of a block, also beside the area.
    #[inline(always)]
    pub(super) fn slopes(&self, lines: &Lines<'a>, block: &LineBlock) -> BlockSlopes<V> {
        let mut slopes = BlockSlopes::new(self.simd, &self.way, block);
        if !self.find_whole(lines, block, &mut slopes) {
            self.find_any(lines, block, &mut slopes);
        }
        slopes
    }

    /// Position across of the eye, posts of a block's level from the lines' first, and of planes per unit of major distance.
    #[inline(always)]
    fn posts_across(&self, lines: &Lines<'a>, block: &LineBlock) -> [V::F; 2] {
        let simd = self.simd;
        let side = f64::from(Grid::side_units(block.stride.level));
        let across = self.ground.across / side - 0.5 - lines.first[1] as f64;
        [simd.splat(across as f32), self.ground.minor * simd.splat((1.0 / side) as f32)]
    }

    /// Finds slopes where registers hold all posts, to the bit as [`Self::find_any`] does: which of them is asked depends on what a view sees. Whether there is a
    /// surface everywhere; if there is not, they mean nothing.
    #[inline(always)]
    fn find_whole(&self, lines: &Lines<'a>, block: &LineBlock, slopes: &mut BlockSlopes<V>) -> bool {
        let Some(near) = lines.near_rows() else { return false };
        let simd = self.simd;
        let [across, minor] = self.posts_across(lines, block);
        let first = simd.splat_int(near.first);

        let mut highest = simd.splat(NO_SLOPE);
        let mut least = simd.splat(f32::from(u16::MAX));
        let low_half = simd.splat_int(0xffff);

        let count = block.count as usize;
        let all = slopes.slope.iter_mut().zip(&slopes.distance).zip(&slopes.per_distance);
        for (index, ((slope, &distance), &per_distance)) in all.enumerate().take(count) {
            let line = (block.first + index as i64 * block.step - lines.first[0]) as i32;
            lines.prefetch(simd, line);
            let Some(row) = near.row(line) else { return false };
            let at = simd.splat(distance);
            let post = minor.mul_add(at, across);
            let floor = post.floor();
            let pair = simd.permute_pairs(row, floor.to_int() - first);
            let (low, high) = ((pair & low_half).to_float(), pair.shr::<16>().to_float());
            least = least.min(low.min(high));

            let code = (high - low).mul_add(post - floor, low);
            let inverse = self.ground.per_depth * simd.splat(per_distance);
            let found = self.ground.height(code, at) * inverse;
            found.store(&mut slope.0);
            highest = highest.max(found);
        }

        slopes.highest = highest;
        slopes.is_whole = simd.splat(f32::from(HeightCode::EMPTY) + 0.5).lt(least).all();
        slopes.is_whole
    }

    /// Finds slopes anywhere.
    #[inline(always)]
    fn find_any(&self, lines: &Lines<'a>, block: &LineBlock, slopes: &mut BlockSlopes<V>) {
        let simd = self.simd;
        let [across, minor] = self.posts_across(lines, block);
        let mut highest = simd.splat(NO_SLOPE);
        let mut lowest = simd.splat(-NO_SLOPE);

        for index in 0..block.count as usize {
            let at = simd.splat(slopes.distance[index]);
            let line = (block.first + index as i64 * block.step - lines.first[0]) as i32;
            lines.prefetch(simd, line);
            let codes = lines.codes(simd, line, minor.mul_add(at, across));
            let inverse = self.ground.per_depth * simd.splat(slopes.per_distance[index]);
            let found = self.ground.slope(self.ground.height(codes, at), inverse);
            found.store(&mut slopes.slope[index].0);
            highest = highest.max(found);
            lowest = lowest.min(found);
        }

        slopes.highest = highest;
        slopes.is_whole = !self.is_nothing(lowest).any();
    }

    /// Goes to one line after the other, between which there is neither void nor edge.
    #[inline(always)]
    pub(super) fn pass_lines(
        &mut self,
        lines: &Lines<'a>,
        block: &LineBlock,
        slopes: &BlockSlopes<V>,
    ) -> Result<()> {
        let simd = self.simd;
        let (ground, steep) = (self.ground, self.steep);
        let least = simd.splat(steep.least);
        let mark = self.mark(block, block.first);
        let every = i64::from(block.stride.lines);
        let mut index = 0;

        while index < block.count {
            // Room for as many parts as all of the lines may have before them.
            let room = (block.count - index) as usize * MOST_STEEP_PARTS as usize;
            let end = self.profile.end(room);
            let mut advance = PlainAdvance::<V>::new(end, self.horizon, self.last, self.reached);
            let mut is_left_to_step = false;

            while index < block.count {
                let at = index as usize;
                let slope = simd.load(&slopes.slope[at].0);
                let inverse = ground.per_depth * simd.splat(slopes.per_distance[at]);
                let line = SampleLine {
                    line: block.first + index * block.step,
                    distance: slopes.distance[at],
                    ..mark
                };
                let mut post = Post { slope, inverse, line };

                let stretch = [advance.horizon.max(advance.last), slope];
                if least.lt(slope - stretch[0]).any() && steep.is_passed(simd, stretch, 1.0) {
                    if every == 1 {
                        let parts = near_parts(line.level, line.distance).max(steep.parts(simd, stretch));
                        let way = CellWay::new(&ground, lines, advance.reached, line, parts);
                        advance.follow(&ground, lines, &way);
                    } else {
                        let parts = steep.divisions(simd, stretch, every);
                        let between = self.way.between(block, line.line, parts, advance.reached);
                        if between.count > 0 && !lines.have(between.first) {
                            is_left_to_step = true;
                            break;
                        }
                        post.line.span = between.step.unsigned_abs() as u8;
                        for part in 0..between.count {
                            let line = between.first + part * between.step;
                            let distance = self.way.distance(mark.level, line) as f32;
                            let line = SampleLine { line, distance, ..post.line };
                            advance.reach(&ground.line(lines, line));
                        }
                    }
                }
                advance.reach(&post);
                index += 1;
            }

            (self.horizon, self.last, self.reached) = advance.finish();
            if is_left_to_step {
                let line = block.first + index * block.step;
                let post = self.stored(block, line, slopes.slope(index));
                self.step(lines, block, &post, false)?;
                index += 1;
            }
        }

        Ok(())
    }
}
