//! Metric values of the spans' steps, and the faces of spans.

use crate::simd::{Floats, Simd};
use crate::voxel::{Grid, HeightCode, PageId, Span};

/// Least major distance of what is seen, units: tangents stay finite.
pub(super) const LEAST_DISTANCE: f64 = 1.0e-6;

/// Orientation of a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaceDirection {
    /// A wall that looks in a direction, 256ths of a turn counter-clockwise from east.
    Side(u8),
    /// An upper end of some slope, as [`Span::slope`].
    Top([i8; 2]),
    /// A lower end.
    Bottom,
}

/// Finds the light of faces.
pub trait FacetLight {
    /// Radiance of a face of a span in a voxel (x, y of the page of bare ground), linear Rec. 709.
    fn light(&mut self, page: PageId, voxel: [u32; 2], span: &Span, facet: FaceDirection) -> [f32; 3];
}

/// Metric values of the spans' steps.
#[derive(Debug, Clone)]
pub(super) struct Metric {
    /// log₂ of voxels along a cell, which is what is called a voxel.
    pub(super) shift: u8,
    pub(super) code: HeightCode,
    /// Voxels of level index 0.
    pub(super) grid: Grid,
    /// A step of height, and the side of a voxel, metres.
    pub(super) scale: f32,
    pub(super) spacing: f32,
    /// Unit vectors (east, north) of directions in 256ths of a turn.
    pub(super) directions: [[f32; 2]; 256],
    /// Logarithms (of 2) of the share of light that comes through a voxel's side, by opacity of spans.
    pub(super) clearness: [f32; Span::OPAQUE as usize + 1],
}

/// Scalar products of a vector and places, east and north.
#[inline(always)]
pub(super) fn dot<V: Simd>(simd: V, [east, north]: [f32; 2], at: [V::F; 2]) -> V::F {
    at[0].mul_add(simd.splat(east), at[1] * simd.splat(north))
}
