//! `hedgehop shadow-heights` from outside: a photograph, outlines and elevation in, a database with the buildings out.

use std::fs;

use image::{Rgb, RgbImage};
use serde_json::Value;
use tempfile::TempDir;

use crate::common::{ends, run};

/// Pixels of a metre along a side.
const SIDE: u32 = 320;
/// South-west corner, metres of EPSG:32632 on the zone's middle meridian.
const CORNER: [f64; 2] = [500_000.0, 5_000_000.0];
/// The sun, degrees.
const AZIMUTH: f64 = 225.0;
const ELEVATION: f64 = 35.0;

/// West, south, east, north from the corner, and heights above the lowest ground, metres.
const BUILDINGS: [([f64; 4], f64); 4] = [
    ([40.0, 40.0, 60.0, 54.0], 9.0),
    ([120.0, 60.0, 136.0, 90.0], 21.0),
    ([60.0, 180.0, 96.0, 196.0], 14.5),
    ([200.0, 200.0, 212.0, 224.0], 33.0),
];

/// A slope.
fn ground([x, y]: [f64; 2]) -> f64 {
    300.0 + 0.06 * x - 0.04 * y
}

fn roof([west, south, east, north]: [f64; 4], height: f64) -> f64 {
    let corners = [[west, south], [east, south], [west, north], [east, north]];
    corners.map(ground).into_iter().fold(f64::INFINITY, f64::min) + height
}

/// Whether the ray from a place towards the sun meets a building within 60 m: it enters between the walls below the roof.
fn is_shaded(place: [f64; 2], direction: [f64; 2], rise: f64) -> bool {
    let ground = ground(place);
    BUILDINGS.into_iter().any(|(walls, height)| {
        let [west, south, east, north] = walls;
        let between = |low: f64, high: f64, axis: usize| {
            let ends = [low, high].map(|wall| (wall - place[axis]) / direction[axis]);
            (ends[0].min(ends[1]), ends[0].max(ends[1]))
        };
        let (x, y) = (between(west, east, 0), between(south, north, 1));
        let (enter, leave) = (x.0.max(y.0).max(0.0), x.1.min(y.1).min(60.0));
        enter < leave && ground + enter * rise < roof(walls, height)
    })
}

fn holds([west, south, east, north]: [f64; 4], [x, y]: [f64; 2]) -> bool {
    x > west && x < east && y > south && y < north
}

/// Light on a place.
fn light(place: [f64; 2]) -> f64 {
    if BUILDINGS.iter().any(|(walls, _)| holds(*walls, place)) {
        return 0.5;
    }
    let (sin, cos) = AZIMUTH.to_radians().sin_cos();
    if is_shaded(place, [sin, cos], ELEVATION.to_radians().tan()) { 0.05 } else { 0.25 }
}

fn photograph() -> RgbImage {
    RgbImage::from_fn(SIDE, SIDE, |column, row| {
        let part = |number: u32| 0.25 + 0.5 * f64::from(number);
        let places = (0..4)
            .map(|index| [f64::from(column) + part(index % 2), f64::from(SIDE - row) - part(index / 2)]);
        let mean = 0.25 * places.map(light).sum::<f64>();
        // Some texture.
        let grain = 1.0 + 0.15 * (f64::from(column) * 0.9).sin() * (f64::from(row) * 1.3).cos();
        let code = (255.0 * (mean * grain).powf(1.0 / 2.2)).round() as u8;
        Rgb([code, code, code])
    })
}

/// A folder with a photograph, elevation and outlines.
fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    photograph().save(folder.path().join("ortho.png")).expect("a picture");
    let [x, y] = CORNER;
    let side = f64::from(SIDE);
    write("ortho.pgw", &format!("1\n0\n0\n-1\n{}\n{}\n", x + 0.5, y + side - 0.5));

    let rows: Vec<String> = (0..SIDE)
        .map(|row| {
            let heights =
                (0..SIDE).map(|column| ground([f64::from(column) + 0.5, side - f64::from(row) - 0.5]));
            heights.map(|height| format!("{height:.3}")).collect::<Vec<_>>().join(" ")
        })
        .collect();

    write(
        "dem.asc",
        &format!(
            "ncols {SIDE}\nnrows {SIDE}\nxllcorner {x}\nyllcorner {y}\ncellsize 1\n{}\n",
            rows.join("\n")
        ),
    );

    let features: Vec<String> = BUILDINGS
        .iter()
        .map(|([west, south, east, north], _)| {
            let (west, south, east, north) = (x + west, y + south, x + east, y + north);
            format!(
                r#"{{"type":"Feature","properties":{{"building":"yes","roof:shape":"flat"}},"geometry":{{"type":"Polygon","coordinates":[[[{west},{south}],[{east},{south}],[{east},{north}],[{west},{north}],[{west},{south}]]]}}}}"#
            )
        })
        .collect();

    let crs = r#""crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::32632"}}"#;
    write(
        "town.geojson",
        &format!(r#"{{"type":"FeatureCollection",{crs},"features":[{}]}}"#, features.join(",")),
    );
    write(
        "place.toml",
        "[[elevation]]\nfile = \"dem.asc\"\ncrs = \"EPSG:32632\"\n[[features]]\nfile = \"heights.geojson\"\n",
    );

    folder
}

const RASTERS: &str =
    "--imagery ortho.png --imagery-crs EPSG:32632 --elevation dem.asc --elevation-crs EPSG:32632";

#[test]
fn a_photograph_gives_heights_that_a_database_takes() {
    let folder = site();
    let flags = format!("shadow-heights town.geojson --sun {AZIMUTH},{ELEVATION} {RASTERS}");
    let told = ends(&run(&folder, &format!("{flags} -o heights.geojson")), 0);
    assert!(told.contains("4 of 4 buildings have got a height: 4 from the picture"), "{told}");
    let text = fs::read_to_string(folder.path().join("heights.geojson")).expect("heights");
    let found: Value = serde_json::from_str(&text).expect("GeoJSON");
    ends(&run(&folder, "build place.toml"), 0);

    for (number, ([west, south, east, north], height)) in BUILDINGS.into_iter().enumerate() {
        let properties = &found["features"][number]["properties"];
        let measured = properties["height"].as_f64().expect("a height");
        assert!((measured - height).abs() < 0.5, "{height} m is measured as {measured} m");
        assert!(properties["height_error"].as_f64().is_some_and(|error| error < 1.0), "{properties}");
        let [x, y] = [CORNER[0] + 0.5 * (west + east), CORNER[1] + 0.5 * (south + north)];
        let told = ends(&run(&folder, &format!("height place.hop --xy {x} {y} --json")), 0);
        let top: Value = serde_json::from_str(&told).expect("JSON");
        let top = top[0]["height_m"].as_f64().expect("a height");
        assert!((top - roof([west, south, east, north], height)).abs() < 0.6, "{top}");
    }

    // Once more it is refused, and with other threads it is the same.
    let told = ends(&run(&folder, &format!("{flags} -o heights.geojson")), 2);
    assert!(told.contains("--overwrite"), "{told}");
    ends(&run(&folder, &format!("{flags} --jobs 1 -o other.geojson")), 0);
    assert_eq!(fs::read_to_string(folder.path().join("other.geojson")).expect("heights"), text);
}

#[test]
fn stated_shadows_need_no_picture_and_a_time_needs_a_zone() {
    let folder = TempDir::new().expect("a temporary folder");
    let ring = "POLYGON ((0 45, 0.001 45, 0.001 45.001, 0 45.001, 0 45))";
    let table = format!("name,polygon,shadow_length\nhall,\"{ring}\",100\nshed,\"{ring}\",\n");
    fs::write(folder.path().join("a.csv"), table).expect("a table");

    // At noon of an equinox the sun stands as high as the complement of the latitude.
    let told = ends(&run(&folder, "shadow-heights a.csv --time 2024-03-20T12:00Z -o b.csv"), 0);
    assert!(told.contains("1 of 2 buildings") && told.contains("shed") | told.contains("line 3"), "{told}");
    let text = fs::read_to_string(folder.path().join("b.csv")).expect("a table");
    let hall = text.lines().nth(1).expect("a row");
    let height: f64 = hall.split(',').rev().nth(2).and_then(|cell| cell.parse().ok()).expect("a height");
    assert!((height - 100.0).abs() < 1.5, "{text}");

    for (flags, code, word) in [
        ("a.csv --time 2024-03-20T12:00 -o c.csv", 2, "offset from UTC"),
        ("a.csv --time 2024-03-20T01:00Z -o c.csv", 2, "above the horizon"),
        ("a.csv -o c.csv", 2, "--time"),
        ("a.csv --sun 180,45 -o c.tif", 2, ".geojson or .csv"),
        ("a.csv --sun 180,45 -o a.csv --overwrite", 2, "is an input"),
        ("none.csv --sun 180,45 -o c.csv", 5, "none.csv"),
    ] {
        let told = ends(&run(&folder, &format!("shadow-heights {flags}")), code);
        assert!(told.contains(word), "{flags}: {told}");
        assert!(!folder.path().join("c.csv").exists());
    }
}

#[test]
fn buildings_beside_the_picture_are_named() {
    let folder = site();
    let text = fs::read_to_string(folder.path().join("town.geojson")).expect("outlines");
    // The first one is moved by 10 km.
    fs::write(
        folder.path().join("far.geojson"),
        text.replace("5000040", "5010040").replace("5000054", "5010054"),
    )
    .expect("outlines");
    let flags = "--imagery ortho.png --imagery-crs EPSG:32632 -o heights.geojson";
    let told =
        ends(&run(&folder, &format!("shadow-heights far.geojson --sun {AZIMUTH},{ELEVATION} {flags}")), 0);
    assert!(
        told.contains("feature 1 is left without a height: the ground behind it is not in the picture"),
        "{told}"
    );
    assert!(told.contains("3 of 4 buildings"), "{told}");
}
