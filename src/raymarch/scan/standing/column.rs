//! What is left of the rows of one plane, and what was seen in them.

use crate::simd::{LANES, Sixteen};

/// Parts of a row that opaque matter covers or not, bits of a byte.
const PARTS: f32 = 8.0;
const ALL: u8 = u8::MAX;

/// Share of the light behind that counts as none.
const NOTHING_LEFT: f32 = 1.0 / 256.0;

/// Share of light from which on what hides it is what is there, as the reference has it.
const HALF: f32 = 0.5;

/// Steepest way through a voxel whose length is told, rise over run: above and below the eye there is no end to it.
const STEEPEST: f32 = 1.0e6;

/// Rows in a word of flags.
const WORD: usize = u64::BITS as usize;

/// Depth in a row's middle.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Middle {
    /// Its inverse, 1/metres; 0: nothing.
    pub inverse: f32,
    /// How that goes on: to the next plane, and for each unit of the tangent of elevation.
    pub tilt: [f32; 2],
}

/// What a row shows of what stands on the ground: shares of light, as yet without the air before it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Seen {
    /// Radiance times the share of the row that shows it, linear Rec. 709.
    pub light: [f32; 3],
    /// That share, 0…1.
    pub share: f32,
    /// Sum of inverse depths times shares, 1/metres.
    pub inverse: f32,
    /// What hides the half of the light in the row's middle.
    pub middle: Middle,
    /// Share of light that is hidden in the middle, 0…1.
    hidden: f32,
}

impl Seen {
    #[inline(always)]
    fn add(&mut self, weight: f32, light: [f32; 3], inverse: f32) {
        for (sum, light) in self.light.iter_mut().zip(light) {
            *sum += weight * light;
        }
        self.share += weight;
        self.inverse += weight * inverse;
    }

    /// Hides a share of the light in the row's middle.
    #[inline(always)]
    fn hide(&mut self, opacity: f32, middle: Middle) {
        if self.hidden >= HALF {
            return;
        }
        self.hidden += (1.0 - self.hidden) * opacity;
        if self.hidden >= HALF {
            self.middle = middle;
        }
    }
}

/// Elements of a row: red, green and blue, the share, inverse depth times that, inverse depth in the middle and how it goes on.
const ELEMENTS: usize = 8;

/// What rows of sixteen planes show of what stands on the ground.
#[derive(Debug, Clone, Default)]
pub struct Cover {
    rows: Vec<[Sixteen; ELEMENTS]>,
    /// Rows of which some plane shows something, first and one beyond the last.
    extent: [usize; 2],
}

/// How a span fills rows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fill {
    /// What it hides of light that comes through; `None`: all.
    pub haze: Option<Haze>,
    /// Inverse depth, 1/metres, and by how much it rises to the next plane.
    pub inverse: Line,
    pub across: f32,
    /// What the first is at least and at most: where the plane leaves what is seen, and at the front of that.
    pub bounds: [f32; 2],
    /// By how much it rises to the next plane at the front.
    pub front: f32,
}

/// What is linear in the tangent of elevation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    tangent: f32,
    value: f32,
    slope: f32,
}

impl Line {
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

    /// The value at a tangent.
    #[inline(always)]
    pub fn at(&self, tangent: f32) -> f32 {
        (tangent - self.tangent) * self.slope + self.value
    }
}

/// What lets some light through, on a plane's way through one voxel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Haze {
    /// Logarithm (of 2) of the share of light that comes through on a level way between the voxel's sides.
    pub clearness: f32,
    /// Depth per distance along the ground.
    pub level: f32,
    /// Tangents between which it is seen.
    pub tangents: [f32; 2],
    /// Where its ends lie.
    pub passage: Passage,
}

/// The ends of a span where a plane enters its voxel and where it leaves it, as tangents.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passage {
    pub top: [f32; 2],
    pub bottom: [f32; 2],
}

impl Haze {
    /// Share of light that it hides from a ray of this tangent, 0…1.
    #[inline(always)]
    fn opacity(&self, tangent: f32) -> f32 {
        let tangent = tangent.max(self.tangents[0]).min(self.tangents[1]);
        let slant = (self.level * tangent).clamp(-STEEPEST, STEEPEST);
        let way = (slant * slant + 1.0).sqrt() * self.passage.share(tangent);
        1.0 - (self.clearness * way).exp2()
    }
}

impl Passage {
    /// Share of the way through the voxel that a ray of this tangent is within the span: ends are lines between the sides.
    #[inline(always)]
    fn share(&self, tangent: f32) -> f32 {
        let crossing = |[near, far]: [f32; 2]| (tangent - near) / (far - near);
        let (mut enter, mut leave) = (0.0_f32, 1.0_f32);
        let [near, far] = self.top;
        if tangent > near.min(far) {
            // Sinking beside the ray, or rising above it.
            if far < near {
                leave = leave.min(crossing(self.top))
            } else {
                enter = enter.max(crossing(self.top))
            }
        }
        let [near, far] = self.bottom;
        if tangent < near.max(far) {
            if far > near {
                leave = leave.min(crossing(self.bottom));
            } else {
                enter = enter.max(crossing(self.bottom));
            }
        }
        (leave - enter).max(0.0)
    }
}

/// The rows of one plane.
#[derive(Debug, Default)]
pub(super) struct Column {
    /// Parts of each row that are covered.
    covered: Vec<u8>,
    /// Share of light that comes through what is semitransparent.
    left: Vec<f32>,
    seen: Vec<Seen>,
    /// Bits of rows that are hidden all over, and how many are not.
    full: Vec<u64>,
    open: usize,
    /// The lowest row that may not be hidden.
    lowest: usize,
    /// Rows that show something, first and one beyond the last.
    extent: [usize; 2],
    /// Whether it is of interest how far away that is.
    has_depths: bool,
}

impl Cover {
    /// Empties it.
    pub(super) fn clear(&mut self) {
        self.extent = [usize::MAX, 0];
    }

    /// Takes what was seen in the rows of sixteen planes: row by row, so that each is written at once.
    pub(super) fn take(&mut self, columns: &[Column; LANES]) {
        let first = columns.iter().map(|column| column.extent[0]).min().unwrap_or(usize::MAX);
        let end = columns.iter().map(|column| column.extent[1]).max().unwrap_or(0);
        self.extent = [first, end];
        if self.rows.len() < end {
            self.rows.resize(end, [Sixteen::default(); ELEMENTS]);
        }
        for row in first..end {
            let elements = &mut self.rows[row];
            for (lane, column) in columns.iter().enumerate() {
                let Seen { light: [red, green, blue], share, inverse, .. } = column.seen[row];
                for (element, value) in elements.iter_mut().zip([red, green, blue, share, inverse]) {
                    element.0[lane] = value;
                }
            }
            for (lane, column) in columns.iter().enumerate().filter(|(_, column)| column.has_depths) {
                let Middle { inverse, tilt: [across, along] } = column.seen[row].middle;
                for (element, value) in elements[5..].iter_mut().zip([inverse, across, along]) {
                    element.0[lane] = value;
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

impl Column {
    /// Empties it for so many rows.
    pub fn begin(&mut self, rows: usize, has_depths: bool) {
        self.has_depths = has_depths;
        // Beyond its extent all rows are as they were.
        let [first, end] = self.extent;
        let used = first.min(end)..end.min(self.covered.len());
        self.covered[used.clone()].fill(0);
        self.left[used.clone()].fill(1.0);
        self.seen[used].fill(Seen::default());
        self.covered.resize(rows, 0);
        self.left.resize(rows, 1.0);
        self.seen.resize(rows, Seen::default());
        self.full.clear();
        self.full.resize(rows.div_ceil(WORD), 0);
        self.open = rows;
        self.lowest = 0;
        self.extent = [usize::MAX, 0];
    }

    /// Whether it is of interest how far away things are.
    #[inline(always)]
    pub fn has_depths(&self) -> bool {
        self.has_depths
    }

    /// Whether all rows are hidden.
    pub fn is_closed(&self) -> bool {
        self.open == 0 || self.lowest == self.covered.len()
    }

    /// All rows below a place are hidden. Returns the lowest one that is not, or how many there are.
    #[inline(always)]
    pub fn close_below(&mut self, place: f32) -> usize {
        let rows = self.covered.len();
        self.lowest = self.lowest.max(place.max(0.0) as usize).min(rows);
        self.lowest = self.next_open(self.lowest, rows).unwrap_or(rows);
        self.lowest
    }

    /// Whether all rows between two places are hidden.
    #[inline(always)]
    pub fn is_full(&self, low: f32, high: f32) -> bool {
        // What ends within a row needs all of that.
        let whole = high.max(0.0) as usize;
        let end = (whole + usize::from(high > whole as f32)).min(self.covered.len());
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
    pub fn fill(&mut self, [low, high]: [f32; 2], light: [f32; 3], fill: &Fill, centres: &[f32]) {
        let rows = self.covered.len();
        let (low, high) = (low.max(0.0), high.min(rows as f32));
        if low >= high {
            return;
        }
        let first = low as usize;
        let end = (high as usize) + usize::from(high > (high as usize) as f32);
        let mut next = first;
        while let Some(row) = self.next_open(next, end) {
            next = row + 1;
            let centre = centres[row];
            let at = row as f32;
            let (from, to) = ((low - at).max(0.0), (high - at).min(1.0));
            let [least, most] = fill.bounds;
            let inverse = fill.inverse.at(centre).max(least).min(most);
            let is_whole = fill.haze.is_none() && self.covered[row] == 0 && to - from >= 1.0;
            let opacity = fill.haze.as_ref().map_or(1.0, |haze| haze.opacity(centre));
            if self.has_depths && (is_whole || (from..to).contains(&0.5)) {
                let tilt = if inverse < most { [fill.across, fill.inverse.slope] } else { [fill.front, 0.0] };
                self.seen[row].hide(opacity, Middle { inverse, tilt });
            }
            if is_whole {
                self.fill_whole(row, light, inverse);
            } else {
                self.fill_row(row, [from * PARTS, to * PARTS], light, inverse, opacity);
            }
        }
        self.extent = [self.extent[0].min(first), self.extent[1].max(end)];
    }

    /// Fills all of a row of which opaque matter covers nothing yet with opaque matter.
    #[inline(always)]
    fn fill_whole(&mut self, row: usize, light: [f32; 3], inverse: f32) {
        self.seen[row].add(self.left[row], light, inverse);
        self.covered[row] = ALL;
        self.full[row / WORD] |= 1 << (row % WORD);
        self.open -= 1;
    }

    /// Fills the parts of a row between two places with what hides a share of light.
    #[inline(always)]
    fn fill_row(&mut self, row: usize, [from, to]: [f32; 2], light: [f32; 3], inverse: f32, opacity: f32) {
        let [begin, end] = [from, to].map(|place| (place + 0.5) as u32);
        let covered = self.covered[row];
        let bits = (((1_u32 << end) - (1_u32 << begin)) as u8) & !covered;
        // What is narrower than a part covers it in part.
        let is_narrow = begin == end;
        let share = if is_narrow {
            if covered == ALL { 0.0 } else { (to - from) / PARTS }
        } else {
            bits.count_ones() as f32 / PARTS
        };
        let weight = self.left[row] * share * opacity;
        if weight > 0.0 {
            self.seen[row].add(weight, light, inverse);
        }
        if opacity >= 1.0 && !is_narrow {
            self.covered[row] |= bits;
        } else {
            self.left[row] *= 1.0 - share * opacity;
        }
        if self.covered[row] == ALL || self.left[row] < NOTHING_LEFT {
            // No light comes from behind, though it may not be known yet how far away the middle is.
            self.left[row] = 0.0;
            if !self.has_depths || self.seen[row].hidden >= HALF {
                self.full[row / WORD] |= 1 << (row % WORD);
                self.open -= 1;
            }
        }
    }
}
