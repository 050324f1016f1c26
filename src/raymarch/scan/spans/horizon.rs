//! The ground's horizon along sixteen planes.

use crate::raymarch::scan::{NO_SLOPE, Profile, VisibleSegment};
use crate::simd::{Floats, Mask, Simd};

/// Goes along a profile: up to which tangents the ground nearer than some distance hides what is behind.
#[derive(Clone, Copy)]
pub(super) struct FloatingHorizon<'p, V: Simd> {
    segments: &'p [VisibleSegment],
    /// The first segment that is not nearer in all planes.
    next: usize,
    /// Greatest tangents of those that are.
    horizon: V::F,
    lowest: f32,
}

impl<'p, V: Simd> FloatingHorizon<'p, V> {
    /// At the eye. `lowest` is the lowest tangent that is of interest, which is told where no ground is seen yet.
    #[inline(always)]
    pub fn new(simd: V, profile: &'p Profile, lowest: f32) -> Self {
        Self { segments: profile.segments(), next: 0, horizon: simd.splat(lowest), lowest }
    }

    /// The horizon that is told where no ground is seen yet: no row lies below this tangent.
    #[inline(always)]
    pub fn lowest(&self) -> f32 {
        self.lowest
    }

    /// Goes on, past the segments that are nearer than these inverse depths (1/metres) in all of `planes`.
    #[inline(always)]
    pub fn advance(&mut self, simd: V, planes: V::M, inverse: V::F) {
        while let Some(segment) = self.segments.get(self.next)
            && !(planes & simd.load(&segment.inverse.0).le(inverse)).any()
        {
            self.horizon = self.horizon.max(simd.load(&segment.slope.0));
            self.next += 1;
        }
    }

    /// The horizons at inverse depths that it has not gone past.
    #[inline(always)]
    pub fn at(&self, simd: V, planes: V::M, inverse: V::F) -> V::F {
        let (mut open, mut horizon) = (planes, self.horizon);
        let mut reached = horizon;

        for (index, segment) in self.segments.iter().enumerate().skip(self.next) {
            let (slope, far) = (simd.load(&segment.slope.0), simd.load(&segment.inverse.0));
            let arrives = open & far.le(inverse);
            if arrives.any() {
                let on_the_way = match index.checked_sub(1).map(|before| &self.segments[before]) {
                    Some(behind) if !segment.line.begins => {
                        Self::between(simd, behind, [slope, far], horizon, inverse)
                    }
                    _ => horizon,
                };
                reached = on_the_way.select(arrives, reached);
                open = open & !arrives;
                if !open.any() {
                    return reached;
                }
            }

            horizon = horizon.max(slope);
        }

        horizon.select(open, reached)
    }

    /// The horizons on the stretch from one segment to the next, where inverse depth is linear in the tangent.
    #[inline(always)]
    fn between(simd: V, behind: &VisibleSegment, [to, far]: [V::F; 2], horizon: V::F, inverse: V::F) -> V::F {
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let (from, near) = (simd.load(&behind.slope.0), simd.load(&behind.inverse.0));
        let rises = horizon.lt(to) & simd.splat(0.5 * NO_SLOPE).lt(from) & far.lt(near);
        let share = ((near - inverse) * (near - far).recip()).max(zero).min(one);
        horizon.max((to - from).mul_add(share, from)).select(rises, horizon)
    }
}
