//! Lines that planes may see, told from where they may look.
//!
//! A [`Footprint`](super::Footprint) tells pages; whoever lights lines ahead of need asks also which lines, and how many of them one may stand for. Where
//! the march divides a stride it depends on how steep the ground is there, which only its heights tell: see [`Rises`].

use crate::simd::{Isa, Kernel, Simd};
use crate::voxel::{APRON, HeightCode, HeightsView, PAGE_SIDE, PageId};

/// Lines of one level that some groups of planes may see.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// The first group, and the one behind the last, counted in the order in which they were added.
    pub groups: [usize; 2],
    /// Level index.
    pub level: u8,
    /// Columns and rows of voxels, first and last.
    pub voxels: [[u32; 2]; 2],
    /// Major distances between which they lie, units.
    pub distances: [f64; 2],
    /// Which of 1, 2 and 4 lines one may stand for, by their log₂.
    pub spans: [bool; 3],
    /// Rise from one line that is read to the next, in height codes, up to which no lines between them are read.
    pub flat: f32,
    /// Height, in codes, that a post must reach for more lines to be read before it: what lies lower is out of sight, or hardly in it.
    pub seen: f32,
    /// Posts across per line along the axis, least and most.
    pub minor: [f32; 2],
}

impl Stretch {
    /// Pages on which it lies, rows from the south.
    pub fn pages(&self) -> impl Iterator<Item = PageId> + use<> {
        let Self { level, voxels: [x, y], .. } = *self;
        let pages = |[first, last]: [u32; 2]| first / PAGE_SIDE..=last / PAGE_SIDE;
        pages(y).flat_map(move |py| pages(x).map(move |px| PageId { level, px, py }))
    }

    /// What of it lies on a page: columns and rows, first and last, counted from the page's first.
    pub fn on(&self, page: PageId) -> [[u32; 2]; 2] {
        let part = |[first, last]: [u32; 2], page: u32| {
            let start = page * PAGE_SIDE;
            [first.max(start) - start, last.min(start + PAGE_SIDE - 1) - start]
        };
        [part(self.voxels[0], page.px), part(self.voxels[1], page.py)]
    }

    /// Steps from line to line that planes may take.
    fn steps(&self) -> impl Iterator<Item = Step> + Clone + use<> {
        let minor = self.minor;
        (0..=self.widest().trailing_zeros() as u8).flat_map(move |log| {
            // Planes go no more across than along, and some rounding.
            let [low, high] = minor.map(|minor| (minor * f32::from(1_u8 << log)).floor() as i32);
            let across = low.max(-ACROSS)..=(high + 1).min(ACROSS);
            across.map(move |across| Step { log, across: across as i8 })
        })
    }

    /// Lines that one may stand for, log₂.
    pub fn own(&self) -> impl Iterator<Item = usize> + use<> {
        let spans = self.spans;
        (0..spans.len()).filter(move |log| spans[*log])
    }

    /// The same where strides are divided.
    pub fn shorter(&self) -> impl Iterator<Item = usize> + use<> {
        let spans = self.spans;
        (0..self.widest().trailing_zeros() as usize).filter(move |log| !spans[*log])
    }

    /// Most lines from one that is read to the next.
    pub fn widest(&self) -> u32 {
        self.spans.iter().rposition(|is_one| *is_one).map_or(1, |log| 1 << log)
    }
}

/// Posts along the side of a block of which rises are known.
const SIDE: usize = 16;
const BLOCKS: usize = PAGE_SIDE as usize / SIDE;

/// Most posts across that planes go while they go four lines along.
const ACROSS: i32 = 5;

/// Codes of one unit of a rise that is kept, log₂.
const UNIT: u32 = 2;

/// Where planes go from a post of a line that is read to the next such line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Step {
    /// log₂ of lines along.
    log: u8,
    /// Posts across.
    across: i8,
}

impl Step {
    /// One bit of 33.
    fn bit(self) -> u64 {
        1 << (u32::from(self.log) * (2 * ACROSS + 1) as u32 + (i32::from(self.across) + ACROSS) as u32)
    }
}

/// Greatest rise of a step, block by block, rounded up to units; the greatest value stands for any greater one, and for posts without surface.
type Rise = [[u8; BLOCKS]; BLOCKS];

/// How steep the ground of a page rises along an axis, in one sense, at most, for the steps that were asked about.
#[derive(Debug, Default)]
pub struct Rises {
    by_step: Vec<(Step, Box<Rise>)>,
    /// Steps that are there, by their numbers.
    known: u64,
    /// The greatest of all of them.
    any: Rise,
    /// The greatest height of each block and of what is around it, codes.
    high: [[u16; BLOCKS]; BLOCKS],
}

impl Rises {
    /// Whether planes may read lines between others, among `columns` and `rows` of the page; `None` if it takes steps to know that were
    /// not [measured](Self::measure).
    pub fn may_divide(&self, stretch: &Stretch, [columns, rows]: [[u32; 2]; 2]) -> Option<bool> {
        let blocks = |[first, last]: [u32; 2]| first as usize / SIDE..=last as usize / SIDE;
        // What is just as high as a unit may be less.
        let flat = (stretch.flat / (1 << UNIT) as f32).floor();
        let rises = |rise: &Rise| {
            blocks(rows).any(|y| {
                let mut both = rise[y][blocks(columns)].iter().zip(&self.high[y][blocks(columns)]);
                both.any(|(&units, &high)| {
                    units == u8::MAX || f32::from(units) > flat && f32::from(high) >= stretch.seen
                })
            })
        };
        let mut steps = stretch.steps();
        if rises(&self.any) {
            let of = |step| self.by_step.iter().find(|(known, _)| *known == step);
            if steps.clone().any(|step| of(step).is_some_and(|(_, rise)| rises(rise))) {
                return Some(true);
            }
        }
        steps.all(|step| self.known & step.bit() != 0).then_some(false)
    }

    /// Measures the steps that a stretch takes to know, on its page, for planes along axis `major`, up it or down.
    pub fn measure(&mut self, stretch: &Stretch, view: &HeightsView<'_>, major: usize, forward: bool) {
        if self.known == 0 {
            self.high = Isa::best().run(Highest(view));
        }
        for step in stretch.steps() {
            if self.known & step.bit() == 0 {
                let rise = Isa::best().run(Steepest { view, major, forward, step });
                let both = self.any.as_flattened_mut().iter_mut().zip(rise.as_flattened());
                both.for_each(|(any, one)| *any = (*any).max(*one));
                self.known |= step.bit();
                self.by_step.push((step, rise));
            }
        }
    }
}

/// Finds the greatest heights of a page.
struct Highest<'v>(&'v HeightsView<'v>);

impl Kernel for Highest<'_> {
    type Output = [[u16; BLOCKS]; BLOCKS];

    /// Plain loops, as of [`Steepest`].
    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Self::Output {
        let Self(view) = self;
        let row = (view.width + 2 * APRON) as usize;
        let mut highest = [[0; BLOCKS]; BLOCKS];
        // A post that is stepped to may lie in the apron, or in the next block.
        let margin = APRON as usize;
        for (y, highest) in highest.iter_mut().enumerate() {
            let rows = view.heights.chunks_exact(row).skip(y * SIDE).take(SIDE + 2 * margin);
            let mut greatest = [0; (PAGE_SIDE + 2 * APRON) as usize];
            for posts in rows {
                for (greatest, &code) in greatest.iter_mut().zip(posts) {
                    *greatest = (*greatest).max(code);
                }
            }
            for (x, highest) in highest.iter_mut().enumerate() {
                let codes = &greatest[x * SIDE..x * SIDE + SIDE + 2 * margin];
                *highest = codes.iter().fold(0, |most, &code: &u16| most.max(code));
            }
        }
        highest
    }
}

/// Finds the greatest rises of a page.
struct Steepest<'v> {
    view: &'v HeightsView<'v>,
    major: usize,
    forward: bool,
    step: Step,
}

impl Kernel for Steepest<'_> {
    type Output = Box<Rise>;

    /// Plain loops over posts side by side, for the compiler to do many at once.
    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Box<Rise> {
        let Self { view, major, forward, step } = self;
        let apron = APRON as usize;
        let row = view.width as usize + 2 * apron;
        let height = view.heights.len() / row - 2 * apron;
        let [along, across] = if major == 0 { [1, row as isize] } else { [row as isize, 1] };
        let along = if forward { along } else { -along };
        let step = (along << step.log) + isize::from(step.across) * across;
        let mut rises = Box::new([[0; BLOCKS]; BLOCKS]);
        for first in (0..height).step_by(SIDE) {
            let mut greatest = [0; PAGE_SIDE as usize];
            for y in first..(first + SIDE).min(height) {
                let start = (y + apron) * row + apron;
                let here = &view.heights[start..start + view.width as usize];
                // The apron is wider than any step.
                let start = (start as isize + step) as usize;
                let there = &view.heights[start..start + here.len()];
                for ((greatest, &here), &there) in greatest.iter_mut().zip(here).zip(there) {
                    let is_empty = here.min(there) == HeightCode::EMPTY;
                    let rise = if is_empty { u16::MAX } else { there.saturating_sub(here) };
                    *greatest = (*greatest).max(rise);
                }
            }
            for (rise, greatest) in rises[first / SIDE].iter_mut().zip(greatest.chunks_exact(SIDE)) {
                let codes = greatest.iter().fold(0, |most, &codes: &u16| most.max(codes));
                *rise = u32::from(codes).div_ceil(1 << UNIT).min(u8::MAX.into()) as u8;
            }
        }
        rises
    }
}
