//! Column of rows of one plane: the part that is still free, and the spans that were seen.

use crate::simd::{Each, Floats, Ints, LANES, Mask, Simd, Sixteen, math};

/// Parts of a row that opaque matter covers or not, bits of an element.
const PARTS: f32 = 8.0;
const ALL: i32 = 0xff;

/// Share of the light behind that counts as none.
const NOTHING_LEFT: f32 = 1.0 / 256.0;

/// Share of light from which on what hides it is what is there, as the reference has it.
const HALF: f32 = 0.5;

/// Steepest way through a voxel whose length is told, rise over run: above and below the eye there is no end to it.
const STEEPEST: f32 = 1.0e6;

/// Rows in a word of flags.
const WORD: usize = u64::BITS as usize;

/// Light of spans in sixteen rows, one above the other: shares, as yet without the air before it.
#[derive(Debug, Clone, Copy)]
struct SpanRows {
    /// Parts of each row that opaque matter covers, bits 0 (lowest) to 7.
    covered: [i32; LANES],
    /// Share of light that comes through what is semitransparent.
    left: Sixteen,
    /// Radiance times the share of the row that shows it, linear Rec. 709.
    light: [Sixteen; 3],
    /// Share of the row that spans cover, 0…1.
    share: Sixteen,
    /// Sum of inverse depths times shares, 1/metres.
    inverse: Sixteen,
}

/// Distance of the spans in the rows' middles.
#[derive(Debug, Clone, Copy)]
struct RowMiddles {
    /// Share of light that is hidden there, 0…1.
    hidden: Sixteen,
    /// Inverse depth of what hides the half of it, 1/metres; 0: nothing.
    inverse: Sixteen,
    /// Change of that distance: to the next plane, and for each unit of the tangent of elevation.
    tilts: [Sixteen; 2],
}

impl SpanRows {
    const EMPTY: Self = Self {
        covered: [0; LANES],
        left: Sixteen([1.0; LANES]),
        light: [NONE; 3],
        share: NONE,
        inverse: NONE,
    };
}

impl RowMiddles {
    const EMPTY: Self = Self { hidden: NONE, inverse: NONE, tilts: [NONE; 2] };
}

const NONE: Sixteen = Sixteen([0.0; LANES]);

/// Numbers of rows, from the first of sixteen on.
const NUMBERS: [f32; LANES] =
    [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];

/// Elements of a row: red, green and blue, the share, inverse depth times that, inverse depth in the middle and how it goes on.
const ELEMENTS: usize = 8;

/// Coverage of rows of sixteen planes by spans.
#[derive(Debug, Clone, Default)]
pub struct SpanCoverage {
    rows: Vec<[Sixteen; ELEMENTS]>,
    /// Rows of which some plane shows something, first and one beyond the last.
    extent: [usize; 2],
}

/// Stretch of sixteen rows that is to be filled.
#[derive(Debug, Clone, Copy)]
struct OpenStretch {
    /// Rows that are not hidden, as bits.
    open: u16,
    /// Places where it begins and ends, rows from the first of the sixteen on.
    within: [f32; 2],
}

/// Fill of rows by one span.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fill {
    /// Haze of the span that lets light through; `None`: it hides all.
    pub haze: Option<Haze>,
    /// Inverse depth, 1/metres, and by how much it rises to the next plane.
    pub inverse: LinearTerm,
    pub across: f32,
    /// Least and greatest value of the first: at the plane's exit from the visible part, and at the front of that.
    pub bounds: [f32; 2],
    /// Rise to the next plane at the front.
    pub front: f32,
}

/// Quantity that is linear in the tangent of elevation.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinearTerm {
    tangent: f32,
    value: f32,
    slope: f32,
}

impl LinearTerm {
    /// The same everywhere.
    #[inline(always)]
    pub fn level(value: f32) -> Self {
        Self { tangent: 0.0, value, slope: 0.0 }
    }

    /// Through a value, rising by `slope` for each unit of the tangent.
    #[inline(always)]
    pub fn new(tangent: f32, value: f32, slope: f32) -> Self {
        Self { tangent, value, slope }
    }

    /// Values at tangents.
    #[inline(always)]
    fn at<V: Simd>(&self, simd: V, tangents: V::F) -> V::F {
        (tangents - simd.splat(self.tangent)).mul_add(simd.splat(self.slope), simd.splat(self.value))
    }
}

/// Half-transparent matter on a plane's way through one voxel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Haze {
    /// Logarithm (of 2) of the share of light that comes through on a level way between the voxel's sides.
    pub clearness: f32,
    /// Depth per distance along the ground.
    pub level: f32,
    /// Tangents between which it is seen.
    pub tangents: [f32; 2],
    /// Ends of that way.
    pub passage: PlanePassage,
}

/// The ends of a span where a plane enters its voxel and where it leaves it, as tangents.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlanePassage {
    /// Inverse depths there, 1/metres.
    pub inverse: [f32; 2],
    pub top: [f32; 2],
    pub bottom: [f32; 2],
}

impl Haze {
    /// Shares of light that it hides from rays of these tangents, 0…1.
    #[inline(always)]
    fn opacity<V: Simd>(&self, simd: V, tangents: V::F) -> V::F {
        let [low, high] = self.tangents.each(|tangent| simd.splat(tangent));
        let tangents = tangents.max(low).min(high);
        let [steepest, one] = [STEEPEST, 1.0].each(|value| simd.splat(value));
        let slant = (simd.splat(self.level) * tangents).abs().min(steepest);
        let way = slant.mul_add(slant, one).sqrt() * self.passage.share(simd, tangents);
        one - math::exp_neg(simd, way * simd.splat(-self.clearness * std::f32::consts::LN_2))
    }
}

impl PlanePassage {
    /// Shares of the way through the voxel that rays of these tangents are within the span: ends are lines between the sides.
    #[inline(always)]
    fn share<V: Simd>(&self, simd: V, tangents: V::F) -> V::F {
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let (mut enter, mut leave) = (zero, one);
        let [near, far] = self.top;

        // Sinking beside the ray, or rising above it.
        let passes = simd.splat(near.min(far)).lt(tangents);
        if far < near {
            leave = leave.min(self.crossing(simd, tangents, self.top)).select(passes, leave);
        } else {
            enter = enter.max(self.crossing(simd, tangents, self.top)).select(passes, enter);
        }

        let [near, far] = self.bottom;
        let passes = tangents.lt(simd.splat(near.max(far)));
        if far > near {
            leave = leave.min(self.crossing(simd, tangents, self.bottom)).select(passes, leave);
        } else {
            enter = enter.max(self.crossing(simd, tangents, self.bottom)).select(passes, enter);
        }

        (leave - enter).max(zero)
    }

    /// Share of the way at which rays are as high as an end: heights, not tangents, are linear along it, so that `near` and `far` count by
    /// the depths there.
    #[inline(always)]
    fn crossing<V: Simd>(&self, simd: V, tangents: V::F, [near, far]: [f32; 2]) -> V::F {
        let [from, to] = self.inverse;
        let begun = (tangents - simd.splat(near)) * simd.splat(to);
        let left = (simd.splat(far) - tangents) * simd.splat(from);
        begun / (begun + left)
    }
}

/// The rows of one plane.
#[derive(Debug, Default)]
pub(super) struct FreeRows {
    /// Number of rows.
    count: usize,
    rows: Vec<SpanRows>,
    /// Nothing unless it is of interest how far away things are.
    middles: Vec<RowMiddles>,
    /// Bits of rows that are hidden all over, and how many are not.
    full: Vec<u64>,
    open: usize,
    /// The lowest row that may not be hidden.
    lowest: usize,
    /// Rows that show something, first and one beyond the last.
    extent: [usize; 2],
}

impl SpanCoverage {
    /// Empties it.
    pub(super) fn clear(&mut self) {
        self.extent = [usize::MAX, 0];
    }

    /// Takes what was seen in the rows of sixteen planes: row by row, so that each is written at once.
    pub(super) fn take(&mut self, columns: &[FreeRows; LANES]) {
        let first = columns.iter().map(|column| column.extent[0]).min().unwrap_or(usize::MAX);
        let end = columns.iter().map(|column| column.extent[1]).max().unwrap_or(0);
        self.extent = [first, end];
        if self.rows.len() < end {
            self.rows.resize(end, [Sixteen::default(); ELEMENTS]);
        }
        for sixteen in first.min(end) / LANES..end.div_ceil(LANES) {
            let rows = self.rows[sixteen * LANES..].chunks_mut(LANES).next().unwrap_or_default();
            for (lane, column) in columns.iter().enumerate() {
                let SpanRows { light: [red, green, blue], share, inverse, .. } = &column.rows[sixteen];
                put(rows, lane, 0, [red, green, blue, share, inverse]);
                if let Some(RowMiddles { inverse, tilts: [across, along], .. }) = column.middles.get(sixteen)
                {
                    put(rows, lane, 5, [inverse, across, along]);
                }
            }
        }
    }

    /// Rows that show something, with their numbers: red, green and blue of the light, share, the sum of inverse depths times shares, and what hides the
    /// middle's half: inverse depth (0: nothing does), which rises by so much to the next plane, and for each unit of the tangent. Without depths the last
    /// three tell nothing.
    pub fn rows(&self) -> impl Iterator<Item = (usize, &[Sixteen; ELEMENTS])> {
        let [first, end] = self.extent;
        (first.min(end)..end).zip(self.rows.get(first..end).unwrap_or_default())
    }
}

/// Puts what one plane has in rows one above the other into a lane of elements of these rows, from `first` on.
#[inline(always)]
fn put<const N: usize>(rows: &mut [[Sixteen; ELEMENTS]], lane: usize, first: usize, values: [&Sixteen; N]) {
    for (row, elements) in rows.iter_mut().enumerate() {
        for (index, values) in values.iter().enumerate() {
            elements[first + index].0[lane] = values.0[row];
        }
    }
}

impl FreeRows {
    /// Empties it for so many rows.
    pub fn begin(&mut self, count: usize, has_depths: bool) {
        // Beyond its extent all rows are as they were.
        let [first, end] = self.extent;
        let used = first.min(end) / LANES..end.div_ceil(LANES);
        let sixteens = count.div_ceil(LANES);
        self.rows[used.clone()].fill(SpanRows::EMPTY);
        self.rows.resize(sixteens, SpanRows::EMPTY);
        if let Some(middles) = self.middles.get_mut(used) {
            middles.fill(RowMiddles::EMPTY);
        }
        self.middles.resize(if has_depths { sixteens } else { 0 }, RowMiddles::EMPTY);
        self.full.clear();
        self.full.resize(count.div_ceil(WORD), 0);
        (self.count, self.open) = (count, count);
        self.lowest = 0;
        self.extent = [usize::MAX, 0];
    }

    /// Whether it is of interest how far away things are.
    #[inline(always)]
    pub fn has_depths(&self) -> bool {
        !self.middles.is_empty()
    }

    /// Whether all rows are hidden.
    pub fn is_closed(&self) -> bool {
        self.open == 0 || self.lowest == self.count
    }

    /// All rows below a place are hidden. Returns the lowest one that is not, or how many there are.
    #[inline(always)]
    pub fn close_below(&mut self, place: f32) -> usize {
        let rows = self.count;
        self.lowest = self.lowest.max(place.max(0.0) as usize).min(rows);
        self.lowest = self.next_open(self.lowest, rows).unwrap_or(rows);
        self.lowest
    }

    /// Whether all rows between two places are hidden.
    #[inline(always)]
    pub fn is_full(&self, low: f32, high: f32) -> bool {
        // What ends within a row needs all of that.
        let whole = high.max(0.0) as usize;
        let end = (whole + usize::from(high > whole as f32)).min(self.count);
        self.next_open((low.max(0.0) as usize).min(end), end).is_none()
    }

    /// The first row from `row` on and before `end` that is not hidden.
    #[inline(always)]
    fn next_open(&self, mut row: usize, end: usize) -> Option<usize> {
        while row < end {
            let (word, bit) = (row / WORD, row % WORD);
            let full = (self.full[word] >> bit).trailing_ones() as usize;
            row += full;
            if bit + full < WORD {
                return (row < end).then_some(row);
            }
        }
        None
    }

    /// Fills what is open between two places, in rows, of which `centres` are the middles' tangents.
    #[inline(always)]
    pub fn fill<V: Simd>(
        &mut self,
        simd: V,
        [low, high]: [f32; 2],
        light: [f32; 3],
        fill: &Fill,
        centres: &[Sixteen],
    ) {
        let (low, high) = (low.max(0.0), high.min(self.count as f32));
        if low >= high {
            return;
        }
        let first = low as usize;
        let end = (high as usize) + usize::from(high > (high as usize) as f32);
        let sixteens = first / LANES..end.div_ceil(LANES);
        for (sixteen, centres) in sixteens.clone().zip(&centres[sixteens]) {
            let row = sixteen * LANES;
            let open = !(self.full[row / WORD] >> (row % WORD)) as u16;
            if open != 0 {
                let within = [low, high].each(|place| place - row as f32);
                self.fill_sixteen(simd, sixteen, OpenStretch { open, within }, light, fill, centres);
            }
        }
        self.extent = [self.extent[0].min(first), self.extent[1].max(end)];
    }

    /// Fills a stretch of sixteen rows.
    #[inline(always)]
    fn fill_sixteen<V: Simd>(
        &mut self,
        simd: V,
        sixteen: usize,
        stretch: OpenStretch,
        light: [f32; 3],
        fill: &Fill,
        centres: &Sixteen,
    ) {
        let OpenStretch { open, within } = stretch;
        let [zero, one, half] = [0.0, 1.0, HALF].each(|value| simd.splat(value));
        let all = simd.splat_int(ALL);

        // Shares of each row at which what fills it begins and ends.
        let [from, to] = [below(simd, within[0]), below(simd, within[1])];
        let open = simd.mask(open) & from.lt(to);
        let centres = simd.load(&centres.0);
        let [least, most] = fill.bounds.each(|bound| simd.splat(bound));
        let inverse = fill.inverse.at(simd, centres).max(least).min(most);
        let opacity = fill.haze.as_ref().map_or(one, |haze| haze.opacity(simd, centres));
        let rows = &mut self.rows[sixteen];
        let covered = simd.load_ints(&rows.covered);
        let [begin, end] = [from, to].each(|place| place.mul_add(simd.splat(PARTS), half).to_int());
        let bits = (power(simd, end) - power(simd, begin)) & (all - covered);

        // What is narrower than a part covers it in part.
        let is_narrow = begin.eq(end);
        let narrow = zero.select(covered.eq(all), to - from);
        let share = narrow.select(is_narrow, ones(simd, bits).to_float() * simd.splat(1.0 / PARTS));
        let left = simd.load(&rows.left.0);
        let hidden = share * opacity;
        let weight = (left * hidden).select(open, zero);
        let add = |value: V::F, sum: &mut Sixteen| weight.mul_add(value, simd.load(&sum.0)).store(&mut sum.0);
        for (channel, sum) in rows.light.iter_mut().enumerate() {
            add(simd.splat(light[channel]), sum);
        }

        add(one, &mut rows.share);
        add(inverse, &mut rows.inverse);
        let covers = open & one.le(opacity) & !is_narrow;
        let covered = (covered | bits).select(covers, covered);
        let left = (left - left * hidden).select(open & !covers, left);

        // No light comes from behind, though it may not be known yet how far away the middle is.
        let is_dark = open & (covered.eq(all) | left.lt(simd.splat(NOTHING_LEFT)));
        covered.store(&mut rows.covered);
        zero.select(is_dark, left).store(&mut rows.left.0);
        let mut is_full = is_dark;

        if let Some(middles) = self.middles.get_mut(sixteen) {
            let hidden = simd.load(&middles.hidden.0);
            let has_middle = open & from.le(half) & half.lt(to);
            let more = (one - hidden).mul_add(opacity, hidden).select(has_middle, hidden);
            let hides = hidden.lt(half) & half.le(more);

            // Once the half is hidden it does not matter how much more.
            more.store(&mut middles.hidden.0);
            inverse.store_masked(hides, &mut middles.inverse.0);
            let goes_on = inverse.lt(most);
            let across = simd.splat(fill.across).select(goes_on, simd.splat(fill.front));
            let along = simd.splat(fill.inverse.slope).select(goes_on, zero);
            across.store_masked(hides, &mut middles.tilts[0].0);
            along.store_masked(hides, &mut middles.tilts[1].0);
            is_full = is_dark & half.le(more);
        }

        let (row, full) = (sixteen * LANES, is_full.bits());
        self.full[row / WORD] |= u64::from(full) << (row % WORD);
        self.open -= full.count_ones() as usize;
    }
}

/// Returns the share of each of sixteen rows that lies below a place. (No closure: compilers leave those of arrays functions of their own, without the
/// instruction set.)
#[inline(always)]
fn below<V: Simd>(simd: V, place: f32) -> V::F {
    (simd.splat(place) - simd.load(&NUMBERS)).max(simd.splat(0.0)).min(simd.splat(1.0))
}

/// 2 to these powers, which are 0 to 8.
#[inline(always)]
fn power<V: Simd>(simd: V, exponents: V::I) -> V::I {
    (exponents + simd.splat_int(127)).shl::<23>().as_floats().to_int()
}

/// Counts the ones among the lowest eight bits.
#[inline(always)]
fn ones<V: Simd>(simd: V, bits: V::I) -> V::I {
    let every = |pattern: i32| simd.splat_int(pattern);
    let pairs = bits - (bits.shr::<1>() & every(0x55));
    let fours = (pairs & every(0x33)) + (pairs.shr::<2>() & every(0x33));
    (fours + fours.shr::<4>()) & every(0xf)
}
