//! Posts whose interpolation keeps the means of voxels.
//!
//! Between posts light is linear, so that the mean over a voxel is ⅛ of the post before it, ¾ of its own and ⅛ of the one behind, along
//! either axis: a voxel of one colour among others loses a quarter to half of its contrast. The inverse of that filter gives it back
//! (Unser, Aldroubi and Eden 1993, *B-spline signal processing*, do so for splines): taps of √2·(√8 − 3)ⁿ, n posts away.

use std::f32::consts::SQRT_2;

use super::field::{FieldArea, PostField, load};
use crate::simd::{Floats, LANES, Simd};

/// Posts on either side of one that take part.
pub const KEEPING_REACH: usize = 3;

/// Weights of a post and of those up to [`KEEPING_REACH`] away; the last holds all that are farther, so that they add up to one.
const TAPS: [f32; KEEPING_REACH + 1] = [SQRT_2, -0.242_640_7, 0.041_630_56, -0.006_096_72];

/// Least share of its own light that a post keeps: light has no sign.
const LEAST_SHARE: f32 = 0.25;

/// Filters sixteen posts from index `at` on by those `step` apart from them. Where a neighbour is void it counts as the post itself.
#[inline(always)]
fn filtered<V: Simd>(simd: V, values: &[f32], at: usize, step: usize) -> V::F {
    let (own, zero) = (load(simd, values, at), simd.splat(0.0));
    let mut sum = own * simd.splat(TAPS[0]);
    for (distance, &tap) in TAPS.iter().enumerate().skip(1) {
        for beside in [at - distance * step, at + distance * step] {
            let beside = load(simd, values, beside);
            // Not in one step, which not all sets round once: posts are the same on every machine.
            sum = sum + beside.select(zero.le(beside), own) * simd.splat(tap);
        }
    }
    sum
}

/// Makes the values of an area such that interpolation keeps their means; `between` and `kept` are memory for it.
#[inline(always)]
pub fn keep_means<V: Simd>(
    simd: V,
    field: &mut PostField,
    area: FieldArea,
    between: &mut Vec<f32>,
    kept: &mut Vec<f32>,
) {
    let FieldArea { first, size: [width, height] } = area;
    let (stride, padded) = (field.stride, width.next_multiple_of(LANES));
    let rows = height + 2 * KEEPING_REACH;

    // Along rows, of all rows that columns reach.
    between.resize((rows + 1) * padded, 0.0);
    for row in 0..rows {
        let start = first + row * stride - KEEPING_REACH * stride;
        for column in (0..padded).step_by(LANES) {
            let along = filtered(simd, &field.values, start + column, 1);
            if let Some(target) = between[row * padded + column..].first_chunk_mut() {
                along.store(target);
            }
        }
    }

    // Along columns of these. Voids stay what they are.
    kept.resize((height + 1) * padded, 0.0);
    let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
    for row in 0..height {
        for column in (0..padded).step_by(LANES) {
            let own = load(simd, &field.values, first + row * stride + column);
            let light = filtered(simd, between, (row + KEEPING_REACH) * padded + column, padded);
            let light = light.max(own * simd.splat(LEAST_SHARE)).min(own.max(one));
            if let Some(target) = kept[row * padded + column..].first_chunk_mut() {
                light.select(zero.le(own), own).store(target);
            }
        }
    }

    for row in 0..height {
        let target = &mut field.values[first + row * stride..][..width];
        target.copy_from_slice(&kept[row * padded..][..width]);
    }
}
