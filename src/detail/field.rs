//! Numbers of posts side by side.

use crate::simd::{Floats, LANES, Simd};

/// A number for each post of some rows, `[north][east]`, and some lanes behind them; below 0: the post is void.
#[derive(Debug, Default)]
pub struct PostField {
    pub values: Vec<f32>,
    /// Posts from one row to the next.
    pub stride: usize,
}

/// Posts of a field that have enough others around them.
#[derive(Debug, Clone, Copy)]
pub struct FieldArea {
    /// Index of the first.
    pub first: usize,
    /// Posts eastward and northward.
    pub size: [usize; 2],
}

/// Value of posts without a surface.
pub const VOID_POST: f32 = -1.0;

/// Lanes that are looked at behind the last post.
const BEHIND: usize = 2 * LANES;

impl PostField {
    /// Makes room for rows of posts.
    pub fn resize(&mut self, stride: usize, rows: usize) {
        self.stride = stride;
        self.values.resize(stride * rows + BEHIND, 0.0);
    }
}

/// Sixteen values from an index on.
#[inline(always)]
pub fn load<V: Simd>(simd: V, values: &[f32], at: usize) -> V::F {
    values.get(at..).and_then(|rest| rest.first_chunk()).map_or(simd.splat(0.0), |lanes| simd.load(lanes))
}

/// Puts sixteen values from an index on.
#[inline(always)]
pub fn put<F: Floats>(lanes: F, target: &mut [f32], at: usize) {
    if let Some(target) = target.get_mut(at..).and_then(|rest| rest.first_chunk_mut()) {
        lanes.store(target);
    }
}
