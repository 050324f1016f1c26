use std::path::Path;

use super::super::track::{ReadOptions, Track};
use super::*;
use crate::flight::assemble::assemble;

fn parse_with(text: &str, options: &ReadOptions) -> Result<Track> {
    let source = PathSource { path: Path::new("path.csv"), options };
    assemble(&source, read(&source, text)?)
}

fn parse(text: &str) -> Result<Track> {
    parse_with(text, &ReadOptions::default())
}

#[track_caller]
fn assert_error(text: &str, parts: &[&str]) {
    let message = parse(text).expect_err("an error").to_string();
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in: {message}");
    }
}

#[test]
fn units_modes_and_separators() {
    let fix = |header: &str, row: &str| parse(&format!("{header}\n{row}\n")).unwrap().fixes[0];
    let full = fix("t;x;y;alt_agl_ft;heading_rad;bank;hfov", "5;100;200;1000;1.5707963267948966;-20;75");
    assert_eq!(full.horizontal, Horizontal::Xy(100.0, 200.0));
    assert_eq!(full.altitude, Altitude { metres: 1000.0 * 0.3048, mode: AltitudeMode::Agl });
    assert!((full.yaw.unwrap() - 90.0).abs() < 1e-9);
    assert_eq!((full.pitch, full.roll, full.hfov), (None, Some(-20.0), Some(75.0)));
    let tabs =
        fix("time\tLongitude (deg)\tLatitude [deg]\tAlt_Ellipsoid_m", "2026-05-01T12:00:00Z\t8\t47\t600");
    assert_eq!(tabs.altitude.mode, AltitudeMode::Ellipsoid);
    assert_eq!(tabs.horizontal, Horizontal::LonLat(8.0, 47.0));
    let scaled = fix("time_ms,lon_e7,lat_e7,alt_km", "1000,82500000,475000000,1.5");
    assert_eq!(scaled.horizontal, Horizontal::LonLat(8.25, 47.5));
    assert_eq!(scaled.altitude, Altitude { metres: 1500.0, mode: AltitudeMode::Msl });
    assert_eq!(fix("t,lon,lat,z", "0,350,1,2").horizontal, Horizontal::LonLat(-10.0, 1.0));
}

#[test]
fn unstated_altitude_mode_is_asked_of_the_user() {
    let text = "t,x,y,alt_m\n0,1,2,3\n";
    let track = parse(text).unwrap();
    assert_eq!(track.fixes[0].altitude.mode, AltitudeMode::Msl);
    assert!(track.notes.iter().any(|note| note.contains("--alt-mode")), "{:?}", track.notes);
    let options = ReadOptions { altitude_mode: Some(AltitudeMode::Agl), ..ReadOptions::default() };
    let track = parse_with(text, &options).unwrap();
    assert_eq!((track.fixes[0].altitude.mode, track.notes.len()), (AltitudeMode::Agl, 0));
    let both = "t,x,y,alt_agl_m,alt_msl_m\n0,1,2,3,4\n";
    assert_eq!(parse(both).unwrap().fixes[0].altitude.metres, 4.0);
    assert_eq!(parse_with(both, &options).unwrap().fixes[0].altitude.metres, 3.0);
    assert_eq!(
        parse_with("t,x,y,alt_msl_m\n0,1,2,3\n", &options).unwrap().fixes[0].altitude.mode,
        AltitudeMode::Msl
    );
}

#[test]
fn seconds_are_taken_before_local_dates() {
    let track =
        parse("time_local,unix_time_s,x,y,z\n2018-10-15 17:34:37 -0500,100,1,2,3\n,101.5,1,2,3\n").unwrap();
    assert_eq!(track.fixes[1].time, 1.5);
}

#[test]
fn comments_blank_lines_and_trailing_separators() {
    let track = parse("# a flight\nt,x,y,z\n\n# start\n0,1,2,3,\n 1 , 2 , 3 , 4 \n").unwrap();
    assert_eq!(track.fixes.len(), 2);
    assert_eq!(track.fixes[1].horizontal, Horizontal::Xy(2.0, 3.0));
}

#[test]
fn headings_of_minus_one_are_unknown_among_positive_ones() {
    let track = parse("t,x,y,z,heading\n0,0,0,0,350\n1,1,0,0,-1\n2,2,0,0,10\n").unwrap();
    assert_eq!(track.fixes[1].yaw, None);
    let track = parse("t,x,y,z,yaw\n0,0,0,0,-2\n1,1,0,0,-1\n").unwrap();
    assert_eq!(track.fixes[1].yaw, Some(-1.0));
}

#[test]
fn equal_times_drop_the_later_fix() {
    let track = parse("t,x,y,z\n0,0,0,0\n0,9,0,0\n1,1,0,0\n1,9,0,0\n").unwrap();
    assert_eq!(track.fixes.len(), 2);
    assert_eq!(track.fixes[1].horizontal, Horizontal::Xy(1.0, 0.0));
    assert!(track.notes.iter().any(|note| note.starts_with("2 fixes repeat")), "{:?}", track.notes);
}

#[test]
fn rows_are_refused_with_line_and_column() {
    assert_error(
        "t,x,y,z\n0,0,0,0\n2,0,0,0\n1,0,0,0\n",
        &["path.csv", "line 4", "out of order", "line 3", "sort"],
    );
    assert_error("t,x,y,z\n0,0,0,nan\n", &["line 2", "column z", "finite"]);
    assert_error("t,x,y,z\n0,0,inf,0\n", &["line 2", "column y", "finite"]);
    assert_error("t,x,y,z\n0,0,1e999,0\n", &["line 2", "column y", "finite"]);
    assert_error("t;x;y;z\n0;0;1,5;0\n", &["line 2", "column y", "decimal point"]);
    assert_error("t,x,y,z\n0,0,1,5,0\n", &["line 2", "5 cells", "names 4", "decimal point"]);
    assert_error("t,x,y,z\n0,0,0\n", &["line 2", "column z"]);
    assert_error("# c\n\nt,x,y,z\n0,,0,0\n", &["line 4", "column x", "empty"]);
    assert_error("t,x,y,z,pitch\n0,0,0,0,91\n", &["line 2", "pitch 91"]);
    assert_error("t,x,y,z,hfov\n0,0,0,0,180\n", &["line 2", "hfov 180"]);
    assert_error("time,x,y,z\nnoon,0,0,0\n", &["line 2", "column time", "ISO 8601"]);
    assert_error("time,x,y,z\n1700000000000,0,0,0\n", &["line 2", "time_ms"]);
    assert_error("t,x,y,z\n0,1e12,0,0\n", &["line 2", "from the origin"]);
    assert_error("t,x,y,z\n", &["no fix"]);
}

#[test]
fn headers_are_refused_with_accepted_spellings() {
    assert_error("0,1,2,3\n", &["line 1", "no header", "time_s,lon_deg,lat_deg,alt_msl_m"]);
    assert_error("x,y,z\n0,1,2\n", &["line 1", "missing", "time_s"]);
    assert_error("t,lon,z\n0,1,2\n", &["line 1", "missing", "lat_deg", "x_m"]);
    assert_error("t,x,y\n0,1,2\n", &["line 1", "missing", "alt_msl_m"]);
    assert_error("t,x,y,alt_fl\n0,1,2,3\n", &["line 1", "alt_fl", "alt_msl_m"]);
    assert_error("t,x,y,z,yaw_mils\n0,1,2,3,4\n", &["line 1", "yaw_mils", "yaw_deg"]);
    assert_error("t,lat_rate_dps,lon,alt\n0,1,2,3\n", &["missing", "lat_deg"]);
}

#[test]
fn swapped_axes_are_told_from_wrong_latitudes() {
    assert_error("t,lat,lon,z\n0,-122,37,3\n", &["line 2", "swapped"]);
    let message = parse("t,lat,lon,z\n0,95,-122,3\n").unwrap_err().to_string();
    assert!(message.contains("latitude 95") && !message.contains("swapped"), "{message}");
    assert_error("t,lat,lon,z\n0,5,400,3\n", &["line 2", "longitude 400"]);
}
