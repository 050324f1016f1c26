//! The same features in each format, texts by hand, and what damage does.

use std::fs;
use std::path::{Path as FilePath, PathBuf};

use glam::dvec2;

use super::super::layer::{Layer, LayerOptions, Row, Value};
use super::read;

fn sample(name: &str) -> PathBuf {
    FilePath::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/features").join(name)
}

fn of_table(table: &str) -> LayerOptions {
    LayerOptions { table: Some(table.to_owned()), ..LayerOptions::default() }
}

fn written(folder: &FilePath, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, bytes).unwrap();
    path
}

fn text(bytes: &str) -> hedgehop_base::Result<Layer> {
    let folder = tempfile::tempdir().unwrap();
    read(&written(folder.path(), "a.json", bytes), &LayerOptions::default())
}

fn number(row: &Row, name: &str) -> Option<f64> {
    match row.attributes.get(name)? {
        Value::Number(number) => Some(*number),
        Value::Text(_) => None,
    }
}

#[test]
fn buildings_are_the_same_in_each_format() {
    let files = [
        read(&sample("buildings.shp"), &LayerOptions::default()).unwrap(),
        read(&sample("buildings.geojson"), &LayerOptions::default()).unwrap(),
        read(&sample("town.gpkg"), &of_table("buildings")).unwrap(),
    ];

    for layer in &files {
        assert_eq!(layer.crs.epsg().unwrap_or(25832), 25832, "{:?}", layer.path);
        assert!(layer.crs.is_equivalent(&hedgehop_geo::Crs::from_epsg(25832).unwrap()));
        assert_eq!(layer.rows.len(), 3);
        assert_eq!(layer.notes.len(), 1, "{:?}", layer.notes);
        assert!(layer.notes[0].ends_with("4 is left out: it has no geometry"), "{:?}", layer.notes);
        let [house, church, pair] = &layer.rows[..] else { unreachable!() };
        let mut corners = house.geometry.areas[0].outer.places.clone();
        corners.sort_by(|a, b| (a.x, a.y).partial_cmp(&(b.x, b.y)).unwrap());
        let at = |x: f64, y: f64| dvec2(612_000.0 + x, 5_241_000.0 + y);
        assert_eq!(corners, [at(10.0, 10.0), at(10.0, 19.0), at(22.0, 10.0), at(22.0, 19.0)]);
        assert_eq!(church.geometry.areas.len(), 1);
        assert_eq!(church.geometry.areas[0].holes.len(), 1);
        assert_eq!(pair.geometry.areas.len(), 2);
        assert_eq!(number(house, "height"), Some(8.5));
        assert_eq!(house.attributes.get("building"), Some(&Value::Text("house".into())));
        assert_eq!(house.attributes.get("name"), Some(&Value::Text("Mühle".into())));
        assert_eq!(pair.attributes.get("height"), None);
        let Some(Value::Text(name)) = church.attributes.get("name") else { panic!("no name") };
        assert!(name.starts_with("St. Anna, long"), "{name}");
        assert_eq!(church.attributes.get("levels"), None);
    }
}

#[test]
fn all_tables_of_a_geopackage_and_heights() {
    let all = read(&sample("town.gpkg"), &LayerOptions::default()).unwrap();
    assert_eq!(all.rows.len(), 3 + 2 + 60);
    assert_eq!(all.rows[0].place, "table \"buildings\", row 1");
    let shapes = read(&sample("roads.shp"), &LayerOptions::default()).unwrap();
    for (row, other) in all.rows[3..5].iter().zip(&shapes.rows) {
        assert_eq!(row.geometry, other.geometry);
        assert_eq!(number(row, "lanes"), number(other, "LANES"));
    }

    assert_eq!(all.rows[3].geometry.lines[0].heights, [600.0, 604.0, 610.0]);
    for (index, tree) in all.rows[5..].iter().enumerate() {
        let place = dvec2(612_000.0 + 3.0 * index as f64, 5_241_000.0 + 7.0 * (index % 9) as f64);
        assert_eq!(tree.geometry.points.places, [place]);
        assert_eq!(number(tree, "height"), Some(5.0 + index as f64 / 4.0));
    }

    let error = read(&sample("town.gpkg"), &of_table("Strassen")).unwrap_err().to_string();
    assert!(
        error.ends_with("has no table \"Strassen\" of features; it has buildings, roads, trees"),
        "{error}"
    );
}

#[test]
fn a_journal_beside_a_database_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path(), "a.gpkg", fs::read(sample("town.gpkg")).unwrap());
    written(folder.path(), "a.gpkg-wal", "");
    assert!(read(&path, &LayerOptions::default()).is_ok());
    written(folder.path(), "a.gpkg-wal", "something");
    let error = read(&path, &LayerOptions::default()).unwrap_err().to_string();
    assert!(error.contains("wal_checkpoint"), "{error}");
}

#[test]
fn rows_that_are_there_many_times_are_no_more_than_the_file() {
    const PAGE: usize = 512;
    let folder = tempfile::tempdir().unwrap();
    let sound = fs::read(sample("town.gpkg")).unwrap();
    let mut answers = Vec::new();
    for start in (PAGE..sound.len()).step_by(PAGE).filter(|start| sound[*start] == 0x0d) {
        // A leaf of which every cell is its first one.
        let mut bytes = sound.clone();
        let first = [bytes[start + 8], bytes[start + 9]];
        let count = (usize::from(u16::from_be_bytes(first)).saturating_sub(8) / 2).min(100);
        bytes[start + 4] = count as u8;
        (0..count).for_each(|cell| bytes[start + 8 + 2 * cell..][..2].copy_from_slice(&first));
        let path = written(folder.path(), "a.gpkg", &bytes);
        answers.push(
            read(&path, &LayerOptions::default()).map_or_else(|error| error.to_string(), |_| String::new()),
        );
    }
    assert!(answers.iter().any(|answer| answer.contains("its rows are longer than the file")), "{answers:?}");
}

#[test]
fn every_form_of_geojson() {
    let point = r#"{"type":"Point","coordinates":[10.5,47.25,900]}"#;
    let layer = text(point).unwrap();
    assert_eq!(layer.crs.epsg(), Some(4326));
    assert_eq!(layer.rows[0].geometry.points.places, [dvec2(10.5, 47.25)]);
    assert_eq!(layer.rows[0].geometry.points.heights, [900.0]);
    let lines = format!(
        "\u{1e}{{\"type\":\"Feature\",\"geometry\":{point},\"properties\":{{\"a\":1,\"bridge\":true,\"tags\":{{\"b\":\"x\"}}}}}}\n\u{1e}{point}\n"
    );
    let layer = text(&lines).unwrap();
    assert_eq!(layer.rows.len(), 2);
    assert_eq!(layer.rows[1].place, "feature 2");
    assert_eq!(layer.rows[0].attributes.get("b"), Some(&Value::Text("x".into())));
    assert_eq!(layer.rows[0].attributes.get("bridge"), Some(&Value::Text("yes".into())));
    let collection = r#"{"type":"GeometryCollection","geometries":[
        {"type":"MultiPoint","coordinates":[[1,2],[3,4]]},
        {"type":"LineString","coordinates":[[1,2],[3,4]]},
        {"type":"MultiLineString","coordinates":[[[1,2],[3,4]],[[5,6],[7,8]]]},
        {"type":"MultiPolygon","coordinates":[[[[0,0],[9,0],[9,9],[0,0]],[[5,2],[6,2],[6,3],[5,2]]]]}]}"#;
    let geometry = &text(collection).unwrap().rows[0].geometry;
    assert_eq!((geometry.points.places.len(), geometry.lines.len(), geometry.areas.len()), (2, 3, 1));
    assert_eq!(geometry.areas[0].holes.len(), 1);
}

#[test]
fn one_bad_feature_costs_itself_alone() {
    let layer = text(
        r#"{"type":"FeatureCollection","name":"x","features":[
        {"type":"Feature","geometry":{"type":"Point","coordinates":"here"},"properties":null},
        {"type":"Feature","geometry":{"type":"Point","coordinates":[1]}},
        {"type":"Feature","geometry":{"type":"LineString","coordinates":[[1,2],3]}},
        {"type":"Feature","geometry":{"type":"LineString","coordinates":[[1,2],"to",[3,4]]}},
        {"type":"Feature","geometry":{"type":"Circle","coordinates":[1,2]}},
        {"type":"Feature","geometry":null,"properties":{}},
        {"type":"Feature","geometry":{"type":"Polygon","coordinates":[[[0,0],[1,1],[0,0]]]}},
        {"type":"Feature","geometry":{"type":"Point","coordinates":[1,2]},"properties":{"height":"12 m"}}]}"#,
    )
    .unwrap();

    assert_eq!(layer.rows.len(), 1);
    assert_eq!(layer.rows[0].place, "feature 8");
    assert_eq!(layer.notes.len(), 5, "{:?}", layer.notes);
    let note = layer.notes.iter().find(|note| note.contains("of a Point")).unwrap();
    assert_eq!(
        note,
        "a.json: 2 rows are left out: its coordinates are not those of a Point (the first of them is feature 1)"
    );
}

#[test]
fn deleted_rows_stay_out() {
    let folder = tempfile::tempdir().unwrap();
    for ending in ["shp", "dbf", "prj"] {
        let mut bytes = fs::read(sample("roads.shp").with_extension(ending)).unwrap();
        if ending == "dbf" {
            let first = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
            bytes[first] = b'*';
        }
        written(folder.path(), &format!("r.{ending}"), bytes);
    }
    let layer = read(&folder.path().join("r.shp"), &LayerOptions::default()).unwrap();
    assert_eq!(layer.rows.len(), 1);
    assert_eq!(layer.notes, ["r.shp: row 1 is left out: it is marked as deleted"]);
}

#[test]
fn systems_are_stated_given_or_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    for ending in ["shp", "dbf"] {
        fs::copy(sample("roads.shp").with_extension(ending), folder.path().join("r").with_extension(ending))
            .unwrap();
    }
    let path = folder.path().join("r.shp");
    let error = read(&path, &LayerOptions::default()).unwrap_err().to_string();
    assert!(error.contains("states no coordinate reference system; put a .prj"), "{error}");
    let given =
        |crs: &str| read(&path, &LayerOptions { crs: Some(crs.to_owned()), ..LayerOptions::default() });
    assert_eq!(given("EPSG:25832").unwrap().crs.epsg(), Some(25832));
    assert!(given("local").unwrap().crs.is_local());
    assert!(given("EPSG:4326").unwrap_err().to_string().contains("cannot be degrees"));
    let metres = r#"{"type":"Point","coordinates":[612000,5241000]}"#;
    assert!(text(metres).unwrap_err().to_string().contains("cannot be degrees of WGS 84"));
    let stated = r#"{"type":"Feature","crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::25832"}},
        "geometry":{"type":"Point","coordinates":[11,47]}}"#;
    assert!(text(stated).unwrap_err().to_string().contains("look like degrees"));
}

#[test]
fn other_files_are_told_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    for (bytes, sentence) in [
        (&b""[..], "is empty"),
        (b"PK\x03\x04....", "unpack it"),
        (b"<?xml version='1.0'?><osm>", "ogr2ogr -f GPKG"),
        (b"\0\0\0\x0d\x0a\x09OSMHeader", "OpenStreetMap's own format"),
        (b"hello", "is neither GeoJSON"),
        (b"{\"type\":\"Topology\"}", "is TopoJSON"),
        (b"{\"type\":\"CityJSON\",\"CityObjects\":{}}", "is CityJSON"),
        (
            b"{\"geometryType\":\"esriGeometryPolygon\",\"spatialReference\":{\"wkid\":4326},\"features\":[\
              {\"attributes\":{\"a\":1},\"geometry\":{\"rings\":[[[0,0],[0,1],[1,1],[0,0]]]}}]}",
            "is Esri JSON",
        ),
        (b"{\"version\":0.6,\"elements\":[{\"type\":\"node\",\"id\":1,\"lat\":1,\"lon\":2}]}", "osmtogeojson"),
        (b"{\"kml\":{\"Document\":{}}}", "is KML in JSON"),
        (b"{\"asset\":{\"version\":\"2.0\"},\"meshes\":[]}", "is glTF"),
        (b"{\"error\":{\"code\":498,\"message\":\"Invalid token\"}}", "the error of a server"),
        (b"{\"a\":1}", "it has no \"type\""),
        (b"{\"type\":\"Feature\",\"geometry\":null}", "its only row is of no use: it has no geometry"),
        (
            b"{\"type\":\"FeatureCollection\",\"features\":[{\"type\":\"Feature\",\"geometry\":{\"type\":\"Blob\"}},\
              {\"type\":\"Feature\",\"geometry\":{\"type\":\"Blob\"}}]}",
            "all its 2 rows are of no use",
        ),
        (b"{\"type\":\"FeatureCollection\",", "this is no GeoJSON"),
        (&[0, 0, 0x27, 0x0a, 0], "fewer than a Shapefile's header"),
        (b"SQLite format 3\0", "fewer than an SQLite header"),
    ] {
        let path = written(folder.path(), "a.bin", bytes);
        let error = read(&path, &LayerOptions::default()).unwrap_err().to_string();
        assert!(error.contains(sentence), "{error}");
    }

    let error = read(&sample("roads.dbf"), &LayerOptions::default()).unwrap_err().to_string();
    assert!(error.contains("name the .shp file"), "{error}");
}

/// Reads a file with bytes flipped, cut and doubled; whatever comes out, it is an answer.
fn damage(name: &str, beside: &[&str], rounds: u64, touched: &str) {
    let folder = tempfile::tempdir().unwrap();
    for other in beside {
        fs::copy(sample(other), folder.path().join(other)).unwrap();
    }

    let sound = fs::read(sample(touched)).unwrap();
    let mut random = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = |below: usize| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random % below.max(1) as u64) as usize
    };
    let (mut read_well, mut refused) = (0, 0);

    for round in 0..rounds {
        let mut bytes = sound.clone();
        match round % 8 {
            0 => bytes.truncate(next(sound.len())),
            // Headers are where lengths stand.
            1..=3 => {
                let at = next(bytes.len().min(200));
                bytes[at] = [0, 1, 0x7f, 0x80, 0xff][next(5)];
            }
            _ => {
                for _ in 0..=next(4) {
                    let at = next(bytes.len());
                    bytes[at] ^= 1 << next(8);
                }
            }
        }

        written(folder.path(), touched, &bytes);
        match read(&folder.path().join(name), &LayerOptions::default()) {
            Ok(_) => read_well += 1,
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().contains('\n'));
            }
        }
    }

    assert!(read_well > 0 && refused > 0, "{touched}: {read_well} read, {refused} refused");
}

#[test]
fn damaged_geojson_is_answered() {
    damage("buildings.geojson", &[], 4000, "buildings.geojson");
}

#[test]
fn damaged_shapefiles_are_answered() {
    let all = ["buildings.shp", "buildings.dbf", "buildings.prj", "buildings.cpg"];
    damage("buildings.shp", &all, 3000, "buildings.shp");
    damage("buildings.shp", &all, 3000, "buildings.dbf");
}

#[test]
fn damaged_geopackages_are_answered() {
    damage("town.gpkg", &[], 3000, "town.gpkg");
}
