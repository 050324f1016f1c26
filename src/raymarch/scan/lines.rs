//! Heights along a line of posts, where sixteen planes cross it.

use super::pages::{Codes, Pages};
use crate::error::Result;
use crate::simd::{Floats, Ints, Simd};
use crate::voxel::{APRON, HeightCode, PAGE_SIDE, PageId};

/// Most pages that a block of lines may lie in, side by side; planes are never so far apart that a level
/// of their footprint needs more.
const MOST_PAGES: usize = 4;

/// Code of what is no surface: below any.
pub const NO_CODE: f32 = -1.0e34;

/// Pages of one level side by side along the minor axis: the lines of one block.
pub struct Lines<'a> {
    /// Height codes with apron of each page, line by line, and how many one line has.
    parts: [(Codes<'a>, i32); MOST_PAGES],
    count: usize,
    /// Index of the pages' first line, and of the first page's first post.
    pub first: [i64; 2],
    /// The area's first and last post, counted from there: beside it the surface goes on level.
    limits: [f32; 2],
}

impl<'a> Lines<'a> {
    /// Pages of `level` with line `line` along axis `major`, that hold the posts `posts` (first and last, may
    /// lie outside the area). `None`: one of them is absent, or they are too many.
    pub fn find(
        pages: &mut Pages<'a>,
        level: u8,
        major: usize,
        line: i64,
        posts: [i64; 2],
    ) -> Result<Option<Self>> {
        let side = i64::from(PAGE_SIDE);
        let grid = pages.source().header().grid;
        let posts_across = i64::from([grid.dims(level).0, grid.dims(level).1][1 - major]);
        let dims = grid.page_dims(level);
        let dims = [i64::from(dims.0), i64::from(dims.1)];
        let [first, last] = posts.map(|post| post.div_euclid(side).clamp(0, dims[1 - major] - 1));
        let page_line = line.div_euclid(side).clamp(0, dims[major] - 1);
        let count = (last - first + 1) as usize;
        if count > MOST_PAGES {
            return Ok(None);
        }
        let mut lines = Self {
            parts: [const { (Codes::Rows(&[]), 0) }; MOST_PAGES],
            count,
            first: [page_line * side, first * side],
            limits: [-(first * side) as f32, (posts_across - 1 - first * side) as f32],
        };
        for part in 0..count {
            let (along, across) = (page_line as u32, first as u32 + part as u32);
            let (px, py) = if major == 0 { (along, across) } else { (across, along) };
            let Some(codes) = pages.codes(PageId { level, px, py }, major)? else { return Ok(None) };
            lines.parts[part] = codes;
        }
        Ok(Some(lines))
    }

    /// Whether these pages hold a line, in an apron or themselves.
    #[inline(always)]
    pub fn have(&self, line: i64) -> bool {
        (-i64::from(APRON)..i64::from(PAGE_SIDE)).contains(&(line - self.first[0]))
    }

    /// Codes at post positions `post` of `line` (both counted from `first`; −1 is the apron), interpolated between
    /// two posts; [`NO_CODE`] where either has no surface.
    #[inline(always)]
    pub fn codes<V: Simd>(&self, simd: V, line: i32, post: V::F) -> V::F {
        let post = self.within(simd, post);
        let floor = post.floor();
        self.cell(simd, line, floor, post - floor)
    }

    /// A post position, taken into the area.
    #[inline(always)]
    pub fn within<V: Simd>(&self, simd: V, post: V::F) -> V::F {
        post.max(simd.splat(self.limits[0])).min(simd.splat(self.limits[1]))
    }

    /// The same, `share` of the way from a post within the area to the next one.
    #[inline(always)]
    pub fn cell<V: Simd>(&self, simd: V, line: i32, first: V::F, share: V::F) -> V::F {
        let cell = first.to_int();
        let mut code = self.part(simd, 0, line, cell, share);
        for part in 1..self.count {
            let start = simd.splat_int(part as i32 * PAGE_SIDE as i32);
            let here = self.part(simd, part, line, cell - start, share);
            code = code.select(start.gt(cell), here);
        }
        code
    }

    #[inline(always)]
    fn part<V: Simd>(&self, simd: V, part: usize, line: i32, cell: V::I, share: V::F) -> V::F {
        let (codes, row) = &self.parts[part];
        let apron = APRON as i32;
        let pair = simd.gather_pairs(codes.all(), cell + simd.splat_int((line + apron) * row + apron));
        let (low, high) = (pair & simd.splat_int(0xffff), pair.shr::<16>());
        let (low, high) = (low.to_float(), high.to_float());
        let code = (high - low).mul_add(share, low);
        // Surfaces have codes from 1 on.
        let nothing = low.min(high).lt(simd.splat(f32::from(HeightCode::EMPTY) + 0.5));
        simd.splat(NO_CODE).select(nothing, code)
    }
}
