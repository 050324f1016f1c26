//! A wayside chapel: nave with an apse, and a tower with a spire before it. Metres: right, up, front; its front is the tower's.

use std::f32::consts::FRAC_1_SQRT_2;

use crate::mesh::{Corner, Part};

/// Half the nave's width; its back and front; heights of its eaves and its ridge.
const NAVE: f32 = 3.2;
const BACK: f32 = -6.0;
const FRONT: f32 = 4.0;
const EAVES: f32 = 4.4;
const RIDGE: f32 = 8.0;
/// Half the tower's width, how far it stands out, and its height.
const TOWER: f32 = 1.9;
const PORCH: f32 = 6.4;
const BELFRY: f32 = 11.0;
/// The spire's tip, and the cross on it.
const TIP: f32 = 19.0;
const CROSS: f32 = 20.6;
/// The plinth: how high it is, and how far it stands out.
const PLINTH: f32 = 0.7;
const LEDGE: f32 = 0.35;

/// All of it, by material.
pub fn build() -> Vec<Part> {
    let (x, z) = (NAVE + LEDGE, LEDGE);
    let stone = Part::new("stone", [0.28, 0.26, 0.23])
        .block([-x, 0.0, BACK - z], [x, PLINTH, FRONT + z])
        .block([-TOWER - z, 0.0, FRONT], [TOWER + z, PLINTH, PORCH + z])
        .add(&apse(2.6 + z, 0.0), &apse(2.6 + z, PLINTH));
    let plaster = Part::new("plaster", [0.62, 0.57, 0.46])
        .block([-NAVE, PLINTH, BACK], [NAVE, EAVES, FRONT])
        .add(&gable(NAVE, EAVES, RIDGE - 0.3, BACK), &gable(NAVE, EAVES, RIDGE - 0.3, FRONT))
        .block([-TOWER, PLINTH, FRONT - 1.0], [TOWER, BELFRY, PORCH])
        .add(&apse(2.6, PLINTH), &apse(2.6, 4.0));
    let tiles = Part::new("tiles", [0.22, 0.075, 0.045])
        .add(&rafter(-1.0, BACK - 0.4), &rafter(-1.0, FRONT + 0.3))
        .add(&rafter(1.0, BACK - 0.4), &rafter(1.0, FRONT + 0.3))
        .add(&apse(3.0, 4.0), &apse(0.2, 6.8));
    let shingles = Part::new("shingles", [0.36, 0.335, 0.30])
        .add(&square(TOWER + 0.35, BELFRY), &square(TOWER - 0.4, BELFRY + 1.6))
        .add(&square(TOWER - 0.4, BELFRY + 1.6), &square(0.08, TIP));
    let iron = Part::new("iron", [0.05, 0.05, 0.05])
        .block([-0.1, TIP - 0.2, MIDDLE - 0.1], [0.1, CROSS, MIDDLE + 0.1])
        .block([-0.5, CROSS - 0.7, MIDDLE - 0.1], [0.5, CROSS - 0.5, MIDDLE + 0.1]);
    let panes = [-4.2, -1.2, 1.8].into_iter().fold(Part::new("panes", [0.03, 0.035, 0.05]), |panes, at| {
        panes
            .block([-NAVE - 0.06, 1.8, at - 0.5], [-NAVE + 0.1, 3.7, at + 0.5])
            .block([NAVE - 0.1, 1.8, at - 0.5], [NAVE + 0.06, 3.7, at + 0.5])
    });

    vec![stone, plaster, tiles, shingles, iron, panes]
}

/// The tower's middle.
const MIDDLE: f32 = 0.5 * (FRONT - 1.0 + PORCH);

/// Half of an octagon behind the nave.
fn apse(radius: f32, y: f32) -> [Corner; 5] {
    let slant = FRAC_1_SQRT_2;
    [(1.0, 0.0), (slant, slant), (0.0, 1.0), (-slant, slant), (-1.0, 0.0)]
        .map(|(right, back)| [radius * right, y, BACK - radius * back])
}

/// The triangle of a gable.
fn gable(half: f32, low: f32, high: f32, z: f32) -> [Corner; 3] {
    [[-half, low, z], [half, low, z], [0.0, high, z]]
}

/// A slope of the roof, cut across: 0.3 m thick, on the side that has the sign.
fn rafter(side: f32, z: f32) -> [Corner; 4] {
    let eaves = [side * (NAVE + 0.5), EAVES - 0.55];
    let corner = |[x, y]: [f32; 2]| [x, y, z];
    let ring = [eaves, [0.0, RIDGE - 0.3], [0.0, RIDGE], [eaves[0], eaves[1] + 0.3]].map(corner);
    if side < 0.0 { ring } else { [ring[3], ring[2], ring[1], ring[0]] }
}

/// A square about the tower's middle.
fn square(half: f32, y: f32) -> [Corner; 4] {
    [[-half, y, MIDDLE + half], [half, y, MIDDLE + half], [half, y, MIDDLE - half], [-half, y, MIDDLE - half]]
}
