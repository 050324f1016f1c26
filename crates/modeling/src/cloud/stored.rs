//! Solids as they stand in a temporary file.

use bytemuck::{Pod, Zeroable};

use super::super::features::{Solid, Wall};

/// A solid over a voxel of a tile.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct StoredSolid {
    /// NaN: it stands on the ground.
    low_m: f32,
    high_m: f32,
    slope: [f32; 2],
    /// Facings of its planes.
    facing: [f32; 3],
    distance_m: [f32; 3],
    opacity: f32,
    /// Column and row of its voxel in its tile.
    pub voxel: [u8; 2],
    wall: u8,
    flags: u8,
    top: [u8; 3],
    material: u8,
    side: [u8; 3],
    /// Nothing.
    rest: u8,
}

const PLANE: u8 = 1;
const ROUND: u8 = 2;
const CORNER: u8 = 3;
const WEDGE: u8 = 4;
const PARALLEL: u8 = 1;
const STRIP: u8 = 2;
const JOINED: [u8; 2] = [4, 8];

impl StoredSolid {
    /// A solid over a voxel, heights to a fraction of a millimetre.
    pub fn of(voxel: [u8; 2], solid: &Solid) -> Self {
        let nothing = (0.0, 0.0);
        let (wall, planes) = match solid.wall {
            Wall::Whole => (0, [nothing; 3]),
            Wall::Plane { facing, distance_m } => (PLANE, [(facing, distance_m), nothing, nothing]),
            Wall::Corner([one, other]) => (CORNER, [one, other, nothing]),
            Wall::Wedge(planes) => (WEDGE, planes),
            Wall::Round(facing) => (ROUND, [(facing, 0.0), nothing, nothing]),
        };

        let bit = |is: bool, bit: u8| if is { bit } else { 0 };
        Self {
            low_m: solid.low_m.map_or(f32::NAN, |low| low as f32),
            high_m: solid.high_m as f32,
            slope: solid.slope.map(|slope| slope as f32),
            facing: planes.map(|(facing, _)| facing as f32),
            distance_m: planes.map(|(_, distance_m)| distance_m as f32),
            opacity: solid.opacity as f32,
            voxel,
            wall,
            flags: bit(solid.parallel, PARALLEL)
                | bit(solid.strip, STRIP)
                | bit(solid.joined[0], JOINED[0])
                | bit(solid.joined[1], JOINED[1]),
            top: solid.top,
            material: solid.material,
            side: solid.side,
            rest: 0,
        }
    }

    /// The solid again.
    pub fn solid(&self) -> Solid {
        let planes =
            [0, 1, 2].map(|index| (f64::from(self.facing[index]), f64::from(self.distance_m[index])));
        let (facing, distance_m) = planes[0];

        Solid {
            low_m: Some(f64::from(self.low_m)).filter(|low| !low.is_nan()),
            high_m: f64::from(self.high_m),
            slope: self.slope.map(f64::from),
            wall: match self.wall {
                PLANE => Wall::Plane { facing, distance_m },
                CORNER => Wall::Corner([planes[0], planes[1]]),
                WEDGE => Wall::Wedge(planes),
                ROUND => Wall::Round(facing),
                _ => Wall::Whole,
            },
            top: self.top,
            side: self.side,
            opacity: f64::from(self.opacity),
            material: self.material,
            parallel: self.flags & PARALLEL != 0,
            strip: self.flags & STRIP != 0,
            joined: JOINED.map(|bit| self.flags & bit != 0),
            facade: None,
        }
    }

    /// Height of its upper end at the highest corner of a voxel of this side, metres.
    pub fn top_m(&self, spacing: f64) -> f64 {
        let [east, north] = self.slope.map(|slope| f64::from(slope.abs()));
        f64::from(self.high_m) + 0.5 * spacing * (east + north)
    }
}
