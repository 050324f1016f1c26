//! The highest surface in a block, from the voxels' upper bounds.

use std::ops::Range;

use super::Pages;
use crate::simd::Each;
use crate::voxel::{PAGE_SIDE, PageId, RADIX};
use hedgehop_base::error::Result;

/// The greatest of [`highest_code`] for some places along the axis.
pub fn highest_along(
    pages: &mut Pages<'_>,
    level: u8,
    axis: usize,
    major: Range<i64>,
    minor: [u32; 2],
) -> Result<u16> {
    major
        .map(|major| highest_code(pages, level, axis, major as u32, minor))
        .try_fold(0, |most, code| Ok(most.max(code?)))
}

/// Greatest upper-bound code of `level`'s voxels at `major` along axis `axis` and `minor` across it
/// (first and last, within the area); where a page is absent, of the coarser voxels there, and `u16::MAX` if there are none.
/// 0: there is no surface. Voxels of level 0 have no bounds.
pub fn highest_code(
    pages: &mut Pages<'_>,
    level: u8,
    axis: usize,
    major: u32,
    minor: [u32; 2],
) -> Result<u16> {
    let mut highest = 0;
    let mut first = minor[0];
    while first <= minor[1] {
        let page = [major, first].each(|index| index / PAGE_SIDE);
        let last = minor[1].min((page[1] + 1) * PAGE_SIDE - 1);
        let (px, py) = if axis == 0 { (page[0], page[1]) } else { (page[1], page[0]) };

        let Some(view) = pages.bounds(PageId { level, px, py })? else {
            let coarser = level + 1;
            if coarser >= pages.source().header().level_count {
                return Ok(u16::MAX);
            }
            let [from, to] = [first, last].each(|index| index / RADIX);
            highest = highest.max(highest_code(pages, coarser, axis, major / RADIX, [from, to])?);
            first = last + 1;
            continue;
        };

        let row = view.width as usize;
        let (along, across) = if axis == 0 { (1, row) } else { (row, 1) };
        let start = (major % PAGE_SIDE) as usize * along;
        for index in first % PAGE_SIDE..=last % PAGE_SIDE {
            highest = highest.max(view.high[start + index as usize * across]);
        }

        first = last + 1;
    }

    Ok(highest)
}
