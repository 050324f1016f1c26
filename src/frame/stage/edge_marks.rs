//! The surface on edges between rows: where it is there, and how its light deviates below the voxel.

use std::ops::Range;

use super::segment_light::{ChunkDetail, GROUND, PlaneLight, WALL};
use crate::sensor::radiance::Deviations;
use crate::simd::{Each, Floats, Simd, Sixteen};

/// Surface on an edge between rows.
#[derive(Debug, Clone, Copy, Default)]
pub struct EdgeMark {
    /// Relative deviations below the voxel, over the ground and over walls.
    pub ground: Sixteen,
    pub wall: Sixteen,
    /// Inverse depth, 1/metres.
    pub inverse: Sixteen,
}

/// Edges, from the lowest, and how many of them tell of detail.
pub struct EdgeMarks<'m> {
    marks: &'m mut [EdgeMark],
    detailed: usize,
    /// And of detail over walls.
    walled: usize,
}

/// Stretch of surface with detail that covers edges.
pub struct MarkedStretch<'s, V: Simd> {
    /// Tangents of the edges that it may cover, and their indices.
    pub edges: &'s [f32],
    pub span: Range<usize>,
    /// Planes in which it is in sight, the tangents up to which they are covered, and those of its farther end.
    pub rises: V::M,
    pub covered: V::F,
    pub high: V::F,
    /// 1 over the rise of the tangent.
    pub per_rise: V::F,
    /// Light and inverse depth of either end.
    pub lights: &'s [PlaneLight; 2],
    pub inverse: [&'s Sixteen; 2],
    pub detail: ChunkDetail,
}

/// Surface in a row, by what its edges tell.
pub struct RowMarks<V: Simd> {
    /// Inverse depth in its middle, 1/metres, and the change of it from edge to edge.
    pub inverse: V::F,
    pub change: V::F,
    pub deviations: Deviations<V>,
    /// Whether there may be deviations over walls.
    pub has_walls: bool,
}

impl<'m> EdgeMarks<'m> {
    /// None tells of detail yet, whatever is in the memory.
    pub fn new(marks: &'m mut [EdgeMark]) -> Self {
        Self { marks, detailed: 0, walled: 0 }
    }

    /// Tells edges that a stretch covers of it.
    #[inline(always)]
    pub fn mark<V: Simd>(&mut self, simd: V, stretch: &MarkedStretch<'_, V>) {
        let MarkedStretch { edges, span, rises, covered, high, per_rise, lights, inverse, detail } = stretch;
        let [near, far] = lights;
        let ends = [[&near[GROUND], &far[GROUND]], *inverse, [&near[WALL], &far[WALL]]];
        let mut lines = [(simd.splat(0.0), simd.splat(0.0)); 3];
        for (line, [near, far]) in lines.iter_mut().zip(ends) {
            let far = simd.load(&far.0);
            *line = (far, (far - simd.load(&near.0)) * *per_rise);
        }
        let [ground, inverse, wall] = lines;

        // Planes that go past edges elsewhere have no detail there.
        for mark in self.marks.get_mut(self.detailed..span.end).unwrap_or_default() {
            *mark = EdgeMark::default();
        }
        self.detailed = self.detailed.max(span.end);
        let has_walls = *detail == ChunkDetail::Walls;
        if has_walls {
            self.walled = self.walled.max(span.end);
        }

        let marks = self.marks.get_mut(span.clone()).unwrap_or_default();
        for (edge, mark) in edges.iter().zip(marks) {
            let edge = simd.splat(*edge);
            let (passed, down) = (*rises & edge.le(*high) & covered.lt(edge), edge - *high);
            ground.1.mul_add(down, ground.0).store_masked(passed, &mut mark.ground.0);
            inverse.1.mul_add(down, inverse.0).store_masked(passed, &mut mark.inverse.0);
            if has_walls {
                wall.1.mul_add(down, wall.0).store_masked(passed, &mut mark.wall.0);
            }
        }
    }

    /// Returns what both edges of a row tell; `None`: no detail.
    #[inline(always)]
    pub fn row<V: Simd>(&self, simd: V, row: usize) -> Option<RowMarks<V>> {
        if row + 1 >= self.detailed {
            return None;
        }
        let edges: &[EdgeMark; 2] = self.marks.get(row..)?.first_chunk()?;
        let edges = edges.each_ref();
        let [near, far] = edges.each(|edge| simd.load(&edge.inverse.0));

        // None where one of them lies on what has none.
        let mut deviations = Deviations::none(simd);
        let [lower, upper] = edges.each(|edge| simd.load(&edge.ground.0));
        deviations.ground = lower.min(upper);
        let has_walls = row + 1 < self.walled;
        if has_walls {
            let [lower, upper] = edges.each(|edge| simd.load(&edge.wall.0));
            let none = simd.splat(0.0);
            deviations.wall = lower.max(none).min(upper.max(none)) + lower.min(none).max(upper.min(none));
        }

        Some(RowMarks { inverse: (near + far) * simd.splat(0.5), change: far - near, deviations, has_walls })
    }
}
