//! Slopes of few heights.
//!
//! ```text
//! of the 64 × 64 voxels of a block, without those of its most frequent height (a lake is no terrace):
//!     at least a quarter is left
//!     they have at least 4 heights, but less than a sixteenth as many as voxels
//!     more than half of them have the height of the voxels to the east and to the north
//! a terrace, as high as the median of the gaps between these heights, if that is more than 4 steps of the database's own heights
//! ```

use std::collections::BTreeMap;

use crate::continuity::found::{Found, Patch};
use crate::continuity::{Fault, Finding};
use hedgehop::voxel::HeightCode;

/// Voxels along the side of a block.
const BLOCK: i64 = 64;
/// Share of voxels that do not have the most frequent height, at least: one of so many.
const LEFT: usize = 4;
/// Heights, at least, and voxels for each of them.
const LEAST_HEIGHTS: usize = 4;
const VOXELS_OF_HEIGHT: usize = 16;
/// Steps of the database's heights, at least.
const LEAST_STEPS: u16 = 4;

pub(super) fn find(patch: &Patch, found: &mut Found) {
    let blocks = |axis: usize| (0..patch.size[axis]).step_by(BLOCK as usize);
    for (x, y) in blocks(1).flat_map(|y| blocks(0).map(move |x| (x, y))) {
        block(patch, x, y, found);
    }
}

fn block(patch: &Patch, x: i64, y: i64, found: &mut Found) {
    let ends = [(x + BLOCK).min(patch.size[0]), (y + BLOCK).min(patch.size[1])];
    let voxels = || (y..ends[1]).flat_map(|y| (x..ends[0]).map(move |x| (x, y)));

    // Voxels of each height, and those that are level with their neighbours.
    let mut heights: BTreeMap<u16, [usize; 2]> = BTreeMap::new();
    for (x, y) in voxels() {
        let code = patch.code_at(x, y);
        if code != HeightCode::EMPTY {
            let is_level = patch.code_at(x + 1, y) == code && patch.code_at(x, y + 1) == code;
            let known = heights.entry(code).or_default();
            known[0] += 1;
            known[1] += usize::from(is_level);
        }
    }

    let Some((frequent, _)) = heights.iter().max_by_key(|(_, [count, _])| *count) else { return };
    let others = || heights.iter().filter(|(code, _)| *code != frequent).map(|(_, counts)| *counts);
    let (count, level) = others().fold((0, 0), |(count, level), [own, flat]| (count + own, level + flat));
    let all = (ends[0] - x) as usize * (ends[1] - y) as usize;
    if count * LEFT < all
        || heights.len() < LEAST_HEIGHTS
        || heights.len() * VOXELS_OF_HEIGHT >= count
        || 2 * level <= count
    {
        return;
    }

    let codes: Vec<u16> = heights.keys().copied().collect();
    let mut gaps: Vec<u16> = codes.windows(2).map(|pair| pair[1] - pair[0]).collect();
    gaps.sort_unstable();
    let gap = gaps[gaps.len() / 2];

    if gap > LEAST_STEPS {
        let middle = [(x + ends[0]) / 2, (y + ends[1]) / 2];
        let size = f64::from(gap) * patch.code.scale;
        found.add(Finding {
            extent: [patch.corner(x, y), patch.corner(ends[0], ends[1])],
            voxels: all as u64,
            ..patch.finding(Fault::Terrace, middle[0], middle[1], size)
        });
    }
}
