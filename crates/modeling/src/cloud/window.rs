//! Points about the voxels of a tile.

use bytemuck::{Pod, Zeroable};

use super::class::PointKind;
use super::store::{CloudTile, Store, TILE};
use hedgehop_base::error::Result;

/// Points of a voxel that are looked at, at most: of more than that every n-th.
const MOST: u32 = 128;

/// A point in the grid.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Mark {
    /// Height, metres above the database's datum.
    pub z: f32,
    /// Place in its voxel, from the west and the south, 65536ths of its side.
    pub within: [u16; 2],
    /// Column and row of its voxel in its tile.
    pub voxel: [u8; 2],
    /// Number of a [`PointKind`].
    pub kind: u8,
    /// Whether it has a colour.
    pub is_coloured: u8,
    /// sRGB.
    pub colour: [u8; 3],
    /// Nothing.
    pub rest: u8,
}

impl Mark {
    pub fn kind(&self) -> PointKind {
        PointKind::of(self.kind)
    }

    pub fn z(&self) -> f64 {
        f64::from(self.z)
    }

    pub fn srgb(&self) -> Option<[u8; 3]> {
        (self.is_coloured != 0).then_some(self.colour)
    }
}

/// A voxel of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TileVoxel {
    /// Column, eastward.
    pub column: usize,
    /// Row, northward.
    pub row: usize,
}

/// A square of voxels and their points.
#[derive(Debug)]
pub(super) struct PointWindow {
    /// South-west voxel, from the grid's origin.
    pub first: [i64; 2],
    /// Voxels along a side.
    pub side: usize,
    /// Begins of the points of each voxel, and the end of the last ones.
    starts: Vec<u32>,
    marks: Vec<Mark>,
}

impl PointWindow {
    /// The points of a tile and so many voxels around it, up to the side of a tile. Those of a voxel stand in the order in which they were found.
    pub fn of(store: &Store<Mark>, tile: CloudTile, halo: i64) -> Result<Self> {
        let first = [tile.0 * TILE - halo, tile.1 * TILE - halo];
        let side = (TILE + 2 * halo) as usize;
        let about = (-1..=1).flat_map(|north| (-1..=1).map(move |east| (tile.0 + east, tile.1 + north)));

        let index = |tile: CloudTile, mark: &Mark| {
            let column = tile.0 * TILE + i64::from(mark.voxel[0]) - first[0];
            let row = tile.1 * TILE + i64::from(mark.voxel[1]) - first[1];
            let inside = |at: i64| (0..side as i64).contains(&at);
            (inside(column) && inside(row)).then(|| row as usize * side + column as usize)
        };
        let mut counts = vec![0_u32; side * side];

        for tile in about.clone() {
            let count = |mark: &Mark| index(tile, mark).into_iter().for_each(|at| counts[at] += 1);
            let mut count = count;
            store.read(tile, |marks| marks.iter().for_each(&mut count))?;
        }

        let steps: Vec<u32> = counts.iter().map(|count| count.div_ceil(MOST).max(1)).collect();
        let mut starts = Vec::with_capacity(counts.len() + 1);
        let mut total = 0;
        for (count, step) in counts.iter().zip(&steps) {
            starts.push(total);
            total += count.div_ceil(*step);
        }

        starts.push(total);
        let mut marks = vec![Mark::zeroed(); total as usize];
        let mut met = vec![0_u32; side * side];
        for tile in about {
            let mut put = |mark: &Mark| {
                let Some(at) = index(tile, mark) else { return };
                if met[at].is_multiple_of(steps[at]) {
                    marks[(starts[at] + met[at] / steps[at]) as usize] = *mark;
                }
                met[at] += 1;
            };
            store.read(tile, |marks| marks.iter().for_each(&mut put))?;
        }

        Ok(Self { first, side, starts, marks })
    }

    /// Points of a voxel.
    pub fn at(&self, voxel: TileVoxel) -> &[Mark] {
        let index = voxel.row * self.side + voxel.column;
        &self.marks[self.starts[index] as usize..self.starts[index + 1] as usize]
    }

    /// The voxels up to so many around one, itself included: steps eastward and northward, and their points.
    pub fn voxels(&self, voxel: TileVoxel, reach: i64) -> impl Iterator<Item = ([i64; 2], &[Mark])> {
        let side = self.side as i64;
        (-reach..=reach).flat_map(move |north| (-reach..=reach).map(move |east| [east, north])).filter_map(
            move |[east, north]| {
                let (column, row) = (voxel.column as i64 + east, voxel.row as i64 + north);
                let is_in = (0..side).contains(&column) && (0..side).contains(&row);
                is_in.then(|| {
                    let other = TileVoxel { column: column as usize, row: row as usize };
                    ([east, north], self.at(other))
                })
            },
        )
    }

    /// Iterates over their points, with places from the middle of the voxel, sides of a voxel.
    pub fn around(&self, voxel: TileVoxel, reach: i64) -> impl Iterator<Item = ([f64; 2], &Mark)> {
        self.voxels(voxel, reach).flat_map(|(step, marks)| {
            marks.iter().map(move |mark| {
                let place = |axis: usize| step[axis] as f64 + f64::from(mark.within[axis]) / 65536.0 - 0.5;
                ([place(0), place(1)], mark)
            })
        })
    }
}
