//! Detail of posts for one ray after the other: blocks of posts that were looked at, kept.

use std::collections::HashMap;

use glam::Vec3;

use super::field::VOID_POST;
use super::measure::DetailMeasure;
use super::posts::{DETAIL_MARGIN, DETAIL_RING, DetailPosts, DetailSource};
use crate::voxel::{Header, PageId, PageView};

/// Posts along a side of a block.
const SIDE: u32 = 32;

/// Most blocks that are kept.
const MOST: usize = 64;

/// Light of a place between four posts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetailedColour {
    /// Reflectance, linear, with the means of voxels kept.
    pub albedo: Vec3,
    /// Relative deviation of light in all octaves below the voxel, 0…1.
    pub deviation: f32,
    /// Relative deviation over a wall, −1…1: above 0 over (y, z), below over (x, z).
    pub wall: f32,
}

/// Place among the posts of a page.
#[derive(Debug, Clone, Copy)]
pub struct PostCell {
    /// Column and row of the south-western post, counted from the page's first; −1 is the one before.
    pub post: [i64; 2],
    /// Share of the way to the next one, eastward and northward.
    pub share: [f32; 2],
}

/// Posts with detail about the places that were asked for last.
#[derive(Debug)]
pub struct DetailBlocks {
    measure: DetailMeasure,
    blocks: HashMap<(PageId, [u32; 2]), DetailPosts>,
}

impl DetailBlocks {
    /// None yet, of a database with such a header.
    pub fn new(header: &Header) -> Self {
        Self { measure: DetailMeasure::of(header), blocks: HashMap::new() }
    }

    /// Finds colour and amplitude at a place of a page, linear between posts.
    pub fn at(&mut self, id: PageId, view: &PageView<'_>, cell: PostCell) -> DetailedColour {
        let measure = &self.measure;
        let block = cell.post.map(|post| post.max(0) as u32 / SIDE);
        if self.blocks.len() >= MOST && !self.blocks.contains_key(&(id, block)) {
            self.blocks.clear();
        }
        let posts = self.blocks.entry((id, block)).or_insert_with(|| {
            let first = block.map(|index| index * SIDE);
            let size = [view.width - first[0], view.height - first[1]].map(|left| left.min(SIDE));
            let mut posts = DetailPosts::default();
            posts.look_best(DetailSource { view: *view, first, size, measure });
            posts
        });

        let south_west = [0, 1]
            .map(|axis| (cell.post[axis] - i64::from(block[axis] * SIDE) + DETAIL_RING as i64) as usize);
        corner_mean(posts, south_west, cell.share)
    }
}

/// Mean of four posts by their shares, the south-western of which is counted from the first of the ring. Posts without a surface do not count.
fn corner_mean(posts: &DetailPosts, south_west: [usize; 2], [east, north]: [f32; 2]) -> DetailedColour {
    let (mut albedo, mut deviation, mut wall, mut known) = (Vec3::ZERO, 0.0, 0.0, 0.0);
    for (row, rise) in [1.0 - north, north].into_iter().enumerate() {
        for (column, across) in [1.0 - east, east].into_iter().enumerate() {
            let at = [south_west[0] + column, south_west[1] + row];
            let share = rise * across;
            let colour = posts.colours(at.map(|post| post + DETAIL_MARGIN - DETAIL_RING));
            let colour = Vec3::from_array(colour.map(|plane| plane.first().copied().unwrap_or(VOID_POST)));
            if colour.x >= 0.0 {
                albedo += colour * share;
                known += share;
            }
            deviation += posts.deviations(at).first().copied().unwrap_or(0.0) * share;
            wall += posts.wall_deviations(at).first().copied().unwrap_or(0.0) * share;
        }
    }
    DetailedColour { albedo: albedo / f32::max(known, f32::MIN_POSITIVE), deviation, wall }
}
