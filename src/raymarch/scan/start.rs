//! Where a march starts: under the eye, and behind what was skipped, nothing is known of the surface yet.

use super::blocks::LineBlock;
use super::ground::NOTHING;
use super::lines::Lines;
use super::march::{LEAST_DISTANCE, Planes};
use super::profile::{NO_SLOPE, Post};
use crate::simd::{Floats, Kernel, Mask, Simd, Sixteen};
use hedgehop_base::error::Result;

/// Inverse depth of what touches the eye, 1/metres.
const AT_EYE: f32 = 1.0e30;

/// A look at the surface under planes, where nothing is known yet.
struct SurfaceLook<'p, 'f, 'a, V: Simd> {
    planes: &'p mut Planes<'f, 'a, V>,
    level: u8,
    distance: f64,
}

impl<V: Simd> Kernel for SurfaceLook<'_, '_, '_, V> {
    type Output = Result<V::F>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Result<V::F> {
        self.planes.look_at_surface(self.level, self.distance)
    }
}

impl<V: Simd> Planes<'_, '_, V> {
    /// Finds where the surface is one line before a block's first: nothing is known after blocks that
    /// were skipped, or at the start.
    #[inline(always)]
    pub(super) fn prime(&mut self, block: &LineBlock) -> Result<()> {
        let level = block.stride.level;
        let before = self.way.distance(level, block.first - block.step);
        let start = f64::from(self.reached).max(before).max(0.0);
        let z = self.surface_at(level, start)?;
        if start > 0.0 {
            return self.begin(self.ground.post(z, self.first_line(block, start)));
        }
        if self.simd.splat(0.0).lt(z).any() && self.inner[0] == 0.0 {
            return self.flood(self.ground.post(z, self.first_line(block, start)));
        }

        // The surface under the eye is seen at no finite tangent: begin where it is below the lowest row.
        let mut distance = self.under_eye(z).min(0.25 * self.way.distance(level, block.first) as f32);
        loop {
            let z = self.surface_at(level, distance.into())?;
            let post = self.ground.post(z, self.first_line(block, distance.into()));
            // Where ground rises it comes into sight sooner.
            let in_sight = self.simd.splat(self.field.tangents[0]).lt(post.slope);
            if !in_sight.any() || distance <= LEAST_DISTANCE {
                return self.begin(post);
            }
            distance *= 0.5;
        }
    }

    /// Height above the eye of a level's bilinear surface at a major distance; nothing where a page is absent.
    #[cold]
    fn surface_at(&mut self, level: u8, distance: f64) -> Result<V::F> {
        self.simd.call(SurfaceLook { planes: self, level, distance })
    }

    #[inline(always)]
    fn look_at_surface(&mut self, level: u8, distance: f64) -> Result<V::F> {
        let (line, share) = self.way.line_at(level, distance);
        let posts = self.posts(level, [distance, distance]);
        let Some(lines) = Lines::find(&mut self.march.pages, None, level, self.group.major, line, posts)?
        else {
            return Ok(self.simd.splat(NOTHING));
        };
        let at = self.simd.splat(distance as f32);
        let z = self.ground.surface(&lines, level, line, at, self.simd.splat(share as f32));
        Ok(self.displaced(level, z, at))
    }

    /// Major distance at which ground at height `z` (≤ 0) above the eye is still below the lowest row in all planes.
    #[cold]
    fn under_eye(&self, z: V::F) -> f32 {
        let steepest = self.simd.splat((-self.field.tangents[0]).max(0.01));
        let mut lanes = Sixteen::default();
        ((self.simd.splat(0.0) - z) * (self.ground.depth * steepest).recip()).store(&mut lanes.0);
        lanes.0.iter().fold(f32::INFINITY, |least, &lane| least.min(0.5 * lane)).max(LEAST_DISTANCE)
    }

    /// Begins at a post. What lies before it is nothing: the solid under an area's edge is a wall.
    #[inline(always)]
    fn begin(&mut self, post: Post<V>) -> Result<()> {
        self.profile.begin(&Post { slope: self.simd.splat(NO_SLOPE), ..post });
        self.is_begun = true;
        self.join(Post { slope: self.over_area(post.slope, post.line.distance), ..post });
        self.last = post.slope;
        self.reached = post.line.distance;
        Ok(())
    }

    /// The eye is under the ground: all is at the eye.
    #[cold]
    fn flood(&mut self, post: Post<V>) -> Result<()> {
        let inverse = self.simd.splat(AT_EYE);
        self.profile.begin(&Post { slope: self.simd.splat(NO_SLOPE), inverse, ..post });
        self.is_begun = true;
        self.join(Post { slope: self.simd.splat(-NO_SLOPE), inverse, ..post });
        Ok(())
    }
}
