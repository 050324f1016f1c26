//! A group of planes in lanes, as the voxels that they cross see them.

use super::metric::LEAST_DISTANCE;
use crate::raymarch::scan::PlaneGroup;
use crate::simd::{Floats, LANES, Simd};

/// Sixteen planes from one eye.
#[derive(Clone, Copy)]
pub(super) struct PlaneLanes<V: Simd> {
    /// Metres of depth per unit of major distance.
    pub depth: V::F,
    /// Curvature's drop per squared unit of major distance, metres.
    pub drop: V::F,
    /// Height of the datum above the eye, metres.
    pub datum: V::F,
    /// Sides of a voxel along the ground per unit of major distance.
    pub ground: V::F,
    /// Depth per distance along the ground.
    pub level: V::F,
    /// Sides of a voxel eastward and northward per metre of depth, and by how much that changes to the next plane.
    pub ahead: [V::F; 2],
    pub beside: [V::F; 2],
}

impl<V: Simd> PlaneLanes<V> {
    /// Puts planes from an eye `height` metres above the datum into lanes; `spacing`: side of a voxel, metres.
    #[inline(always)]
    pub fn new(simd: V, group: &PlaneGroup, height: f64, spacing: f32) -> Self {
        let depth = simd.load(&group.depth);
        let (mut ahead, mut beside) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
        let mut ground = [0.0; LANES];
        for lane in 0..LANES {
            let (way, change) = (group.way(lane), group.beside(lane));
            ground[lane] = way[0].hypot(way[1]) as f32;
            for axis in 0..2 {
                ahead[axis][lane] = (way[axis] / f64::from(group.depth[lane])) as f32;
                beside[axis][lane] = change[axis];
            }
        }

        let ground = simd.load(&ground);
        Self {
            depth,
            drop: simd.load(&group.drop),
            datum: simd.splat(-height as f32),
            ground,
            level: depth / (ground * simd.splat(spacing)),
            ahead: [simd.load(&ahead[0]), simd.load(&ahead[1])],
            beside: [simd.load(&beside[0]), simd.load(&beside[1])],
        }
    }

    /// Inverse depths at major distances, 1/metres.
    #[inline(always)]
    pub fn inverse(&self, simd: V, distance: V::F) -> V::F {
        (self.depth * distance.max(simd.splat(LEAST_DISTANCE as f32))).recip()
    }

    /// Heights of the datum above the eye at major distances, with the Earth's curvature, metres.
    #[inline(always)]
    pub fn datum(&self, distance: V::F) -> V::F {
        (self.drop * distance).neg_mul_add(distance, self.datum)
    }
}
