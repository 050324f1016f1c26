//! What is refused, and in which words.

use std::fs;

use time::macros::datetime;

use super::super::shadow_heights;
use super::rows::options;
use crate::shadow_height::ShadowOptions;
use hedgehop::sunlight::{Sun, SunSetting};
use hedgehop_base::error::Error;
use hedgehop_base::progress::{Observer, Silent};

const ROW: &str = r#"{"type":"Feature","properties":{"shadow_length":20},"geometry":{"type":"Polygon","coordinates":[[[11,47],[11.001,47],[11.001,47.001],[11,47]]]}}"#;

fn told(text: &str, change: impl Fn(&mut ShadowOptions)) -> Error {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.geojson");
    fs::write(&path, text).unwrap();
    let mut options = options(path);
    change(&mut options);
    shadow_heights(&options, &Silent).unwrap_err()
}

#[test]
fn suns_that_throw_no_shadows_are_refused() {
    for (sun, word) in [
        (SunSetting::Time(datetime!(2024-10-05 22:12 UTC)), "above the horizon"),
        (SunSetting::At(Sun { azimuth: 0.0, elevation: 90.0 }), "90.0°"),
        (SunSetting::At(Sun { azimuth: 0.0, elevation: 0.0 }), "time at which the picture was taken"),
    ] {
        let error = told(ROW, |options| options.sun = sun);
        assert!(matches!(&error, Error::Configuration(what) if what.contains(word)), "{error}");
    }
}

#[test]
fn files_without_buildings_are_refused_by_name() {
    for text in ["", "{\"type\":\"FeatureCollection\",\"features\":[]}", "[1]"] {
        let error = told(text, |_| {}).to_string();
        assert!(error.contains("a.geojson"), "{error}");
    }
    let error = told(ROW, |options| options.highest_m = f64::NAN);
    assert!(matches!(error, Error::Configuration(_)), "{error}");
}

#[test]
fn odd_outlines_harm_nobody() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.geojson");
    let ring = |places: &str| {
        format!(
            r#"{{"type":"Feature","properties":{{"shadow_length":20}},"geometry":{{"type":"Polygon","coordinates":[[{places}]]}}}}"#
        )
    };
    let rows = [
        // Crossing itself, flat, as large as the Earth, at a pole.
        ring("[11,47],[11.001,47.001],[11.001,47],[11,47.001]"),
        ring("[11,47],[11.001,47],[11.002,47]"),
        ring("[-180,-80],[180,-80],[180,80],[-180,80]"),
        ring("[0,90],[90,90],[180,90]"),
    ];
    fs::write(&path, rows.join("\n")).unwrap();
    let report = shadow_heights(&options(path), &Silent).unwrap();
    assert_eq!(report.answers.len(), 4);
    report.geojson().unwrap();
}

#[test]
fn a_request_to_stop_ends_it() {
    struct Stopped;
    impl Observer for Stopped {
        fn cancelled(&self) -> bool {
            true
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.geojson");
    fs::write(&path, ROW).unwrap();
    let error = shadow_heights(&options(path), &Stopped).unwrap_err();
    assert!(matches!(&error, Error::Interrupted(what) if what.contains("no heights")), "{error}");
}
