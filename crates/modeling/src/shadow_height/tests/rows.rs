//! Layers with stated shadows, and what is written of them.

use std::fs;
use std::path::PathBuf;

use tempfile::TempDir;

use super::super::{Answer, shadow_heights};
use crate::features::{self, LayerOptions, Value};
use crate::shadow_height::{ShadowOptions, ShadowReport};
use hedgehop::sunlight::{Sun, SunSetting};
use hedgehop_base::progress::Silent;

pub(super) fn options(buildings: PathBuf) -> ShadowOptions {
    ShadowOptions {
        buildings,
        layer: LayerOptions::default(),
        sun: SunSetting::At(Sun { azimuth: 180.0, elevation: 45.0 }),
        elevation: Vec::new(),
        imagery: Vec::new(),
        local: false,
        raw_spacing: None,
        highest_m: 100.0,
        all: false,
        threads: 2,
    }
}

fn report(folder: &TempDir, name: &str, text: &str) -> ShadowReport {
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    shadow_heights(&options(path), &Silent).unwrap()
}

const RING: &str =
    "[[[500000.10,5200000.0],[500020,5200000],[500020,5200020],[500000.10,5200020],[500000.10,5200000.0]]]";
const CRS: &str = r#""crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::32632"}}"#;

#[test]
fn geojson_stays_as_it_was_but_for_the_heights() {
    let folder = tempfile::tempdir().unwrap();
    let feature = |properties: &str| {
        format!(
            r#"{{"id":7.10,"type":"Feature","geometry":{{"type":"Polygon","coordinates":{RING}}},"properties":{properties}}}"#
        )
    };

    let rows = [
        feature(r#"{"zeta":1e2,"shadow_length":12.50,"name":"a\u00e9","shadow_note":"old"}"#),
        feature(r#"{"shadow_tip":[500010,5200035],"height":null}"#),
        feature(r#"{"height":"30 ft"}"#),
        feature("null"),
        feature(r#"{"shadow_length":"long"}"#),
        r#"{"type":"Feature","properties":{"shadow_length":4},"geometry":{"type":"Point","coordinates":[500000,5200000]}}"#.to_owned(),
    ];

    let text = format!(r#"{{"type":"FeatureCollection",{CRS},"features":[{}]}}"#, rows.join(","));
    let report = report(&folder, "a.geojson", &text);
    let written = report.geojson().unwrap();
    let lines: Vec<&str> = written.lines().collect();
    assert_eq!(lines[0], format!(r#"{{"type":"FeatureCollection",{CRS},"features":["#));
    let wanted =
        feature(r#"{"zeta":1e2,"shadow_length":12.50,"name":"a\u00e9","height":12.5,"height_error":0.5}"#);
    assert_eq!(lines[1], format!("{wanted},"));

    // The grid's scale there is 0.9996: 15 m of it are 15.006 m.
    let wanted =
        feature(r#"{"shadow_tip":[500010,5200035],"height":15.01,"height_error":0.5,"shadow_length":15.01}"#);
    assert_eq!(lines[2], format!("{wanted},"));
    assert_eq!(lines[3], format!("{},", rows[2]));
    assert!(lines[4].contains(r#""properties":{"shadow_note":"it states no shadow_length"#), "{}", lines[4]);
    assert!(lines[5].contains(r#"its shadow_length is \"long\""#), "{}", lines[5]);
    assert!(lines[6].contains("it has no area"), "{}", lines[6]);
    assert!(report.notes.iter().any(|note| note.contains("ground is taken as level")), "{:?}", report.notes);

    // A second time nothing changes: all that could be measured has a height.
    let again = folder.path().join("b.geojson");
    fs::write(&again, &written).unwrap();
    let again = shadow_heights(&options(again), &Silent).unwrap();
    assert_eq!(again.geojson().unwrap(), written);
}

#[test]
fn bare_geometries_and_lines_of_features_are_kept_apart() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!(
        "\u{1e}{{\"type\":\"Polygon\",{CRS},\"coordinates\":{RING}}}\n{{\"type\":\"Feature\",\"properties\":{{\"shadow_length\":3}},\"geometry\":{{\"type\":\"Polygon\",\"coordinates\":{RING}}}}}\n"
    );
    let written = report(&folder, "a.json", &text).geojson().unwrap();
    let lines: Vec<&str> = written.lines().collect();
    assert!(
        lines[0].starts_with(&format!(r#"{{"type":"Feature",{CRS},"properties":{{"shadow_note""#)),
        "{written}"
    );
    assert!(lines[1].contains(r#""properties":{"shadow_length":3,"height":3"#), "{written}");
    let path = folder.path().join("b.json");
    fs::write(&path, &written).unwrap();
    assert_eq!(features::read(&path, &LayerOptions::default()).unwrap().rows.len(), 2);
}

#[test]
fn tables_come_back_as_tables_and_as_features() {
    let folder = tempfile::tempdir().unwrap();
    let text = "name;polygon;shadow_length\n\
        \"b;c\";POLYGON ((11 47, 11.0003 47, 11.0003 47.0002, 11 47.0002, 11 47));20.0\n\
        none;POLYGON ((11 47, 11.0003 47, 11.0003 47.0002, 11 47.0002, 11 47));\n\
        bad;;3\n";
    let report = report(&folder, "a.csv", text);
    let lines: Vec<String> = report.csv().unwrap().lines().map(str::to_owned).collect();
    assert_eq!(lines[0], "name;polygon;shadow_length;height;height_error;shadow_note");
    assert!(
        lines[1].starts_with("\"b;c\";POLYGON ((11 47,") && lines[1].ends_with(";20.0;20.0;0.5;"),
        "{}",
        lines[1]
    );
    assert!(lines[2].contains("it states no shadow_length") && lines[3].starts_with("bad;;3;;"), "{lines:?}");
    let path = folder.path().join("b.geojson");
    fs::write(&path, report.geojson().unwrap()).unwrap();
    let layer = features::read(&path, &LayerOptions::default()).unwrap();
    assert_eq!(layer.rows[0].attributes.get("height"), Some(&Value::Number(20.0)));
    assert_eq!(layer.rows[0].geometry, report.layer.rows[0].geometry);
}

#[test]
fn shapefiles_become_geojson_in_their_own_system() {
    let sample = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/features/buildings.shp");
    let report = shadow_heights(&options(sample.clone()), &Silent).unwrap();
    assert!(report.answers.iter().all(|answer| !matches!(answer, Answer::Height(_))));
    let folder = tempfile::tempdir().unwrap();
    let before = features::read(&sample, &LayerOptions::default()).unwrap();

    for (name, text) in [("a.geojson", report.geojson().unwrap()), ("a.csv", report.csv().unwrap())] {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        let options =
            LayerOptions { crs: Some(before.crs.proj().unwrap().to_owned()), ..LayerOptions::default() };
        let after = features::read(&path, &options).unwrap();
        assert!(after.crs.is_equivalent(&before.crs));

        for (a, b) in before.rows.iter().zip(&after.rows) {
            assert_eq!(
                a.geometry.areas.iter().map(|area| area.outer.places.clone()).collect::<Vec<_>>(),
                b.geometry.areas.iter().map(|area| area.outer.places.clone()).collect::<Vec<_>>()
            );
            assert!(b.attributes.iter().count() >= a.attributes.iter().count());
        }
    }
}
