//! The order in which planes meet the spans of a voxel.

use crate::simd::{Floats, Mask, Simd};
use crate::voxel::Span;

/// Span of a voxel, with planes that are still to meet it.
#[derive(Clone, Copy)]
pub(super) struct MetSpan<'s, V: Simd> {
    pub span: &'s Span,
    pub planes: V::M,
    /// Shares of the planes' ways through the voxel between which they are within its walls.
    pub shares: [V::F; 2],
}

/// Finds the span that planes are to meet next, and these planes; `None`: none is left.
///
/// Each plane meets what begins nearest, and of spans that begin together the first one. Where a trunk stands in the halves of its crown, that is
/// another one from plane to plane.
#[inline(always)]
pub(super) fn next_of<V: Simd>(simd: V, met: &[Option<MetSpan<'_, V>>]) -> Option<(usize, V::M)> {
    if let [Some(span)] = met {
        return span.planes.any().then_some((0, span.planes));
    }

    let mut nearest = simd.splat(f32::INFINITY);
    for span in met.iter().flatten() {
        let is_nearer = span.planes & span.shares[0].lt(nearest);
        nearest = span.shares[0].select(is_nearer, nearest);
    }

    let (mut next, mut others) = (None, simd.mask(u16::MAX));
    for (index, span) in met.iter().enumerate() {
        let Some(span) = span else { continue };
        let planes = span.planes & span.shares[0].le(nearest) & others;
        others = others & !planes;
        // Best is a span that all of its planes are to meet now.
        if planes.any() {
            if !(span.planes & !planes).any() {
                return Some((index, planes));
            }
            next = next.or(Some((index, planes)));
        }
    }

    next
}
