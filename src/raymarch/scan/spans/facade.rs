//! Façades on the fronts of spans.

use super::metric::{Metric, dot};
use super::plane_lanes::PlaneLanes;
use crate::detail::{AlongMeans, FacadePattern};
use crate::simd::{Each, Floats, Kernel, Simd};
use crate::voxel::{Grid, PAGE_SIDE, PageId, Span};
use glam::DVec2;

/// Steepest way of a plane along a wall, by which footprints along it are bounded.
const STEEPEST: f32 = 64.0;

/// Façade of a front in some planes.
pub(super) struct FacadeFront<'r, V: Simd> {
    pattern: FacadePattern,
    along: AlongMeans<V>,
    /// Depth of the front, metres.
    depth: V::F,
    /// Height of the floor over the eye, metres.
    floor: V::F,
    /// Tangents of the rows' edges.
    edges: &'r [f32],
}

/// Wall of a cell that has a façade.
pub(super) struct FacedWall<'s> {
    pub span: &'s Span,
    /// Direction that the wall looks in, 256ths of a turn counter-clockwise from east.
    pub facing: u8,
    /// Centre of the cell, metres in the database's system.
    pub centre: DVec2,
}

/// Front of a span in the planes that meet it.
pub(super) struct FrontLanes<V: Simd> {
    /// East and north of the cell's centre, sides of it.
    pub at: [V::F; 2],
    /// Depth, metres.
    pub depth: V::F,
    /// Height of the datum above the eye, metres.
    pub above: V::F,
}

/// Finds the centre of a cell of a page, metres in the database's system.
pub(super) fn centre(grid: &Grid, page: PageId, voxel: [u32; 2], shift: u8) -> DVec2 {
    // The voxel that stands for a coarse cell begins at its middle.
    let half = if shift == 0 { 0.5 } else { 0.0 };
    let [x, y] = [page.px * PAGE_SIDE + voxel[0], page.py * PAGE_SIDE + voxel[1]].map(f64::from);
    grid.origin + (DVec2::new(x, y) + half) * grid.spacing
}

/// Tangents of the lower and the upper edge of a row.
#[inline(always)]
pub(super) fn row_edges(edges: &[f32], row: usize) -> [f32; 2] {
    let edge = |row: usize| edges.get(row).or(edges.last()).copied().unwrap_or_default();
    [edge(row), edge(row + 1)]
}

impl<V: Simd> FacadeFront<'_, V> {
    /// Light in a row of a wall of some light.
    #[inline(always)]
    pub fn light(&self, simd: V, row: usize, light: [V::F; 3]) -> [V::F; 3] {
        simd.call(RowLight { simd, facade: self, row, light })
    }
}

/// Look at a wall's front, which finds its façade; `None`: it is plain.
///
/// Few faces have one, so that it is a call of its own.
pub(super) struct FrontLook<'f, 'r, V: Simd> {
    pub simd: V,
    pub metric: &'f Metric,
    pub wall: &'f FacedWall<'f>,
    pub front: &'f FrontLanes<V>,
    pub lanes: &'f PlaneLanes<V>,
    /// Tangents of the rows' edges.
    pub edges: &'r [f32],
}

impl<'r, V: Simd> Kernel for FrontLook<'_, 'r, V> {
    type Output = Option<FacadeFront<'r, V>>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Self::Output {
        let Self { simd, metric, wall, front, lanes, edges } = self;
        let FacedWall { span, facing, centre } = *wall;
        let pattern = FacadePattern::of_wall(span, facing, metric.code)?;
        let tangent = pattern.tangent();
        let spacing = simd.splat(metric.spacing);
        let start = simd.splat(pattern.place_along(centre));
        let along = dot(simd, tangent, front.at).mul_add(spacing, start);

        // The next plane meets the wall's line where its way along it makes up for the one across.
        let normal = metric.directions[usize::from(facing)];
        let [ahead, beside] = [lanes.ahead, lanes.beside].each(|way| dot(simd, normal, way));
        let [along_ahead, along_beside] = [lanes.ahead, lanes.beside].each(|way| dot(simd, tangent, way));
        let step = (along_ahead * beside / ahead - along_beside).abs() * spacing * front.depth;
        let extent = step.min(simd.splat(STEEPEST)).max(simd.splat(0.0));

        let floor = simd.splat(metric.scale * f32::from(span.facade.floor)) + front.above;
        let along = pattern.along(simd, along, extent);
        Some(FacadeFront { pattern, along, depth: front.depth, floor, edges })
    }
}

/// Light in one row.
struct RowLight<'f, 'r, V: Simd> {
    simd: V,
    facade: &'f FacadeFront<'r, V>,
    row: usize,
    light: [V::F; 3],
}

impl<V: Simd> Kernel for RowLight<'_, '_, V> {
    type Output = [V::F; 3];

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Self::Output {
        let Self { simd, facade: FacadeFront { pattern, along, depth, floor, edges }, row, light } = self;
        let [low, high] = row_edges(edges, row);
        let middle = simd.splat(0.5 * (low + high)) * *depth - *floor;
        let factors = pattern.factors(simd, along, middle, simd.splat(high - low) * *depth);

        // Planes that do not meet the front may have no numbers.
        let zero = simd.splat(0.0);
        let [red, green, blue] = factors;
        [light[0] * red.max(zero), light[1] * green.max(zero), light[2] * blue.max(zero)]
    }
}
