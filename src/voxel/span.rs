//! Matter over a voxel of level 1: what one height per place cannot say.
//!
//! A page's heights are those of the highest surface: roofs, crowns of trees, decks of bridges (cases 1 and 2 of Nack
//! et al., US 5,317,689, 1994). Where something stands, the page also has the bare ground under it, and *spans*: over one
//! voxel a solid from one height to another (case 3; many of them are case 4, runs of equal voxels of a column, of which only
//! those that are not transparent are stored). Near the eye bare ground and spans are seen, further away the heights alone.
//!
//! A span need not fill its voxel, so that walls are straight whatever their direction, and roofs smooth:
//!
//! ```text
//!       upper end: a plane            cuts: half-planes, three at most
//!            __..--               +-------/-+   facing: where a wall's outside lies
//!      high --                    |######/  |
//!          |      |               |#####/   |   how far the wall lies from the
//!      low |______|               |--..#    |   voxel's centre in that direction
//!                                 +----``---+
//! ```
//!
//! Two cuts say the corner of a house, a gable's end, and each of the three planes and more of a roof that meet in one point; three a side of a
//! hipped roof where its ridge is shorter than a voxel.

use super::{Cut, Facade};
use crate::simd::Each;

/// A solid over one voxel of level 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Span {
    /// Height code of the lower end; [`Self::GROUND`]: it stands on the bare ground, and no ray passes below (the patent's
    /// state *fill*).
    pub low: u16,
    /// Height code of the upper end over the voxel's centre.
    pub high: u16,
    /// Slope of the upper end, eastward and northward: rise over run in [`Self::SLOPE_STEPS`] steps.
    pub slope: [i8; 2],
    /// Cuts, within all of which it lies. One behind none, and a second or third one that is round, make no sense.
    pub cuts: [Cut; 3],
    /// Colour of the upper end, sRGB.
    pub top: [u8; 3],
    /// Opacity in its lower four bits, in [`Self::OPAQUE`] steps, and [`Self::PARALLEL`], [`Self::STRIP`] and [`Self::JOINED`].
    pub state: u8,
    /// Colour of sides and lower end, sRGB.
    pub side: [u8; 3],
    /// Material class, 0 = unknown.
    pub material: u8,
    /// Façade of its sides; files hold it apart.
    pub facade: Facade,
}

impl Span {
    /// Nothing: what a span is filled with before it is one.
    pub(super) const NONE: Self = Self {
        low: 0,
        high: 0,
        slope: [0; 2],
        cuts: [Cut::NONE; 3],
        top: [0; 3],
        state: 0,
        side: [0; 3],
        material: 0,
        facade: Facade::NONE,
    };
    /// The lower end's code of what stands on the ground.
    pub const GROUND: u16 = 0;
    /// Steps of a slope per unit of slope.
    pub const SLOPE_STEPS: f32 = 32.0;
    /// Opacity of what hides all that is behind it: the patent's state *opaque*; less than that is *semitransparent*, and 0,
    /// *transparent*, is not stored.
    pub const OPAQUE: u8 = 15;
    /// The bits of opacity.
    pub const OPACITY: u8 = 15;
    /// Bit of `state`: the lower end has the slope of the upper one.
    pub const PARALLEL: u8 = 16;
    /// Bit of `state`: not what is inside of the first wall, but a strip along it, half to either side and as wide as the span is
    /// high: a wire.
    pub const STRIP: u8 = 32;
    /// Bits of `state` for the first two cuts: beyond the wall the same thing goes on, another plane of its roof. Beyond a third one it always does.
    pub const JOINED: [u8; 2] = [64, 128];

    /// Share of the light that it hides on a way as long as its voxel's side, of a strip as long as that is thick, 0…1.
    pub fn opacity(&self) -> f32 {
        f32::from(self.state & Self::OPACITY) / f32::from(Self::OPAQUE)
    }

    /// Returns how many height codes thick a strip is, ≥ 1; it is as wide as that.
    pub fn thickness(&self) -> u16 {
        self.high.saturating_sub(self.low).max(1)
    }

    /// Whether a bit of `state` is set.
    pub fn is(&self, bit: u8) -> bool {
        self.state & bit != 0
    }

    /// Whether beyond the wall of a cut the same thing goes on.
    #[inline]
    pub fn is_joined(&self, index: usize) -> bool {
        Self::JOINED.get(index).is_none_or(|bit| self.is(*bit))
    }

    /// Slope of the upper end, eastward and northward, rise over run.
    pub fn slopes(&self) -> [f32; 2] {
        self.slope.each(|slope| f32::from(slope) / Self::SLOPE_STEPS)
    }

    /// Lists its walls: normals (east, north) and their distances from the voxel's centre, sides of the voxel; none where it fills the voxel.
    pub fn walls(&self) -> impl Iterator<Item = ([f32; 2], f32)> {
        self.cuts.into_iter().filter(|cut| cut.is_wall()).map(|cut| (cut.normal(), cut.distance()))
    }

    /// Whether it holds the voxel's centre.
    pub fn holds_centre(&self) -> bool {
        self.walls().all(|(_, distance)| distance >= 0.0)
    }

    /// Codes that it lies between, wherever in its voxel, 0 for the lower one on the ground; `rise` as for [`super::SpanTable::new`]. A slope
    /// of (a, b) rises by (|a| + |b|) / 2 at a corner.
    pub(super) fn reach(&self, rise: f64) -> [u16; 2] {
        let steps: f64 = self.slope.iter().map(|slope| f64::from(slope.unsigned_abs())).sum();
        let room = (steps * rise).ceil().min(f64::from(u16::MAX)) as u16;
        let low = match self.low {
            Self::GROUND => Self::GROUND,
            low if self.is(Self::PARALLEL) => low.saturating_sub(room).max(1),
            low => low,
        };
        [low, self.high.saturating_add(room)]
    }

    /// Says what is wrong with the span by itself, if something is.
    pub(super) fn check(&self) -> Option<String> {
        let is_sound = self.state & Self::OPACITY != 0
            && self.low <= self.high
            && self.high > 0
            && self.cuts.is_sorted_by_key(|cut| !cut.is_wall())
            && !self.cuts[1..].iter().any(|cut| cut.is_round())
            && (0..2).all(|index| self.cuts[index].is_wall() || !self.is(Self::JOINED[index]));
        (!is_sound).then(|| {
            format!(
                "a span of state {} from code {} to {}, cut {:?}",
                self.state, self.low, self.high, self.cuts
            )
        })
    }
}
