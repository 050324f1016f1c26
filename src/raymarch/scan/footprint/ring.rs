//! Wedge of the area that groups of planes look at, ring by ring.

use glam::DVec3;

use super::super::{MarchField, PlaneGroup, Strides};
use crate::simd::{Each, LANES};
use crate::voxel::Grid;

/// Group of planes, and what of the surface is seen in it.
#[derive(Debug)]
pub struct FootprintGroup {
    /// The planes.
    pub group: PlaneGroup,
    /// Field that they are to see.
    pub field: MarchField,
}

/// Groups side by side.
pub(super) struct Wedge {
    /// The axis that they follow, of the eye and of voxels, and which way along it.
    pub major: usize,
    pub forward: f64,
    /// Units across per unit of major distance, least and greatest.
    pub minor: [f64; 2],
    pub drop: [f64; 2],
    /// Ground distance per unit of major distance, metres.
    pub ground: [f64; 2],
    /// Major distances between which some plane lies over the area, and between which all do.
    pub over: [f64; 2],
    pub inner: [f64; 2],
    /// Metres of height per unit of major distance: below the lowest rows, and above the highest.
    pub slopes: [f64; 2],
    /// Major distance before which all rays are above the highest surface.
    pub begin: f64,
}

/// A stretch along the major axis, with all that lies across it between the outermost planes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ring {
    /// Major distances.
    pub from: f64,
    pub to: f64,
    /// Units of the longest block in it.
    pub block: f64,
    /// Levels that some plane may read in it, finest and coarsest.
    pub levels: [u8; 2],
    /// Level of the bounds by which it is skipped; it may be none of the area's.
    pub skip_level: u8,
}

/// The rings of a wedge, nearest first. Each is as long as the longest block that some plane may read in it: one that is not hidden as a whole is
/// read as a whole. The last ones may lie beyond the area.
pub(super) struct Rings<'a> {
    strides: &'a Strides,
    /// The eye's place along the major axis, units.
    eye: f64,
    forward: f64,
    ground: [f64; 2],
    /// Major distance of the next ring.
    at: f64,
    /// Indices of the first and the last stride that some plane may have in the next ring, as far as they are known. They only grow.
    first: usize,
    last: usize,
}

/// Voxels of a level.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sides {
    /// The side of a voxel, units, and one over it.
    side: f64,
    per_unit: f64,
    /// The last one along each axis.
    last: [u32; 2],
}

/// Major distances of the multiples of `side` behind another, nearest first.
pub(super) fn edges_after(eye: f64, forward: f64, side: f64, distance: f64) -> impl Iterator<Item = f64> {
    let here = (eye + forward * distance) / side;
    let mut end = if forward > 0.0 { here.floor() } else { here.ceil() };
    let edges = std::iter::repeat_with(move || {
        end += forward;
        (end * side - eye) * forward
    });
    // Rounding may leave the first one where it was.
    edges.skip_while(move |edge| *edge <= distance)
}

impl Wedge {
    /// `ceiling`: height of the highest surface, metres above the eye.
    pub fn new(groups: &[FootprintGroup], ceiling: f64) -> Self {
        let extremes = |values: &mut dyn Iterator<Item = f64>| {
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
                [low.min(value), high.max(value)]
            })
        };
        let lanes = |of: &dyn Fn(&PlaneGroup) -> [f32; LANES]| {
            extremes(&mut groups.iter().flat_map(|own| of(&own.group)).map(f64::from))
        };
        let enter = lanes(&|group| group.over[0]);
        let leave = lanes(&|group| group.over[1]);
        let slopes = groups.iter().flat_map(|FootprintGroup { group, field }| {
            group.depth.map(|depth| field.tangents.each(|tangent| f64::from(tangent) * f64::from(depth)))
        });
        let slopes = slopes.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [least, most]| {
            [low.min(least), high.max(most)]
        });
        let begin = groups.iter().map(|own| f64::from(own.field.begin(&own.group, ceiling)));
        let first = &groups[0].group;

        Self {
            major: first.major,
            forward: first.forward,
            minor: lanes(&|group| group.minor),
            drop: lanes(&|group| group.drop),
            ground: extremes(&mut groups.iter().map(|own| own.group.ground)),
            over: [enter[0], leave[1]],
            inner: [enter[1], leave[0]],
            slopes,
            begin: begin.fold(f64::INFINITY, f64::min),
        }
    }

    /// Units across between the outermost planes, from one major distance to another.
    fn across(&self, from: f64, to: f64) -> [f64; 2] {
        let [low, high] = self.minor;
        [if low < 0.0 { low * to } else { low * from }, if high > 0.0 { high * to } else { high * from }]
    }

    /// Voxels, first and last along each axis, between two major distances, and so many units before and around.
    pub fn voxels(
        &self,
        eye: DVec3,
        sides: &Sides,
        [from, to]: [f64; 2],
        [before, around]: [f64; 2],
    ) -> [[u32; 2]; 2] {
        let ends = [
            eye[self.major] + self.forward * (from - before),
            eye[self.major] + self.forward * (to + around),
        ];
        let ends = if self.forward > 0.0 { ends } else { [ends[1], ends[0]] };
        let across = eye[1 - self.major];
        let [low, high] = self.across(from, to);
        let mut voxels = [[0; 2]; 2];
        voxels[self.major] = ends.each(|unit| sides.voxel(unit, self.major));
        voxels[1 - self.major] =
            [across + low - around, across + high + around].each(|unit| sides.voxel(unit, 1 - self.major));
        voxels
    }

    /// Voxels, first and last along each axis, between two major distances that lie on one of them.
    pub fn voxels_of_strip(&self, eye: DVec3, sides: &Sides, [from, to]: [f64; 2]) -> [[u32; 2]; 2] {
        let along = sides.voxel(eye[self.major] + self.forward * (from + to) / 2.0, self.major);
        let across = eye[1 - self.major];
        let mut voxels = [[along; 2]; 2];
        voxels[1 - self.major] =
            self.across(from, to).each(|units| sides.voxel(across + units, 1 - self.major));
        voxels
    }

    /// Major distance before which rings that lie farther than one in these voxels lie in them, too, with so many units around.
    pub fn within(&self, eye: DVec3, sides: &Sides, voxels: [[u32; 2]; 2], around: f64) -> f64 {
        let unit = |voxel: u32| f64::from(voxel) * sides.side;
        // Nothing of the area is beyond its first and last voxels.
        let border = |axis: usize| {
            let [first, last] = voxels[axis];
            let low = if first == 0 { f64::NEG_INFINITY } else { unit(first) };
            [low, if last >= sides.last[axis] { f64::INFINITY } else { unit(last + 1) }]
        };
        let [along, across] =
            [self.major, 1 - self.major].each(|axis| border(axis).each(|unit| unit - eye[axis]));
        let ahead = if self.forward > 0.0 { along[1] } else { -along[0] };
        let [low, high] = self.minor;
        let aside = [
            if low < 0.0 { (across[0] + around) / low } else { f64::INFINITY },
            if high > 0.0 { (across[1] - around) / high } else { f64::INFINITY },
        ];
        aside.into_iter().fold(ahead - around, f64::min)
    }
}

impl<'a> Rings<'a> {
    /// Iterates over the rings of `wedge` around `eye` from a major distance on.
    pub fn new(strides: &'a Strides, eye: DVec3, wedge: &Wedge, at: f64) -> Self {
        let Wedge { major, forward, ground, .. } = *wedge;
        Self { strides, eye: eye[major], forward, ground, at, first: 0, last: 0 }
    }

    fn edge_after(&self, side: f64, distance: f64) -> f64 {
        edges_after(self.eye, self.forward, side, distance).next().unwrap_or(distance + side)
    }

    /// Major distances between which some plane may have the stride `index`: the last block of a stride may reach beyond its distance.
    fn reach(&self, index: usize) -> [f64; 2] {
        let (stride, until) = self.strides.with_end(index);
        [stride.from / self.ground[1], until / self.ground[0] + stride.block_units()]
    }

    /// Returns the part of a ring that may be read at a level: others may be before and behind it.
    pub fn part_of_level(&self, ring: &Ring, level: u8) -> [f64; 2] {
        if ring.levels[0] == ring.levels[1] {
            return [ring.from, ring.to];
        }
        let own = (self.first..=self.last).filter(|index| self.strides.get(*index).level == level);
        let own = own.map(|index| self.reach(index));
        let [begin, end] =
            own.fold([f64::INFINITY, 0.0], |[begin, end], [from, to]| [from.min(begin), to.max(end)]);
        let (begin, end) = (begin.max(ring.from), end.min(ring.to));
        [begin.min(end), end]
    }

    /// The next one.
    pub fn next_ring(&mut self) -> Ring {
        let from = self.at;
        while self.reach(self.first)[1] <= from {
            self.first += 1;
        }
        self.last = self.last.max(self.first);
        let (last, to) = loop {
            let last = self.strides.get(self.last);
            let side = 64.0 * f64::from(Grid::side_units(last.level));
            let to = self.edge_after(side, from);
            if self.strides.with_end(self.last).1 > to * self.ground[1] {
                break (last, to);
            }
            self.last += 1;
        };
        self.at = to;
        let levels = [self.strides.get(self.first).level, last.level];
        Ring { from, to, block: last.block_units(), levels, skip_level: last.skip_level() }
    }
}

impl Sides {
    /// Returns the sides of voxels of `level`.
    pub fn new(grid: &Grid, level: u8) -> Self {
        let side = f64::from(Grid::side_units(level));
        let (nx, ny) = grid.dims(level);
        Self { side, per_unit: 1.0 / side, last: [nx - 1, ny - 1] }
    }

    /// Converts a count of voxels to units.
    pub fn units(&self, voxels: f64) -> f64 {
        voxels * self.side
    }

    fn voxel(&self, unit: f64, axis: usize) -> u32 {
        // What is negative becomes 0.
        ((unit * self.per_unit) as u32).min(self.last[axis])
    }
}
