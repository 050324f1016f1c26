//! What pixels see of the fan of planes: light and inverse depth between planes and rows.

use std::ops::Range;

use super::cell::{Cell, Scale, add, between};
use crate::raymarch::scan::{LevelRow, Upright};
use crate::simd::{Floats, Ints, LANES, Simd, Sixteen};

/// Inverse depths of neighbouring planes that differ by more than this share belong to two surfaces.
const EDGE: f32 = 0.06;

/// Inverse depth from which on the surface is at the eye, 1/metres.
const AT_EYE: f32 = 1.0e20;

/// What the planes saw.
#[derive(Clone, Copy)]
pub struct Planes<'a> {
    /// How the screen lies in them.
    pub upright: &'a Upright,
    /// Light, `[group][row]`.
    pub cells: &'a [Cell],
    /// What the cells' codes stand for.
    pub scale: Scale,
    /// Inverse depth, `[group][row]`; empty if nobody asks.
    pub inverse: &'a [Sixteen],
}

/// Where sixteen pixels lie among planes and rows.
pub struct Place<V: Simd> {
    plane: V::F,
    row: V::F,
    /// 1 + a² + t² of their directions.
    square: V::F,
    /// The first of two neighbouring groups that hold all planes of theirs, and the row, of an unrolled screen.
    level: Option<(usize, V::I)>,
}

/// Looks planes up for rows of a screen.
pub struct Fan<'a, V: Simd> {
    simd: V,
    planes: Planes<'a>,
    columns: V::F,
    /// First row of `levels`.
    first: usize,
    /// Rows of an unrolled screen; none of a rolled one.
    levels: Vec<LevelRow>,
}

impl<'a, V: Simd> Fan<'a, V> {
    /// For some rows of the screen.
    #[inline(always)]
    pub fn new(simd: V, planes: Planes<'a>, rows: Range<usize>) -> Self {
        let first = rows.start;
        let levels = rows.map_while(|row| planes.upright.level_row(row as f32 + 0.5)).collect();
        let mut columns = [0.0; LANES];
        columns.iter_mut().enumerate().for_each(|(lane, column)| *column = lane as f32 + 0.5);
        Self { simd, planes, columns: simd.load(&columns), first, levels }
    }

    /// Where sixteen pixels from `column` of a screen's `row` on are seen.
    #[inline(always)]
    pub fn place(&self, column: usize, row: usize) -> Place<V> {
        let simd = self.simd;
        let columns = self.columns + simd.splat(column as f32);
        let one = simd.splat(1.0);
        let Some(level) = self.levels.get(row - self.first) else {
            let look = self.planes.upright.look(simd, columns, row as f32 + 0.5);
            let square = look.across.mul_add(look.across, look.tangent.mul_add(look.tangent, one));
            return Place { plane: look.plane, row: look.row, square, level: None };
        };
        let across = columns.mul_add(simd.splat(level.across[0]), simd.splat(level.across[1]));
        let square = across.mul_add(across, simd.splat(level.tangent * level.tangent + 1.0));
        let plane = columns.mul_add(simd.splat(level.plane[0]), simd.splat(level.plane[1]));
        let [planes, rows] = self.planes.upright.size;
        let row = level.row.clamp(0, rows as i32 - 1);
        // Two groups hold all sixteen, unless planes are much closer than pixels.
        let at = |column: f32| column.mul_add(level.plane[0], level.plane[1]).floor() as i32;
        let (first, last) = (at(column as f32 + 0.5), at(column as f32 + LANES as f32 - 0.5) + 2);
        let group = first.div_euclid(LANES as i32);
        let is_held = group >= 0 && last < (group + 2) * LANES as i32 && last < planes as i32;
        let level = is_held.then(|| {
            let index = plane.floor().to_int() - simd.splat_int(group * LANES as i32);
            (group as usize * rows + row as usize, index)
        });
        Place { plane, row: simd.splat(row as f32), square, level }
    }

    /// Linear light in units of the cells' [scale](super::Scale::units): linear between the planes,
    /// or cubic between planes and rows of a rolled screen.
    #[inline(always)]
    pub fn light(&self, place: &Place<V>) -> [V::F; 3] {
        let simd = self.simd;
        let left = place.plane.floor();
        let share = place.plane - left;
        if let Some((at, index)) = place.level {
            let [low, high] = [&self.planes.cells[at], &self.planes.cells[at + self.planes.upright.size[1]]];
            // The next sixteen pixels of the row, which are asked for after those below these.
            let later = at + 2 * self.planes.upright.size[1];
            simd.prefetch(self.planes.cells, later);
            let (low, high) = (simd.load(&low.0), simd.load(&high.0));
            let from = simd.permute2(low, high, index).to_bits();
            let to = simd.permute2(low, high, index + simd.splat_int(1)).to_bits();
            return between(simd, from, to, share);
        }
        let below = place.row.floor();
        let rise = place.row - below;
        let (left, below) = (left.to_int(), below.to_int());
        if !self.levels.is_empty() {
            let right = left + simd.splat_int(1);
            return between(simd, self.words(left, below), self.words(right, below), share);
        }
        let mut light = [simd.splat(0.0); 3];
        let across = cubic(simd, share);
        for (row, up) in cubic(simd, rise).into_iter().enumerate() {
            let row = below + simd.splat_int(row as i32 - 1);
            for (plane, weight) in across.into_iter().enumerate() {
                let words = self.words(left + simd.splat_int(plane as i32 - 1), row);
                add(simd, &mut light, words, weight * up);
            }
        }
        for light in &mut light {
            *light = light.max(simd.splat(0.0));
        }
        light
    }

    /// Range, metres: 0 at the eye, infinite for the sky. Across an edge the nearest plane counts.
    #[inline(always)]
    pub fn range(&self, place: &Place<V>) -> V::F {
        let simd = self.simd;
        let (left, below) = (place.plane.floor(), place.row.floor());
        let (share, rise, below_row) = (place.plane - left, place.row - below, below);
        let (left, below) = (left.to_int(), below.to_int());
        let (right, above) = (left + simd.splat_int(1), below + simd.splat_int(1));
        let (a, b) = (self.inverse(left, below), self.inverse(right, below));
        let (c, d) = if self.levels.is_empty() {
            (self.inverse(left, above), self.inverse(right, above))
        } else {
            (a, b)
        };
        let (low, high) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
        let (lower, upper) = ((b - a).mul_add(share, a), (d - c).mul_add(share, c));
        // Inverse depth along the optical axis is what is linear from row to row.
        let [first, per_row] = self.planes.upright.horizontal();
        let (first, per_row) = (simd.splat(first), simd.splat(per_row));
        let (low_depth, depth) = (below_row.mul_add(per_row, first), place.row.mul_add(per_row, first));
        let (lower, upper) = (lower * low_depth, upper * (low_depth + per_row));
        let half = simd.splat(0.5);
        let (near_left, near_below) = (share.lt(half), rise.lt(half));
        let nearest = a.select(near_left, b).select(near_below, c.select(near_left, d));
        let smooth = (high - low).le((high + low) * simd.splat(EDGE));
        let between = (upper - lower).mul_add(rise, lower) * depth.recip();
        let inverse = between.select(smooth, nearest);
        let zero = simd.splat(0.0);
        let range = place.square.sqrt() * inverse.recip();
        let range = zero.select(simd.splat(AT_EYE).lt(inverse), range);
        range.select(zero.lt(inverse), simd.splat(f32::INFINITY))
    }

    /// Light that a plane saw in a row; both are taken into the fan.
    #[inline(always)]
    fn words(&self, plane: V::I, row: V::I) -> V::I {
        self.simd.gather_words(bytemuck::cast_slice(self.planes.cells), self.index(plane, row))
    }

    #[inline(always)]
    fn inverse(&self, plane: V::I, row: V::I) -> V::F {
        self.simd.gather(bytemuck::cast_slice(self.planes.inverse), self.index(plane, row))
    }

    /// Where a plane's row is among words.
    #[inline(always)]
    fn index(&self, plane: V::I, row: V::I) -> V::I {
        let simd = self.simd;
        let [planes, rows] = self.planes.upright.size;
        let plane = plane.max(simd.splat_int(0)).min(simd.splat_int(planes as i32 - 1));
        let row = row.max(simd.splat_int(0)).min(simd.splat_int(rows as i32 - 1));
        let cell = plane.shr::<4>().mul(simd.splat_int(rows as i32)) + row;
        cell.shl::<4>() + (plane & simd.splat_int(LANES as i32 - 1))
    }
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
