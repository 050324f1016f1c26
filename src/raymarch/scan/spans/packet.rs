//! Packets of planes on their way through blocks and voxels (ray packets: Wald et al., 2001).
//!
//! All planes of a group cross the borders between columns of voxels, across the axis that they mostly run along, at the same major
//! distances; in between each climbs by so many voxels along the other axis. Planes that climb in the same sense pass
//! voxels column by column, and in each column in that sense: whatever voxels two of them share, both pass in this order.
//!
//! ```text
//!              ┌───┬───┬───┐          along: columns of voxels, from the block's near side
//!              │   │  ╱│ __│          up:    voxels of a column, in the sense in which planes climb
//!   ┌───┬───┬──┼─╱─┼_─´┼───┤
//!   │   │ _╱│╱´│_─´│   │   │          a voxel's part of a plane lies between the borders of its column
//!   │_─´│´__┼─´│   │   │   │          and those that the plane climbs through
//!   └───┴───┴──┴───┴───┘
//! ```

use std::ops::Range;

use super::metric::LEAST_DISTANCE;
use crate::raymarch::scan::PlaneGroup;
use crate::simd::{Each, Floats, LANES, Mask, Simd};
use crate::voxel::{BLOCK_SIDE, Grid};

const SIDE: f64 = BLOCK_SIDE as f64;
const LAST_VOXEL: i32 = BLOCK_SIDE as i32 - 1;

/// Columns that a plane along an axis takes to climb by one voxel, at most.
const FAR: f32 = 1.0e9;

/// Allowance for rounding in the range of blocks that are looked at, voxels.
const ROUNDING: f64 = 0.05;

/// Cells that planes are followed through, each of which is a voxel to them.
#[derive(Clone, Copy)]
pub(super) struct CellExtent<'g> {
    /// The grid of voxels.
    pub grid: &'g Grid,
    /// log₂ of these along a cell.
    pub shift: u8,
    /// Major distances between which planes are followed, cells.
    pub over: [f64; 2],
}

/// Planes of a group that climb in the same sense.
#[derive(Clone, Copy)]
pub(super) struct PlanePacket<'g, V: Simd> {
    /// Planes that are followed.
    pub planes: V::M,
    group: &'g PlaneGroup,
    /// Eye along the major axis and along the other one, units.
    eye: [f64; 2],
    /// Index of the last block along each.
    last: [i64; 2],
    /// +1 or −1: sense in which they climb.
    sense: f64,
    /// Voxels that they climb from column to column, and the inverse.
    climb: V::F,
    per_voxel: V::F,
    /// Major distances between which they are followed, units.
    over: [V::F; 2],
    /// The least and the greatest of them.
    extent: [f64; 2],
}

/// Column of blocks across the major axis.
pub(super) struct BlockColumn<V: Simd> {
    /// Along the major axis.
    index: i64,
    /// Major distance of its near side, units; behind the eye, less than 0.
    pub start: f64,
    /// Place of each plane along the other axis there, units.
    places: [f64; LANES],
    /// Distances from the near side between which planes are followed, units.
    over: [V::F; 2],
}

/// Planes that cross a block.
pub(super) struct BlockPassage<V: Simd> {
    /// Column and row of the block in the area.
    pub cell: [i64; 2],
    /// The planes.
    pub planes: V::M,
    /// Major distance of its near side, units.
    pub start: f64,
    /// Distances from there at which they enter and leave, units.
    over: [V::F; 2],
    /// Height over the lower side at the near side, voxels.
    height: V::F,
}

/// Planes that cross a column of voxels in a block.
pub(super) struct VoxelColumn<V: Simd> {
    planes: V::M,
    /// Distances from the block's near side at which they enter and leave, units.
    over: [V::F; 2],
    /// Voxels that some plane crosses, in the sense in which they climb.
    pub voxels: Range<i32>,
}

/// Planes that cross a voxel.
pub(super) struct VoxelPassage<V: Simd> {
    /// The planes.
    pub planes: V::M,
    /// Distances from the block's near side at which they enter and leave, units.
    over: [V::F; 2],
    /// Major distances, units.
    pub distances: [V::F; 2],
}

impl<'g, V: Simd> PlanePacket<'g, V> {
    /// Gathers the planes of a group from `eye` (units, which are cells here) that climb upward or downward; `None` where there are none.
    #[inline(always)]
    pub fn new(
        simd: V,
        group: &'g PlaneGroup,
        CellExtent { grid, shift, over: [from, until] }: CellExtent<'_>,
        eye: [f64; 2],
        upward: bool,
    ) -> Option<Self> {
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let minor = simd.load(&group.minor);
        let falls = minor.lt(zero);
        let enter = simd.load(&group.over[0]).max(simd.splat(from.max(LEAST_DISTANCE) as f32));
        let leave = simd.load(&group.over[1]).min(simd.splat(until as f32));
        let planes = if upward { !falls } else { falls } & enter.lt(leave);
        if !planes.any() {
            return None;
        }

        let last = [grid.nx, grid.ny].each(|side| ((i64::from(side) - 1) >> shift) / i64::from(BLOCK_SIDE));
        let least = enter.select(planes, simd.splat(f32::INFINITY)).least();
        let greatest = leave.select(planes, zero).greatest();

        Some(Self {
            planes,
            group,
            eye: turned_to(group.major, eye),
            last: turned_to(group.major, last),
            sense: if upward { 1.0 } else { -1.0 },
            climb: minor.abs(),
            per_voxel: one / minor.abs().max(simd.splat(1.0 / FAR)),
            over: [enter, leave],
            extent: [f64::from(least), f64::from(greatest)],
        })
    }

    /// Counts the columns of blocks that they cross, outward: numbers for [`Self::column`].
    #[inline(always)]
    pub fn columns(&self) -> Range<i64> {
        let [first, last] = self.extent.each(|distance| {
            let place = (self.eye[0] + self.group.forward * distance) / SIDE;
            // On a border it is the column that planes enter.
            let index = if self.group.forward < 0.0 { place.ceil() as i64 - 1 } else { place.floor() as i64 };
            let index = index.clamp(0, self.last[0]);
            if self.group.forward < 0.0 { self.last[0] - index } else { index }
        });
        first..last + 1
    }

    /// A column of blocks.
    #[inline(always)]
    pub fn column(&self, simd: V, number: i64) -> BlockColumn<V> {
        let index = if self.group.forward < 0.0 { self.last[0] - number } else { number };
        let near = if self.group.forward < 0.0 { index + 1 } else { index };
        let start = (near as f64 * SIDE - self.eye[0]) * self.group.forward;
        let mut places = [0.0; LANES];
        for (place, minor) in places.iter_mut().zip(self.group.minor) {
            *place = self.eye[1] + f64::from(minor) * start;
        }

        let (zero, side) = (simd.splat(0.0), simd.splat(SIDE as f32));
        let from_start = |distance: V::F| distance - simd.splat(start as f32);
        let over = [from_start(self.over[0]).max(zero), from_start(self.over[1]).min(side)];

        BlockColumn { index, start, places, over }
    }

    /// Blocks of a column that they may cross, in the sense in which they climb: rows in the area.
    #[inline(always)]
    pub fn rows(&self, simd: V, column: &BlockColumn<V>) -> impl Iterator<Item = i64> + use<V> {
        let planes = self.planes & column.over[0].lt(column.over[1]);
        let far = simd.splat(f32::INFINITY);

        // Places over one that is near them all: single precision tells those apart.
        let origin = (column.places[LANES / 2] / SIDE).floor() * SIDE;
        let mut height = [0.0_f32; LANES];
        for (height, place) in height.iter_mut().zip(column.places) {
            *height = ((place - origin) * self.sense) as f32;
        }

        let height = simd.load(&height);
        let low = self.climb.mul_add(column.over[0], height).select(planes, far).least();
        let high =
            self.climb.mul_add(column.over[1], height).select(planes, simd.splat(0.0) - far).greatest();
        let row = |height: f64| ((origin + height * self.sense) / SIDE).floor() as i64;
        let [first, last] = [row(f64::from(low) - ROUNDING), row(f64::from(high) + ROUNDING)];
        let [least, most] = [first.min(last).max(0), first.max(last).min(self.last[1])];
        let is_upward = self.sense > 0.0;

        let count = if planes.any() { most - least + 1 } else { 0 };
        (0..count).map(move |step| if is_upward { least + step } else { most - step })
    }

    /// The planes that cross a block of a column; `None` where none does.
    #[inline(always)]
    pub fn block(&self, simd: V, column: &BlockColumn<V>, row: i64) -> Option<BlockPassage<V>> {
        let lower = (if self.sense < 0.0 { row + 1 } else { row }) as f64 * SIDE;
        let mut height = [0.0_f32; LANES];
        for (height, place) in height.iter_mut().zip(column.places) {
            *height = ((place - lower) * self.sense) as f32;
        }

        let height = simd.load(&height);
        let over = self.between(simd, height, [0.0, SIDE as f32], column.over);
        let planes = self.planes & over[0].lt(over[1]);
        planes.any().then(|| BlockPassage {
            cell: turned_to(self.group.major, [column.index, row]),
            planes,
            start: column.start,
            over,
            height,
        })
    }

    /// Between which distances from a block's near side, within `over`, planes are between two heights.
    #[inline(always)]
    fn between(&self, simd: V, height: V::F, heights: [f32; 2], over: [V::F; 2]) -> [V::F; 2] {
        let [low, high] = heights.each(|border| (simd.splat(border) - height) * self.per_voxel);
        [over[0].max(low), over[1].min(high)]
    }

    /// Counts the columns of voxels of a block that planes cross: numbers for [`Self::voxel_column`].
    #[inline(always)]
    pub fn voxel_columns(&self, simd: V, block: &BlockPassage<V>) -> Range<i32> {
        let (far, zero) = (simd.splat(f32::INFINITY), simd.splat(0.0));
        let first = block.over[0].select(block.planes, far).least() as i32;
        let end = block.over[1].select(block.planes, zero).greatest().ceil() as i32;
        first.min(LAST_VOXEL)..end
    }

    /// A column of voxels of a block.
    #[inline(always)]
    pub fn voxel_column(&self, simd: V, block: &BlockPassage<V>, number: i32) -> VoxelColumn<V> {
        let borders = [number, number + 1].each(|border| simd.splat(border as f32));
        let over = [block.over[0].max(borders[0]), block.over[1].min(borders[1])];
        let planes = block.planes & over[0].lt(over[1]);
        let (far, zero) = (simd.splat(SIDE as f32), simd.splat(0.0));
        let low = self.climb.mul_add(over[0], block.height).select(planes, far).least();
        let high = self.climb.mul_add(over[1], block.height).select(planes, zero).greatest();
        let voxels = (low.max(0.0) as i32)..(high as i32).min(LAST_VOXEL) + 1;
        VoxelColumn { planes, over, voxels }
    }

    /// The planes that cross a voxel of a column, `up` from its lowest one; `None` where none does.
    #[inline(always)]
    pub fn voxel(
        &self,
        simd: V,
        block: &BlockPassage<V>,
        column: &VoxelColumn<V>,
        up: i32,
    ) -> Option<VoxelPassage<V>> {
        let heights = [up, up + 1].each(|border| border as f32);
        let over = self.between(simd, block.height, heights, column.over);
        let planes = column.planes & over[0].lt(over[1]);
        let start = simd.splat(block.start as f32);
        let least = simd.splat(LEAST_DISTANCE as f32);
        planes.any().then(|| VoxelPassage {
            planes,
            over,
            distances: over.each(|along| (start + along).max(least)),
        })
    }

    /// Number of a voxel in its block, row by row northward.
    #[inline(always)]
    pub fn place(&self, column: i32, up: i32) -> usize {
        let turned = |number: i32, sense: f64| if sense < 0.0 { LAST_VOXEL - number } else { number };
        let [x, y] =
            turned_to(self.group.major, [turned(column, self.group.forward), turned(up, self.sense)]);
        (y * BLOCK_SIDE as i32 + x) as usize
    }

    /// Places of planes where they enter and leave a voxel: from its centre eastward and northward, sides of it.
    #[inline(always)]
    pub fn ends(
        &self,
        simd: V,
        block: &BlockPassage<V>,
        voxel: &VoxelPassage<V>,
        [column, up]: [i32; 2],
    ) -> [[V::F; 2]; 2] {
        let centre = [column, up].each(|number| simd.splat(number as f32 + 0.5));
        let senses = [self.group.forward, self.sense].each(|sense| simd.splat(sense as f32));
        let [enter, leave] = voxel.over;
        [self.place_from(centre, senses, block, enter), self.place_from(centre, senses, block, leave)]
    }

    /// Places of planes at distances from a block's near side: from a voxel's centre eastward and northward, sides of it.
    #[inline(always)]
    fn place_from(
        &self,
        centre: [V::F; 2],
        senses: [V::F; 2],
        block: &BlockPassage<V>,
        along: V::F,
    ) -> [V::F; 2] {
        let across = self.climb.mul_add(along, block.height);
        turned_to(self.group.major, [(along - centre[0]) * senses[0], (across - centre[1]) * senses[1]])
    }

    /// Place of the eye from a voxel's centre, eastward and northward, units.
    #[inline(always)]
    pub fn eye_from(&self, block: &BlockPassage<V>, [column, up]: [i32; 2]) -> [f32; 2] {
        let [_, row] = turned_to(self.group.major, block.cell);
        let lower = (if self.sense < 0.0 { row + 1 } else { row }) as f64 * SIDE;
        let along = -(block.start + f64::from(column) + 0.5) * self.group.forward;
        let across = self.eye[1] - lower - (f64::from(up) + 0.5) * self.sense;
        turned_to(self.group.major, [along as f32, across as f32])
    }
}

impl<V: Simd> BlockPassage<V> {
    /// Major distances at which planes enter and leave, units.
    #[inline(always)]
    pub fn distances(&self, simd: V) -> [V::F; 2] {
        let start = simd.splat(self.start as f32);
        [start + self.over[0], start + self.over[1]]
    }
}

/// Turns two axes so that the major one is first, and back.
#[inline(always)]
fn turned_to<T: Copy>(major: usize, [x, y]: [T; 2]) -> [T; 2] {
    if major == 0 { [x, y] } else { [y, x] }
}
