//! From which side ground is seen, and how much of it that shows.
//!
//! A pixel of distant ground is many posts, of which an eye near the ground sees those best that slope towards it, and some
//! not at all. Where a texel stands for many posts, each counts by the height that it has in the picture: a
//! slope's rise along the view, more what the eye looks down. A plain mean is too dark where the light comes from behind the eye,
//! and too bright against the light.

/// Least weight of a post, a tangent: where all are hidden, their mean counts.
const LEAST: f32 = 0.03;

/// Tangents of depression that views are sorted by: those below [`STEEPER`]'s first, below its second; from higher up
/// all posts are seen alike.
const INCLINES: [f32; 2] = [0.15, 0.6];
pub const STEEPER: [f64; 2] = [0.3, 1.2];

/// Steps of slopes of [`Slopes`] per unit.
const STEPS: f32 = 32.0;

/// A post's slope eastward and northward, up to 4.
pub type Slopes = [i8; 2];

/// Those of a post without a surface.
pub const VOID: Slopes = [i8::MIN; 2];

/// Its weight: it counts only where no other does.
const VOID_WEIGHT: f32 = 1.0e-6;

/// The nearest steps to two slopes.
#[inline(always)]
pub fn encode(slopes: [f32; 2]) -> Slopes {
    slopes.map(|slope| (slope * STEPS).clamp(-127.0, 127.0).round_ties_even() as i8)
}

/// A sense of a view along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Facing {
    /// 0: along x, 1: along y.
    pub major: u8,
    /// Up the axis.
    pub forward: bool,
    /// How steeply down: 0 below a tangent of 0.3, 1 below 1.2, 2 beyond.
    pub incline: u8,
}

impl Facing {
    /// Looking straight down: all slopes are seen alike.
    pub fn down(major: u8) -> Self {
        Self { major, forward: true, incline: INCLINES.len() as u8 }
    }

    /// How much of a post is seen, up to a common factor.
    #[inline(always)]
    pub fn weight(&self, slopes: Slopes) -> f32 {
        if slopes == VOID {
            return VOID_WEIGHT;
        }
        self.weight_of(slopes.map(|slope| f32::from(slope) / STEPS))
    }

    /// How much of ground with these slopes eastward and northward is seen, up to a common factor.
    #[inline(always)]
    pub fn weight_of(&self, slopes: [f32; 2]) -> f32 {
        let Some(&down) = INCLINES.get(usize::from(self.incline)) else { return 1.0 };
        let slope = slopes[usize::from(self.major)];
        (down + if self.forward { slope } else { -slope }).max(LEAST)
    }
}
