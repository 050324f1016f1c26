//! Directions of a screen's pixels in axes that turn with it: the same for every pose.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::simd::LANES;
use crate::space::Camera;

/// Rows and strips of a cell: fewer make more cells to be turned in each frame, more make them mark more than pixels need.
const CELL_ROWS: usize = 32;
const CELL_STRIPS: usize = 2;

/// Directions of sixteen pixels: x, y, z; all zero where there is no ray.
pub type DirectionStrip = [[f32; LANES]; 3];

/// A cone that holds the directions of some pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionCell {
    /// Unit vector.
    pub axis: DVec3,
    /// Angle between it and the outermost direction, radians.
    pub radius: f64,
}

/// The direction of each pixel.
#[derive(Debug, Clone)]
pub struct Directions {
    camera: Camera,
    /// `[strip][row]`, strips of sixteen columns: in the order in which the image stage reads them.
    table: Vec<DirectionStrip>,
    /// `[strips][rows]` of [`CELL_STRIPS`] and [`CELL_ROWS`]; `None` where no pixel has a ray.
    cells: Vec<Option<DirectionCell>>,
}

/// Some strips that are to be filled.
pub struct DirectionPart<'d> {
    /// First column.
    first: usize,
    table: &'d mut [DirectionStrip],
    cells: &'d mut [Option<DirectionCell>],
}

impl Directions {
    /// Makes room for the directions of `camera`'s screen; [`Self::parts`] are to be filled before it is used.
    pub fn new(camera: &Camera) -> Self {
        let strips = (camera.width as usize).div_ceil(LANES);
        let rows = camera.height as usize;
        Self {
            camera: camera.clone(),
            table: vec![[[0.0; LANES]; 3]; strips * rows],
            cells: vec![None; strips.div_ceil(CELL_STRIPS) * rows.div_ceil(CELL_ROWS)],
        }
    }

    /// Splits the directions into parts to be filled, in any order.
    pub fn parts(&mut self) -> Vec<DirectionPart<'_>> {
        let rows = self.camera.height as usize;
        let strips = self.table.chunks_mut(rows * CELL_STRIPS);
        strips
            .zip(self.cells.chunks_mut(rows.div_ceil(CELL_ROWS)))
            .enumerate()
            .map(|(index, (table, cells))| DirectionPart { first: index * CELL_STRIPS * LANES, table, cells })
            .collect()
    }

    /// Whether the screen of `camera` has the same directions.
    pub fn serve(&self, camera: &Camera) -> bool {
        self.camera.maps_like(camera)
    }

    /// Cones that hold all directions.
    pub fn cells(&self) -> impl Iterator<Item = DirectionCell> {
        self.cells.iter().copied().flatten()
    }

    /// Solid angle of these cones, steradians: that of what is in sight, or some times it.
    pub fn solid_angle(&self) -> f64 {
        self.cells().map(|cell| TAU * (1.0 - cell.radius.cos())).sum()
    }

    /// Sixteen pixels from `column` (a multiple of sixteen) of a `row` on.
    #[inline(always)]
    pub fn strip(&self, column: usize, row: usize) -> &DirectionStrip {
        &self.table[column / LANES * self.camera.height as usize + row]
    }
}

impl DirectionPart<'_> {
    /// Asks `camera` for each direction.
    pub fn fill(self, camera: &Camera) {
        let Self { first, table, cells } = self;
        let (last, rows) = (camera.width as usize - 1, camera.height as usize);
        for (index, strip) in table.iter_mut().enumerate() {
            let (row, column) = (index % rows, first + index / rows * LANES);
            for lane in 0..LANES {
                let column = (column + lane).min(last);
                let direction = camera.mapped(column as f64 + 0.5, row as f64 + 0.5);
                let direction = direction.map_or([0.0; 3], |it| it.normalize().as_vec3().to_array());
                for (lanes, value) in strip.iter_mut().zip(direction) {
                    lanes[lane] = value;
                }
            }
        }
        for (index, cell) in cells.iter_mut().enumerate() {
            let (from, to) = (index * CELL_ROWS, ((index + 1) * CELL_ROWS).min(rows));
            *cell = cone(|| table.chunks(rows).flat_map(|strip| &strip[from..to]));
        }
    }
}

/// The cone around some directions.
fn cone<'d, I: Iterator<Item = &'d DirectionStrip>>(strips: impl Fn() -> I) -> Option<DirectionCell> {
    let directions = || {
        strips()
            .flat_map(|strip| (0..LANES).map(|lane| strip.map(|axis| f64::from(axis[lane]))))
            .map(DVec3::from_array)
            .filter(|direction| *direction != DVec3::ZERO)
    };
    let first = directions().next()?;
    let axis = directions().sum::<DVec3>().try_normalize().unwrap_or(first);
    let farthest = directions().map(|direction| direction.distance(axis)).fold(0.0, f64::max);
    Some(DirectionCell { axis, radius: 2.0 * (0.5 * farthest).min(1.0).asin() })
}
