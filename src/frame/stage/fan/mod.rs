//! What pixels see of a fan of planes: light and range between planes and rows.

mod panorama;
mod upright;

pub use panorama::PanoramaFan;
pub use upright::UprightFan;

use super::cell::{Cell, Scale};
use crate::raymarch::scan::Shape;
use crate::simd::{Floats, Mask, Simd, Sixteen};

/// Inverse depths of neighbouring planes that differ by more than this share belong to two surfaces.
const EDGE: f32 = 0.06;

/// Inverse depth from which on the surface is at the eye, 1/metres.
const AT_EYE: f32 = 1.0e20;

/// What the planes saw.
#[derive(Clone, Copy)]
pub struct Planes<'a> {
    /// How they lie before the screen.
    pub shape: &'a Shape,
    /// Light, group by group, of each the rows that the shape keeps.
    pub cells: &'a [Cell],
    /// What the cells' codes stand for.
    pub scale: Scale,
    /// Factor on the light that a screen shows, by channel: how bright the hour is.
    pub tint: [f32; 3],
    /// Inverse depth, or what the shape makes of it; in the same order, empty if nobody asks.
    pub inverse: &'a [Sixteen],
}

/// Looks pixels up in a fan.
pub trait LookUp<V: Simd> {
    /// Where sixteen pixels lie in it.
    type Place;

    /// Where sixteen pixels from `column` (a multiple of sixteen) of a screen's `row` on lie.
    fn place(&self, column: usize, row: usize) -> Self::Place;
    /// Their linear light, in units of the cells' [scale](Scale::units).
    fn light(&self, place: &Self::Place) -> [V::F; 3];
    /// Their range, metres: 0 at the eye, infinite for the sky. Across an edge the nearest plane and row count.
    fn range(&self, place: &Self::Place) -> V::F;
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

/// Inverse depth between four neighbours, with the weights of left and right and of below and above; across an edge that of the
/// nearest. `inverse` has left and right of four rows, rising, of which the middle ones count.
#[inline(always)]
fn smooth_or_nearest<V: Simd>(simd: V, inverse: [[V::F; 2]; 4], [across, along]: [[V::F; 2]; 2]) -> V::F {
    let [_, lower, upper, _] = inverse;
    let smooth = is_near(simd, lower[0], lower[1])
        & is_near(simd, upper[0], upper[1])
        & is_even(simd, inverse, 0)
        & is_even(simd, inverse, 1);
    let (left, below) = (across[1].lt(across[0]), along[1].lt(along[0]));
    let nearest = lower[0].select(left, lower[1]).select(below, upper[0].select(left, upper[1]));
    let low = lower[1].mul_add(across[1], lower[0] * across[0]);
    let high = upper[1].mul_add(across[1], upper[0] * across[0]);
    high.mul_add(along[1], low * along[0]).select(smooth, nearest)
}

/// Whether two rows may belong to one surface on both sides of all pixels: then [`smooth_or_nearest`] does not look at the rows about them.
#[inline(always)]
fn is_along<V: Simd>(simd: V, lower: [V::F; 2], upper: [V::F; 2]) -> bool {
    (is_near(simd, lower[0], upper[0]) & is_near(simd, lower[1], upper[1])).all()
}

/// Whether inverse depths may belong to one surface.
#[inline(always)]
fn is_near<V: Simd>(simd: V, a: V::F, b: V::F) -> V::M {
    (a - b).abs().le((a + b) * simd.splat(EDGE))
}

/// Whether the middle ones of four rows may belong to one surface. Towards the horizon its rows lie far apart, but evenly.
#[inline(always)]
fn is_even<V: Simd>(simd: V, [under, lower, upper, over]: [[V::F; 2]; 4], side: usize) -> V::M {
    let step = (upper[side] - lower[side]).abs() * simd.splat(0.5);
    let others = (lower[side] - under[side]).abs().min((over[side] - upper[side]).abs());
    is_near(simd, lower[side], upper[side]) | step.le(others)
}
