//! `build --features` and `[[features]]` from outside.

use std::fs;

use tempfile::TempDir;

use crate::common::{ends, run};

/// A folder with level ground of 300 m, and a house and a road on it.
fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    let rows = vec![vec!["50"; 300].join(" "); 300].join("\n");
    write(
        "dem.asc",
        &format!("ncols 300\nnrows 300\nxllcorner 500000\nyllcorner 5000000\ncellsize 1\n{rows}\n"),
    );
    let crs = r#""crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::32632"}}"#;
    let house = r#"{"type":"Feature","properties":{"building":"house","height":9},"geometry":{"type":"Polygon","coordinates":[[[500100,5000100],[500116,5000100],[500116,5000110],[500100,5000110],[500100,5000100]]]}}"#;
    let road = r#"{"type":"Feature","properties":{"highway":"residential"},"geometry":{"type":"LineString","coordinates":[[500020,5000080],[500280,5000085]]}}"#;
    write("town.geojson", &format!(r#"{{"type":"FeatureCollection",{crs},"features":[{house},{road}]}}"#));
    let features = "[[features]]\nfile = \"town.geojson\"\n";
    write("place.toml", &format!("[[elevation]]\nfile = \"dem.asc\"\ncrs = \"EPSG:32632\"\n{features}"));
    folder
}

#[test]
fn flags_and_recipes_put_the_same_on_the_ground_whatever_the_workers() {
    let folder = site();
    ends(&run(&folder, "build place.toml"), 0);
    let flags = "build --elevation dem.asc --elevation-crs EPSG:32632 --features town.geojson";
    ends(&run(&folder, &format!("{flags} -o one.hop --jobs 1")), 0);
    ends(&run(&folder, &format!("{flags} -o three.hop --jobs 3 --memory 300M")), 0);
    let read = |name: &str| fs::read(folder.path().join(name)).expect("a database");
    assert!(read("place.hop") == read("one.hop") && read("one.hop") == read("three.hop"));
    let told = ends(&run(&folder, "verify place.hop"), 0);
    assert!(told.contains("sound"), "{told}");
    let told = ends(&run(&folder, "info place.hop"), 0);
    assert!(told.contains("bare ground: 1 pages") && told.contains("50.0 to 58."), "{told}");
    let told = ends(&run(&folder, "height place.hop --xy 500108.5 5000104.5 500050 5000050"), 0);
    assert!(told.contains("58.") && told.contains("50.00"), "{told}");
}

#[test]
fn pictures_show_the_house_by_both_engines() {
    let folder = site();
    ends(&run(&folder, "build place.toml"), 0);
    for engine in ["planes", "reference"] {
        let view = "render place.hop --eye 500108,5000060,54 --ypr 0,0,0 --size 64x48 --hfov 60";
        let told = ends(&run(&folder, &format!("{view} --engine {engine} -o {engine}.exr")), 0);
        assert!(!told.contains("bug"), "{told}");
    }

    ends(
        &run(
            &folder,
            "render place.hop --eye 500208,5000060,54 --ypr 0,0,0 --size 64x48 --hfov 60 -o beside.exr",
        ),
        0,
    );

    let mean = |a: &str, b: &str| -> f64 {
        let told = ends(&run(&folder, &format!("compare {a}.exr {b}.exr --json")), 0);
        let (_, after) = told.split_once("\"mean\": ").expect("a mean difference");
        after.split([',', '\n']).next().expect("a number").parse().expect("a number")
    };
    let [engines, places] = [mean("planes", "reference"), mean("planes", "beside")];
    assert!(
        engines < 2.0 && places > 5.0,
        "{engines} of 255 between engines, {places} with and without the house"
    );
}

#[test]
fn files_that_hold_no_features_are_refused_by_name() {
    let folder = site();
    fs::write(folder.path().join("broken.geojson"), "{\"type\":\"FeatureCollection\",\"features\":[")
        .expect("a file");
    let flags = "build --elevation dem.asc --elevation-crs EPSG:32632 -o area.hop --features";
    for (file, code) in [("broken.geojson", 3), ("dem.asc", 4), ("missing.geojson", 5)] {
        let told = ends(&run(&folder, &format!("{flags} {file}")), code);
        assert!(told.contains(file) && !folder.path().join("area.hop").exists(), "{told}");
    }
    let recipe = "[[elevation]]\nfile = \"dem.asc\"\ncrs = \"EPSG:32632\"\n[[features]]\nfile = \"broken.geojson\"\nkind = \"castle\"\n";
    fs::write(folder.path().join("wrong.toml"), recipe).expect("a file");
    let told = ends(&run(&folder, "recipe check wrong.toml"), 3);
    assert!(told.contains("line 6") && told.contains("'castle' is no kind of feature"), "{told}");
}
