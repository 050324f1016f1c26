//! A model over a lattice of voxels: columns of solids.

use glam::{DVec2, dvec2};

use super::fit::Over;
use super::rays::RayWindow;
use super::soup::Soup;
use crate::Materials;
use crate::features::{Solid, TreeKind, Wall};
use hedgehop::voxel::{Grid, HeightCode, SharedObject, Span, SpanTable, Symmetry};

/// Voxels along a tile that is looked at at once.
const TILE: usize = 32;

/// Voxels of the largest footprint.
const MOST_VOXELS: usize = 1 << 22;

/// Model over voxels, its foot at height 0 at a place of voxel (0, 0).
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Shape {
    /// South-west voxel.
    pub first: [i64; 2],
    pub columns: usize,
    pub rows: usize,
    /// Number of the first solid of each voxel, row by row, and of all.
    starts: Vec<u32>,
    solids: Vec<Solid>,
}

impl Shape {
    /// Whether a model is not too large for such voxels.
    ///
    /// # Errors
    /// A clause: it is.
    pub(super) fn check(soup: &Soup, spacing: f64) -> Result<(), String> {
        let size = (soup.corners[1] - soup.corners[0]) / spacing;
        if (size.x + 2.0) * (size.y + 2.0) <= MOST_VOXELS as f64 {
            return Ok(());
        }
        Err(format!(
            "it is {:.0} by {:.0} voxels wide; no more than {MOST_VOXELS} together fit: see `scale`",
            size.x, size.y
        ))
    }

    /// Converts a model that was checked, whose foot is at `phase` from the south-west corner of voxel (0, 0), in voxels, 0…1. What `stands` has its lowest
    /// parts on the ground, wherever that is below them.
    pub(super) fn of(soup: &Soup, spacing: f64, phase: DVec2, material: u8, stands: bool) -> Self {
        let [low, high] = soup.corners.map(|corner| dvec2(corner.x, corner.y) / spacing + phase);
        let (first, last) = (low.floor(), high.floor());
        let size = last - first + 1.0;
        let (columns, rows) = (size.x as usize, size.y as usize);
        let corner = (first - phase) * spacing;
        let tiles = (columns.div_ceil(TILE), rows.div_ceil(TILE));
        let mut of_tile: Vec<Vec<u32>> = vec![Vec::new(); tiles.0 * tiles.1];

        for (number, face) in (0..).zip(&soup.faces) {
            let [west, south, east, north] = face.bounds();
            let index = |at: f64, from: f64, count: usize| {
                ((at - from) / (spacing * TILE as f64)).floor().clamp(0.0, count as f64 - 1.0) as usize
            };
            for row in index(south, corner.y, tiles.1)..=index(north, corner.y, tiles.1) {
                for column in index(west, corner.x, tiles.0)..=index(east, corner.x, tiles.0) {
                    of_tile[row * tiles.0 + column].push(number);
                }
            }
        }

        let mut found: Vec<Vec<Solid>> = vec![Vec::new(); columns * rows];
        for (tile, faces) in of_tile.into_iter().enumerate() {
            let (x0, y0) = (tile % tiles.0 * TILE, tile / tiles.0 * TILE);
            let window = RayWindow {
                corner: corner + dvec2(x0 as f64, y0 as f64) * spacing,
                spacing,
                columns: TILE.min(columns - x0),
                rows: TILE.min(rows - y0),
            };

            for (index, mut cell) in window.look(soup, faces.into_iter()).into_iter().enumerate() {
                let (x, y) = (x0 + index % window.columns, y0 + index / window.columns);
                let centre = corner + (dvec2(x as f64, y as f64) + 0.5) * spacing;
                let over = Over { soup, centre, spacing, material, stands };
                found[y * columns + x] = over.fit(&mut cell);
            }
        }

        let first = [first.x as i64, first.y as i64];
        let mut shape = Self { first, columns, rows, starts: vec![0], solids: Vec::new() };
        for solids in found {
            shape.solids.extend(solids);
            shape.starts.push(shape.solids.len() as u32);
        }

        shape
    }

    /// The object that a database places: its solids in the colours of the place, heights by steps from its foot. `None`: it is too wide.
    pub fn shared(&self, grid: &Grid, code: HeightCode, materials: &Materials) -> Option<SharedObject> {
        let most = usize::from(SharedObject::MOST_VOXELS);
        if self.columns > most || self.rows > most {
            return None;
        }
        // Code 0 is kept for the ground.
        let above = HeightCode { offset: 0.0, ..code };
        let size = [self.columns as u16, self.rows as u16];
        let spans_of = |column: u16, row: u16, spans: &mut Vec<Span>| {
            let first = spans.len();
            let solids = self.over([self.first[0] + i64::from(column), self.first[1] + i64::from(row)]);
            let dressed = solids.iter().map(|solid| materials.dressed(solid));
            spans.extend(dressed.filter_map(|solid| solid.encode(&above, grid.spacing)));
            spans[first..].sort_by_key(|span| (span.low, span.high));
        };
        Some(SharedObject::new(size, SpanTable::rise(code, grid.spacing), spans_of))
    }

    /// Raises a tree that stands in the middle of a voxel.
    pub fn planted(tree: TreeKind, spacing: f64) -> Self {
        let (side, solids) = tree.voxels(spacing);
        let mut found: Vec<Vec<Solid>> = vec![Vec::new(); side * side];
        solids.into_iter().for_each(|placed| found[placed.voxel].push(placed.solid));
        let first = [-(side as i64 / 2); 2];
        let mut shape = Self { first, columns: side, rows: side, starts: vec![0], solids: Vec::new() };
        for mut solids in found {
            let low = |solid: &Solid| solid.low_m.unwrap_or(f64::NEG_INFINITY);
            solids.sort_by(|a, b| low(a).total_cmp(&low(b)));
            shape.solids.extend(solids);
            shape.starts.push(shape.solids.len() as u32);
        }
        shape
    }

    /// Solids over a voxel, counted from voxel (0, 0); heights are metres from the foot.
    pub fn over(&self, [column, row]: [i64; 2]) -> &[Solid] {
        let (column, row) = (column - self.first[0], row - self.first[1]);
        if column < 0 || row < 0 || column >= self.columns as i64 || row >= self.rows as i64 {
            return &[];
        }
        let index = row as usize * self.columns + column as usize;
        &self.solids[self.starts[index] as usize..self.starts[index + 1] as usize]
    }
}

/// A solid of a shape that is laid in one of eight ways.
pub fn laid(symmetry: Symmetry, solid: &Solid) -> Solid {
    let facing = |angle: f64| {
        let angle = if symmetry.is_mirrored() { std::f64::consts::PI - angle } else { angle };
        angle + f64::from(symmetry.turns()) * std::f64::consts::FRAC_PI_2
    };
    let wall = match solid.wall {
        Wall::Whole => Wall::Whole,
        Wall::Plane { facing: angle, distance_m } => Wall::Plane { facing: facing(angle), distance_m },
        Wall::Corner(planes) => Wall::Corner(planes.map(|(angle, distance_m)| (facing(angle), distance_m))),
        Wall::Wedge(planes) => Wall::Wedge(planes.map(|(angle, distance_m)| (facing(angle), distance_m))),
        Wall::Round(angle) => Wall::Round(facing(angle)),
    };
    Solid { slope: symmetry.turn(solid.slope), wall, ..*solid }
}
