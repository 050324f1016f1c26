//! Direction from which ground is seen, and how much of it that shows.
//!
//! A pixel of distant ground is many posts, of which an eye near the ground sees those best that slope towards it, and some
//! not at all. Where a texel stands for many posts, each counts by the height that it has in the picture: a
//! slope's rise along the view, more what the eye looks down. A plain mean is too dark where the light comes from behind the eye,
//! and too bright against the light.

use crate::simd::{Floats, Simd};

/// Least weight of a post, a tangent: where all are hidden, their mean counts.
const LEAST: f32 = 0.03;

/// Tangents of depression that views are sorted by: those below [`STEEPER`]'s first, below its second; from higher up
/// all posts are seen alike.
const INCLINES: [f32; 2] = [0.15, 0.6];
pub const STEEPER: [f64; 2] = [0.3, 1.2];

/// Weight of a post without a surface: it counts only where no other does.
pub const VOID_WEIGHT: f32 = 1.0e-6;

/// A sense of a view along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Facing {
    /// 0: along x, 1: along y.
    pub major: u8,
    /// Up the axis.
    pub forward: bool,
    /// Steepness of the view down: 0 below a tangent of 0.3, 1 below 1.2, 2 beyond.
    pub incline: u8,
}

impl Facing {
    /// Looking straight down: all slopes are seen alike.
    pub fn down(major: u8) -> Self {
        Self { major, forward: true, incline: INCLINES.len() as u8 }
    }

    /// Returns how much of ground with these slopes eastward and northward is seen, up to a common factor.
    #[inline(always)]
    pub fn weight<V: Simd>(&self, simd: V, slopes: [V::F; 2]) -> V::F {
        let Some(&down) = INCLINES.get(usize::from(self.incline)) else { return simd.splat(1.0) };
        let slope = slopes[usize::from(self.major)];
        let down = simd.splat(down);
        let seen = if self.forward { down + slope } else { down - slope };
        seen.max(simd.splat(LEAST))
    }
}
