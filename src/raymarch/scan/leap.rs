//! Leaps over what the bounds of wide squares hide: the void about an area, and valleys behind a ridge.
//!
//! ```text
//! while a square that begins where the march has come to is hidden:
//!     on to the far edge of the widest one
//! back to the begin of the last block before there
//! ```
//!
//! That block is marched as any other, so that the march goes on from the line that it would have come to.

use super::blocks::Way;
use super::march::Planes;
use crate::simd::{Each, Kernel, Simd};

/// A leap from where planes have come to with a stride.
struct Leap<'p, 'f, 'a, V: Simd> {
    planes: &'p mut Planes<'f, 'a, V>,
    stride: usize,
}

impl<V: Simd> Kernel for Leap<'_, '_, '_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        self.planes.leap_from(self.stride);
    }
}

impl<V: Simd> Planes<'_, '_, V> {
    /// Leaps from where the march has come to with a stride, and nothing is known of the surface.
    pub(super) fn leap(&mut self, stride: usize) {
        self.simd.call(Leap { planes: self, stride });
    }

    #[inline(always)]
    fn leap_from(&mut self, stride: usize) {
        let mut end = self.way;
        let mut from = f64::from(self.reached);
        while let Some(beyond) = self.beyond_hidden(&end, from) {
            end = beyond;
            from = end.passed();
        }

        let ground = self.group.ground;
        let last = self.march.strides.index_at(end.passed() * ground, stride);
        let block = self.march.strides.get(last);
        let begin = end.back_to_block(block);
        // Blocks that no bounds skip are marched line by line.
        if begin.passed() <= self.way.passed() || self.march.bounding(&block).is_none() {
            return;
        }

        // The stride of the block before: the longest one that would have been chosen where such a block begins.
        let strides = &self.march.strides;
        let mut before = strides.index_at(begin.passed() * ground, stride);
        while before > stride {
            let other = strides.get(before);
            let reached = begin.back_to_block(other).line_before(other);
            if strides.index_at(reached * ground, stride) >= before {
                break;
            }
            before -= 1;
        }
        let line = begin.line_before(strides.get(before));
        self.reached = self.reached.max(line as f32);
        self.way = begin;
    }

    /// The way from behind the widest square that holds its begin and is hidden from a major distance on; `None` if none is, or the area ends.
    #[inline(always)]
    fn beyond_hidden(&self, way: &Way, from: f64) -> Option<Way> {
        let mut beyond = None;
        for (step, side) in self.march.bounds.sides() {
            let Some((index, end)) = way.square(side) else { break };
            let to = end.passed();
            let minor = self.units([from, to]).each(|units| (units / side as f64).floor() as i64);
            let code = self.march.bounds.highest(step, self.group.major, index, minor);
            if !code.is_some_and(|code| self.hides(code, [from as f32, to as f32])) {
                break;
            }
            beyond = Some(end);
        }
        beyond
    }
}
