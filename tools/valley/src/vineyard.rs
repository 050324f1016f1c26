//! A vineyard on the eastern slope, an orchard below it, and the track to both, by OpenStreetMap's tags: all of it lines.

use crate::features::{Feature, Geometry};
use crate::noise::mix;
use crate::outline::Place;

/// Corners of the field that is planted: south-west, north-west, north-east, south-east.
pub const FIELD: [Place; 4] = [(1758.0, 1009.0), (1800.7, 1099.4), (1879.0, 1070.5), (1850.0, 978.7)];
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
const ORCHARD: [Place; 2] = [(1783.0, 1130.0), (1799.0, 1163.0)];
const NEXT: Place = (8.0, -3.6);
const ORCHARD_ROWS: usize = 3;

/// The track: from the farm's, past the gravel works, to the field's gate.
pub const TRACK: [Place; 8] = [
    (1645.0, 1124.0),
    (1664.0, 1128.0),
    (1690.0, 1134.0),
    (1712.0, 1133.0),
    (1740.0, 1124.0),
    (1764.0, 1122.0),
    (1785.0, 1112.0),
    (1801.0, 1094.0),
];
const TRACK_WIDTH: f64 = 3.0;

/// All features.
pub fn draw() -> Vec<Feature> {
    let mut features = vec![Feature::new(
        Geometry::Line(TRACK.to_vec()),
        [("highway", "track".into()), ("surface", "gravel".into()), ("width", TRACK_WIDTH.into())],
    )];
    let [south_west, north_west, north_east, south_east] = inset(0.5 * HEADLAND);

    // Its gate is where the track ends.
    let gate = between(north_west, south_west, 6.0);
    let beside = between(north_west, north_east, 6.0);
    features.push(Feature::new(
        Geometry::Line(vec![gate, south_west, south_east, north_east, beside]),
        [("barrier", "fence".into()), ("height", FENCE.into())],
    ));

    features.extend(vines().into_iter().zip(LEAVES.into_iter().cycle()).map(|(row, leaves)| {
        Feature::new(
            Geometry::Line(row.to_vec()),
            [("barrier", "hedge".into()), ("height", VINE.into()), ("colour", leaves.into())],
        )
    }));

    features.extend((0..ORCHARD_ROWS).map(|row| {
        let moved = |(x, y): Place| (x + row as f64 * NEXT.0, y + row as f64 * NEXT.1);
        Feature::new(
            Geometry::Line(ORCHARD.map(moved).to_vec()),
            [("natural", "tree_row".into()), ("height", 5.5.into()), ("leaf_type", "broadleaved".into())],
        )
    }));

    features
}

/// Rows of vines, up the slope, from the south.
pub fn vines() -> Vec<[Place; 2]> {
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
fn inset(by: f64) -> [Place; 4] {
    [0, 1, 2, 3].map(|k| {
        let (x, y) = FIELD[k];
        let [a, b] = [FIELD[(k + 1) % 4], FIELD[(k + 3) % 4]].map(|other| {
            let there = between((x, y), other, by);
            (there.0 - x, there.1 - y)
        });
        (x + a.0 + b.0, y + a.1 + b.1)
    })
}

fn part(a: Place, b: Place, t: f64) -> Place {
    (mix(a.0, b.0, t), mix(a.1, b.1, t))
}

/// The place so many metres from one towards another.
fn between(a: Place, b: Place, metres: f64) -> Place {
    part(a, b, metres / distance(a, b))
}

fn distance(a: Place, b: Place) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}
