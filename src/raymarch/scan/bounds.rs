//! The highest surface in a block, from the voxels' upper bounds.

use super::Pages;
use crate::simd::Each;
use crate::voxel::{PAGE_SIDE, PageId, RADIX};
use hedgehop_base::error::Result;

/// Returns the greatest upper-bound code of `level`'s voxels at `major` along axis `axis` and `minor` across it
/// (first and last, within the area); where a page is absent, of the coarser voxels there, and `u16::MAX` if there are none.
/// 0: there is no surface. Voxels of level 0 have no bounds.
///
/// # Errors
/// A page that is damaged.
pub fn highest_code(
    pages: &mut Pages<'_>,
    level: u8,
    axis: usize,
    major: [u32; 2],
    minor: [u32; 2],
) -> Result<u16> {
    let mut highest = 0;
    let mut along = major[0];
    while along <= major[1] {
        let end = major[1].min((along / PAGE_SIDE + 1) * PAGE_SIDE - 1);
        let mut across = minor[0];
        while across <= minor[1] {
            let last = minor[1].min((across / PAGE_SIDE + 1) * PAGE_SIDE - 1);
            let code = highest_on_page(pages, level, axis, [along, end], [across, last])?;
            highest = highest.max(code);
            across = last + 1;
        }
        along = end + 1;
    }

    Ok(highest)
}

/// Returns the greatest upper-bound code of voxels that lie on one page; else as [`highest_code`].
fn highest_on_page(
    pages: &mut Pages<'_>,
    level: u8,
    axis: usize,
    major: [u32; 2],
    minor: [u32; 2],
) -> Result<u16> {
    let page = [major[0], minor[0]].each(|index| index / PAGE_SIDE);
    let (px, py) = if axis == 0 { (page[0], page[1]) } else { (page[1], page[0]) };

    let Some(view) = pages.bounds(PageId { level, px, py })? else {
        let coarser = level + 1;
        if coarser >= pages.source().header().level_count {
            return Ok(u16::MAX);
        }
        let [major, minor] = [major, minor].each(|ends| ends.each(|index| index / RADIX));
        return highest_code(pages, coarser, axis, major, minor);
    };

    let row = view.width as usize;
    let [[x, end], [y, top]] = if axis == 0 { [major, minor] } else { [minor, major] };
    let [x, end, y, top] = [x, end, y, top].each(|index| (index % PAGE_SIDE) as usize);
    let codes = (y..=top).flat_map(|y| &view.high[y * row..][x..=end]);
    Ok(codes.fold(0, |highest, &code| highest.max(code)))
}
