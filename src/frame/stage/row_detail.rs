//! Detail below the voxel in rows of sixteen planes.
//!
//! ```text
//! place      = eye + distance of the row's middle, along each plane
//! along      = distance between the row's edges, where the surface is on each
//! across     = range · angle of a pixel
//! light of the row × (1 + deviation · mean of the tile over the box with the same second moments)
//!
//! walls:       the tile stands over (y, z) or (x, z), and so does the box
//! ```

use glam::DVec3;
use hedgehop_texture::{CELLS_PER_VOXEL, SIDE};

use super::edge_marks::RowMarks;
use crate::detail::{DetailTiles, FADING, LEAST_TOWARD, Synthesis, WALL_SCALE};
use crate::raymarch::scan::PlaneGroup;
use crate::simd::{Each, Floats, LANES, Mask, Simd};

/// Cells of the tile per unit.
const CELLS: f64 = CELLS_PER_VOXEL as f64;

/// Greatest change of inverse depth over a row, relative to it.
const MOST_CHANGE: f32 = 1.0;

/// Least relative deviation of a row that is looked after.
const LEAST_DEVIATION: f32 = 1.0e-3;

/// Sum of squared sides of a footprint without detail, cells².
const NO_MORE: f32 = (FADING[1] * CELLS * CELLS) as f32;

/// Least inverse depth, 1/metres: of rows that are hardly seen.
const LEAST_INVERSE: f32 = 1.0e-5;

/// Detail on the ground that planes see.
#[derive(Debug, Clone, Copy)]
pub struct RowDetail<'t> {
    tiles: &'t DetailTiles,
    /// 0: planes run along x, 1: along y.
    major: usize,
    /// The eye, cells from a corner of the tile.
    eye: [f32; 2],
    /// Cells along the major axis, with its sense, and along the minor one, per metre of depth.
    per_depth: [[f32; LANES]; 2],
    /// The eye over walls: east, north and up, cells from a corner of the tile.
    eye_by_walls: [f32; 3],
    /// Cells along the axes of a wall that lies over (y, z) and over (x, z), squared, per squared cell that a pixel is wide.
    by_walls: [[f32; LANES]; 2],
    /// Cells per metre.
    per_metre: f32,
    /// Curvature's drop per squared metre of depth, metres.
    drop: [f32; LANES],
    /// Squared cells along the ground per squared metre of depth.
    squared_per_depth: [f32; LANES],
    /// Squared cells that a pixel is wide per squared metre of range.
    squared_per_range: f32,
    /// Least height of a row, as tangent.
    row: f32,
    strength: f32,
}

/// Row of planes that asks for detail.
pub struct DetailedRow<V: Simd> {
    /// Square of range per depth.
    pub slant_squared: V::F,
    /// Tangent in its middle, and from edge to edge.
    pub tangent: f32,
    pub height: f32,
    /// Surface in it.
    pub marks: RowMarks<V>,
}

/// Place and width of a row of planes.
struct Footprint<V: Simd> {
    /// Depth, metres.
    depth: V::F,
    /// From the eye along the major axis and along the minor one, cells.
    major: V::F,
    minor: V::F,
    /// Square of the width, cells².
    width: V::F,
}

/// View in which detail is seen.
#[derive(Debug, Clone, Copy)]
pub struct DetailView<'t> {
    /// Detail that is seen.
    pub synthesis: &'t Synthesis,
    /// The eye: units, units, metres.
    pub eye: DVec3,
    /// Width of pixels, radians.
    pub angle: f64,
    /// Least height of a row, as tangent.
    pub row: f32,
    /// Spacing of the grid, metres.
    pub spacing: f64,
}

/// Ends of a stretch of surface, the nearer one first.
pub struct StretchEnds<V: Simd> {
    /// Tangents.
    pub slopes: [V::F; 2],
    /// Inverse depths, 1/metres.
    pub inverse: [V::F; 2],
    /// Depth of the farther one, metres.
    pub depth: V::F,
}

impl<'t> RowDetail<'t> {
    /// Detail for a group of planes.
    pub fn new(group: &PlaneGroup, view: &DetailView<'t>) -> Self {
        let DetailView { synthesis, eye, angle, row, spacing } = *view;
        let PlaneGroup { major, forward, minor, depth, drop, .. } = group;
        let cells = |lane: usize, units: f64| (units * CELLS / f64::from(depth[lane])) as f32;
        let per_depth: [[f32; LANES]; 2] = [
            std::array::from_fn(|lane| cells(lane, *forward)),
            std::array::from_fn(|lane| cells(lane, f64::from(minor[lane]))),
        ];
        let squared_per_depth: [f32; LANES] =
            std::array::from_fn(|lane| per_depth[0][lane].powi(2) + per_depth[1][lane].powi(2));
        // Seen at a grazing angle, a pixel goes over more of a wall.
        let by_wall = |axis: usize| {
            let toward = &per_depth[usize::from(axis != *major)];
            std::array::from_fn(|lane| {
                let square = toward[lane] * toward[lane] / squared_per_depth[lane];
                square.max(LEAST_TOWARD).recip() * (WALL_SCALE * WALL_SCALE) as f32
            })
        };
        Self {
            tiles: &synthesis.tiles,
            major: *major,
            eye_by_walls: [eye.x, eye.y, eye.z / spacing]
                .each(|at| (at * CELLS * WALL_SCALE).rem_euclid(SIDE as f64) as f32),
            by_walls: [by_wall(0), by_wall(1)],
            per_metre: (CELLS / spacing) as f32,
            drop: std::array::from_fn(|lane| drop[lane] / (depth[lane] * depth[lane])),
            eye: [eye.x, eye.y].each(|at| (at * CELLS).rem_euclid(SIDE as f64) as f32),
            per_depth,
            squared_per_depth,
            squared_per_range: (angle * CELLS / spacing).powi(2) as f32,
            row,
            strength: synthesis.strength as f32,
        }
    }

    /// Whether any plane shows detail on a stretch: not where a row goes over voxels of it.
    #[inline(always)]
    pub fn is_seen<V: Simd>(&self, simd: V, ends: &StretchEnds<V>) -> bool {
        let [[low, high], [near, far]] = [ends.slopes, ends.inverse];
        let cells = (near - far) * ends.depth * ends.depth * simd.splat(self.row);
        let along = cells * cells * simd.load(&self.squared_per_depth);
        let rise = (high - low).max(simd.splat(0.0));
        along.lt(rise * rise * simd.splat(NO_MORE)).any()
    }

    /// Factor on the light of a row; `None`: it is as good as one.
    #[inline(always)]
    pub fn factor<V: Simd>(&self, simd: V, row: &DetailedRow<V>) -> Option<V::F> {
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let depth = row.marks.inverse.max(simd.splat(LEAST_INVERSE)).recip();
        let [major, minor] = self.per_depth.each_ref().each(|per_depth| simd.load(per_depth) * depth);

        // Squares of the footprint along and across, as shares of the squared distance and in cells.
        let change = (row.marks.change * depth).abs().min(simd.splat(MOST_CHANGE));
        let (per_depth, per_range) = (simd.load(&self.squared_per_depth), simd.splat(self.squared_per_range));
        let distance = per_depth * depth * depth;
        let (along, across) = (change * change, row.slant_squared * per_range * per_depth.recip());
        let strength = simd.splat(self.strength);
        let mut factor = one;
        if row.marks.has_walls && simd.splat(LEAST_DEVIATION).lt(row.marks.deviations.wall.abs()).any() {
            let footprint = Footprint { depth, major, minor, width: across * distance };
            factor = self.over_walls(simd, row, &footprint).mul_add(strength, factor);
        }
        let deviation = row.marks.deviations.ground * strength * fading(simd, (along + across) * distance);
        if !simd.splat(LEAST_DEVIATION).lt(deviation).any() {
            return row.marks.has_walls.then_some(factor.max(zero));
        }

        // Squares of its extent along the axes.
        let (major_square, minor_square) = (major * major, minor * minor);
        let squares =
            [along * major_square + across * minor_square, along * minor_square + across * major_square];
        let [x, y] = if self.major == 0 { [major, minor] } else { [minor, major] };
        let [wide, high] = if self.major == 0 { squares } else { [squares[1], squares[0]] };
        let centre = [x + simd.splat(self.eye[0]), y + simd.splat(self.eye[1])];
        let mean = self.tiles.ground.means(simd, row.marks.deviations.ground, centre, [wide, high]);

        Some(deviation.mul_add(mean, factor).max(zero))
    }

    /// Relative deviation over walls, in a row's footprint.
    #[inline(always)]
    fn over_walls<V: Simd>(&self, simd: V, row: &DetailedRow<V>, footprint: &Footprint<V>) -> V::F {
        let Footprint { depth, major, minor, width } = *footprint;
        let (zero, scale) = (simd.splat(0.0), simd.splat(WALL_SCALE as f32));
        let wall = row.marks.deviations.wall;
        let over_north = zero.lt(wall);

        // Up: what the row spans at its depth, and by what its edges differ in depth.
        let tangent = simd.splat(row.tangent);
        let rise = (simd.splat(row.height) - tangent * row.marks.change * depth)
            * depth
            * simd.splat(self.per_metre);
        let fading = fading(simd, rise.mul_add(rise, width));
        let height = (tangent + simd.load(&self.drop) * depth) * depth;
        let up = height * simd.splat(self.per_metre) * scale + simd.splat(self.eye_by_walls[2]);

        let [east, north] = if self.major == 0 { [major, minor] } else { [minor, major] };
        let [eye_east, eye_north, _] = self.eye_by_walls.each(|at| simd.splat(at));
        let beside = (north * scale + eye_north).select(over_north, east * scale + eye_east);
        let [over_north_wide, over_east_wide] = self.by_walls.each_ref().each(|wide| simd.load(wide));
        let wide = width * over_north_wide.select(over_north, over_east_wide);

        let mean = self.tiles.walls.means(simd, wall, [beside, up], [wide, rise * rise * scale * scale]);
        wall.abs() * fading * mean
    }
}

/// Share that detail has at sums of squared sides in cells, as [`crate::detail::GroundTile::fading`] has it in voxels.
#[inline(always)]
fn fading<V: Simd>(simd: V, squares: V::F) -> V::F {
    let [from, to] = FADING.each(|voxels| (voxels * CELLS * CELLS) as f32);
    let left = (simd.splat(to) - squares) * simd.splat(1.0 / (to - from));
    left.max(simd.splat(0.0)).min(simd.splat(1.0))
}
