//! Land cover from outside: what `build`, `info --classes` and `height` say of it.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::common::{ends, run};

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
    let told = ends(&run(&folder, "info place.hop"), 0);
    assert!(
        !told.contains("materials") && told.contains("2: features house.geojson: 1 row, EPSG:32632"),
        "{told}"
    );
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
    let height = |at: usize| json["classes"]["heights_m"][at].as_f64().expect("a number");
    assert!((height(0) - 100.0).abs() < 0.01 && (height(1) - 100.0).abs() < 0.01, "{json:#}");
    let told = ends(&run(&folder, "info --bbox 500150,5000000,500250,5000100 place.hop"), 0);
    let part = "part      500150,5000000,500250,5000100: heights 100.0 to 100.0 m above";
    assert!(told.contains(part) && told.contains("level 1, 1 pages"), "{told}");

    for flags in ["", "--classes ", "--json "] {
        let told = ends(&run(&folder, &format!("info {flags}--bbox 0,0,10,10 place.hop")), 2);
        assert!(told.contains("the box 0,0,10,10 lies outside the area, which is"), "{flags}: {told}");
        let told = ends(
            &run(&folder, &format!("info {flags}--bbox 500000.1,5000000.1,500000.2,5000000.2 place.hop")),
            2,
        );
        assert!(told.contains("larger --bbox"), "{flags}: {told}");
    }

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

/// 640 m by 320 m of level ground with a tree on each 20 m by 20 m.
const TREES: &str = "[place]\nlocal = true\nbbox = [0, 0, 640, 320]\nspacing_m = 1\n[[terrain]]\nkind = \"plane\"\nheight_m = 9\n\
                     [[scatter]]\nobjects = [\"conifer\", \"broadleaf\", \"shrub\", \"rock\"]\nscale = [0.6, 1.4]\nspacing_m = 20\n";

#[test]
fn objects_tell_how_often_they_are_placed() {
    let folder = TempDir::new().expect("a temporary folder");
    fs::write(folder.path().join("trees.toml"), TREES).expect("a recipe");
    ends(&run(&folder, "build trees.toml"), 0);
    let told = ends(&run(&folder, "info --classes trees.hop"), 0);
    let forms = "1: scatter conifer, broadleaf, shrub, rock: about 20 m apart, scaled by 0.6 to 1.4";
    assert!(told.contains("0: terrain plane: 1 shape") && told.contains(forms), "{told}");
    assert!(told.contains("by source 0: plane "), "{told}");

    let json = |flags: &str| -> Vec<Value> {
        let told = ends(&run(&folder, &format!("info --classes --json {flags} trees.hop")), 0);
        let json: Value = serde_json::from_str(&told).expect("JSON");
        let objects = json["classes"]["objects"].as_array().expect("a list").clone();
        assert_eq!(Some(objects.len() as u64), json["placed_objects"].as_u64());
        objects
    };

    let number = |object: &Value, key: &str| object[key].as_u64().expect("a number");
    let sum = |objects: &[Value], key: &str| objects.iter().map(|object| number(object, key)).sum::<u64>();

    // Four forms at four scales; trees stand well inside their squares, so that none is beside the area.
    let all = json("");
    assert_eq!((all.len(), sum(&all, "placed")), (16, 32 * 16));
    assert_eq!(number(&all[15], "number"), 15);
    let halves = [json("--bbox 0,0,256,320"), json("--bbox 256,0,640,320")];
    assert!(halves.iter().all(|half| sum(half, "placed") > 100));
    assert_eq!(sum(&halves[0], "placed") + sum(&halves[1], "placed"), 32 * 16);

    // Ten of them by themselves, the most placed first, and what the six others have together.
    let told = ends(&run(&folder, "info --classes trees.hop"), 0);
    let rows: Vec<&str> = told.lines().filter(|line| line.contains(" times ")).collect();
    assert_eq!(rows.len(), 11, "{told}");
    assert!(rows[0].trim_start().starts_with("by object") && rows[0].contains(" voxels "), "{told}");
    assert!(rows[10].trim_start().starts_with("6 others"), "{told}");
    let times = |row: &str| {
        let words: Vec<&str> = row.split_whitespace().collect();
        let at = words.iter().position(|word| *word == "times").expect("times");
        words[at - 1].parse::<u64>().expect("a number")
    };
    let counts: Vec<u64> = rows.iter().map(|row| times(row)).collect();
    assert!(counts[..10].is_sorted_by(|a, b| a >= b), "{told}");
    assert_eq!(counts.iter().sum::<u64>(), 32 * 16);
    assert!(!ends(&run(&folder, "info trees.hop"), 0).contains(" times "));
}
