//! Rows of sixteen planes: the parts that are still free, and the spans that were seen.

#[cfg(test)]
mod tests;

use std::ops::Range;

use super::facade::FacadeFront;
use super::fill::Fill;
use crate::simd::{Floats, Ints, LANES, Mask, Simd, Sixteen};

/// Parts of a row that opaque matter covers or not, bits of an element.
const PARTS: f32 = 8.0;
const ALL: i32 = 0xff;

/// Share of the light behind that counts as none.
const NOTHING_LEFT: f32 = 1.0 / 256.0;

/// Share of light from which on what hides it is what is there, as the reference has it.
const HALF: f32 = 0.5;

/// Rows behind the last one that are asked for together with it.
const BEYOND: usize = 2;

/// Bit of each plane.
const PLANE_BITS: [i32; LANES] = {
    let mut bits = [0; LANES];
    let mut plane = 0;
    while plane < LANES {
        bits[plane] = 1 << plane;
        plane += 1;
    }
    bits
};

const NONE: Sixteen = Sixteen([0.0; LANES]);

/// Light of spans in one row of sixteen planes: shares, as yet without the air before it.
#[derive(Debug, Clone, Copy)]
pub struct SpanRow {
    /// Radiance times the share of the row that shows it, linear Rec. 709.
    pub light: [Sixteen; 3],
    /// Share of the row that spans cover, 0…1.
    pub share: Sixteen,
    /// Sum of inverse depths times shares, 1/metres.
    pub inverse: Sixteen,
    /// Parts of the row that opaque matter covers, bits 0 (lowest) to 7.
    covered: [i32; LANES],
    /// Share of light that comes through what is semitransparent.
    left: Sixteen,
}

/// Distance of the spans in a row's middle.
#[derive(Debug, Clone, Copy)]
pub struct RowMiddle {
    /// Inverse depth of what hides half of the light, 1/metres; 0: nothing.
    pub inverse: Sixteen,
    /// Change of that: to the next plane, and for each unit of the tangent of elevation.
    pub tilts: [Sixteen; 2],
    /// Share of light that is hidden there, 0…1.
    hidden: Sixteen,
}

impl SpanRow {
    const EMPTY: Self = Self {
        light: [NONE; 3],
        share: NONE,
        inverse: NONE,
        covered: [0; LANES],
        left: Sixteen([1.0; LANES]),
    };
}

impl RowMiddle {
    const EMPTY: Self = Self { inverse: NONE, tilts: [NONE; 2], hidden: NONE };
}

/// Coverage of rows of sixteen planes by spans.
#[derive(Debug, Clone, Default)]
pub struct SpanCoverage {
    rows: Vec<SpanRow>,
    /// Nothing unless it is of interest how far away things are.
    middles: Vec<RowMiddle>,
    /// Planes, as bits, that show something in a row; what memory has of other rows is from before.
    shown: Vec<u16>,
    /// Planes, as bits, in which a row is hidden all over. Behind the last row come [`BEYOND`] that are not.
    full: Vec<u16>,
    /// The lowest row that may not be hidden, of each plane.
    lowest: [i32; LANES],
}

/// Part of a row that a face fills.
struct RowPart<V: Simd> {
    /// Number of the row.
    row: usize,
    /// Planes in which it is open, as bits.
    planes: u16,
    /// Places between which it is filled, rows from its lower edge.
    within: [V::F; 2],
    /// Radiance of the face there, linear Rec. 709.
    light: [V::F; 3],
    /// Tangent of its middle.
    centre: f32,
}

/// Face of a span that rows are filled with.
pub(super) struct FilledFace<'f, V: Simd> {
    pub fill: &'f Fill<V>,
    /// `None`: the light is the same in all rows.
    pub facade: Option<&'f FacadeFront<'f, V>>,
}

impl SpanCoverage {
    /// Empties it for so many rows.
    pub(super) fn begin(&mut self, rows: usize, has_depths: bool) {
        self.shown.clear();
        self.shown.resize(rows, 0);
        self.full.clear();
        self.full.resize(rows + BEYOND, 0);
        if self.rows.len() < rows {
            self.rows.resize(rows, SpanRow::EMPTY);
        }
        self.middles.resize(if has_depths { rows } else { 0 }, RowMiddle::EMPTY);
        self.lowest = [0; LANES];
    }

    /// Rows that show something, with their numbers; of each what is in its middle, if that is of interest.
    pub fn rows(&self) -> impl Iterator<Item = (usize, &SpanRow, Option<&RowMiddle>)> {
        let shown = self.shown.iter().enumerate().filter(|(_, planes)| **planes != 0);
        shown.map(|(row, _)| (row, &self.rows[row], self.middles.get(row)))
    }

    /// Number of rows.
    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        self.shown.len()
    }

    /// Whether it is of interest how far away things are.
    #[inline(always)]
    pub(super) fn has_depths(&self) -> bool {
        !self.middles.is_empty()
    }

    /// Takes rows below `places` for hidden in some planes. Returns the lowest row of each that is not hidden, or how many rows there are.
    #[inline(always)]
    pub(super) fn close_below<V: Simd>(&mut self, simd: V, planes: V::M, places: V::F) -> V::I {
        let (zero, own) = (simd.splat_int(0), simd.load_ints(&PLANE_BITS));
        let count = simd.splat(self.count() as f32);
        let below = places.max(simd.splat(0.0)).min(count).to_int();
        let before = simd.load_ints(&self.lowest);
        let mut lowest = before.max(below).select(planes, before);

        let mut is_full = planes;
        loop {
            let full = simd.gather_pairs(&self.full, lowest) & own;
            is_full = is_full & !full.eq(zero);
            if !is_full.any() {
                break;
            }
            lowest = (lowest + simd.splat_int(1)).select(is_full, lowest);
        }

        lowest.store(&mut self.lowest);
        lowest
    }

    /// The rows that lie between two places in some of `planes`.
    #[inline(always)]
    pub(super) fn rows_between<V: Simd>(
        &self,
        simd: V,
        planes: V::M,
        [low, high]: [V::F; 2],
    ) -> Range<usize> {
        let (zero, count) = (simd.splat(0.0), simd.splat(self.count() as f32));
        let below = low.max(zero).min(count).to_int().least(planes);
        // A row in which something ends is one of them.
        let above = (count - high).max(zero).min(count).to_int().least(planes);
        below.max(0) as usize..self.count().saturating_sub(above.max(0) as usize)
    }

    /// Whether one of these rows is not hidden in some of `planes`.
    #[inline(always)]
    pub(super) fn has_open(&self, planes: u16, rows: Range<usize>) -> bool {
        self.full.get(rows).is_some_and(|rows| rows.iter().any(|full| planes & !full != 0))
    }

    /// Fills what is open in `planes` between two places, in rows, all of which lie in a range; `centres` are the middles' tangents. A façade
    /// makes each row's light its own. The fill has numbers in all planes, as [`Fill::keep`] leaves them.
    #[inline(always)]
    pub(super) fn fill<V: Simd>(
        &mut self,
        simd: V,
        planes: u16,
        rows: Range<usize>,
        places: [V::F; 2],
        seen: &FilledFace<'_, V>,
        centres: &[f32],
    ) {
        let FilledFace { fill, facade } = *seen;
        for row in rows {
            let open = planes & !self.full[row];
            if open == 0 {
                continue;
            }

            let within = [places[0] - simd.splat(row as f32), places[1] - simd.splat(row as f32)];
            let light = match facade {
                Some(facade) => facade.light(simd, row, fill.light),
                None => fill.light,
            };
            let part = RowPart { row, planes: open, within, light, centre: centres[row] };
            self.fill_row(simd, &part, fill);
        }
    }

    /// Fills a part of a row.
    #[inline(always)]
    fn fill_row<V: Simd>(&mut self, simd: V, part: &RowPart<V>, fill: &Fill<V>) {
        let RowPart { row: number, planes, within, light: [r, g, b], centre } = *part;
        let [zero, one, half] = [simd.splat(0.0), simd.splat(1.0), simd.splat(HALF)];
        let (all, tangent) = (simd.splat_int(ALL), simd.splat(centre));

        // Shares of the row at which what fills it begins and ends.
        let [from, to] = [within[0].max(zero).min(one), within[1].max(zero).min(one)];
        let open = simd.mask(planes) & from.lt(to);
        if !open.any() {
            return;
        }

        if self.shown[number] == 0 {
            self.rows[number] = SpanRow::EMPTY;
            if let Some(middle) = self.middles.get_mut(number) {
                *middle = RowMiddle::EMPTY;
            }
        }

        self.shown[number] |= open.bits();
        let row = &mut self.rows[number];
        let inverse = fill.inverse_at(tangent);
        let covered = simd.load_ints(&row.covered);
        let begin = from.mul_add(simd.splat(PARTS), half).to_int();
        let end = to.mul_add(simd.splat(PARTS), half).to_int();
        let bits = (power(simd, end) - power(simd, begin)) & (all - covered);

        // A stretch that is narrower than a part covers that in part.
        let is_narrow = begin.eq(end);
        let narrow = zero.select(covered.eq(all), to - from);
        let share = narrow.select(is_narrow, ones(simd, bits).to_float() * simd.splat(1.0 / PARTS));
        let left = simd.load(&row.left.0);
        let opacity = fill.opacity_at(simd, tangent);
        let hidden = share * opacity;
        let weight = (left * hidden).select(open, zero);

        // All lanes are stored: the next face often goes on in this row, and what is stored in part must have got to the cache before it is loaded.
        let [red, green, blue] = &mut row.light;
        for (sum, value) in [(red, r), (green, g), (blue, b), (&mut row.inverse, inverse)] {
            weight.mul_add(value, simd.load(&sum.0)).store(&mut sum.0);
        }

        (simd.load(&row.share.0) + weight).store(&mut row.share.0);
        let covers = open & one.le(opacity) & !is_narrow;
        let covered = (covered | bits).select(covers, covered);
        let left = (left - left * hidden).select(open & !covers, left);

        // No light comes from behind, though it may not be known yet how far away the middle is.
        let is_dark = open & (covered.eq(all) | left.lt(simd.splat(NOTHING_LEFT)));
        covered.store(&mut row.covered);
        zero.select(is_dark, left).store(&mut row.left.0);
        let mut is_full = is_dark;

        if let Some(middle) = self.middles.get_mut(number) {
            let hidden = simd.load(&middle.hidden.0);
            let has_middle = open & from.le(half) & half.lt(to);
            let more = (one - hidden).mul_add(opacity, hidden).select(has_middle, hidden);
            let hides = hidden.lt(half) & half.le(more);

            // Once the half is hidden it does not matter how much more.
            more.store(&mut middle.hidden.0);
            inverse.store_masked(hides, &mut middle.inverse.0);
            let [across, along] = fill.tilts_at(simd, inverse);
            across.store_masked(hides, &mut middle.tilts[0].0);
            along.store_masked(hides, &mut middle.tilts[1].0);
            is_full = is_dark & half.le(more);
        }

        self.full[number] |= is_full.bits();
    }
}

/// 2 to these powers, which are 0 to 8.
#[inline(always)]
fn power<V: Simd>(simd: V, exponents: V::I) -> V::I {
    (exponents + simd.splat_int(127)).shl::<23>().as_floats().to_int()
}

/// Counts the ones among the lowest eight bits.
#[inline(always)]
fn ones<V: Simd>(simd: V, bits: V::I) -> V::I {
    let pairs = bits - (bits.shr::<1>() & simd.splat_int(0x55));
    let fours = (pairs & simd.splat_int(0x33)) + (pairs.shr::<2>() & simd.splat_int(0x33));
    (fours + fours.shr::<4>()) & simd.splat_int(0xf)
}
