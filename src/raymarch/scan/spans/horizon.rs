//! The ground's horizon along one plane.

use crate::raymarch::scan::{NO_SLOPE, Profile, VisibleSegment};

/// Goes along a profile: up to which tangent the ground nearer than some distance hides what is behind.
pub(super) struct FloatingHorizon<'p> {
    segments: &'p [VisibleSegment],
    lane: usize,
    /// The first segment that is not nearer.
    next: usize,
    /// Greatest tangent of those that are.
    horizon: f32,
    /// The lowest tangent that is of interest, which is told where no ground is seen yet.
    lowest: f32,
}

impl<'p> FloatingHorizon<'p> {
    pub fn new(profile: &'p Profile, lane: usize, lowest: f32) -> Self {
        Self { segments: profile.segments(), lane, next: 0, horizon: lowest, lowest }
    }

    /// The horizon that is told where no ground is seen yet: no row lies below this tangent.
    #[inline(always)]
    pub fn lowest(&self) -> f32 {
        self.lowest
    }

    /// The horizon at an inverse depth, 1/metres, which does not grow from one call to the next by more than a voxel's width.
    #[inline(always)]
    pub fn at(&mut self, inverse: f32) -> f32 {
        (self.next, self.horizon) = self.passed(inverse);
        self.reached(self.next, self.horizon, inverse)
    }

    /// The horizon farther away, for one who comes back.
    #[inline(always)]
    pub fn beyond(&self, inverse: f32) -> f32 {
        let (next, horizon) = self.passed(inverse);
        self.reached(next, horizon, inverse)
    }

    /// The first segment that is not nearer, and the greatest tangent of those that are.
    #[inline(always)]
    fn passed(&self, inverse: f32) -> (usize, f32) {
        let (mut next, mut horizon) = (self.next, self.horizon);
        while let Some(segment) = self.segments.get(next)
            && segment.inverse.0[self.lane] > inverse
        {
            horizon = horizon.max(segment.slope.0[self.lane]);
            next += 1;
        }
        (next, horizon)
    }

    /// The horizon between two segments.
    #[inline(always)]
    fn reached(&self, next: usize, horizon: f32, inverse: f32) -> f32 {
        let lane = self.lane;
        // On the stretch to the next one inverse depth is linear in the tangent.
        let Some(ahead) = self.segments.get(next).filter(|segment| !segment.line.begins) else {
            return horizon;
        };
        let Some(behind) = next.checked_sub(1).map(|index| &self.segments[index]) else {
            return horizon;
        };
        let (from, to) = (behind.slope.0[lane], ahead.slope.0[lane]);
        let (near, far) = (behind.inverse.0[lane], ahead.inverse.0[lane]);
        if to <= horizon || from <= 0.5 * NO_SLOPE || near <= far {
            return horizon;
        }
        horizon.max(from + (to - from) * ((near - inverse) / (near - far)).clamp(0.0, 1.0))
    }
}
