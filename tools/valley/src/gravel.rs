//! A plant that sorts gravel: a bunker on legs with a house on it, and a belt that rises to where a heap lies. Its front is the belt's end.

use crate::voxels::Voxels;

/// Right, front, up: voxels of half a metre.
pub const SIZE: [usize; 3] = [15, 56, 26];

/// Colours, sRGB, by their numbers from 1 on.
pub const COLOURS: [[u8; 3]; 5] =
    [[92, 98, 102], [176, 160, 96], [150, 154, 152], [120, 78, 62], [54, 52, 50]];
const STEEL: u8 = 1;
const BUNKER: u8 = 2;
const WALLS: u8 = 3;
const ROOF: u8 = 4;
const BELT: u8 = 5;

/// Heights at which the legs end, the bunker ends, and the house ends: voxels above the ground.
const LEGS: usize = 8;
const BIN: usize = 14;
const EAVES: usize = 22;
/// Width and depth of the bunker, voxels.
const DEPTH: usize = 15;

/// All of it.
pub fn build() -> Voxels {
    let mut plant = Voxels::new(SIZE);
    for (x, y) in [(1, 1), (12, 1), (1, 12), (12, 12)] {
        plant.fill([x, y, 0], [x + 2, y + 2, LEGS], STEEL);
    }
    plant.fill([0, 0, LEGS], [DEPTH, DEPTH, BIN], BUNKER);
    plant.fill([0, 0, BIN], [DEPTH, DEPTH, EAVES], WALLS);
    plant.fill([0, 0, EAVES], [DEPTH, DEPTH, EAVES + 1], ROOF);
    plant.fill([5, 3, EAVES + 1], [10, 10, EAVES + 4], WALLS);
    belt(&mut plant);
    plant
}

/// Builds the belt from below the bunker up to the front, on two trestles.
fn belt(plant: &mut Voxels) {
    let rise = |y: usize| 4 + (y - 10) / 4;
    for y in 10..SIZE[1] {
        let low = rise(y);
        plant.fill([5, y, low], [10, y + 1, low + 1], STEEL);
        plant.fill([5, y, low + 1], [10, y + 1, low + 2], BELT);
    }
    for y in [24, 38] {
        for x in [5, 8] {
            plant.fill([x, y, 0], [x + 2, y + 2, rise(y)], STEEL);
        }
    }
}
