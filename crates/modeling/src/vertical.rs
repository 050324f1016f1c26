//! Heights of all sources above one datum.
//!
//! Heights above the ellipsoid are lowered by the EGM96 undulation, which is evaluated on a lattice over the area and
//! interpolated between: the model itself has nodes every quarter of a degree. What cannot be converted is an
//! error (see [`VerticalDatum::conversion`]), never a shift of nothing.

use glam::DVec2;

use super::warp;
use hedgehop::voxel::Grid;
use hedgehop_base::error::Result;
use hedgehop_geo::{Crs, Transform, VerticalDatum, VerticalShift};

/// Distance between lattice nodes, metres, unless that made more than [`MOST_NODES`] along a side.
const NODE_METRES: f64 = 8000.0;
const MOST_NODES: u32 = 1024;

/// Shift that is added to a source's heights, metres.
#[derive(Debug, Clone)]
pub(super) enum Shift {
    /// Nothing.
    Zero,
    /// Bilinear between nodes, row-major from the south-west, `count.0` to a row, `step` voxels apart.
    Lattice { count: (u32, u32), step: (f64, f64), nodes: Vec<f64> },
}

impl Shift {
    /// Finds the shift of heights above `from` to `to`.
    pub fn between(from: VerticalDatum, to: VerticalDatum, grid: &Grid, crs: &Crs) -> Result<Self> {
        match VerticalDatum::conversion(from, to)? {
            VerticalShift::None => Ok(Self::Zero),
            shift => Self::over(shift, grid, crs),
        }
    }

    fn over(shift: VerticalShift, grid: &Grid, crs: &Crs) -> Result<Self> {
        let degrees_from_world = Transform::new(crs, &Crs::wgs84())?;
        let cells = |voxels: u32| {
            let wanted = (f64::from(voxels) * grid.spacing / NODE_METRES).ceil();
            wanted.clamp(1.0, f64::from(MOST_NODES)) as u32
        };
        let (cells_x, cells_y) = (cells(grid.nx), cells(grid.ny));
        let step = (f64::from(grid.nx) / f64::from(cells_x), f64::from(grid.ny) / f64::from(cells_y));
        let mut nodes = Vec::new();
        for row in 0..=cells_y {
            for column in 0..=cells_x {
                let (x, y) = warp::world(grid, f64::from(column) * step.0, f64::from(row) * step.1);
                // Where the projection ends there are no heights to be shifted either.
                let degrees = degrees_from_world.apply(x, y);
                nodes
                    .push(degrees.map_or(0.0, |(longitude, latitude)| shift.apply(longitude, latitude, 0.0)));
            }
        }
        Ok(Self::Lattice { count: (cells_x + 1, cells_y + 1), step, nodes })
    }

    /// Whether there is nothing to add anywhere.
    pub fn is_zero(&self) -> bool {
        matches!(self, Self::Zero)
    }

    /// At a position in units from the area's south-west corner, metres.
    pub fn at(&self, place: DVec2) -> f64 {
        let Self::Lattice { count, step, nodes } = self else { return 0.0 };
        let node_at = |units: f64, step: f64, count: u32| {
            let place = units / step;
            let node = (place as u32).min(count - 2);
            (node as usize, place - f64::from(node))
        };
        let ((i, u), (j, v)) = (node_at(place.x, step.0, count.0), node_at(place.y, step.1, count.1));
        let node = |i: usize, j: usize| nodes[j * count.0 as usize + i];
        let south = node(i, j) * (1.0 - u) + node(i + 1, j) * u;
        let north = node(i, j + 1) * (1.0 - u) + node(i + 1, j + 1) * u;
        south * (1.0 - v) + north * v
    }

    /// Least and greatest shift, metres.
    pub fn range(&self) -> (f64, f64) {
        match self {
            Self::Zero => (0.0, 0.0),
            Self::Lattice { nodes, .. } => {
                nodes.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &node| {
                    (low.min(node), high.max(node))
                })
            }
        }
    }
}

/// The database's datum for sources with these (in order of priority): theirs if all agree, else the first that is
/// no ellipsoid. Ellipsoidal heights alone become EGM96, but stay as they are without a place on Earth. Without any source it is mean sea level.
pub(super) fn common_datum(datums: &[VerticalDatum], local: bool) -> VerticalDatum {
    if datums.is_empty() {
        return VerticalDatum::Msl;
    }
    let first = datums.iter().find(|datum| **datum != VerticalDatum::Ellipsoid);
    first.copied().unwrap_or(if local { VerticalDatum::Ellipsoid } else { VerticalDatum::Egm96 })
}
