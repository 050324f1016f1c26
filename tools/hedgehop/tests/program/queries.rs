//! `height`, `sight` and `profile` from outside.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::common::{ends, run};

/// A folder with a database in a zone of UTM: ground of 100 m, and a ridge of 60 m across its middle.
fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let height = |x: i32| 100 + (60 - 2 * (x - 50).abs()).max(0);
    let row = (0..100).map(|x| height(x).to_string()).collect::<Vec<_>>().join(" ");
    let head = "ncols 100\nnrows 60\nxllcorner 500000\nyllcorner 5000000\ncellsize 10\n";
    let write = |name: &str, text: String| fs::write(folder.path().join(name), text).expect("a file");
    write("dem.asc", format!("{head}{}\n", vec![row; 60].join("\n")));
    write("flight.csv", "time_s,x_m,y_m,alt_m\n0,500100,5000300,200\n10,500900,5000300,200\n".into());
    write("place.toml", "[[elevation]]\nfile = \"dem.asc\"\ncrs = \"EPSG:32632\"\n".into());
    ends(&run(&folder, "build place.toml"), 0);
    folder
}

#[track_caller]
fn number(json: &Value, at: &str) -> f64 {
    json.pointer(at).and_then(Value::as_f64).unwrap_or_else(|| panic!("{at} of {json:#}"))
}

#[test]
fn heights_are_told_by_degrees_and_by_metres() {
    let folder = site();
    let told = ends(&run(&folder, "height place.hop 500505 5000300 500105 5000300 --xy"), 0);
    assert!(told.contains("160.0") && told.contains("100.00 m above"), "{told}");
    let json = ends(&run(&folder, "height place.hop 500505 5000300 --xy --json"), 0);
    let json: Value = serde_json::from_str(&json).expect("JSON");
    assert!((number(&json, "/0/height_m") - 160.0).abs() < 0.1, "{json}");
    assert!((number(&json, "/0/lon_deg") - 9.0064).abs() < 1e-4, "{json}");
    assert!((number(&json, "/0/lat_deg") - 45.1562).abs() < 1e-4, "{json}");
    let told = ends(&run(&folder, "height place.hop 500505,5000300 500105, 5000300 --xy"), 0);
    assert!(told.contains("160.0") && told.contains("100.00 m above"), "{told}");

    // The same place in degrees: 9° east is the zone's middle.
    let json = ends(&run(&folder, "height place.hop 9.0064 45.1535 --json"), 0);
    let json: Value = serde_json::from_str(&json).expect("JSON");
    assert!((number(&json, "/0/x_m") - 500_503.0).abs() < 3.0, "{json}");
    assert!((number(&json, "/0/lon_deg") - 9.0064).abs() < 1e-9);

    for (args, words) in [
        ("9.5 45.1535", "outside the area"),
        ("-9.5,45.1535", "-9.5 45.1535 lies outside the area"),
        ("1e300,1 --xy", "1e300 1 lies outside the area"),
        ("9.0064,45.1535,3", "pairs"),
        ("500505 5000300", "--xy for metres"),
        ("9.0064", "value"),
        ("9.0064 45.1535 3", "pairs"),
    ] {
        let told = ends(&run(&folder, &format!("height place.hop {args}")), 2);
        assert!(told.contains(words), "{args}: {told}");
    }
}

#[test]
fn points_see_each_other_over_the_ridge_only() {
    let folder = site();
    let sight = |height: f64| {
        let args = format!(
            "sight place.hop --from 500105,5000300,{height} --to 500905,5000300,{height} --xy --json"
        );
        serde_json::from_str::<Value>(&ends(&run(&folder, &args), 0)).expect("JSON")
    };
    let clear = sight(75.0);
    assert_eq!(clear["sees"], true);
    assert!((number(&clear, "/nearest/above_ground_m") - 15.0).abs() < 0.5, "{clear}");
    let hidden = sight(20.0);
    assert_eq!(hidden["sees"], false);

    // 20 m up the near slope, which rises by 2 m in 10 m from 100 m before the eye on.
    assert!((number(&hidden, "/blocked_at/distance_m") - 200.0).abs() < 8.0, "{hidden}");
    assert!((number(&hidden, "/missing_m") - 80.0).abs() < 2.0, "{hidden}");
    assert!((number(&hidden, "/blocked_at/lon_deg") - 9.004).abs() < 1e-3, "{hidden}");
    let told = ends(&run(&folder, "sight place.hop --from 500105,5000300,20 --to 500905,5000300,20 --xy"), 0);
    assert!(told.contains("hides the far point") && told.contains("m higher"), "{told}");
    let told = ends(
        &run(&folder, "sight place.hop --from 500105,5000300,220 --to 500905,5000300,220 --xy --msl"),
        0,
    );
    assert!(told.contains("see each other over 800 m"), "{told}");
    let told = ends(&run(&folder, "sight place.hop --from 9,45.15,2 --to 9,45.15,2"), 2);
    assert!(told.contains("two points") || told.contains("outside"), "{told}");
}

#[test]
fn points_on_level_ground_are_hidden_by_the_earth_alone() {
    let folder = site();
    let sight = |more: &str| {
        let ends_at = "--from 500025,5000300,0 --to 500185,5000300,0";
        ends(&run(&folder, &format!("sight place.hop {ends_at} --xy{more}")), 0)
    };
    let told = sight(" --curvature off");
    assert!(told.contains("they see each other over 160 m"), "{told}");
    // (160 m)² / 2R′ is 1.7 mm.
    let told = sight("");
    assert!(told.contains("it would have to be 0.002 m higher"), "{told}");
    // From the ridge down beyond its foot, and back.
    for ends_at in
        ["--from 500505,5000300,0 --to 500905,5000300,0", "--from 500905,5000300,0 --to 500505,5000300,0"]
    {
        let told = ends(&run(&folder, &format!("sight place.hop {ends_at} --xy")), 0);
        assert!(told.contains("they see each other over 400 m"), "{told}");
    }
}

/// A local database of level ground, 600 m by 400 m, of which the middle third has no data.
fn gap() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let row =
        (0..60).map(|x| if (20..40).contains(&x) { "-9999" } else { "100" }).collect::<Vec<_>>().join(" ");
    let head = "ncols 60\nnrows 40\nxllcorner 0\nyllcorner 0\ncellsize 10\nnodata_value -9999\n";
    let write = |name: &str, text: String| fs::write(folder.path().join(name), text).expect("a file");
    write("dem.asc", format!("{head}{}\n", vec![row; 40].join("\n")));
    write("far.csv", "time_s,x_m,y_m,alt_m\n0,9000,300,200\n10,9900,300,200\n".into());
    ends(&run(&folder, "build --elevation dem.asc --local -o gap.hop"), 0);
    folder
}

#[test]
fn places_in_gaps_outside_and_twice_are_told() {
    let folder = gap();
    let found = json(&folder, "height gap.hop 300,200 100,200 --json");
    assert!(
        found[0]["height_m"].is_null() && (number(&found, "/1/height_m") - 100.0).abs() < 1e-6,
        "{found}"
    );
    assert!(found[1].get("lon_deg").is_none() && found[1].get("x_m").is_some(), "no place on Earth: {found}");

    for (args, code, words) in [
        ("height gap.hop 300 200", 0, "300.0 200.0  no ground: a gap of the data"),
        ("height gap.hop 300 2000", 2, "300 2000 lies outside the area"),
        (
            "sight gap.hop --from 300,200,2 --to 50,50,2",
            2,
            "there is no ground at 300 200, a gap of the data",
        ),
        ("sight gap.hop --from 900,200,2 --to 50,50,2", 2, "900 200 lies outside the area"),
        ("sight gap.hop --from 50,50,2 --to 50,50,2", 2, "are the same point, 50.0 50.0 at 102.0 m"),
        (
            "sight gap.hop --from 250,200,150 --to 350,200,150 --msl",
            0,
            "100 m; there is no ground between them",
        ),
        ("sight gap.hop --from 50,200,0 --to 150,200,0", 0, "they see each other over 100 m"),
        ("profile gap.hop --from 50,50 --to 50,50", 2, "are the same place, 50.0 50.0"),
        ("profile gap.hop --from 250,50 --to 350,50 -o gap.svg", 2, "nothing to draw"),
        ("profile gap.hop --from 250,50 --to 350,50 -o gap.csv", 0, "all places lie in a gap of the data"),
        ("profile gap.hop --from 105,50 --to 305,50 -o part.svg", 0, "of 21 places lie in a gap of the data"),
        ("profile gap.hop --path far.csv -o far.svg", 0, "all places lie outside the area, x 0.0 to 600.0"),
        ("contours gap.hop -o lines.geojson", 0, "no lines every 0.001 m: the ground is level, 100.00 m"),
        ("contours gap.hop -o lines.geojson --bbox 250,50,350,150", 0, "there is a gap of the data"),
        (
            "contours gap.hop -o lines.geojson --bbox 50,50,56,56",
            0,
            "less than two by two posts, which are 10 m apart",
        ),
        ("contours gap.hop -o lines.geojson --bbox 900,50,950,56", 2, "lies outside the area"),
    ] {
        let told = ends(&run(&folder, args), code);
        assert!(told.contains(words), "{args}: {told}");
    }

    let told = ends(&run(&site(), "contours place.hop -o lines.geojson --interval 1000"), 0);
    assert!(told.contains("lies between two of them, from 100.00 to 160.00 m; give a smaller"), "{told}");
}

#[test]
fn profiles_are_drawn_and_listed() {
    let folder = site();
    let told = ends(&run(&folder, "profile place.hop --path flight.csv -o flight.svg"), 0);
    assert!(told.contains("0.80 km") && told.contains("above ground at least"), "{told}");
    let plot = fs::read_to_string(folder.path().join("flight.svg")).expect("a plot");
    assert!(plot.starts_with("<svg") && plot.contains("km along the line"), "{plot}");

    ends(
        &run(
            &folder,
            "profile place.hop --from 500105,5000300 --to 500905,5000300 --xy --step 50 -o line.csv",
        ),
        0,
    );

    let table = fs::read_to_string(folder.path().join("line.csv")).expect("a table");
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("distance_m,lon_deg,lat_deg,x_m,y_m,ground_m"));
    assert_eq!(lines.clone().count(), 17);
    let middle: Vec<&str> = lines.nth(8).expect("the middle").split(',').collect();
    assert_eq!(middle[0], "400.000");
    assert!((middle[5].parse::<f64>().expect("a height") - 160.0).abs() < 0.2, "{middle:?}");

    for (args, words) in [
        ("--path flight.csv -o flight.gif", ".svg"),
        ("--path flight.csv -o flight.csv", "flight.csv"),
        ("--from 1,2", "--to"),
        ("", "--path"),
    ] {
        let told = ends(&run(&folder, &format!("profile place.hop {args}")), 2);
        assert!(told.contains(words), "{args}: {told}");
    }
}

/// A database of level ground of 100 m, voxels of a metre, with a bridge from west to east across its middle and a hall south of it.
fn crossing() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let write = |name: &str, text: String| fs::write(folder.path().join(name), text).expect("a file");
    let row = vec!["100"; 200].join(" ");
    let head = "ncols 200\nnrows 200\nxllcorner 500000\nyllcorner 5000000\ncellsize 1\n";
    write("dem.asc", format!("{head}{}\n", vec![row; 200].join("\n")));
    let bridge = r#"{"type":"Feature","properties":{"highway":"secondary","bridge":"yes","layer":1,"width":8},
        "geometry":{"type":"LineString","coordinates":[[500010,5000100],[500190,5000100]]}}"#;
    let hall = r#"{"type":"Feature","properties":{"building":"yes","height":9,"roof:shape":"flat"},
        "geometry":{"type":"Polygon","coordinates":[[[500080,5000030],[500110,5000030],[500110,5000050],[500080,5000050],[500080,5000030]]]}}"#;
    let crs = r#""crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::32632"}}"#;
    write("map.geojson", format!(r#"{{"type":"FeatureCollection",{crs},"features":[{bridge},{hall}]}}"#));
    let elevation = "[[elevation]]\nfile = \"dem.asc\"\ncrs = \"EPSG:32632\"\n";
    write("place.toml", format!("{elevation}[[features]]\nfile = \"map.geojson\"\n"));
    ends(&run(&folder, "build place.toml"), 0);
    folder
}

fn json(folder: &TempDir, args: &str) -> Value {
    serde_json::from_str(&ends(&run(folder, args), 0)).expect("JSON")
}

#[test]
fn bare_ground_is_told_below_roofs_and_bridges() {
    let folder = crossing();
    let height =
        |more: &str| json(&folder, &format!("height place.hop 500095.5 5000040.5 --xy --json{more}"));
    let (roof, bare) = (height(""), height(" --bare"));
    assert!((number(&roof, "/0/height_m") - 109.0).abs() < 0.1, "{roof}");
    assert!((number(&bare, "/0/height_m") - 100.0).abs() < 0.1, "{bare}");
    assert_ne!(roof.pointer("/0/material"), bare.pointer("/0/material"), "ground is not made of roofs");
    let highest = |more: &str| {
        let line = "profile place.hop --from 500095.5,5000010 --to 500095.5,5000150 --xy -o line.csv";
        ends(&run(&folder, &format!("{line}{more}")), 0);
        let table = fs::read_to_string(folder.path().join("line.csv")).expect("a table");
        let heights =
            table.lines().skip(1).map(|line| line.rsplit(',').next().and_then(|told| told.parse().ok()));
        heights.map(|height: Option<f64>| height.expect("a height")).fold(f64::NEG_INFINITY, f64::max)
    };
    let [roof, bare] = ["", " --bare"].map(highest);
    assert!(roof > 108.0 && (bare - 100.0).abs() < 0.1, "{roof} {bare}");
}

#[test]
fn points_see_each_other_under_a_bridge() {
    let folder = crossing();
    let ends_at = |height: f64| {
        format!("sight place.hop --from 500095.5,5000070,{height} --to 500095.5,5000130,{height} --xy --msl")
    };
    let sees = |height: f64| json(&folder, &format!("{} --json", ends_at(height)));
    let under = sees(101.0);
    assert_eq!(
        (&under["sees"], &under["standing"], number(&under, "/missing_m")),
        (&true.into(), &Value::Null, 0.0)
    );
    assert!((number(&under, "/nearest/above_ground_m") - 1.0).abs() < 0.1, "{under}");
    let deck = number(&json(&folder, "height place.hop 500095.5 5000100.5 --xy --json"), "/0/height_m");
    let hidden = sees(deck - 0.1);
    assert_eq!(hidden["sees"], false, "{hidden}");
    assert!(hidden["standing"].is_string() && number(&hidden, "/missing_m") > 0.0, "{hidden}");
    let told = ends(&run(&folder, &ends_at(deck - 0.1)), 0);
    assert!(told.contains("what stands on the ground (") && told.contains("hides the far point"), "{told}");
}

#[test]
fn points_within_a_house_and_straight_lines_up_are_told() {
    let folder = crossing();
    let sees = |from: &str, to: &str| {
        let args = format!("sight place.hop --from {from} --to {to} --xy --msl");
        (ends(&run(&folder, &args), 0), json(&folder, &format!("{args} --json")))
    };

    // In the hall, which is 9 m high, and below ground.
    let (told, found) = sees("500095.5,5000040.5,104", "500095.5,5000070,99");
    let hall = found.pointer("/within/from/standing").and_then(Value::as_str).expect("a material");
    let lead = format!(
        "the near point lies within what stands on the ground ({hall}); the far point lies below the ground; "
    );
    assert!(told.starts_with(&lead) && told.contains("no height of it would do"), "{told}");
    assert_eq!(found.pointer("/within/to/standing"), Some(&Value::Null), "{found}");
    assert_eq!((&found["sees"], &found["missing_m"]), (&false.into(), &Value::Null), "{found}");

    // Straight down onto the roof of the hall, and onto the ground beside it.
    let (told, found) = sees("500095.5,5000040.5,150", "500095.5,5000040.5,100.5");
    assert!((number(&found, "/missing_m") - 8.5).abs() < 0.1, "{found}");
    assert!(told.contains("it would have to be 8.5 m higher"), "{told}");
    let (told, found) = sees("500095.5,5000070,150", "500095.5,5000070,100.5");
    assert!(told.starts_with("they see each other over 49.5 m of height"), "{told}");
    assert_eq!((&found["within"]["from"], &found["within"]["to"]), (&Value::Null, &Value::Null), "{found}");
}
