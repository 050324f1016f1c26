//! A page's radiance as lines across scan planes: filtered over what a line stands for.
//!
//! ```text
//! along the planes:   mean over the stride from one line to the next     the ends count half
//! across them:        mean over 1, 2 or 4 posts, by the footprint
//! both:               posts count by what is seen of them                facing
//! ```
//!
//! At a grazing angle a pixel covers several times as much along the ray as across it: a stride follows
//! from the first, and the width of texels from the second. Texels of a line lie side by side
//! whichever axis the planes run along.

use super::facing::Facing;
use super::page::{Baking, ImageFinish, LitPosts, encode};
use super::posts::PageLight;
use super::window::{Window, WindowRow};
use crate::detail::{DETAIL_RING, DetailPosts};
use crate::sensor::radiance::part::{PostPart, RING};
use crate::simd::{Each, Floats, Isa, LANES, Simd, turned};
use crate::voxel::{BARE, PageId, PageSource};
use hedgehop_base::error::Result;

/// Filter that turns posts of a page into lines along the planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LineFilter {
    /// Direction of the planes: lines are columns of the page if along x, rows if along y.
    pub facing: Facing,
    /// log₂ of posts across a texel, up to 2.
    pub shift: u8,
    /// Lines from one to the next: 1, 2 or 4. Those divisible by it are there.
    pub span: u8,
}

impl LineFilter {
    /// Whether lines of a level show detail below its voxels: from so near that texels are no wider than posts of the finest.
    pub fn has_detail(&self, level: u8) -> bool {
        matches!(level, 0 | BARE) && self.shift == 0 && usize::from(self.span) <= 2 * DETAIL_RING
    }

    /// Whether texels are posts of the finest level themselves.
    pub fn shows_posts(&self, level: u8) -> bool {
        matches!(level, 0 | BARE) && self.shift == 0 && self.span == 1
    }
}

/// Steps of relative deviation per one.
pub const DEVIATION_UNITS: f32 = 65535.0;

/// Steps of relative deviation over walls per one, and the code of none.
pub const WALL_UNITS: f32 = 32767.0;
pub const NO_WALL: u16 = 1 << 15;

/// Lines of a part of a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LineImage {
    /// Texels as of a page, `[line][texel]`; a texel more on either side of all that lie across the part.
    pub texels: Vec<u32>,
    /// Relative deviations of light below the voxel, 65,535 to one, `[line][texel]` as texels; empty if lines have no detail.
    pub deviations: Vec<u16>,
    /// Relative deviations over walls, 32,767 to one from 32,768 on: above it over (y, z), below over (x, z); as deviations, empty if there are no walls.
    pub walls: Vec<u16>,
    /// Texels from one line to the next: those of the part and two.
    pub row: usize,
}

impl LineImage {
    /// The lines of a part of a page that begins with a line; `None` where the page is absent. Every instruction set gives the
    /// same bits.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn bake(
        source: &dyn PageSource,
        id: PageId,
        part: PostPart,
        lamp: &PageLight<'_>,
        filter: LineFilter,
        scratch: &mut FilterScratch,
        isa: Isa,
    ) -> Result<Option<Self>> {
        let FilterScratch { window, detail, sums, image } = scratch;
        let detail = filter.has_detail(id.level).then_some(detail);
        let finish = LineFiltering { filter, sums, image };
        isa.run(Baking { source, id, part, lamp, facing: &filter.facing, window, detail, finish })
    }

    /// A line without light.
    pub fn dark() -> Self {
        let row = 2 * LANES;
        Self { texels: vec![0; row], deviations: Vec::new(), walls: Vec::new(), row }
    }

    /// Returns the begin of line `index`, of the last one if it is beyond.
    #[inline(always)]
    pub fn start_of(&self, index: usize) -> usize {
        index.saturating_mul(self.row).min(self.texels.len() - self.row)
    }

    /// Bytes of texels and deviations.
    pub fn bytes(&self) -> usize {
        let deviations = size_of_val(self.deviations.as_slice()) + size_of_val(self.walls.as_slice());
        size_of_val(self.texels.as_slice()) + deviations
    }
}

/// Memory for what is needed to make lines, used again and again: lines are kept for long, and what lay between them in memory and is free
/// would be of little use.
#[derive(Debug, Default)]
pub struct FilterScratch {
    window: Window,
    detail: DetailPosts,
    sums: Sums,
    image: Vec<u32>,
}

struct LineFiltering<'l> {
    filter: LineFilter,
    sums: &'l mut Sums,
    image: &'l mut Vec<u32>,
}

impl ImageFinish for LineFiltering<'_> {
    type Image = LineImage;

    #[inline(always)]
    fn image<V: Simd>(self, simd: V, posts: LitPosts<'_>) -> LineImage {
        let LitPosts { window, detail, size } = posts;
        let Self { filter, sums, image } = self;
        let (major, wide) = (usize::from(filter.facing.major), 1 << filter.shift);
        let lines = Shares::of_lines(usize::from(filter.span), size[major]);
        let texels = Shares::of_texels(wide, size[1 - major]);

        // Rows of posts lie along x: columns of texels are lines if the planes run along x.
        let [rows, columns] = if major == 0 { [&texels, &lines] } else { [&lines, &texels] };
        let row = texels.count;
        image.resize(rows.count * columns.count, 0);

        if rows.step == 1 && columns.step == 1 {
            for (index, target) in image.chunks_exact_mut(columns.count).enumerate() {
                let posts = window.row(rows.first + index);
                encode(simd, target, posts.light.each(|plane| &plane[columns.first..]));
            }
        } else {
            sums.begin(size[0] + 2 * RING, columns.count);
            for (index, target) in image.chunks_exact_mut(columns.count).enumerate() {
                sums.clear();
                for (post, share) in rows.posts(index) {
                    sums.add(simd, window.row(post), share);
                }
                encode(simd, target, sums.means(simd, columns));
            }
        }

        let turned_if_columns = |image: &[u32]| {
            if major == 0 { turned(image, columns.count, 0..columns.count) } else { image.to_vec() }
        };
        let texels = turned_if_columns(image);
        let [mut deviations, mut walls] = [Vec::new(), Vec::new()];
        if let Some(detail) = detail {
            let middles = Middles { rows, columns, window };
            middles.encode(image, |post| detail.deviations(post), 0.0, DEVIATION_UNITS);
            deviations.extend(turned_if_columns(image).into_iter().map(|deviation| deviation as u16));

            if !detail.wall_deviations([0, 0]).is_empty() {
                middles.encode(image, |post| detail.wall_deviations(post), f32::from(NO_WALL), WALL_UNITS);
                walls.extend(turned_if_columns(image).into_iter().map(|deviation| deviation as u16));
            }
        }

        LineImage { texels, deviations, walls, row }
    }
}

/// Posts in the middles of lines and texels, whose deviations stand for theirs.
struct Middles<'m> {
    rows: &'m Shares,
    columns: &'m Shares,
    window: &'m Window,
}

impl Middles<'_> {
    /// Writes codes `zero` + `units` · deviation of each into an image; `deviations` are those of a post and of the posts behind it, counted from the first of
    /// the detail's ring. Snow hides its share of them.
    fn encode<'d>(
        &self,
        image: &mut [u32],
        deviations: impl Fn([usize; 2]) -> &'d [f32],
        zero: f32,
        units: f32,
    ) {
        let Self { rows, columns, window } = self;
        let middle = |shares: &Shares, index: usize| shares.first + shares.step / 2 + index * shares.step;
        let column = middle(columns, 0);
        for (index, target) in image.chunks_exact_mut(columns.count).enumerate() {
            let row = middle(rows, index);
            let found = deviations([column, row].each(|at: usize| at + DETAIL_RING - RING));
            let found = found.iter().step_by(columns.step).zip(target.iter_mut());
            let bare = window.row(row).bare;
            if bare.is_empty() {
                found.for_each(|(deviation, target)| *target = (deviation * units + (zero + 0.5)) as u32);
                continue;
            }
            for ((deviation, target), share) in found.zip(bare[column..].iter().step_by(columns.step)) {
                *target = (deviation * share * units + (zero + 0.5)) as u32;
            }
        }
    }
}

/// Posts along an axis that make a line or a texel of several, and the weight of each.
struct Shares {
    /// The first post of the first one, counted with the ring, and posts from one to the next: 1, 2 or 4.
    first: usize,
    step: usize,
    /// Number of the posts.
    count: usize,
    /// Posts behind the last.
    end: usize,
    /// Whether the post at either end of a step counts half, for this one and for the next.
    has_halves: bool,
}

impl Shares {
    fn of_lines(span: usize, along: usize) -> Self {
        let (first, has_halves) = (RING - span / 2, span > 1);
        Self { first, step: span, count: along.div_ceil(span), end: along + 2 * RING, has_halves }
    }

    /// A texel more on either side; the last one may be narrower than the others, and the one beside goes on from it.
    fn of_texels(wide: usize, across: usize) -> Self {
        let (first, end) = (RING - wide, RING + across + wide);
        Self { first, step: wide, count: across.div_ceil(wide) + 2, end, has_halves: false }
    }

    /// Posts of one of them, and their shares.
    #[inline(always)]
    fn posts(&self, index: usize) -> impl Iterator<Item = (usize, f32)> {
        let (first, step, has_halves) = (self.first + index * self.step, self.step, self.has_halves);
        let posts = first..self.end.min(first + step + usize::from(has_halves));
        posts.map(move |post| {
            (post, if has_halves && (post == first || post == first + step) { 0.5 } else { 1.0 })
        })
    }
}

/// Radiance times weights, summed up over rows of posts: red, green, blue, and the weights.
#[derive(Debug, Default)]
struct Sums {
    /// Posts of a row by channel, and as many behind it as are looked at.
    posts: [Vec<f32>; 4],
    /// Means of the posts of a row that are taken together; the fourth is not used.
    means: [Vec<f32>; 4],
    width: usize,
}

impl Sums {
    /// Begins the sums of rows of `width` posts, which make `count` sums.
    fn begin(&mut self, width: usize, count: usize) {
        self.width = width;
        self.posts.iter_mut().for_each(|plane| plane.resize(width + LANES, 0.0));
        self.means.iter_mut().for_each(|plane| plane.resize(count.next_multiple_of(LANES), 0.0));
    }

    fn clear(&mut self) {
        self.posts.iter_mut().for_each(|plane| plane.fill(0.0));
    }

    /// Adds a row.
    #[inline(always)]
    fn add<V: Simd>(&mut self, simd: V, row: WindowRow<'_>, share: f32) {
        let [red, green, blue] = row.light;
        let share = simd.splat(share);
        for first in (0..self.width).step_by(LANES) {
            let load = |plane: &[f32]| plane[first..].first_chunk().map_or(share, |lanes| simd.load(lanes));
            let weight = load(row.weights) * share;
            let light = [load(red) * weight, load(green) * weight, load(blue) * weight, weight];
            for (channel, plane) in self.posts.iter_mut().enumerate() {
                let more = light[channel];
                if let Some(sums) = plane[first..].first_chunk_mut() {
                    (simd.load(sums) + more).store(sums);
                }
            }
        }
    }

    /// Mean radiance over posts of a row that belong together.
    #[inline(always)]
    fn means<V: Simd>(&mut self, simd: V, columns: &Shares) -> [&[f32]; 3] {
        for (posts, together) in self.posts.iter_mut().zip(&mut self.means) {
            posts[columns.end..].fill(0.0);
            let together = &mut together[..columns.count];
            match columns.step {
                1 => sum_up::<1>(posts, columns, together),
                2 => sum_up::<2>(posts, columns, together),
                _ => sum_up::<4>(posts, columns, together),
            }
        }
        let [red, green, blue, weights] = &mut self.means;
        for plane in [&mut *red, &mut *green, &mut *blue] {
            for (mean, weight) in plane.as_chunks_mut().0.iter_mut().zip(weights.as_chunks().0) {
                (simd.load(mean) / simd.load(weight)).store(mean);
            }
        }
        [red, green, blue]
    }
}

/// Sums of `STEP` posts each, or of these and the next one's first, which both count half.
#[inline(always)]
fn sum_up<const STEP: usize>(posts: &[f32], columns: &Shares, target: &mut [f32]) {
    let (head, tail) = if columns.has_halves { (0.5, 0.5) } else { (1.0, 0.0) };
    let steps = &posts[columns.first..].as_chunks::<STEP>().0[..columns.count + 1];
    for (index, target) in target.iter_mut().enumerate() {
        let rest: f32 = steps[index][1..].iter().sum();
        *target = head * steps[index][0] + rest + tail * steps[index + 1][0];
    }
}
