//! Radiance of a page's posts and of some around it.
//!
//! ```text
//! posts in the area:       colour × light on their slopes; of coarse levels on four slopes that stand for those under the voxel
//! posts beside the area:   as the nearest in it
//! posts without a surface: as the mean of those beside them that have one
//! ```
//!
//! The page's apron holds all that this needs, so that pages agree where they meet and no other page is touched.

use super::facing::{Facing, Slopes};
use super::posts::{Lamp, Posts, Rows, VOID};
use crate::voxel::{Header, PageId, PageView};

/// Posts around the page: the apron of images of lines, a texel of four posts.
pub const RING: usize = 4;

/// Posts around it that are lit: those of the ring, and what voids in it take their light from.
pub const LIT: usize = RING + 1;

/// Posts of a page and of some around it, and what they send.
pub struct Window {
    /// Red, green and blue, `[north][east]`.
    pub planes: [Vec<f32>; 3],
    /// How they slope.
    pub slopes: Vec<Slopes>,
    /// Posts of a row.
    pub stride: usize,
    rows: usize,
}

impl Window {
    /// Page `id` and [`RING`] posts around it.
    #[inline(always)]
    pub fn around(lamp: &Lamp<'_>, header: &Header, id: PageId, view: PageView<'_>, facing: &Facing) -> Self {
        let [stride, rows] = [view.width, view.height].map(|side| side as usize + 2 * LIT);
        let posts = Posts::new(lamp, header, id, view, facing);
        let planes = [(); 3].map(|()| vec![0.0; stride * rows]);
        let mut window = Self { planes, slopes: vec![Slopes::default(); stride * rows], stride, rows };
        let [columns, inside] = posts.inside.clone();
        for y in inside.clone() {
            let range = y * stride + columns.start..y * stride + columns.end;
            let [red, green, blue] = &mut window.planes;
            let light = [&mut red[range.clone()], &mut green[range.clone()], &mut blue[range.clone()]];
            posts.row(y, Rows { light, slopes: &mut window.slopes[range] });
        }
        for y in 0..rows {
            let nearest = y.clamp(inside.start, inside.end - 1);
            for x in 0..stride {
                let from = nearest * stride + x.clamp(columns.start, columns.end - 1);
                window.repeat(from, y * stride + x);
            }
        }
        window.cover_voids();
        window.crop();
        window
    }

    fn repeat(&mut self, from: usize, to: usize) {
        if from != to {
            self.planes.iter_mut().for_each(|plane| plane[to] = plane[from]);
            self.slopes[to] = self.slopes[from];
        }
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

    /// Takes the outermost posts away.
    fn crop(&mut self) {
        let (width, stride) = (self.stride - 2, self.stride);
        let rows = 1..self.rows - 1;
        for plane in &mut self.planes {
            *plane = rows.clone().flat_map(|row| &plane[row * stride + 1..][..width]).copied().collect();
        }
        let slopes = rows.clone().flat_map(|row| &self.slopes[row * stride + 1..][..width]);
        self.slopes = slopes.copied().collect();
        (self.stride, self.rows) = (width, rows.len());
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
