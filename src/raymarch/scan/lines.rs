//! Heights along a line of posts, where sixteen planes cross it.
//!
//! Tried without gain: registers of each line's own posts instead of a block's, where planes drift far within one (gathers are as
//! fast: both wait for memory); fetching a group's lines of the next block (march −4 %, light +2 %).

use super::pages::{Codes, Pages, together};
use crate::simd::{Each, Floats, Ints, LANES, Simd};
use crate::voxel::{APRON, Grid, HeightCode, PAGE_SIDE, PageId};
use hedgehop_base::error::Result;

/// Most pages that a block of lines may lie in, side by side; planes are never so far apart that a level
/// of their footprint needs more.
const MOST_PAGES: usize = 4;

/// Posts of a line that a register holds.
const NEAR: i64 = 2 * LANES as i64;

/// Bits of an index within a page.
const SIDE_BITS: u32 = PAGE_SIDE.trailing_zeros();

/// Code of what is no surface: below any.
pub const NO_CODE: f32 = -1.0e34;

/// Posts of a level that planes look at.
#[derive(Debug, Clone, Copy)]
pub struct LinePosts {
    /// The first and the last one; they may lie outside the area.
    pub ends: [i64; 2],
    /// The farthest that the next group of planes looks at, beside them.
    pub next: i64,
}

/// Height codes of a page's lines with apron, and how many one line has.
type LinePart<'a> = (Codes<'a>, i32);

/// Posts that the next group of planes looks at.
struct Beside<'a> {
    /// Their page: one of the lines' own, or another.
    part: Option<usize>,
    page: Option<LinePart<'a>>,
    /// The farthest of them, counted from the page's first.
    post: i32,
}

/// Pages of one level side by side along the minor axis: the lines of one block.
pub struct Lines<'a> {
    row: PageRow,
    parts: [LinePart<'a>; MOST_PAGES],
    count: usize,
    /// First of [`NEAR`] posts that hold all that are asked for; `None` if they do not.
    near: Option<i32>,
    /// Where the next group of planes looks; `None`: not known.
    next: Option<Beside<'a>>,
    /// Index of the first line of those that are here, and of the first page's first post.
    pub first: [i64; 2],
    /// Number of lines here, without aprons.
    held: i64,
    /// Whether all posts that are asked for lie in the area.
    is_inside: bool,
    /// The area's first and last post, counted from there: beside it the surface goes on level.
    limits: [f32; 2],
}

/// Registers of a block's lines: each holds all posts of a line that are asked for.
#[derive(Clone, Copy)]
pub struct NearRows<'l> {
    /// Post with which they begin, counted from the lines' first.
    pub first: i32,
    codes: &'l [u16],
    row: usize,
}

impl<'l> NearRows<'l> {
    /// Returns the register's posts of a line, which is counted from the first; `None` if the line is not there.
    #[inline(always)]
    pub fn row(&self, line: i32) -> Option<&'l [u16; 2 * LANES]> {
        let apron = APRON as i32;
        let start = (line + apron) as usize * self.row + (self.first + apron) as usize;
        self.codes.get(start..)?.first_chunk()
    }
}

/// Pages side by side along the minor axis, or strips of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct PageRow {
    level: u8,
    /// Index of the pages along the major axis, and number of the strip.
    along: i64,
    strip: u32,
    /// Indices of the first page and the last one across.
    across: [i64; 2],
}

impl PageRow {
    /// Finds the row of pages that holds line `line` of `level` along axis `major`, and `posts`, beside the area the outermost one; and how many lines it has.
    #[inline(always)]
    fn new(grid: &Grid, level: u8, major: usize, line: i64, posts: &LinePosts) -> (Self, i64) {
        let dims = grid.page_dims(level);
        let dims = [i64::from(dims.0), i64::from(dims.1)];
        let across = posts.ends.each(|post| (post >> SIDE_BITS).clamp(0, dims[1 - major] - 1));
        let along = (line >> SIDE_BITS).clamp(0, dims[major] - 1);
        let side = i64::from(PAGE_SIDE);
        let (held, strip) = together(major, (line - along * side).clamp(0, side - 1) as u32);
        (Self { level, along, strip, across }, i64::from(held))
    }

    fn page(&self, major: usize, across: i64) -> PageId {
        let (along, across) = (self.along as u32, across as u32);
        let (px, py) = if major == 0 { (along, across) } else { (across, along) };
        PageId { level: self.level, px, py }
    }
}

impl<'a> Lines<'a> {
    /// Finds the pages of `level` that hold line `line` along axis `major`, and `posts`; `latest` are lines that were found before. `None`: one of the pages is
    /// absent, or they are too many.
    pub fn find(
        pages: &mut Pages<'a>,
        latest: Option<Self>,
        level: u8,
        major: usize,
        line: i64,
        posts: LinePosts,
    ) -> Result<Option<Self>> {
        let grid = pages.source().header().grid;
        let (row, held) = PageRow::new(&grid, level, major, line, &posts);
        let mut lines = match latest {
            Some(latest) if latest.row == row => latest,
            _ => match Self::of(pages, row, major, held)? {
                Some(lines) => lines,
                None => return Ok(None),
            },
        };
        lines.look(pages, major, posts);
        Ok(Some(lines))
    }

    /// Lines of some pages; `None`: one of them is absent, or they are too many.
    fn of(pages: &mut Pages<'a>, row: PageRow, major: usize, held: i64) -> Result<Option<Self>> {
        let side = i64::from(PAGE_SIDE);
        let [first, last] = row.across;
        let count = (last - first + 1) as usize;
        if count > MOST_PAGES {
            return Ok(None);
        }

        let dims = pages.source().header().grid.dims(row.level);
        let posts_across = i64::from([dims.0, dims.1][1 - major]);
        let mut lines = Self {
            row,
            parts: [const { (Codes::Rows(&[]), 0) }; MOST_PAGES],
            count,
            near: None,
            next: None,
            first: [row.along * side + held * i64::from(row.strip), first * side],
            held,
            is_inside: false,
            limits: [-(first * side) as f32, (posts_across - 1 - first * side) as f32],
        };
        for part in 0..count {
            let Some(codes) = pages.codes(row.page(major, first + part as i64), major, row.strip)? else {
                return Ok(None);
            };
            lines.parts[part] = codes;
        }
        Ok(Some(lines))
    }

    /// Looks at some posts of these lines.
    #[inline(always)]
    fn look(&mut self, pages: &mut Pages<'a>, major: usize, posts: LinePosts) {
        let [first, last] = self.row.across;
        let start = self.first[1];
        let ends = posts.ends.each(|post| post - start);
        self.near = self.near(ends);
        self.is_inside = ends[0] as f32 > self.limits[0] && (ends[1] as f32) < self.limits[1];

        let beside = posts.next >> SIDE_BITS;
        let post = (posts.next - (beside << SIDE_BITS)) as i32;
        self.next = if (first..=last).contains(&beside) {
            Some(Beside { part: Some((beside - first) as usize), page: None, post })
        } else {
            // It may be of no group's business: nothing is read for it.
            let page = self.row.page(major, beside.max(0));
            pages.known_codes(page, major, self.row.strip).map(|page| Beside {
                part: None,
                page: Some(page),
                post,
            })
        };
    }

    /// Returns the first of [`NEAR`] posts of one page that hold `posts`, first and last, and one more on either side for rounding.
    fn near(&self, [first, last]: [i64; 2]) -> Option<i32> {
        let (low, high) = (-i64::from(APRON), i64::from(self.parts[0].1) - i64::from(APRON) - NEAR);
        let holds = self.count == 1 && low <= high && last - first + 2 < NEAR;
        holds.then(|| (first - 1).clamp(low, high) as i32)
    }

    /// The registers that hold all posts of each line, where there are such and all of them lie in the area.
    #[inline(always)]
    pub fn near_rows(&self) -> Option<NearRows<'_>> {
        let first = self.near.filter(|_| self.is_inside)?;
        let (codes, row) = &self.parts[0];
        Some(NearRows { first, codes: codes.all(), row: *row as usize })
    }

    /// Has the processor fetch what the next group of planes will look at of a line, which is soon.
    #[inline(always)]
    pub fn prefetch<V: Simd>(&self, simd: V, line: i32) {
        let Some(Beside { part, page, post }) = &self.next else { return };
        if let Some((codes, row)) = page.as_ref().or_else(|| self.parts.get((*part)?)) {
            simd.prefetch(codes.all(), ((line + APRON as i32) * row + post) as usize);
        }
    }

    /// Whether these pages hold a line, in an apron or themselves.
    #[inline(always)]
    pub fn have(&self, line: i64) -> bool {
        (-i64::from(APRON)..self.held).contains(&(line - self.first[0]))
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
        let apron = APRON as i32;
        let (codes, row) = &self.parts[0];
        if let Some(near) = self.near
            && let Some(codes) = codes.all().get(((line + apron) * row + near + apron) as usize..)
            && let Some(codes) = codes.first_chunk()
        {
            return code(simd, simd.permute_pairs(codes, cell - simd.splat_int(near)), share);
        }
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
        code(simd, pair, share)
    }
}

/// Between two codes.
#[inline(always)]
fn code<V: Simd>(simd: V, pair: V::I, share: V::F) -> V::F {
    let (low, high) = (pair & simd.splat_int(0xffff), pair.shr::<16>());
    let (low, high) = (low.to_float(), high.to_float());
    let code = (high - low).mul_add(share, low);
    // Surfaces have codes from 1 on.
    let nothing = low.min(high).lt(simd.splat(f32::from(HeightCode::EMPTY) + 0.5));
    simd.splat(NO_CODE).select(nothing, code)
}
