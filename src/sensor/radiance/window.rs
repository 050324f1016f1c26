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

use super::facing::Slopes;
use super::posts::{Posts, Rows, VOID};

/// Posts around the page: the apron of images of lines, a texel of four posts.
pub const RING: usize = 4;

/// Posts around it that are lit: those of the ring, and what voids in it take their light from.
pub const LIT: usize = RING + 1;

/// Posts of a part of a page and [`LIT`] around it, and what they send.
pub struct Window {
    /// Red, green and blue, `[north][east]`.
    planes: [Vec<f32>; 3],
    /// How they slope.
    slopes: Vec<Slopes>,
    stride: usize,
    rows: usize,
}

/// Posts around the ring.
const BESIDE: usize = LIT - RING;

impl Window {
    /// Lights a part, and what its voids take their light from.
    #[inline(always)]
    pub fn around(posts: &Posts<'_>) -> Self {
        let [stride, rows] = [0, 1].map(|axis: usize| posts.part[axis].len());
        let planes = [(); 3].map(|()| vec![0.0; stride * rows]);
        let mut window = Self { planes, slopes: vec![Slopes::default(); stride * rows], stride, rows };
        let [columns, lit] = [0, 1].map(|axis: usize| {
            let (lit, first) = (&posts.lit[axis], posts.part[axis].start);
            lit.start - first..lit.end - first
        });
        for y in lit.clone() {
            let range = y * stride + columns.start..y * stride + columns.end;
            let [red, green, blue] = &mut window.planes;
            let light = [&mut red[range.clone()], &mut green[range.clone()], &mut blue[range.clone()]];
            posts.row(y + posts.part[1].start, Rows { light, slopes: &mut window.slopes[range] });
        }
        window.repeat([columns, lit]);
        window.cover_voids();
        window
    }

    /// Has posts beside those that are lit send what the nearest do.
    fn repeat(&mut self, [columns, lit]: [Range<usize>; 2]) {
        let beside: Vec<_> = (0..self.stride).filter(|x| !columns.contains(x)).collect();
        for y in lit.clone() {
            for &x in &beside {
                let (from, to) =
                    (y * self.stride + x.clamp(columns.start, columns.end - 1), y * self.stride + x);
                self.planes.iter_mut().for_each(|plane| plane[to] = plane[from]);
                self.slopes[to] = self.slopes[from];
            }
        }
        for y in (0..self.rows).filter(|y| !lit.contains(y)) {
            let nearest = y.clamp(lit.start, lit.end - 1) * self.stride;
            let nearest = nearest..nearest + self.stride;
            self.planes.iter_mut().for_each(|plane| plane.copy_within(nearest.clone(), y * self.stride));
            self.slopes.copy_within(nearest, y * self.stride);
        }
    }

    /// Posts of the part and [`RING`] around it, eastward and northward.
    pub fn size(&self) -> [usize; 2] {
        [self.stride - 2 * BESIDE, self.rows - 2 * BESIDE]
    }

    /// Red, green and blue of a row of them, and how they slope.
    #[inline(always)]
    pub fn row(&self, y: usize) -> ([&[f32]; 3], &[Slopes]) {
        let start = (y + BESIDE) * self.stride + BESIDE;
        let row = start..start + self.stride - 2 * BESIDE;
        ([0, 1, 2].map(|channel: usize| &self.planes[channel][row.clone()]), &self.slopes[row])
    }

    /// Gives posts without a surface the mean of what those beside them send, or black: at the rim of a void, pixels and texels
    /// look a little beyond the last post.
    fn cover_voids(&mut self) {
        let voids: Vec<_> = (0..self.planes[0].len()).filter(|&post| self.planes[0][post] == VOID).collect();
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
