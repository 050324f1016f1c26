//! Places that are chosen and do not follow from the terrain: airstrip, farm, tanks, power line. Metres in the area.

use glam::{DVec2, dvec2};

/// Middle of the airstrip.
pub const STRIP: DVec2 = dvec2(1175.0, 690.0);
/// Direction of the airstrip, degrees clockwise from grid north; its length and width, metres.
pub const STRIP_DIRECTION: f64 = 15.0;
pub const STRIP_SIZE: DVec2 = dvec2(660.0, 30.0);
/// Margin that is kept free besides: before its ends and beside it.
const STRIP_VERGE: DVec2 = dvec2(40.0, 12.0);

/// West, south, east, north of the farm that was scanned.
pub const FARM: [f64; 4] = [1660.0, 1270.0, 1750.0, 1350.0];
/// Knots of the track to it; the first is moved onto the main road.
pub const FARM_TRACK: [DVec2; 6] = [
    dvec2(1525.0, 997.0),
    dvec2(1584.0, 984.0),
    dvec2(1618.0, 1030.0),
    dvec2(1640.0, 1110.0),
    dvec2(1664.0, 1205.0),
    dvec2(1684.0, 1268.0),
];

/// West, south, east, north of the yard of tanks.
pub const TANKS: [f64; 4] = [1650.0, 770.0, 1710.0, 822.0];

/// Places of the power line's pylons, from the south-east.
pub const LINE: [DVec2; 8] = [
    dvec2(2100.0, 1390.0),
    dvec2(1931.0, 1451.0),
    dvec2(1764.0, 1515.0),
    dvec2(1585.0, 1579.0),
    dvec2(1450.0, 1690.0),
    dvec2(1310.0, 1800.0),
    dvec2(1270.0, 1930.0),
    dvec2(1210.0, 2120.0),
];

/// A use that keeps the ground free of woods, crops and hedges.
pub enum Kept {
    /// The airstrip; metres along it from its middle.
    Strip {
        along: f64,
    },
    /// Grass around it.
    Verge,
    Farm,
    Tanks,
}

/// The use of a place, if it has one.
pub fn kept(x: f64, y: f64) -> Option<Kept> {
    let (along, across) = along_strip(x, y);
    let (length, width) = (STRIP_SIZE.x / 2.0, STRIP_SIZE.y / 2.0);
    if along.abs() < length && across.abs() < width {
        return Some(Kept::Strip { along });
    }
    if along.abs() < length + STRIP_VERGE.x && across.abs() < width + STRIP_VERGE.y {
        return Some(Kept::Verge);
    }
    if beside(FARM, x, y) <= 0.0 {
        return Some(Kept::Farm);
    }
    (beside(TANKS, x, y) <= 0.0).then_some(Kept::Tanks)
}

/// Whether a tree may stand at a place with a crown of that radius.
pub fn bears_tree(x: f64, y: f64, radius: f64) -> bool {
    let (along, across) = along_strip(x, y);
    let free = radius + 4.0;
    let on_strip = along.abs() < STRIP_SIZE.x / 2.0 + STRIP_VERGE.x + free
        && across.abs() < STRIP_SIZE.y / 2.0 + STRIP_VERGE.y + free;
    !on_strip && beside(FARM, x, y) > free && beside(TANKS, x, y) > free && beside_line(x, y) > free + 6.0
}

/// Ends of the airstrip, the southern one first.
pub fn strip_ends() -> [DVec2; 2] {
    let (s, c) = STRIP_DIRECTION.to_radians().sin_cos();
    [-0.5, 0.5].map(|part| {
        let along = part * STRIP_SIZE.x;
        dvec2(STRIP.x + along * s, STRIP.y + along * c)
    })
}

/// Distance from the power line, metres.
pub fn beside_line(x: f64, y: f64) -> f64 {
    let spans = LINE.windows(2).map(|pair| {
        let [DVec2 { x: ax, y: ay }, DVec2 { x: bx, y: by }] = [pair[0], pair[1]];
        let (dx, dy) = (bx - ax, by - ay);
        let t = (((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
        (x - ax - t * dx).hypot(y - ay - t * dy)
    });
    spans.fold(f64::INFINITY, f64::min)
}

fn along_strip(x: f64, y: f64) -> (f64, f64) {
    let (s, c) = STRIP_DIRECTION.to_radians().sin_cos();
    let (dx, dy) = (x - STRIP.x, y - STRIP.y);
    (dx * s + dy * c, dx * c - dy * s)
}

/// Returns how far a place lies outside of a rectangle; 0 or less in it.
pub fn beside([west, south, east, north]: [f64; 4], x: f64, y: f64) -> f64 {
    (west - x).max(x - east).max(south - y).max(y - north)
}

/// About where the mast stands: on the highest ground nearby.
pub const MAST: DVec2 = dvec2(1181.0, 1906.0);
