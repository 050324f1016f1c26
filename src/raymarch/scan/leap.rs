//! Leaps over what the bounds of wide squares hide: the void about an area, and valleys behind a ridge.
//!
//! ```text
//! while a square in which the march goes on is hidden:
//!     all blocks that end before the far edge of the widest one are passed over, without a look at them
//! ```
//!
//! Their strides follow from each other as ever, so that what lies behind is marched as if each had been looked at.

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
        let Self { planes, mut stride } = self;
        while let Some(beyond) = planes.beyond_hidden() {
            if !planes.pass_blocks(&beyond, &mut stride) {
                break;
            }
        }
    }
}

impl<V: Simd> Planes<'_, '_, V> {
    /// Leaps from where the march has come to with a stride, and nothing is known of the surface: once from each of the narrowest squares.
    #[inline(always)]
    pub(super) fn leap(&mut self, stride: usize) {
        let from = self.march.bounds.sides().next().and_then(|(_, side)| self.way.square(side));
        let from = from.map(|(index, _)| index);
        if from == self.leapt_from {
            return;
        }
        self.leapt_from = from;
        self.simd.call(Leap { planes: self, stride });
    }

    /// Returns the way from behind the widest hidden square in which the march goes on; `None` if none is, or the area ends.
    #[inline(always)]
    fn beyond_hidden(&self) -> Option<Way> {
        let mut beyond = None;
        for (step, side) in self.march.bounds.sides() {
            let Some((index, end)) = self.way.square(side) else { break };
            let (from, to) = (self.reached, end.passed());
            let minor = self.units([from.into(), to]).each(|units| (units / side as f64).floor() as i64);
            let code = self.march.bounds.highest(step, self.group.major, index, minor);
            if !code.is_some_and(|code| self.hides(code, [from, to as f32])) {
                break;
            }
            beyond = Some(end);
        }
        beyond
    }

    /// Passes over blocks that end before a way begins; whether there was any.
    #[inline(always)]
    fn pass_blocks(&mut self, beyond: &Way, stride: &mut usize) -> bool {
        let mut is_passed = false;
        loop {
            let (chosen, until) = self.next_stride(stride);
            if self.march.bounding(&chosen).is_none() {
                return is_passed;
            }

            // All blocks that end where the stride holds still, and then the one in which it ends.
            let last = match self.way.pass(chosen, beyond, until) {
                Some(last) => last,
                None => {
                    let mut way = self.way;
                    let Some(block) = way.next(chosen, self.reached.into()) else { return is_passed };
                    if way.passed() > beyond.passed() {
                        return is_passed;
                    }
                    let last = block.first + block.step * (block.count - 1);
                    let distance = self.way.distance(chosen.level, last);
                    self.way = way;
                    if block.count > 0 { distance } else { self.reached.into() }
                }
            };
            self.reached = self.reached.max(last as f32);
            is_passed = true;
        }
    }
}
