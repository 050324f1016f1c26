//! The highest surface in a block, from the voxels' upper bounds.

use super::Pages;
use crate::error::Result;
use crate::voxel::{PAGE_SIDE, PageId};

/// Greatest upper-bound code of `level`'s voxels at `major` along axis `axis` and `minor` across it
/// (first and last, within the area); `u16::MAX` where a page is absent. 0: there is no surface.
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
        let page = [major, first].map(|index| index / PAGE_SIDE);
        let last = minor[1].min((page[1] + 1) * PAGE_SIDE - 1);
        let (px, py) = if axis == 0 { (page[0], page[1]) } else { (page[1], page[0]) };
        let Some(view) = pages.get(PageId { level, px, py })? else { return Ok(u16::MAX) };
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
