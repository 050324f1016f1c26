//! A vineyard on the eastern slope, an orchard below it, and the track to both, by OpenStreetMap's tags: all of it lines.

use glam::{DVec2, dvec2};

use crate::features::{Feature, Geometry, Tag};
use crate::noise::mix;

/// Corners of the field that is planted: south-west, north-west, north-east, south-east.
pub const FIELD: [DVec2; 4] =
    [dvec2(1758.0, 1009.0), dvec2(1800.7, 1099.4), dvec2(1879.0, 1070.5), dvec2(1850.0, 978.7)];
/// Margin that is left free along the field's sides, metres; the fence runs in the middle of it.
const HEADLAND: f64 = 7.0;
/// Distance of the vines' rows, metres.
pub const ROWS: f64 = 5.0;
/// Height of the vines and of the fence, metres.
const VINE: f64 = 1.6;
const FENCE: f64 = 1.1;
/// Colours of rows in turn, sRGB.
const LEAVES: [&str; 3] = ["#5f7a36", "#6b8240", "#587030"];

/// The orchard's first row, and the step to the next.
const ORCHARD: [DVec2; 2] = [dvec2(1783.0, 1130.0), dvec2(1799.0, 1163.0)];
const NEXT: DVec2 = dvec2(8.0, -3.6);
const ORCHARD_ROWS: usize = 3;

/// The track: from the farm's, past the gravel works, to the field's gate.
pub const TRACK: [DVec2; 8] = [
    dvec2(1645.0, 1124.0),
    dvec2(1664.0, 1128.0),
    dvec2(1690.0, 1134.0),
    dvec2(1712.0, 1133.0),
    dvec2(1740.0, 1124.0),
    dvec2(1764.0, 1122.0),
    dvec2(1785.0, 1112.0),
    dvec2(1801.0, 1094.0),
];
const TRACK_WIDTH: f64 = 3.0;

/// All features.
pub fn draw() -> Vec<Feature> {
    let mut features = vec![Feature::new(
        Geometry::Line(TRACK.to_vec()),
        [Tag::new("highway", "track"), Tag::new("surface", "gravel"), Tag::new("width", TRACK_WIDTH)],
    )];
    let [south_west, north_west, north_east, south_east] = inset(0.5 * HEADLAND);

    // Its gate is where the track ends.
    let gate = between(north_west, south_west, 6.0);
    let beside = between(north_west, north_east, 6.0);
    features.push(Feature::new(
        Geometry::Line(vec![gate, south_west, south_east, north_east, beside]),
        [Tag::new("barrier", "fence"), Tag::new("height", FENCE)],
    ));

    features.extend(vines().into_iter().zip(LEAVES.into_iter().cycle()).map(|(row, leaves)| {
        Feature::new(
            Geometry::Line(row.to_vec()),
            [Tag::new("barrier", "hedge"), Tag::new("height", VINE), Tag::new("colour", leaves)],
        )
    }));

    features.extend((0..ORCHARD_ROWS).map(|row| {
        let moved = |place: DVec2| place + row as f64 * NEXT;
        Feature::new(
            Geometry::Line(ORCHARD.map(moved).to_vec()),
            [Tag::new("natural", "tree_row"), Tag::new("height", 5.5), Tag::new("leaf_type", "broadleaved")],
        )
    }));

    features
}

/// Rows of vines, up the slope, from the south.
pub fn vines() -> Vec<[DVec2; 2]> {
    let [south_west, north_west, north_east, south_east] = inset(HEADLAND);
    let deep = distance(south_west, north_west);
    let count = (deep / ROWS) as usize;
    let row = |k| {
        let along = k as f64 / count as f64;
        [part(south_west, north_west, along), part(south_east, north_east, along)]
    };
    (0..=count).map(row).collect()
}

/// The field's corners, moved `by` metres inward along both sides of each.
fn inset(by: f64) -> [DVec2; 4] {
    [0, 1, 2, 3].map(|k| {
        let corner = FIELD[k];
        let [a, b] =
            [FIELD[(k + 1) % 4], FIELD[(k + 3) % 4]].map(|other| between(corner, other, by) - corner);
        corner + a + b
    })
}

fn part(a: DVec2, b: DVec2, t: f64) -> DVec2 {
    dvec2(mix(a.x, b.x, t), mix(a.y, b.y, t))
}

/// The place so many metres from one towards another.
fn between(a: DVec2, b: DVec2, metres: f64) -> DVec2 {
    part(a, b, metres / distance(a, b))
}

fn distance(a: DVec2, b: DVec2) -> f64 {
    (a.x - b.x).hypot(a.y - b.y)
}
