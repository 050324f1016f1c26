//! Radiance of some of a page's posts and of those around them.
//!
//! ```text
//! posts in the area:       colour × light on their slopes; of coarse levels on four slopes that stand for those under the voxel
//! posts beside the area:   as the nearest in it
//! posts without a surface: as the mean of those beside them that have one
//! ```
//!
//! The page's apron holds all that this needs, so that pages agree where they meet and no other page is touched.

use std::ops::Range;

use super::posts::{PostRows, Posts, VOID};
use crate::sensor::radiance::part::{LIT, RING};
use crate::simd::{Each, LANES, Simd};

/// Posts of a part of a page and [`LIT`] around it, and what they send.
#[derive(Debug, Default)]
pub struct Window {
    /// Red, green and blue, `[north][east]`, and some lanes behind them.
    planes: [Vec<f32>; 3],
    /// Weight of each post: how much of it is seen.
    weights: Vec<f32>,
    /// Share of each post's luminance that is the ground's, where there is snow.
    bare: Vec<f32>,
    has_snow: bool,
    stride: usize,
    rows: usize,
}

/// A row of posts, and all that lies in memory behind it.
#[derive(Clone, Copy)]
pub struct WindowRow<'w> {
    /// Red, green and blue.
    pub light: [&'w [f32]; 3],
    /// Weight of each post: how much of it is seen.
    pub weights: &'w [f32],
    /// Share of each post's luminance that is the ground's; empty: there is no snow.
    pub bare: &'w [f32],
}

/// Posts around the ring.
const BESIDE: usize = LIT - RING;

impl Window {
    /// Lights a part, and what its voids take their light from. What was lit before is forgotten.
    #[inline(always)]
    pub fn light<V: Simd>(&mut self, simd: V, posts: &Posts<'_>) {
        self.has_snow = posts.has_snow();
        [self.stride, self.rows] = [0, 1].each(|axis: usize| posts.part[axis].len());
        let (stride, length) = (self.stride, self.stride * self.rows + LANES);
        self.all().for_each(|plane| plane.resize(length, 0.0));
        let [columns, lit] = [0, 1].each(|axis: usize| {
            let (lit, first) = (&posts.lit[axis], posts.part[axis].start);
            lit.start - first..lit.end - first
        });
        let mut has_voids = false;
        for y in lit.clone() {
            let first = y * stride + columns.start;
            let light = self.planes.each_mut().each(|plane| &mut plane[first..]);
            let (weights, bare) = (&mut self.weights[first..], &mut self.bare[first..]);
            let target = PostRows { light, weights, bare };
            has_voids |= posts.row(simd, y + posts.part[1].start, target);
        }
        self.repeat([columns, lit]);
        if has_voids {
            self.cover_voids();
        }
    }

    /// Has posts beside those that are lit send what the nearest do.
    fn repeat(&mut self, [columns, lit]: [Range<usize>; 2]) {
        let beside: Vec<_> = (0..self.stride).filter(|x| !columns.contains(x)).collect();
        for y in lit.clone() {
            for &x in &beside {
                let (from, to) =
                    (y * self.stride + x.clamp(columns.start, columns.end - 1), y * self.stride + x);
                self.all().for_each(|plane| plane[to] = plane[from]);
            }
        }
        for y in (0..self.rows).filter(|y| !lit.contains(y)) {
            let nearest = y.clamp(lit.start, lit.end - 1) * self.stride;
            let nearest = nearest..nearest + self.stride;
            let to = y * self.stride;
            self.all().for_each(|plane| plane.copy_within(nearest.clone(), to));
        }
    }

    fn all(&mut self) -> impl Iterator<Item = &mut Vec<f32>> {
        self.planes.iter_mut().chain([&mut self.weights, &mut self.bare])
    }

    /// A row of the part and [`RING`] around it.
    #[inline(always)]
    pub fn row(&self, y: usize) -> WindowRow<'_> {
        let first = (y + BESIDE) * self.stride + BESIDE;
        WindowRow {
            light: self.planes.each_ref().each(|plane| &plane[first..]),
            weights: &self.weights[first..],
            bare: if self.has_snow { &self.bare[first..] } else { &[] },
        }
    }

    /// Gives posts without a surface the mean of what those beside them send, or black: at the rim of a void, pixels and texels
    /// look a little beyond the last post.
    fn cover_voids(&mut self) {
        let voids: Vec<_> =
            (0..self.stride * self.rows).filter(|&post| self.planes[0][post] == VOID).collect();
        let light: Vec<_> = voids.iter().map(|&post| self.mean_beside(post)).collect();
        for (post, light) in voids.into_iter().zip(light) {
            for (plane, light) in self.planes.iter_mut().zip(light) {
                plane[post] = light;
            }
        }
    }

    /// Mean of the posts beside a post that have a surface.
    fn mean_beside(&self, post: usize) -> [f32; 3] {
        let (x, y) = (post % self.stride, post / self.stride);
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for row in y.saturating_sub(1)..(y + 2).min(self.rows) {
            for column in x.saturating_sub(1)..(x + 2).min(self.stride) {
                let beside = row * self.stride + column;
                if self.planes[0][beside] != VOID {
                    count += 1.0;
                    for (sum, plane) in sum.iter_mut().zip(&self.planes) {
                        *sum += plane[beside];
                    }
                }
            }
        }
        sum.map(|sum: f32| sum / f32::max(count, 1.0))
    }
}
