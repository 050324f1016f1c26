//! The march over displaced ground: lines near the eye, and samples between them that are finer than its bumps.
//!
//! ```text
//! for each line, for each sample up to it:
//!     highest that displacement may lift it to is below every horizon  → it waits: its own height is of no interest
//!     else                                                             → the one that waits, then this one, as high as they are
//! ```

use super::blocks::LineBlock;
use super::displaced_field::DisplacedPlanes;
use super::lines::Lines;
use super::march::Planes;
use super::profile::{Post, SampleLine};
use crate::simd::{Floats, Kernel, Mask, Simd};
use crate::voxel::Grid;

/// Share of a cell that a stretch may be longer than one.
const SAME: f32 = 1.0e-3;

/// The march up to some line of a block.
struct DisplacedMarch<'p, 'f, 'a, V: Simd> {
    planes: &'p mut Planes<'f, 'a, V>,
    lines: &'p Lines<'a>,
    block: &'p LineBlock,
    count: i64,
}

/// Look at displacements at a major distance, as a function of its own: they are asked for in several places, most of them rare.
struct DisplacedHeights<'p, 'd, V: Simd> {
    relief: &'p DisplacedPlanes<'d, V>,
    at: V::F,
}

/// A sample that waits, as high as without displacement.
struct Waiting<V: Simd> {
    z: V::F,
    line: SampleLine,
}

impl<V: Simd> Kernel for DisplacedHeights<'_, '_, V> {
    type Output = V::F;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> V::F {
        self.relief.heights(self.at)
    }
}

impl<V: Simd> Kernel for DisplacedMarch<'_, '_, '_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Self { planes, lines, block, count } = self;
        for index in 0..count {
            planes.sample_up_to(lines, block, block.first + index * block.step);
        }
    }
}

impl<'a, V: Simd> Planes<'_, 'a, V> {
    /// Marches along the first lines of a block that displacement reaches.
    #[cold]
    pub(super) fn march_displaced(&mut self, lines: &Lines<'a>, block: &LineBlock, count: i64) {
        debug_assert_eq!(block.stride.lines, 1, "lines between are read only where none is left out");
        self.simd.call(DisplacedMarch { planes: self, lines, block, count });
    }

    /// Returns heights above the eye of the surface of a level at a major distance, metres, where without displacement it is `z`.
    #[inline(always)]
    pub(super) fn displaced(&self, level: u8, z: V::F, at: V::F) -> V::F {
        match &self.relief {
            Some(relief) if relief.level() == level => z + self.simd.call(DisplacedHeights { relief, at }),
            _ => z,
        }
    }

    /// Goes to a line, sample by sample.
    #[inline(always)]
    fn sample_up_to(&mut self, lines: &Lines<'a>, block: &LineBlock, line: i64) {
        let (simd, mark) = (self.simd, self.mark(block, line));
        let side = Grid::side_units(mark.level) as f32;
        let rim = self.is_at_rim(self.ground.line(lines, mark).slope);
        let is_plain = !rim && !self.is_at_edge(mark.distance);
        let lift = simd.splat(self.displaced_stretch.bound(self.reached) as f32);
        let parts = self.displaced_stretch.parts(mark.distance);

        // A coarser level may have stood in for more than a cell.
        let is_longer = mark.distance - self.reached > side * (1.0 + SAME);
        let from = if is_longer { mark.distance - side } else { self.reached };
        let mut waiting = None;

        for part in i32::from(!is_longer)..=parts {
            let share = part as f32 / parts as f32;
            let distance =
                if part == parts { mark.distance } else { (mark.distance - from).mul_add(share, from) };
            let along = 1.0 - (mark.distance - distance) / side;
            let z = self.ground.surface(lines, mark.level, line, simd.splat(distance), simd.splat(along));
            let sample = Waiting::<V> { z, line: SampleLine { distance, share: along, ..mark } };

            let highest = self.ground.post(z + lift, sample.line).slope;
            if is_plain && !self.horizon.lt(highest).any() {
                waiting = Some(sample);
                continue;
            }
            if let Some(waiting) = waiting.take() {
                self.reach_sample(lines, &waiting, rim);
            }
            self.reach_sample(lines, &sample, rim);
        }

        if let Some(waiting) = waiting {
            self.reach_sample(lines, &waiting, rim);
        }
    }

    /// Takes in the surface up to a sample.
    #[inline(always)]
    fn reach_sample(&mut self, lines: &Lines<'a>, sample: &Waiting<V>, rim: bool) {
        let Waiting { z, line } = *sample;
        let z = self.displaced(line.level, z, self.simd.splat(line.distance));
        let post: Post<V> = self.ground.post(z, line);
        self.pass(lines, post, rim);
    }
}
