//! Shares of the sun's disc that the posts of a page see.

use std::collections::BTreeSet;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

use super::Sun;
use super::course::{Course, Leg};
use super::rows::{CourseRows, NONE, mix};
use super::sweep::{Crossing, Shadow, Step, carry};
use crate::cache::{Bytes, KeyedCache};
use crate::simd::{Isa, Kernel, Simd};
use crate::voxel::{APRON, Header, PAGE_SIDE, PageId, PageSource, RADIX};
use hedgehop_base::error::Result;

/// Posts around a page whose share of the sun is told with it.
pub const SHADE_APRON: u32 = 5;

/// Share of the fall over a voxel by which ground must lie below a sharp shadow's height to see nothing of the sun: the edges of shadows take half a voxel,
/// and ground that a ray grazes is lit.
const SOFT: f32 = 0.5;

/// Greatest share, as it is stored.
const ALL: f32 = 255.0;

/// Fall of the sun on a database's ground.
#[derive(Debug, Clone)]
pub struct Shade {
    course: Course,
    isa: Isa,
}

/// Share of the sun's disc that each post of a page sees.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShadePage {
    /// Shares in 1/255, `[height + 10][width + 10]`, rows from south to north; 255 beside the area.
    pub shares: Vec<u8>,
    /// Row stride: posts eastward with those around the page.
    pub stride: usize,
}

impl ShadePage {
    /// Share of the sun, 0…1, at a post (eastward, northward), counted from the first of those around the page; beyond them that of the nearest.
    pub fn at(&self, [x, y]: [usize; 2]) -> f32 {
        let rows = self.shares.len() / self.stride;
        f32::from(self.shares[y.min(rows - 1) * self.stride + x.min(self.stride - 1)]) / ALL
    }

    /// The greatest share of the sun, 0…1, at a post, counted as [`Self::at`] counts, and the eight about it. What stands there divides light from the shadow that it throws
    /// itself, and its sides belong to the light.
    pub fn about(&self, [x, y]: [usize; 2]) -> f32 {
        let nine = (0..9).map(|index| [(x + index % 3).saturating_sub(1), (y + index / 3).saturating_sub(1)]);
        nine.map(|place| self.at(place)).fold(0.0, f32::max)
    }
}

impl Bytes for Arc<ShadePage> {
    fn bytes(&self) -> usize {
        self.shares.len()
    }
}

impl Shade {
    /// Under `sun`, over a database with this header.
    pub fn new(header: &Header, sun: Sun) -> Self {
        Self { course: Course::new(header, sun), isa: Isa::best() }
    }

    /// The same with another instruction set; shadows have the same bits.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// Posts of the page and around it that are in the area, as rows and posts along them.
    fn target(&self, id: PageId) -> [Range<i64>; 2] {
        let dims = self.course.dims(id.level);
        let axis = |page: u32, size: i64| {
            let [first, apron] = [i64::from(page) * i64::from(PAGE_SIDE), i64::from(SHADE_APRON)];
            (first - apron).max(0)..(first + i64::from(PAGE_SIDE) + apron).min(size)
        };
        let axes = [axis(id.px, dims[0]), axis(id.py, dims[1])];
        [axes[self.course.major].clone(), axes[1 - self.course.major].clone()]
    }

    /// Row just before the first of some that a ray of the sun comes to.
    fn begin(&self, rows: &Range<i64>) -> f64 {
        if self.course.towards > 0 { rows.end as f64 - 0.5 } else { rows.start as f64 - 0.5 }
    }

    /// The way of the sun's rays to a page: all that, besides the heights of [`Self::supports`], its shares are a function of.
    pub fn way(&self, id: PageId) -> impl Debug + use<> {
        let [rows, posts] = self.target(id);
        let (first, strands) = self.course.strands(&rows, &posts);
        (self.course.legs(id.level, self.begin(&rows), first, strands), rows, posts)
    }

    /// Pages whose heights [`Self::page`] may read for a page: itself, those around it, and those towards the sun; for those that `source` does not have
    /// what stands in for them.
    pub fn supports(&self, source: &dyn PageSource, id: PageId) -> Vec<PageId> {
        let course = &self.course;
        let [rows, posts] = self.target(id);
        let (first, strands) = course.strands(&rows, &posts);
        let end = self.begin(&rows);
        let near = if course.towards > 0 { rows.start } else { rows.end - 1 };
        let own = Leg { level: id.level, end, near, count: rows.end - rows.start, first, strands };
        let mut pages = BTreeSet::new();
        for leg in [own].iter().chain(&course.legs(id.level, end, first, strands)) {
            course.pages(leg, |page| self.add(source, page, &mut pages));
        }
        pages.into_iter().collect()
    }

    /// Adds a page, or what stands in for it.
    fn add(&self, source: &dyn PageSource, id: PageId, pages: &mut BTreeSet<PageId>) {
        if source.has(id) {
            pages.insert(id);
        } else if id.level + 1 < source.header().level_count {
            // The coarser posts around its own.
            let (side, radix) = (i64::from(PAGE_SIDE), i64::from(RADIX));
            let dims = self.course.dims(id.level + 1);
            let around = |page: u32, last: i64| {
                let first = i64::from(page) * side / radix;
                let [low, high] = [first - 1, first + side / radix].map(|post| post.clamp(0, last) / side);
                low as u32..=high as u32
            };
            for py in around(id.py, dims[1] - 1) {
                for px in around(id.px, dims[0] - 1) {
                    self.add(source, PageId { level: id.level + 1, px, py }, pages);
                }
            }
        }
    }

    /// Computes what the posts of a page see of the sun; `None` where the page is absent.
    ///
    /// # Errors
    /// A page, this one or one towards the sun, that is damaged.
    pub fn page(&self, source: &dyn PageSource, id: PageId) -> Result<Option<ShadePage>> {
        let Some(view) = source.heights(id)? else { return Ok(None) };
        let (course, apron) = (&self.course, SHADE_APRON as usize);
        let stride = view.width as usize + 2 * apron;
        let height = view.heights.len() / (view.width + 2 * APRON) as usize;
        let mut shares = vec![ALL as u8; stride * (height - 2 * (APRON as usize - apron))];
        let [rows, posts] = self.target(id);
        let (first, strands) = course.strands(&rows, &posts);
        let reader = CourseRows { source, course };
        let legs = course.legs(id.level, self.begin(&rows), first, strands);
        let mut shadow = carry(&reader, &legs, strands, self.isa)?;
        let step = Step::of(course, id.level);
        shadow.go(step.times(0.5));
        let soft = SOFT * course.fall_over_voxel(id.level);
        let mut heights = vec![NONE; strands + 1];
        let mut line = vec![0; (posts.end - posts.start) as usize];
        let count = rows.end - rows.start;

        for index in 0..count {
            let row = if course.towards > 0 { rows.end - 1 - index } else { rows.start + index };
            let (aside, share) = course.aside(row);
            reader.read(id.level, row, first + aside, &mut heights)?;

            // Where the posts lie between the strands.
            let place = -course.lean * row as f64;
            let strand = (posts.start as f64 + place).floor() as i64 - first;
            let own = &heights[(posts.start - first - aside) as usize..];
            let among = (place - place.floor()) as f32;

            self.isa.run(Lighting {
                shadow: &shadow,
                spread: course.spread(),
                strand: strand as usize,
                among,
                own,
                soft,
                line: &mut line,
            });

            put(&mut shares, stride, course.major, id, row, posts.start, &line);
            self.isa.run(Crossing { shadow: &mut shadow, row: &heights, share, step });
        }

        Ok(Some(ShadePage { shares, stride }))
    }
}

/// Writes a row of posts from `first` on.
fn put(shares: &mut [u8], stride: usize, major: usize, id: PageId, row: i64, first: i64, line: &[u8]) {
    let place = |page: u32, post: i64| {
        (post - i64::from(page) * i64::from(PAGE_SIDE) + i64::from(SHADE_APRON)) as usize
    };
    if major == 1 {
        let start = place(id.py, row) * stride + place(id.px, first);
        shares[start..start + line.len()].copy_from_slice(line);
    } else {
        let start = place(id.py, first) * stride + place(id.px, row);
        for (share, target) in line.iter().zip(shares[start..].iter_mut().step_by(stride)) {
            *target = *share;
        }
    }
}

/// Shares of the sun along a row.
struct Lighting<'s> {
    shadow: &'s Shadow,
    /// Widening of a half-shadow per metre, metres of height.
    spread: f32,
    /// The strand before the first post, and how far from it to the next one the posts lie.
    strand: usize,
    among: f32,
    /// Heights of the posts.
    own: &'s [f32],
    soft: f32,
    line: &'s mut [u8],
}

impl Kernel for Lighting<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, _: V) {
        let Self { shadow: Shadow { full, half, way }, spread, strand, among, own, soft, line } = self;
        let count = line.len();
        let beside = |plane| -> [&[f32]; 2] {
            let plane: &Vec<f32> = plane;
            [&plane[strand..strand + count], &plane[strand + 1..strand + 1 + count]]
        };
        let (full, half, way) = (beside(full), beside(half), beside(way));
        let own = &own[..count];
        for post in 0..count {
            let between = |plane: [&[f32]; 2]| mix(plane[0][post], plane[1][post], among);
            let depth = between(half) - own[post];
            // What throws the half-shadow hides so much of the sun, and something nearer may hide all of it.
            let part = 1.0 - depth / (between(way) * spread + soft);
            let rest = 1.0 - (between(full) - own[post]) / soft;
            line[post] = (part.min(rest).clamp(0.0, 1.0) * ALL + 0.5) as u8;
        }
    }
}

/// Shares of one database's pages under one sun, kept within a budget.
#[derive(Debug)]
pub struct Shades {
    shade: Shade,
    pages: KeyedCache<PageId, Arc<ShadePage>>,
}

impl Shades {
    /// Nothing is known yet, and at most `budget` bytes are kept besides what the latest frames used.
    pub fn new(shade: Shade, budget: usize) -> Self {
        Self { shade, pages: KeyedCache::new(budget) }
    }

    /// Returns how the sun falls.
    pub fn shade(&self) -> &Shade {
        &self.shade
    }

    /// Whether a page's shares are kept.
    pub fn has(&self, id: PageId) -> bool {
        self.pages.has(id)
    }

    /// Bytes that are kept.
    pub fn bytes(&self) -> usize {
        self.pages.bytes()
    }

    /// A new frame begins: drops what was not used for longest if there is more than the budget allows.
    pub fn begin_frame(&self) {
        self.pages.begin_frame();
    }

    /// Returns what the posts of a page see of the sun; `None` where the page is absent.
    ///
    /// # Errors
    /// As of [`Shade::page`].
    pub fn page(&self, source: &dyn PageSource, id: PageId) -> Result<Option<Arc<ShadePage>>> {
        self.pages.get(id, || Ok(self.shade.page(source, id)?.map(Arc::new)))
    }
}
