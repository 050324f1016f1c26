//! Land cover from outside: what `build`, `info --classes` and `height` say of it.

mod common;

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use common::{ends, run};

/// Ground of 600 m by 400 m, of which the west is water, and a house on the grass in the east.
fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).expect("a file");
    let rows = vec![vec!["100"; 60].join(" "); 40].join("\n");
    let head = "ncols 60\nnrows 40\nxllcorner 500000\nyllcorner 5000000\ncellsize 10\n";
    write("dem.asc", format!("{head}{rows}\n").as_bytes());
    let class = |column: usize| if column < 20 { 80 } else { 30 };
    let classes: Vec<u8> = (0..60 * 40).map(|pixel| class(pixel % 60)).collect();
    write("cover.bil", &classes);
    let head = "NROWS 40\nNCOLS 60\nNBANDS 1\nNBITS 8\nPIXELTYPE UNSIGNEDINT\nLAYOUT BIL\nULXMAP 500005\nULYMAP 5000395\nXDIM 10\nYDIM 10\n";
    write("cover.hdr", head.as_bytes());
    let ring = "[[500400,5000100],[500420,5000100],[500420,5000120],[500400,5000120],[500400,5000100]]";
    let house = format!(
        r#"{{"type":"FeatureCollection","crs":{{"type":"name","properties":{{"name":"urn:ogc:def:crs:EPSG::32632"}}}},"features":[{{"type":"Feature","properties":{{"building":"yes","height":9,"roof:shape":"flat","roof:material":"concrete"}},"geometry":{{"type":"Polygon","coordinates":[{ring}]}}}}]}}"#
    );
    write("house.geojson", house.as_bytes());
    folder
}

const BUILD: &str = "build --elevation dem.asc --elevation-crs EPSG:32632 --land-cover cover.bil --land-cover-crs EPSG:32632 --land-cover-scheme worldcover \
                     --features house.geojson --spacing 2 -o place.hop";

#[test]
fn areas_are_told_by_material() {
    let folder = site();
    ends(&run(&folder, BUILD), 0);
    assert!(!ends(&run(&folder, "info place.hop"), 0).contains("materials"));
    let told = ends(&run(&folder, "info --classes place.hop"), 0);
    for words in ["grass", "water, snow and ice", "buildings and pavement", "33.333 %", "spans"] {
        assert!(told.contains(words), "{words}: {told}");
    }
    let json: Value =
        serde_json::from_str(&ends(&run(&folder, "info --classes --json place.hop"), 0)).expect("JSON");
    let area = |name: &str| {
        let classes = json["classes"]["materials"].as_array().expect("a list");
        classes
            .iter()
            .find(|class| class["name"] == name)
            .map_or(f64::NAN, |class| class["area_km2"].as_f64().expect("a number"))
    };
    assert!((area("water") - 0.08).abs() < 1e-9 && (area("concrete") - 0.0004).abs() < 2e-5, "{json:#}");
    assert!((area("grass") + area("concrete") - 0.16).abs() < 1e-9, "{json:#}");
    assert_eq!(json["metadata"]["materials"][0]["name"], "water");
    let part = "info --json --bbox 500150,5000000,500250,5000100 place.hop";
    let json: Value = serde_json::from_str(&ends(&run(&folder, part), 0)).expect("JSON");
    let share = |at: usize| json["classes"]["materials"][at]["share"].as_f64().expect("a number");
    assert_eq!((share(0), share(1)), (0.5, 0.5));
    assert!(ends(&run(&folder, "info --bbox 1,1,0,0 place.hop"), 2).contains("west < east"));
}

#[test]
fn places_have_their_material() {
    let folder = site();
    ends(&run(&folder, BUILD), 0);
    let told = ends(&run(&folder, "height place.hop --xy 500101 5000100 500301 5000300 500410 5000110"), 0);
    let lines: Vec<&str> = told.lines().collect();
    assert!(lines[0].ends_with(", water") && lines[1].ends_with(", grass"), "{told}");
    assert!(lines[2].contains("109.") && lines[2].ends_with(", concrete"), "{told}");
}

#[test]
fn schemes_must_be_known() {
    let folder = site();
    let told = ends(&run(&folder, &BUILD.replace("worldcover", "clc")), 2);
    assert!(told.contains("worldcover, corine, nlcd"), "{told}");
    let told = ends(&run(&folder, &BUILD.replace("--land-cover-scheme worldcover", "")), 2);
    assert!(told.contains("--land-cover-scheme"), "{told}");
    let told = ends(&run(&folder, &BUILD.replace("worldcover", "nlcd")), 0);
    assert!(told.contains("80 (800 pixels)") && told.contains("30 (1600 pixels)"), "{told}");
    assert!(told.contains("is it of another scheme"), "{told}");
}
