//! Reading of the plane image: light and range of pixels between planes and rows.

mod along_row;
mod columns;
mod panorama;
mod plane_rows;
mod upright;

#[cfg(test)]
mod tests;

pub use panorama::PanoramaImage;
pub use upright::UprightImage;

use along_row::AlongRow;

use super::cell::{Cell, Scale};
use super::solids::GROUND;
use crate::raymarch::scan::PlaneArray;
use crate::simd::{Each, Floats, Ints, Mask, Simd, Sixteen};

/// Inverse depths of neighbouring planes that differ by more than this share of their sum belong to two surfaces.
const EDGE: f32 = 0.06;

/// Inverse depths that differ by no more than this share of their sum have a straight line between them.
const FLAT: f32 = 0.003;

/// Inverse depth from which on the surface is at the eye, 1/metres.
const AT_EYE: f32 = 1.0e20;

/// Plane image that pixels are read from.
#[derive(Clone, Copy)]
pub struct PlaneSource<'a> {
    /// Layout of the planes before the screen.
    pub shape: &'a PlaneArray,
    /// Light, group by group, of each the rows that the shape keeps.
    pub cells: &'a [Cell],
    /// Light that the cells' codes stand for.
    pub scale: Scale,
    /// Factor on the light that a screen shows, by channel: how bright the hour is.
    pub tint: [f32; 3],
    /// Distances.
    pub depths: Depths<'a>,
}

/// Distances that planes saw, in the order of their light; empty if nobody asks.
#[derive(Clone, Copy)]
pub struct Depths<'a> {
    /// Inverse depth, or what the shape makes of it.
    pub inverse: &'a [Sixteen],
    /// Slopes of what stands, to the next plane and to the next row; infinite where nothing does. Empty if all is ground.
    pub tilts: [&'a [Sixteen]; 2],
}

/// Shares of pixels among four words: left and right of the row below and of the row above.
struct Among<V: Simd> {
    words: [[V::I; 2]; 2],
    /// Share of the way to the right, and up.
    shares: [V::F; 2],
}

impl Depths<'_> {
    #[inline(always)]
    fn inverse<V: Simd>(&self, simd: V, words: V::I) -> V::F {
        simd.gather(bytemuck::cast_slice(self.inverse), words)
    }

    /// Inverse depth of pixels about which something stands: that of the nearest word, along the face that is seen there. Elsewhere it is `ground`. And about
    /// which of them something does.
    ///
    /// Faces end from one plane to the next: between them there is nothing to interpolate.
    #[inline(always)]
    fn standing<V: Simd>(&self, simd: V, ground: V::F, among: &Among<V>) -> (V::F, V::M) {
        let [across, along] = self.tilts.each(bytemuck::cast_slice);
        if across.is_empty() {
            return (ground, simd.mask(0));
        }
        let Among { words, shares: [aside, up] } = among;
        let mut stands = simd.mask(0);
        for &words in words.as_flattened() {
            stands = stands | simd.gather(across, words).lt(simd.splat(GROUND));
        }
        if !stands.any() {
            return (ground, stands);
        }

        let half = simd.splat(0.5);
        let (left, below) = (aside.lt(half), up.lt(half));
        let nearest = words.each(|[west, east]| west.select(left, east));
        let nearest = nearest[0].select(below, nearest[1]);
        let (known, one) = (self.inverse(simd, nearest), simd.splat(1.0));
        let (aside, up) = (aside.select(left, *aside - one), up.select(below, *up - one));
        let (across, along) = (simd.gather(across, nearest), simd.gather(along, nearest));
        let on = aside.mul_add(across, up.mul_add(along, known));
        let on = on.max(known * half).min(known * simd.splat(2.0));
        (on.select(across.lt(simd.splat(GROUND)), known).select(stands, ground), stands)
    }
}

/// Looks pixels up in a plane image.
pub trait LookUp<V: Simd> {
    /// Place of sixteen pixels in it.
    type Place;
    /// State of a strip of sixteen columns, from one row to the next.
    type Strip;

    /// Memory for strips.
    fn strip(&self) -> Self::Strip;
    /// Begins a strip from `column` (a multiple of sixteen) on, whose rows follow each other downward.
    fn begin(&self, strip: &mut Self::Strip, column: usize);
    /// Places sixteen pixels from `column` (a multiple of sixteen) of a screen's `row` on.
    fn place(&self, column: usize, row: usize) -> Self::Place;
    /// Reads the roots of their light, in [steps](Scale::step) of the cells' scale.
    fn roots(&self, strip: &mut Self::Strip, place: &Self::Place) -> [V::F; 3];
    /// Reads their range, metres: 0 at the eye, infinite for the sky. Across an edge the nearest plane and row count. And where there may be an outline: an edge, or
    /// something that stands.
    fn range(&self, place: &Self::Place) -> (V::F, V::M);
}

/// Weights of four neighbours at `share` of the way from the second to the third: the cubic of Keys (1981), which is sharper than a
/// straight line.
#[inline(always)]
fn cubic<V: Simd>(simd: V, share: V::F) -> [V::F; 4] {
    let rest = simd.splat(1.0) - share;
    let outer = share * rest * simd.splat(-0.5);
    let (first, last) = (outer * rest, outer * share);
    let third = share.mul_add(simd.splat(-1.5), simd.splat(2.0)).mul_add(share, simd.splat(0.5)) * share;
    [first, simd.splat(1.0) - first - third - last, third, last]
}

/// Inverse depth between four neighbours, with the weights of left and right and of below and above. Across an edge it is that of the nearest, and goes on from
/// there as the surface on that side does. Beside it, across which pixels there is an edge.
///
/// `tap` is what the weights are of, for a plane, 0 and 1 being those to the left and to the right, in a row, 0 and 1 being those below and above. Where the four
/// differ it is asked for those beside them, −1 and 2. `is_plain`: it is linear between planes and rows where the surface is a plane, so a surface that bends is
/// followed; and planes beside were marched.
#[inline(always)]
fn along_surface<V: Simd>(
    simd: V,
    tap: impl Fn(i32, i32) -> V::F,
    is_plain: bool,
    [across, along]: [[V::F; 2]; 2],
) -> (V::F, V::M) {
    let (lower, upper) = ([tap(0, 0), tap(1, 0)], [tap(0, 1), tap(1, 1)]);
    let low = lower[1].mul_add(across[1], lower[0] * across[0]);
    let high = upper[1].mul_add(across[1], upper[0] * across[0]);
    let straight = high.mul_add(along[1], low * along[0]);
    let is_flat = is_near(simd, FLAT, lower[0], lower[1])
        & is_near(simd, FLAT, upper[0], upper[1])
        & is_near(simd, FLAT, lower[0], upper[0])
        & is_near(simd, FLAT, lower[1], upper[1]);
    if is_flat.all() {
        return (straight, simd.mask(0));
    }

    let (under, over) = ([tap(0, -1), tap(1, -1)], [tap(0, 2), tap(1, 2)]);
    let is_smooth = is_near(simd, EDGE, lower[0], lower[1])
        & is_near(simd, EDGE, upper[0], upper[1])
        & is_even(simd, [under[0], lower[0], upper[0], over[0]])
        & is_even(simd, [under[1], lower[1], upper[1], over[1]]);
    let sides = [across[1].lt(across[0]), along[1].lt(along[0])];
    let zero = simd.splat(0.0);

    let known = nearest::<V>(sides, [lower, upper]);
    let by_rows = steps_about::<V>(known, sides, [[upper, lower], [under, over], [over, under]]);
    let mut by_planes = [zero; 3];

    if is_plain {
        let beside = [[tap(-1, 0), tap(2, 0)], [tap(-1, 1), tap(2, 1)]];
        let others = [[lower[1], lower[0]], [upper[1], upper[0]]];
        let behind = beside.each(|[left, right]| [right, left]);
        by_planes = steps_about::<V>(known, sides, [others, beside, behind]);
    }

    let (mut curved, mut on) = (straight, known);
    for &([there, before, behind], [a, b]) in &[(by_planes, across), (by_rows, along)] {
        on = a.min(b).mul_add(lesser(simd, there, before), on);
        if is_plain {
            let bend = lesser(simd, there - before, behind - there);
            curved = (a * b * simd.splat(-0.5)).mul_add(bend, curved);
        }
    }

    // An eye at the surface has no steps.
    let found = curved.select(is_smooth, on.max(known * simd.splat(0.5)));
    (found.select(known.lt(simd.splat(AT_EYE)), known), !is_smooth)
}

/// Returns the nearest of four neighbours, given by rows, the lower row first: the left one in planes where `is_left`, of the lower row in
/// planes where `is_below`.
#[inline(always)]
fn nearest<V: Simd>([is_left, is_below]: [V::M; 2], [below, above]: [[V::F; 2]; 2]) -> V::F {
    below[0].select(is_left, below[1]).select(is_below, above[0].select(is_left, above[1]))
}

/// Returns three steps of inverse depth, 1/metres, along one axis: from the nearest neighbour (`known`) to the other one, from the one
/// beyond the nearest to it, and from the other one to the one behind that.
#[inline(always)]
fn steps_about<V: Simd>(
    known: V::F,
    sides: [V::M; 2],
    [others, beyond, behind]: [[[V::F; 2]; 2]; 3],
) -> [V::F; 3] {
    let other = nearest::<V>(sides, others);
    [other - known, known - nearest::<V>(sides, beyond), nearest::<V>(sides, behind) - other]
}

/// The lesser of two values of one sign; 0 of two (the minmod limiter, Roe 1986).
#[inline(always)]
fn lesser<V: Simd>(simd: V, one: V::F, other: V::F) -> V::F {
    let zero = simd.splat(0.0);
    one.min(other).max(zero) + one.max(other).min(zero)
}

/// Whether inverse depths differ by no more than a share of their sum.
#[inline(always)]
fn is_near<V: Simd>(simd: V, share: f32, a: V::F, b: V::F) -> V::M {
    (a - b).abs().le((a + b) * simd.splat(share))
}

/// Whether the middle ones of four rows may belong to one surface. Towards the horizon its rows lie far apart, but evenly.
#[inline(always)]
fn is_even<V: Simd>(simd: V, [under, lower, upper, over]: [V::F; 4]) -> V::M {
    let step = (upper - lower).abs() * simd.splat(0.5);
    let others = (lower - under).abs().min((over - upper).abs());
    is_near(simd, EDGE, lower, upper) | step.le(others)
}
