//! The airfield and its GeoPackage against the ground that it stands on.

use glam::DVec2;
use rusqlite::{Connection, MAIN_DB};

use crate::features::{Feature, Geometry};
use crate::geotiff::ORIGIN;
use crate::grid::{around, sample};
use crate::outline::area;
use crate::tests::{FILES, SAMPLE};
use crate::{airfield, roads, sites};

fn corners(feature: &Feature) -> Vec<DVec2> {
    match &feature.geometry {
        Geometry::Point(place) => vec![*place],
        Geometry::Line(places) | Geometry::Polygon(places) => places.clone(),
    }
}

#[test]
fn airfield_stands_beside_the_strip_on_free_and_nearly_level_ground() {
    let all = [airfield::buildings(), airfield::grounds(), airfield::ways()];
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for feature in all.iter().flatten() {
        if let Geometry::Polygon(ring) = &feature.geometry {
            assert!(area(ring) > 20.0, "{} m²", area(ring));
        }
        let is_taxiway = feature.text("aeroway") == Some("taxiway");

        for DVec2 { x, y } in corners(feature) {
            let is_on_strip = matches!(sites::kept(x, y), Some(sites::Kept::Strip { .. }));
            assert!(!is_on_strip || is_taxiway, "{:?} on the strip at {x}, {y}", feature.tags[0].key);
            for pixel in around(x, y, 3.0) {
                assert!(roads::outside(&SAMPLE.roads, pixel) > 3.0, "on a road at {x}, {y}");
                assert!(SAMPLE.water.outside[pixel] > 3.0, "in water at {x}, {y}");
                let stands = SAMPLE.valley.surface[pixel] - SAMPLE.valley.bare[pixel];
                // Hedges make way, trees do not.
                assert!(stands < 3.0, "{stands} m stand at {x}, {y}");
            }
            let ground = sample(&SAMPLE.valley.bare, x, y);
            (low, high) = (low.min(ground), high.max(ground));
        }
    }

    assert!(high - low < 4.0, "from {low} m to {high}");
}

#[test]
fn a_geopackage_has_its_tables_rows_and_places() {
    let (_, bytes) = FILES.iter().find(|(name, _)| name.ends_with(".gpkg")).unwrap();
    let mut base = Connection::open_in_memory().unwrap();
    base.deserialize_read_exact(MAIN_DB, bytes.as_slice(), bytes.len(), true).unwrap();
    let number = |question: &str| base.query_row(question, [], |row| row.get::<_, i64>(0)).unwrap();
    assert_eq!(number("PRAGMA application_id"), 0x4750_4b47);
    assert_eq!(base.query_row("PRAGMA integrity_check", [], |row| row.get::<_, String>(0)).unwrap(), "ok");
    let tables =
        [("buildings", airfield::buildings()), ("grounds", airfield::grounds()), ("ways", airfield::ways())];

    for (name, features) in tables {
        assert_eq!(number(&format!("SELECT count(*) FROM {name}")), features.len() as i64, "{name}");
        let [west, north] = ["min_x", "max_y"].map(|column| {
            let question = format!("SELECT {column} FROM gpkg_contents WHERE table_name = '{name}'");
            base.query_row(&question, [], |row| row.get::<_, f64>(0)).unwrap()
        });
        let places: Vec<DVec2> = features.iter().flat_map(corners).collect();
        let least = places.iter().map(|place| place.x).fold(f64::INFINITY, f64::min);
        let most = places.iter().map(|place| place.y).fold(f64::NEG_INFINITY, f64::max);
        assert!((west - ORIGIN.x - least).abs() < 0.006 && (north - ORIGIN.y - most).abs() < 0.006, "{name}");
    }

    let height: f64 = base
        .query_row("SELECT height FROM buildings WHERE building = 'clubhouse'", [], |row| row.get(0))
        .unwrap();
    assert_eq!(height, 6.8);
}
