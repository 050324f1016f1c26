//! The ground's crest along one plane.

use crate::raymarch::scan::Profile;
use crate::raymarch::scan::profile::{NO_SLOPE, VisibleSegment};

/// Goes along a profile: up to which tangent the ground nearer than some distance hides what is behind.
pub(super) struct Crest<'p> {
    sights: &'p [VisibleSegment],
    lane: usize,
    /// The first sight that is not nearer.
    next: usize,
    /// Greatest tangent of those that are.
    crest: f32,
    /// The lowest tangent that is of interest, which is told where no ground is seen yet.
    lowest: f32,
}

impl<'p> Crest<'p> {
    pub fn new(profile: &'p Profile, lane: usize, lowest: f32) -> Self {
        Self { sights: profile.sights(), lane, next: 0, crest: lowest, lowest }
    }

    /// The crest that is told where no ground is seen yet: no row lies below this tangent.
    #[inline(always)]
    pub fn lowest(&self) -> f32 {
        self.lowest
    }

    /// The crest at an inverse depth, 1/metres, which does not grow from one call to the next by more than a voxel's width.
    #[inline(always)]
    pub fn at(&mut self, inverse: f32) -> f32 {
        (self.next, self.crest) = self.passed(inverse);
        self.reached(self.next, self.crest, inverse)
    }

    /// The crest farther away, for one who comes back.
    #[inline(always)]
    pub fn beyond(&self, inverse: f32) -> f32 {
        let (next, crest) = self.passed(inverse);
        self.reached(next, crest, inverse)
    }

    /// The first sight that is not nearer, and the greatest tangent of those that are.
    #[inline(always)]
    fn passed(&self, inverse: f32) -> (usize, f32) {
        let (mut next, mut crest) = (self.next, self.crest);
        while let Some(sight) = self.sights.get(next)
            && sight.inverse.0[self.lane] > inverse
        {
            crest = crest.max(sight.slope.0[self.lane]);
            next += 1;
        }
        (next, crest)
    }

    /// The crest between two sights.
    #[inline(always)]
    fn reached(&self, next: usize, crest: f32, inverse: f32) -> f32 {
        let lane = self.lane;
        // On the stretch to the next one inverse depth is linear in the tangent.
        let Some(ahead) = self.sights.get(next).filter(|sight| !sight.line.begins) else {
            return crest;
        };
        let Some(behind) = next.checked_sub(1).map(|index| &self.sights[index]) else {
            return crest;
        };
        let (from, to) = (behind.slope.0[lane], ahead.slope.0[lane]);
        let (near, far) = (behind.inverse.0[lane], ahead.inverse.0[lane]);
        if to <= crest || from <= 0.5 * NO_SLOPE || near <= far {
            return crest;
        }
        crest.max(from + (to - from) * ((near - inverse) / (near - far)).clamp(0.0, 1.0))
    }
}
