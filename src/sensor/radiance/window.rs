//! Radiance of a page's posts and of some around it.
//!
//! ```text
//! for each block of posts that one page of the next finer level lies under:
//!     that page is there:  mean over the 4 × 4 finer posts, each lit by its own normal, by what is seen of them
//!     else:                lit by the normals of the level itself
//! posts outside the area, or in absent pages:  as the nearest that is known
//! ```
//!
//! A normal of its own level knows nothing of slopes that are finer than a voxel, and ground of which these are
//! half the relief would grow brighter and smoother with distance. One level further down is as far as this
//! looks: every further one costs sixteen times as many posts.
//!
//! Which way a post is lit depends on its block alone, not on the page that asks: pages agree where they meet.

use std::ops::Range;

use super::facing::{Facing, Slopes};
use super::posts::{Lamp, Posts, Rows, VOID};
use crate::error::Result;
use crate::voxel::{PAGE_SIDE, PageId, PageSource, RADIX};

/// Posts around the page: the apron of images of lines, a texel of four posts.
pub const RING: usize = 4;

/// Posts around it that are lit: those of the ring, and what voids in it take their light from.
const LIT: usize = RING + 1;

/// Posts of a level from `first` on, and what they send.
pub struct Window {
    /// Red, green and blue, `[north][east]`; NaN: not known.
    pub planes: [Vec<f32>; 3],
    /// How they slope.
    pub slopes: Vec<Slopes>,
    /// Posts of a row.
    pub stride: usize,
    /// First post (eastward, northward), counted from the area's.
    first: [i64; 2],
    rows: usize,
}

/// Posts eastward and northward, counted from the area's first.
type Block = [Range<i64>; 2];

impl Window {
    /// Around page `id` of `size` posts, which is there.
    #[inline(always)]
    pub fn around(
        lamp: &Lamp<'_>,
        source: &dyn PageSource,
        id: PageId,
        size: [usize; 2],
        facing: &Facing,
    ) -> Result<Self> {
        let [stride, rows] = size.map(|side| side + 2 * LIT);
        let corner = [id.px, id.py].map(|page| i64::from(page * PAGE_SIDE));
        let first = corner.map(|corner| corner - LIT as i64);
        let planes = [(); 3].map(|()| vec![f32::NAN; stride * rows]);
        let slopes = vec![Slopes::default(); stride * rows];
        let mut window = Self { planes, slopes, stride, first, rows };
        let (nx, ny) = source.header().grid.dims(id.level);
        let last = [i64::from(nx), i64::from(ny)];
        let side = i64::from(if id.level == 0 { PAGE_SIDE } else { PAGE_SIDE / RADIX });
        let wanted = [0, 1]
            .map(|axis| first[axis].max(0)..(first[axis] + [stride, rows][axis] as i64).min(last[axis]));
        for py in wanted[1].start / side..=(wanted[1].end - 1) / side {
            for px in wanted[0].start / side..=(wanted[0].end - 1) / side {
                let block = [(px, 0), (py, 1)].map(|(page, axis): (i64, usize)| {
                    wanted[axis].start.max(page * side)..wanted[axis].end.min((page + 1) * side)
                });
                window.light(lamp, source, id.level, &block, facing)?;
            }
        }
        let own = [0, 1].map(|axis| corner[axis]..corner[axis] + size[axis] as i64);
        window.extend(last, &own);
        window.cover_voids();
        window.crop();
        Ok(window)
    }

    /// Lights a block that lies in one page of the level, and over one page of the next finer level.
    #[inline(always)]
    fn light(
        &mut self,
        lamp: &Lamp<'_>,
        source: &dyn PageSource,
        level: u8,
        block: &Block,
        facing: &Facing,
    ) -> Result<()> {
        let page = |side: u32| block.clone().map(|range| range.start as u32 / side);
        if let Some(finer) = level.checked_sub(1) {
            let side = PAGE_SIDE / RADIX;
            let [px, py] = page(side);
            let id = PageId { level: finer, px, py };
            if let Some(view) = source.page(id)? {
                let posts = Posts::new(lamp, source.header(), id, view);
                self.fill(block, side, |y, columns, rows| posts.mean_row(y, columns, facing, rows));
                return Ok(());
            }
        }
        let [px, py] = page(PAGE_SIDE);
        let id = PageId { level, px, py };
        if let Some(view) = source.page(id)? {
            let posts = Posts::new(lamp, source.header(), id, view);
            self.fill(block, PAGE_SIDE, |y, columns, rows| posts.row(y, columns, rows));
        }
        Ok(())
    }

    /// Fills a block row by row; rows and columns are counted from the first of a square of `side`.
    #[inline(always)]
    fn fill(&mut self, block: &Block, side: u32, row: impl Fn(usize, Range<usize>, Rows<'_>)) {
        let corner = block.clone().map(|range| range.start - range.start % i64::from(side));
        let [columns, _] = block.clone();
        for y in block[1].clone() {
            let start = self.index([columns.start, y]);
            let range = start..start + columns.clone().count();
            let [red, green, blue] = &mut self.planes;
            let light = [&mut red[range.clone()], &mut green[range.clone()], &mut blue[range.clone()]];
            let target = Rows { light, slopes: &mut self.slopes[range] };
            let columns = (columns.start - corner[0]) as usize..(columns.end - corner[0]) as usize;
            row((y - corner[1]) as usize, columns, target);
        }
    }

    fn index(&self, [x, y]: [i64; 2]) -> usize {
        (y - self.first[1]) as usize * self.stride + (x - self.first[0]) as usize
    }

    /// Gives posts that are not known what the nearest one in the area of `dims` posts sends, else the nearest of the
    /// page's `own`.
    fn extend(&mut self, dims: [i64; 2], own: &Block) {
        for y in self.first[1]..self.first[1] + self.rows as i64 {
            let is_own_row = own[1].contains(&y);
            for x in self.first[0]..self.first[0] + self.stride as i64 {
                if is_own_row && own[0].contains(&x) {
                    continue;
                }
                let target = self.index([x, y]);
                let near = self.index([x.clamp(0, dims[0] - 1), y.clamp(0, dims[1] - 1)]);
                let nearest = self
                    .index([x.clamp(own[0].start, own[0].end - 1), y.clamp(own[1].start, own[1].end - 1)]);
                // A post in an absent page has no neighbour to agree with.
                let from = if self.planes[0][near].is_nan() { nearest } else { near };
                for plane in &mut self.planes {
                    plane[target] = plane[from];
                }
                self.slopes[target] = self.slopes[from];
            }
        }
    }
    /// Gives posts without a surface the mean of what those beside them send, or black: at the rim of a void, pixels and texels
    /// look a little beyond the last post.
    fn cover_voids(&mut self) {
        let voids: Vec<_> = (0..self.planes[0].len()).filter(|&post| self.planes[0][post] == VOID).collect();
        let light: Vec<_> = voids.iter().map(|&post| self.mean_beside(post)).collect();
        for (post, light) in voids.into_iter().zip(light) {
            for (plane, light) in self.planes.iter_mut().zip(light) {
                plane[post] = light;
            }
        }
    }

    /// Takes the outermost posts away.
    fn crop(&mut self) {
        let (width, stride) = (self.stride - 2, self.stride);
        let rows = 1..self.rows - 1;
        for plane in &mut self.planes {
            *plane = rows.clone().flat_map(|row| &plane[row * stride + 1..][..width]).copied().collect();
        }
        let slopes = rows.clone().flat_map(|row| &self.slopes[row * stride + 1..][..width]);
        self.slopes = slopes.copied().collect();
        self.first = self.first.map(|first| first + 1);
        (self.stride, self.rows) = (width, rows.len());
    }

    /// Mean of the posts beside a post that have a surface.
    fn mean_beside(&self, post: usize) -> [f32; 3] {
        let (x, y) = (post % self.stride, post / self.stride);
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for row in y.saturating_sub(1)..(y + 2).min(self.rows) {
            for column in x.saturating_sub(1)..(x + 2).min(self.stride) {
                let beside = row * self.stride + column;
                if self.planes[0][beside] != VOID {
                    count += 1.0;
                    for (sum, plane) in sum.iter_mut().zip(&self.planes) {
                        *sum += plane[beside];
                    }
                }
            }
        }
        sum.map(|sum: f32| sum / f32::max(count, 1.0))
    }
}
