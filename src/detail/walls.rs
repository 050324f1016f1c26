//! Walls of rock: steep ground, which imagery from above hardly sees.
//!
//! ```text
//! slope                   → share of wall                  none below 56°, all from 72° on
//! facing                  → whether detail lies over (y, z) or over (x, z)
//! luminance               → mean of what is as steep, three posts about      a wall has no curtains
//! relative deviation d    → d · √(1 − share) over the ground, d · √share over the wall
//! ```
//!
//! One voxel of imagery stands for all of a wall's height above it. What differs from voxel to voxel would hang down the wall in stripes.

use super::amplitude::most_deviation;
use super::field::{FieldArea, PostField, load, put};
use crate::simd::{Floats, LANES, Mask, Simd};

/// Posts on either side of one that its colour on a wall is the mean of.
const CALM_REACH: usize = 3;

/// Posts on either side of one that its share of wall depends on.
const SLOPE_REACH: usize = 1;

/// Posts on either side of one that its wall depends on.
pub const WALL_REACH: usize = CALM_REACH + SLOPE_REACH;

/// Squares of the slope from which ground is a wall in part, and wholly.
pub const STEEP: [f32; 2] = [2.25, 9.0];

/// Cells of the tile over a wall per cell over the ground: imagery tells nothing of a wall from one voxel's width to several.
pub const WALL_SCALE: f64 = 1.0 / 3.0;

/// Least square of the share of a view's way over the ground that is taken to go straight at a wall.
pub const LEAST_TOWARD: f32 = 0.02;

/// Least relative deviation of light on walls, before materials have their share and where white leaves room: rock is rough, whatever its colour from above.
const LEAST_OF_WALLS: f32 = 0.15;

/// Steepness of posts, and what follows from it; memory that is used again and again.
#[derive(Debug, Default)]
pub struct Walls {
    /// Heights in sides of a voxel; [`VOID_POST`](super::field::VOID_POST) of voids.
    pub heights: PostField,
    /// Shares of wall, 0…1, as heights.
    shares: PostField,
    /// Mean luminance of what is as steep, of an area's posts in rows of whole lanes.
    calm: Vec<f32>,
    /// Sums along rows: luminance times share, and share.
    sums: [Vec<f32>; 2],
    /// Relative deviations over walls, of an area's posts in rows of whole lanes: above 0 over (y, z), below over (x, z).
    pub deviations: Vec<f32>,
    /// Whether some post is a wall.
    pub is_any: bool,
}

impl Walls {
    /// Finds shares of wall of an area's posts and those around it that colours are taken from.
    #[inline(always)]
    pub fn find<V: Simd>(&mut self, simd: V, area: FieldArea) {
        let Self { heights, shares, .. } = self;
        let FieldArea { first, size: [width, height] } = area;
        let stride = heights.stride;
        shares.stride = stride;
        shares.values.resize(heights.values.len(), 0.0);

        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let mut steepest = zero;
        let origin = first - CALM_REACH * (stride + 1);
        for row in 0..height + 2 * CALM_REACH {
            for column in (0..width + 2 * CALM_REACH).step_by(LANES) {
                let at = origin + row * stride + column;
                let [east, north] = slopes(simd, heights, at);
                let share = (east * east + north * north - simd.splat(STEEP[0]))
                    * simd.splat(1.0 / (STEEP[1] - STEEP[0]));
                let share = share.max(zero).min(one).select(zero.le(load(simd, &heights.values, at)), zero);
                steepest = steepest.max(share);
                put(share, &mut shares.values, at);
            }
        }
        self.is_any = zero.lt(steepest).any();
    }

    /// Averages the luminance of an area's walls.
    #[inline(always)]
    pub fn average<V: Simd>(&mut self, simd: V, luminance: &PostField, area: FieldArea) {
        let Self { shares, calm, sums, .. } = self;
        let FieldArea { first, size: [width, height] } = area;
        let (stride, padded) = (shares.stride, width.next_multiple_of(LANES));
        let (zero, least) = (simd.splat(0.0), simd.splat(f32::MIN_POSITIVE));

        // Along rows, of all rows that columns reach.
        let rows = height + 2 * CALM_REACH;
        sums.iter_mut().for_each(|sums| sums.resize((rows + 1) * padded, 0.0));
        for row in 0..rows {
            for column in (0..padded).step_by(LANES) {
                let own = first + row * stride - CALM_REACH * stride + column;
                let (mut light, mut weight) = (zero, zero);
                for at in own - CALM_REACH..=own + CALM_REACH {
                    let share = load(simd, &shares.values, at);
                    light = light + load(simd, &luminance.values, at).max(zero) * share;
                    weight = weight + share;
                }
                put(light, &mut sums[0], row * padded + column);
                put(weight, &mut sums[1], row * padded + column);
            }
        }

        // Along columns of these.
        calm.resize((height + 1) * padded, 0.0);
        for row in 0..height {
            for column in (0..padded).step_by(LANES) {
                let (mut light, mut weight) = (zero, zero);
                for row in row..=row + 2 * CALM_REACH {
                    light = light + load(simd, &sums[0], row * padded + column);
                    weight = weight + load(simd, &sums[1], row * padded + column);
                }
                put(light / weight.max(least), calm, row * padded + column);
            }
        }
    }

    /// Takes the averages as the luminance of an area's posts, by their shares of wall.
    #[inline(always)]
    pub fn calm<V: Simd>(&self, simd: V, luminance: &mut PostField, area: FieldArea) {
        let FieldArea { first, size: [width, height] } = area;
        let (stride, padded) = (self.shares.stride, width.next_multiple_of(LANES));
        for row in 0..height {
            for column in (0..width).step_by(LANES) {
                let at = first + row * stride + column;
                let own = load(simd, &luminance.values, at);
                let calm = load(simd, &self.calm, row * padded + column);
                let light = (calm - own) * load(simd, &self.shares.values, at) + own;
                // Lanes behind the area are as they were.
                let lanes = simd.mask(u16::MAX >> (LANES - (width - column).min(LANES)));
                if let Some(target) = luminance.values.get_mut(at..).and_then(|rest| rest.first_chunk_mut()) {
                    light.store_masked(lanes, target);
                }
            }
        }
    }

    /// Takes that part of an area's relative deviations that lies over walls out of `deviations`, which are in rows of whole lanes, of posts of such `roots` of
    /// light.
    #[inline(always)]
    pub fn split<V: Simd>(&mut self, simd: V, deviations: &mut [f32], roots: &PostField, area: FieldArea) {
        let Self { heights, shares, deviations: walls, .. } = self;
        let FieldArea { first, size: [width, height] } = area;
        let padded = width.next_multiple_of(LANES);
        walls.resize((height + 1) * padded, 0.0);
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        for row in 0..height {
            for column in (0..padded).step_by(LANES) {
                let (at, own) = (first + row * heights.stride + column, row * padded + column);
                let share = load(simd, &shares.values, at);
                let deviation = load(simd, deviations, own);
                let [east, north] = slopes(simd, heights, at);
                let least =
                    simd.splat(LEAST_OF_WALLS).min(most_deviation(simd, load(simd, &roots.values, at)));
                let wall = deviation.max(least) * share.sqrt();
                let faces_east = (north * north).le(east * east);
                put(wall.select(faces_east, zero - wall), walls, own);
                put(deviation * (one - share).sqrt(), deviations, own);
            }
        }
    }
}

/// Slopes eastward and northward of sixteen posts from an index on: half the difference of their neighbours. What is void counts as high as the post.
#[inline(always)]
fn slopes<V: Simd>(simd: V, heights: &PostField, at: usize) -> [V::F; 2] {
    let (zero, half) = (simd.splat(0.0), simd.splat(0.5));
    let own = load(simd, &heights.values, at);
    let mut slopes = [zero; 2];
    for (slope, step) in slopes.iter_mut().zip([1, heights.stride]) {
        let (before, behind) =
            (load(simd, &heights.values, at - step), load(simd, &heights.values, at + step));
        *slope = (behind.select(zero.le(behind), own) - before.select(zero.le(before), own)) * half;
    }
    slopes
}
