//! Posts where no point of the ground is: under roofs, crowns and bridges, in shadows of the sensor, over water.
//!
//! ```text
//! in sixteen directions: the nearest post, at most so many voxels away
//! a voxel that holds points of something, or has posts on nearly all sides: h = Σ hₖ/dₖ² / Σ 1/dₖ²
//! others, beyond the rim of the cloud and amid wide gaps: no post
//! ```
//! As GDAL's fillnodata does it, in eight directions.

use super::posts::{Mix, Post};
use super::store::{CloudTile, Store, TILE};
use hedgehop_base::error::Result;

/// Distance to which posts are sought: metres, and voxels at least and at most.
const REACH_M: f64 = 60.0;
const REACH: (f64, f64) = (12.0, 128.0);
/// Directions in which posts must be found around a voxel without points: more than a straight rim has.
const ENCLOSED: usize = 11;

/// Sixteen directions, as steps eastward and northward; lengths differ.
const DIRECTIONS: [[i64; 2]; 16] = [
    [1, 0],
    [2, 1],
    [1, 1],
    [1, 2],
    [0, 1],
    [-1, 2],
    [-1, 1],
    [-2, 1],
    [-1, 0],
    [-2, -1],
    [-1, -1],
    [-1, -2],
    [0, -1],
    [1, -2],
    [1, -1],
    [2, -1],
];

/// Returns the distance to which posts are sought, voxels of this side (metres).
pub(super) fn reach(spacing: f64) -> i64 {
    (REACH_M / spacing).ceil().clamp(REACH.0, REACH.1) as i64
}

/// Posts of a tile and so many voxels around it.
#[derive(Debug)]
pub(super) struct PostField {
    side: i64,
    halo: i64,
    posts: Vec<Post>,
}

impl PostField {
    /// Reads a store that has all posts of a tile in one run, or none.
    pub fn of(store: &Store<Post>, tile: CloudTile, halo: i64) -> Result<Self> {
        let side = TILE + 2 * halo;
        let mut posts = vec![Post::NONE; (side * side) as usize];
        let rings = (halo + TILE - 1) / TILE;
        for (east, north) in
            (-rings..=rings).flat_map(|north| (-rings..=rings).map(move |east| (east, north)))
        {
            let (x, y) = (east * TILE + halo, north * TILE + halo);
            let mut next = 0_i64;
            store.read((tile.0 + east, tile.1 + north), |found| {
                for post in found {
                    let (column, row) = (x + next % TILE, y + next / TILE);
                    if (0..side).contains(&column) && (0..side).contains(&row) {
                        posts[(row * side + column) as usize] = *post;
                    }
                    next += 1;
                }
            })?;
        }

        Ok(Self { side, halo, posts })
    }

    /// The post of a voxel, counted from the tile's south-west one.
    pub fn at(&self, column: i64, row: i64) -> Post {
        self.posts[((row + self.halo) * self.side + column + self.halo) as usize]
    }

    /// All of them, row by row from the south.
    pub fn posts(&self) -> impl Iterator<Item = &Post> {
        self.posts.iter()
    }

    /// The posts of the tile, gaps filled from as far as the field goes.
    pub fn filled(&self) -> Vec<Post> {
        let voxels = (0..TILE).flat_map(|row| (0..TILE).map(move |column| (column, row)));
        voxels.map(|(column, row)| self.fill(column, row)).collect()
    }

    fn fill(&self, column: i64, row: i64) -> Post {
        let here = self.at(column, row);
        if here.is_known() {
            return here;
        }

        let (mut sum, mut weight, mut found, mut mix) = (0.0, 0.0, 0, Mix::default());
        for step in DIRECTIONS {
            let Some((post, distance)) = self.nearest([column, row], step) else { continue };
            let share = 1.0 / (distance * distance);
            sum += share * f64::from(post.height);
            weight += share;
            mix.add(post.srgb(), share);
            found += 1;
        }

        let is_held = here.flags & Post::HELD != 0;
        if found == 0 || (!is_held && found < ENCLOSED) {
            return here;
        }

        let colour = mix.srgb();
        let flags = here.flags | if colour.is_some() { Post::COLOURED } else { 0 };
        Post { height: (sum / weight) as f32, colour: colour.unwrap_or_default(), flags }
    }

    /// The nearest post in a direction, and how far it is, voxels.
    fn nearest(&self, from: [i64; 2], step: [i64; 2]) -> Option<(Post, f64)> {
        let length = (step[0] as f64).hypot(step[1] as f64);
        let steps = (self.halo as f64 / length) as i64;
        (1..=steps).find_map(|count| {
            let post = self.at(from[0] + count * step[0], from[1] + count * step[1]);
            post.is_known().then_some((post, length * count as f64))
        })
    }
}
