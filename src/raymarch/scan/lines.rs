//! Heights along a line of posts, where sixteen planes cross it.

use super::Pages;
use crate::error::Result;
use crate::simd::{Floats, Ints, Simd};
use crate::voxel::{APRON, HeightCode, PAGE_SIDE, PageId};

/// Most pages that a block of lines may lie in, side by side; planes are never so far apart that a level
/// of their footprint needs more.
const MOST_PAGES: usize = 4;

/// Pages of one level side by side along the minor axis: the lines of one block.
pub struct Lines<'a> {
    /// Height codes with apron of each page.
    parts: [&'a [u16]; MOST_PAGES],
    /// Elements of a row of each page, apron included.
    rows: [i32; MOST_PAGES],
    count: usize,
    /// 0: lines are columns of pages, 1: rows.
    major: usize,
    /// Index of the pages' first line, and of the first page's first post.
    pub first: [i64; 2],
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
        let dims = pages.source().header().grid.page_dims(level);
        let dims = [i64::from(dims.0), i64::from(dims.1)];
        let [first, last] = posts.map(|post| post.div_euclid(side).clamp(0, dims[1 - major] - 1));
        let page_line = line.div_euclid(side).clamp(0, dims[major] - 1);
        let count = (last - first + 1) as usize;
        if count > MOST_PAGES {
            return Ok(None);
        }
        let mut lines = Self {
            parts: [&[]; MOST_PAGES],
            rows: [0; MOST_PAGES],
            count,
            major,
            first: [page_line * side, first * side],
        };
        for part in 0..count {
            let (along, across) = (page_line as u32, first as u32 + part as u32);
            let (px, py) = if major == 0 { (along, across) } else { (across, along) };
            let Some(view) = pages.get(PageId { level, px, py })? else { return Ok(None) };
            lines.parts[part] = view.heights;
            lines.rows[part] = (view.width + 2 * APRON) as i32;
        }
        Ok(Some(lines))
    }

    /// Codes at post positions `post` of `line` (both counted from `first`; −1 is the apron), interpolated between
    /// two posts; 0 where either has no surface.
    #[inline(always)]
    pub fn codes<V: Simd>(&self, simd: V, line: i32, post: V::F) -> V::F {
        let floor = post.floor();
        let share = post - floor;
        let cell = floor.to_int();
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
        let (table, row) = (self.parts[part], self.rows[part]);
        let apron = APRON as i32;
        let low_half = simd.splat_int(0xffff);
        let (low, high) = if self.major == 1 {
            let pair = simd.gather_pairs(table, cell + simd.splat_int((line + apron) * row + apron));
            (pair & low_half, pair.shr::<16>())
        } else {
            let row_step = simd.splat_int(row);
            let index = cell.mul(row_step) + simd.splat_int(apron * row + line + apron);
            let low = simd.gather_pairs(table, index) & low_half;
            (low, simd.gather_pairs(table, index + row_step) & low_half)
        };
        let (low, high) = (low.to_float(), high.to_float());
        let code = (high - low).mul_add(share, low);
        // Surfaces have codes from 1 on.
        let nothing = low.min(high).lt(simd.splat(f32::from(HeightCode::EMPTY) + 0.5));
        simd.splat(0.0).select(nothing, code)
    }
}
