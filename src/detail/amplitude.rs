//! Amplitude of the octaves below the voxel, from the finest one that voxels hold.
//!
//! ```text
//! magnitude = |root of light − mean about it|                    what differs in material counts as the post itself
//! along rows:     the lesser of the means over three posts on either side
//! along columns:  the same of these
//! ```
//!
//! An edge, of paint, a shadow or a kerb, leaves the posts beside it calm on their other side; texture does not.

use super::field::{FieldArea, PostField, load, put};
use crate::simd::{Floats, LANES, Mask, Simd};
use crate::voxel::Material;

/// Posts on either side that the finest octave takes.
const OCTAVE_REACH: usize = 1;

/// Posts on either side of one whose magnitudes are averaged.
const SIDE_REACH: usize = 3;

/// Posts on either side of one that its amplitude depends on.
pub const AMPLITUDE_REACH: usize = OCTAVE_REACH + SIDE_REACH;

/// Relative deviation of light (standard deviation over mean) of all hidden octaves together per [`calmer_side`] of [`finest`] over the root of light.
///
/// The filter leaves 0.79 of an octave's energy, a voxel's mean holds 1/1.35 of it, the lesser sides of even noise have half of its standard deviation, four octaves have
/// twice the deviation of one, and light has twice that of its root: 10. Half more makes up for imagery whose contrast lies in few places, and for what fades, by views
/// over four pictures; others are judged.
pub const PER_MAGNITUDE: f32 = 15.5;

/// Greatest relative deviation of light: darker than black is nothing.
pub const MOST_DEVIATION: f32 = 0.6;

/// Standard deviations of light that reach white, and no further: what is nearly white cannot be much lighter in places.
const UP_TO_WHITE: f32 = 3.0;

/// Root of light below which relative deviations grow no more.
const DARK: f32 = 0.1;

/// Share of an octave's amplitude that a material has below the voxel: kerbs, cars, ridges and shores make the neighbourhood of what is smooth itself look rough.
pub fn material_factor(material: Material) -> f32 {
    match material {
        Material::Asphalt | Material::Concrete | Material::Metal | Material::Glass => 0.5,
        Material::RoofTiles | Material::RoofFelt | Material::Plaster => 0.5,
        Material::Snow | Material::Ice => 0.6,
        Material::Water => 0.4,
        _ => 1.0,
    }
}

/// Numbers of posts that amplitudes follow from.
#[derive(Debug, Default)]
pub struct AmplitudeFields {
    /// Roots of luminance.
    pub roots: PostField,
    /// Numbers of materials: what differs there is an edge, and tells nothing of what lies within.
    pub materials: PostField,
}

/// Memory for amplitudes of a part, used again and again.
#[derive(Debug, Default)]
pub struct AmplitudeScratch {
    magnitudes: Vec<f32>,
    along_rows: Vec<f32>,
}

impl AmplitudeScratch {
    /// Finds relative deviations of light below the voxel of the posts of an area, into `deviations`, `[north][east]`, in rows of [`padded`](Self::padded) posts.
    #[inline(always)]
    pub fn find<V: Simd>(
        &mut self,
        simd: V,
        fields: &AmplitudeFields,
        area: FieldArea,
        deviations: &mut Vec<f32>,
    ) {
        let Self { magnitudes, along_rows } = self;
        let AmplitudeFields { roots, materials } = fields;
        let FieldArea { first, size: [width, height] } = area;
        let (stride, padded, rows) = (roots.stride, Self::padded(width), height + 2 * SIDE_REACH);
        let wide = padded + LANES;
        let origin = first - SIDE_REACH * (stride + 1);

        // Magnitudes of all posts that sides reach.
        magnitudes.resize(rows * wide + LANES, 0.0);
        for row in 0..rows {
            for column in (0..wide).step_by(LANES) {
                let magnitude = finest(simd, fields, origin + row * stride + column);
                put(magnitude, magnitudes, row * wide + column);
            }
        }

        // Calmer sides along rows, then along columns.
        along_rows.resize(rows * padded, 0.0);
        for row in 0..rows {
            for column in (0..padded).step_by(LANES) {
                let beside = Along { at: row * wide + column, step: 1 };
                let kinds = Along { at: origin + row * stride + column, step: 1 };
                put(
                    calmer_side(simd, magnitudes, beside, materials, kinds),
                    along_rows,
                    row * padded + column,
                );
            }
        }

        deviations.resize((height + 1) * padded, 0.0);
        for row in 0..height {
            for column in (0..padded).step_by(LANES) {
                let beside = Along { at: row * padded + column, step: padded };
                let own = first + row * stride + column;
                let kinds = Along { at: own - SIDE_REACH * stride, step: stride };
                let magnitude = calmer_side(simd, along_rows, beside, materials, kinds);
                let root = load(simd, &roots.values, own);
                let deviation = simd.splat(PER_MAGNITUDE) * magnitude / root.max(simd.splat(DARK));
                put(deviation.min(most_deviation(simd, root)), deviations, row * padded + column);
            }
        }
    }

    /// Posts from one row of deviations to the next, where rows have so many posts.
    pub fn padded(width: usize) -> usize {
        width.next_multiple_of(LANES)
    }
}

/// Greatest relative deviations of posts of such roots of light.
#[inline(always)]
pub fn most_deviation<V: Simd>(simd: V, root: V::F) -> V::F {
    let (one, root) = (simd.splat(1.0), root.max(simd.splat(DARK)));
    let room = (one / (root * root) - one) * simd.splat(1.0 / UP_TO_WHITE);
    room.min(simd.splat(MOST_DEVIATION)).max(simd.splat(0.0))
}

/// Magnitude of the finest octave at sixteen posts: the root of light less the mean about it; 0 of voids. What is void, or of another material, counts as the post itself.
#[inline(always)]
fn finest<V: Simd>(simd: V, fields: &AmplitudeFields, at: usize) -> V::F {
    let AmplitudeFields { roots, materials } = fields;
    let (own, zero) = (load(simd, &roots.values, at), simd.splat(0.0));
    let kind = load(simd, &materials.values, at);
    let mut about = zero;
    for (row, weight) in [(at - roots.stride, 1.0), (at, 2.0), (at + roots.stride, 1.0)] {
        for (post, share) in [(row - 1, 1.0), (row, 2.0), (row + 1, 1.0)] {
            let beside = load(simd, &roots.values, post);
            let counts = zero.le(beside) & is_alike(load(simd, &materials.values, post), kind);
            about = about + beside.select(counts, own) * simd.splat(weight * share / 16.0);
        }
    }
    (own - about).abs().select(zero.le(own), zero)
}

/// Posts one after the other: the first of sixteen, and the way from each to the next.
#[derive(Clone, Copy)]
struct Along {
    at: usize,
    step: usize,
}

/// Lesser of the means over either side of sixteen posts, of those of their material: an edge lies to one side of what is beside it, roughness to both.
#[inline(always)]
fn calmer_side<V: Simd>(
    simd: V,
    magnitudes: &[f32],
    along: Along,
    materials: &PostField,
    kinds: Along,
) -> V::F {
    let kind = load(simd, &materials.values, kinds.at + SIDE_REACH * kinds.step);
    let own = load(simd, magnitudes, along.at + SIDE_REACH * along.step);
    let mut sides = [simd.splat(0.0); 2];
    for (side, sum) in sides.iter_mut().enumerate() {
        for post in (0..SIDE_REACH).map(|post| side * (SIDE_REACH + 1) + post) {
            let is_own = is_alike(load(simd, &materials.values, kinds.at + post * kinds.step), kind);
            *sum = *sum + load(simd, magnitudes, along.at + post * along.step).select(is_own, own);
        }
    }
    sides[0].min(sides[1]) * simd.splat(1.0 / SIDE_REACH as f32)
}

/// Whether numbers of materials are the same.
#[inline(always)]
fn is_alike<F: Floats<M = M>, M: Mask>(one: F, other: F) -> M {
    one.le(other) & other.le(one)
}
