//! Texels of a line between which planes cross it.

use super::lines::{DEVIATION_UNITS, NO_WALL, WALL_UNITS};
use crate::simd::{Floats, Ints, LANES, Simd};

/// Texels on either side of places.
#[derive(Clone, Copy)]
pub struct TexelPair<V: Simd> {
    from: V::I,
    to: V::I,
    /// Share of the way to the second.
    share: V::F,
}

/// Places among a line's texels: the area's edge goes on as its outermost ones.
#[inline(always)]
pub fn clipped<V: Simd>(simd: V, place: V::F, row: usize) -> V::F {
    place.max(simd.splat(-1.0)).min(simd.splat(row as f32 - 2.001))
}

/// Texels about places out of a line, whose first is place −1.
#[inline(always)]
pub fn words<V: Simd>(simd: V, row: &[u32], place: V::F) -> TexelPair<V> {
    let floor = place.floor();
    let (from, to) = simd.gather_word_pairs(row, floor.to_int() + simd.splat_int(1));
    TexelPair { from, to, share: place - floor }
}

/// Texels about places out of `near`, which holds all that are asked for; a line begins with its element `origin`.
#[inline(always)]
pub fn words_near<V: Simd>(simd: V, near: &[u32; 2 * LANES], place: V::F, origin: i32) -> TexelPair<V> {
    let floor = place.floor();
    let near: &[[f32; LANES]; 2] = bytemuck::cast_ref(near);
    let (low, high) = (simd.load(&near[0]), simd.load(&near[1]));
    let index = floor.to_int() + simd.splat_int(origin + 1);
    let [from, to] = simd.permute_neighbours(low, high, index);
    TexelPair { from: from.to_bits(), to: to.to_bits(), share: place - floor }
}

/// Radiance between texels, in [`UNITS`](crate::pixels::UNITS).
#[inline(always)]
pub fn radiance<V: Simd>(simd: V, texels: TexelPair<V>) -> [V::F; 3] {
    let TexelPair { from, to, share } = texels;
    let (low, middle) = (simd.splat_int(0x3ff), simd.splat_int(0x3ff << 10));
    let red = mix(simd, from & low, to & low, share);
    let green = mix(simd, from & middle, to & middle, share);
    let blue = mix(simd, from.shr::<20>(), to.shr::<20>(), share);
    [red, green, blue]
}

/// Relative deviations of light below the voxel.
#[derive(Clone, Copy)]
pub struct Deviations<V: Simd> {
    /// Over the ground, 0…1.
    pub ground: V::F,
    /// Over walls, −1…1: above 0 over (y, z), below over (x, z).
    pub wall: V::F,
    /// Whether some of these are not 0.
    pub has_walls: bool,
}

impl<V: Simd> Deviations<V> {
    /// None.
    #[inline(always)]
    pub fn none(simd: V) -> Self {
        Self { ground: simd.splat(0.0), wall: simd.splat(0.0), has_walls: false }
    }
}

/// Relative deviation over the ground from the code of one.
#[inline(always)]
pub fn over_ground<V: Simd>(simd: V, code: V::F) -> V::F {
    code * simd.splat(1.0 / DEVIATION_UNITS)
}

/// Relative deviation over walls from the code of one.
#[inline(always)]
pub fn over_walls<V: Simd>(simd: V, code: V::F) -> V::F {
    (code - simd.splat(f32::from(NO_WALL))) * simd.splat(1.0 / WALL_UNITS)
}

/// Code between two, the second of which is in the upper half of words.
#[inline(always)]
pub fn code_between<V: Simd>(simd: V, pairs: V::I, share: V::F) -> V::F {
    let (from, to) = ((pairs & simd.splat_int(0xffff)).to_float(), pairs.shr::<16>().to_float());
    (to - from).mul_add(share, from)
}

/// Codes of deviations about places, as [`words_near`] finds texels.
#[inline(always)]
pub fn codes_near<V: Simd>(simd: V, near: &[u16; 2 * LANES], place: V::F, origin: i32) -> V::F {
    let floor = place.floor();
    let index = floor.to_int() + simd.splat_int(origin + 1);
    code_between(simd, simd.permute_pairs(near, index), place - floor)
}

/// Between two codes, which are roots.
#[inline(always)]
fn mix<V: Simd>(simd: V, from: V::I, to: V::I, share: V::F) -> V::F {
    let (from, to) = (from.to_float(), to.to_float());
    let from = from * from;
    to.mul_add(to, simd.splat(0.0) - from).mul_add(share, from)
}
