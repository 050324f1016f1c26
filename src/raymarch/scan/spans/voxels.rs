//! Voxels of a block along a plane, all at once.
//!
//! A plane passes eight columns of voxels on its way through a block, column after column along the axis that it mostly runs along,
//! and one or two voxels in each: sixteen lanes, from near to far.
//!
//! ```text
//!              ┌───┬───┐  climb ≤ 1 voxel from column to column,
//!              │  ╱│   │  so that a column's second voxel is the one above its first
//!   ┌───┬───┬──┼─╱─┼───┤
//!   │   │ __│╱´│   │   │  lane 2·column:     until the border above, or the column's end
//!   │_─´│´  │  │   │   │  lane 2·column + 1: from there to the column's end, if that is not reached yet
//!   └───┴───┴──┴───┴───┘
//! ```

use crate::raymarch::scan::spans::metric::LEAST_DISTANCE;
use crate::simd::{Each, Floats, Ints, LANES, Mask, Simd, Sixteen};
use crate::voxel::BLOCK_SIDE;

const SIDE: f64 = BLOCK_SIDE as f64;
const VOXELS: usize = (BLOCK_SIDE * BLOCK_SIDE) as usize;

/// Columns of the lanes, and which of their voxels it is: the first or the second.
const COLUMNS: [f32; LANES] =
    [0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 5.0, 5.0, 6.0, 6.0, 7.0, 7.0];
const SECOND: [f32; LANES] = [0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0];

/// Distance to a border that is never reached, columns.
const FAR: f32 = 1.0e9;

/// Course of a plane through blocks.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlaneCourse {
    eye: [f64; 2],
    way: [f64; 2],
    /// Metres of depth per unit of major distance.
    depth: f64,
    /// The axis that it mostly runs along: its columns lie one after the other.
    axis: usize,
    /// Sense along that axis and along the other one, in which it is to climb.
    senses: [f32; 2],
    /// Major distance from column to column, units.
    per_column: f64,
    /// Voxels that it climbs from column to column, 0…1, and the inverse.
    climb: f32,
    columns: f32,
}

/// Height codes below which all is hidden, linear in the major distance.
#[derive(Debug, Clone, Copy)]
pub(super) struct VoxelVeil {
    /// At the eye, and for each unit of the distance.
    pub base: f64,
    pub per_unit: f64,
}

/// Voxels of a block of which something may be seen, and where the plane enters and leaves them.
#[derive(Debug, Default)]
pub(super) struct Passed {
    /// Bits of lanes.
    pub lanes: u16,
    /// Numbers of voxels in the block, row by row northward.
    places: [i32; LANES],
    /// Major distances, units.
    distances: [Sixteen; 2],
    /// Inverse depths, 1/metres.
    inverse: [Sixteen; 2],
    /// Places from the voxel's centre, eastward and northward, sides of a voxel.
    at: [[Sixteen; 2]; 2],
}

/// One of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct PassedVoxel {
    /// Number of the voxel in the block, row by row northward.
    pub place: usize,
    /// Entry and exit of the plane: major distances, units; inverse depths, 1/metres; from the voxel's centre eastward and northward, sides of it.
    pub distances: [f32; 2],
    pub inverse: [f32; 2],
    pub at: [[f32; 2]; 2],
}

impl PlaneCourse {
    /// A plane's from `eye` (units), `way` units eastward and northward and `depth` metres per unit of major distance.
    #[inline(always)]
    pub fn new([eye, way]: [[f64; 2]; 2], depth: f64) -> Self {
        let axis = usize::from(way[1].abs() > way[0].abs());
        let (along, across) = (way[axis], way[1 - axis]);
        let climb = (across / along).abs() as f32;
        Self {
            eye,
            way,
            depth,
            axis,
            senses: [along, across].each(|way| if way < 0.0 { -1.0 } else { 1.0 }),
            per_column: 1.0 / along.abs(),
            climb,
            columns: (1.0 / climb).min(FAR),
        }
    }

    /// Passes the block whose south-west voxel is `corner`, between two major distances, and finds voxels on the way of which the height codes in `tops`
    /// (row by row northward; 0: nothing stands there) rise out of a veil.
    #[inline(always)]
    pub fn pass<V: Simd>(
        &self,
        simd: V,
        corner: [i64; 2],
        tops: &[f32; VOXELS],
        [enter, leave]: [f64; 2],
        veil: VoxelVeil,
        passed: &mut Passed,
    ) {
        let [column, second] = [&COLUMNS, &SECOND].each(|lanes| simd.load(lanes));
        let (zero, one, half) = (simd.splat(0.0), simd.splat(1.0), simd.splat(0.5));
        let [forward, upward] = self.senses;

        // Where it comes to the first column: distance, and how high there, from the block's border on the side it comes from.
        let near = |axis: usize, sense: f32| corner[axis] as f64 + if sense < 0.0 { SIDE } else { 0.0 };
        let (axis, other) = (self.axis, 1 - self.axis);
        let start = (near(axis, forward) - self.eye[axis]) * f64::from(forward) * self.per_column;
        let height = self.eye[other] + self.way[other] * start - near(other, upward);
        let height = simd.splat((height * f64::from(upward)) as f32);
        let climb = simd.splat(self.climb);
        let first = column.mul_add(climb, height);
        let voxel = first.floor();
        let border = ((voxel + one - first) * simd.splat(self.columns)).min(one);
        let voxel = voxel + second;

        // Columns from the first one's near side.
        let columns = [enter, leave].each(|at| simd.splat(((at - start) / self.per_column) as f32));
        let from = border.mul_add(second, column).max(columns[0]);
        let to = (one - border).mul_add(second, border + column).min(columns[1]);
        let last = SIDE as f32 - 1.0;
        let is_within = from.lt(to) & zero.le(voxel) & voxel.le(simd.splat(last));

        // Numbers of voxels go up to the east and to the north.
        let strides = [1.0, SIDE as f32];
        let origin = |axis: usize, sense: f32| if sense < 0.0 { last * strides[axis] } else { 0.0 };
        let place = simd.splat(origin(axis, forward) + origin(other, upward));
        let place = column.mul_add(simd.splat(strides[axis] * forward), place);
        let place = voxel.mul_add(simd.splat(strides[other] * upward), place).to_int();
        let top = simd.gather(tops, place);
        let per_column = simd.splat(self.per_column as f32);
        let distance = |column: V::F| (column - columns[0]).mul_add(per_column, simd.splat(enter as f32));
        let distances = [from, to].each(distance);

        // Whichever end it is deeper hidden at has the last word.
        let end = distances[usize::from(veil.per_unit < 0.0)];
        let hidden = end.mul_add(simd.splat(veil.per_unit as f32), simd.splat(veil.base as f32));
        passed.lanes = (is_within & zero.lt(top) & hidden.lt(top)).bits();
        if passed.lanes == 0 {
            return;
        }

        place.store(&mut passed.places);
        let centre = [column, voxel].each(|at| at + half);
        let senses = [forward, upward].each(|sense| simd.splat(sense));
        let depth = simd.splat(self.depth as f32);

        for end in 0..2 {
            let (column, distance) = ([from, to][end], distances[end]);
            let distance = distance.max(simd.splat(LEAST_DISTANCE as f32));
            distance.store(&mut passed.distances[end].0);
            (one / (depth * distance)).store(&mut passed.inverse[end].0);
            let height = column.mul_add(climb, height);
            ((column - centre[0]) * senses[0]).store(&mut passed.at[end][axis].0);
            ((height - centre[1]) * senses[1]).store(&mut passed.at[end][other].0);
        }
    }
}

impl Passed {
    /// Iterates over the voxels passed, from near to far.
    #[inline(always)]
    pub fn voxels(&self) -> impl Iterator<Item = PassedVoxel> {
        let mut lanes = self.lanes;
        std::iter::from_fn(move || {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes.wrapping_sub(1);
            (lane < LANES).then(|| PassedVoxel {
                place: self.places[lane] as usize,
                distances: self.distances.each_ref().each(|ends| ends.0[lane]),
                inverse: self.inverse.each_ref().each(|ends| ends.0[lane]),
                at: self.at.each_ref().each(|at| at.each_ref().each(|ends| ends.0[lane])),
            })
        })
    }
}
