use std::fs;

use crate::{Crs, VerticalDatum};

fn refused(text: &str) -> String {
    Crs::from_user(text).expect_err(text).to_string()
}

#[test]
fn users_may_name_a_system_in_many_ways() {
    let zone = Crs::from_epsg(32_633).expect("a known code");
    for text in ["EPSG:32633", "epsg:32633", " 32633 ", "urn:ogc:def:crs:EPSG::32633", "+init=epsg:32633"] {
        assert_eq!(Crs::from_user(text).expect(text), zone);
    }
    assert_eq!(zone.name(), "WGS 84 / UTM zone 33N");
    assert_eq!(zone.epsg(), Some(32_633));
    let typed =
        Crs::from_user("+proj=utm +zone=33 +datum=WGS84 +units=m +no_defs +type=crs").expect("a definition");
    assert!(typed.is_equivalent(&zone) && typed.epsg().is_none());
    assert!(Crs::from_user("LOCAL").expect("local").is_local());
}

#[test]
fn files_hold_systems_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("area.prj");
    fs::write(&path, "\u{feff}+proj=utm +zone=33 +datum=WGS84\n").expect("written");
    let read = Crs::from_user(path.to_str().expect("a plain path")).expect("a definition");
    assert!(read.is_equivalent(&Crs::from_epsg(32_633).expect("a known code")));
    fs::write(&path, "PROJCS[\"x\"").expect("written");
    let error = refused(path.to_str().expect("a plain path"));
    assert!(error.contains("area.prj") && error.contains("breaks off"), "{error}");
    assert!(refused(folder.path().join("none.prj").to_str().expect("a plain path")).contains("cannot read"));
}

#[test]
fn compound_systems_bring_their_heights() {
    for (text, code, datum) in [
        ("EPSG:4326+5773", 4326, VerticalDatum::Egm96),
        ("EPSG:9518", 9518, VerticalDatum::Egm2008),
        ("EPSG:4979", 4979, VerticalDatum::Ellipsoid),
        ("EPSG:5498", 5498, VerticalDatum::Navd88),
    ] {
        let (crs, vertical) = Crs::with_vertical_from_user(text).expect(text);
        assert_eq!((crs.epsg(), vertical.expect(text).datum), (Some(code), Some(datum)), "{text}");
        assert!(crs.is_geographic());
    }
    let (feet, vertical) = Crs::with_vertical_from_user("EPSG:2263+6360").expect("compound");
    assert!(!feet.is_metric());
    assert_eq!(vertical.expect("heights").metres_per_unit, Some(1200.0 / 3937.0));
}

#[test]
fn refusals_say_what_to_do() {
    for (text, remedy) in [
        ("EPSG:1", "--crs '+proj="),
        ("EPSG:99999999", "--crs '+proj="),
        ("EPSG:5773", "--src-vdatum"),
        ("EPSG:x", "EPSG:32633"),
        ("EPSG:4326+1", "--src-vdatum"),
        ("WGS 72 of ours", "EPSG:32633"),
        ("", "EPSG:32633"),
        ("+proj=nothing", "gdalwarp"),
        ("+zone=33", "+proj"),
        ("+proj=utm +zone=99", "+proj=utm +zone=99"),
        ("+proj=longlat +ellps=clrk66 +nadgrids=conus", "+towgs84"),
        ("EPSG:4978", "gdalwarp"),
        ("EPSG:4807", "units of 0.9 degrees"),
    ] {
        let error = refused(text);
        assert!(error.contains(remedy), "{text}: {error}");
    }

    let error = Crs::from_epsg(7).expect_err("no such code").to_string();
    assert!(error.contains("EPSG:7"), "{error}");
}

#[test]
fn units_are_known() {
    let of = |text| Crs::from_user(text).expect(text).metres_per_unit();
    assert_eq!(of("EPSG:32633"), Some(1.0));
    assert_eq!(of("EPSG:2263"), Some(1200.0 / 3937.0));
    assert_eq!(of("EPSG:4326"), None);
    assert_eq!(of("local"), Some(1.0));
    assert!(Crs::local().is_metric() && !Crs::wgs84().is_metric());
}

#[test]
fn records_come_back() {
    for text in
        ["EPSG:32633", "EPSG:3857", "EPSG:26711", "local", "+proj=laea +lat_0=50 +lon_0=10 +ellps=GRS80"]
    {
        let crs = Crs::from_user(text).expect(text);
        let record = Crs::from_record(crs.name(), crs.epsg(), crs.proj()).expect(text);
        assert_eq!(record, crs);
    }
    assert!(Crs::from_record("broken", None, Some("+proj=")).is_err());
}

#[test]
fn areas_find_their_metric_system() {
    for (what, bounds, code) in [
        ("Mount Rainier", [-122.0, 46.0, -121.0, 47.0], 32_610),
        ("Olinda", [-34.9, -8.1, -34.8, -7.9], 32_725),
        ("a tall narrow country", [-75.0, -55.0, -67.0, -17.0], 32_719),
        ("18° around a zone", [6.0, -5.0, 24.0, 5.0], 32_633),
        ("30° along the equator", [0.0, -5.0, 30.0, 5.0], 4087),
        ("Europe", [-10.0, 35.0, 30.0, 70.0], 32_632),
        ("the planet", [-180.0, -90.0, 180.0, 90.0], 4087),
        ("the planet from 0", [0.0, -90.0, 360.0, 90.0], 4087),
        ("across the 180th meridian", [179.0, -18.0, -179.0, -16.0], 32_701),
        ("the same from 0", [179.0, -18.0, 181.0, -16.0], 32_701),
        ("North Pole", [-180.0, 85.0, 180.0, 90.0], 32_661),
        ("South Pole", [-180.0, -90.0, 180.0, -85.0], 32_761),
        ("the Arctic", [-180.0, 60.0, 180.0, 90.0], 3995),
        ("Antarctica", [-180.0, -90.0, 180.0, -60.0], 3031),
        ("nonsense", [f64::NAN, 0.0, 1.0, 1.0], 4087),
    ] {
        let crs = Crs::metric_for(bounds);
        assert_eq!(crs.epsg(), Some(code), "{what}");
        assert!(crs.is_metric(), "{what}");
    }

    for code in (32_601..=32_661).chain(32_701..=32_761).chain([3995, 3031, 4087]) {
        assert!(Crs::from_epsg(code).is_ok_and(|crs| crs.is_metric()), "EPSG:{code}");
    }
}

/// Places where PROJ knows no shift are told, beside those of the same system where it does.
#[test]
fn doubts_are_about_places() {
    let near = |[x, y]: [f64; 2]| [x - 0.1, y - 0.1, x + 0.1, y + 0.1];
    let table = [
        ("EPSG:26194", [558_018.0, 374_323.0], "for this area no shift of"),
        ("EPSG:26191", [500_000.0, 300_000.0], "good to 7 m"),
        ("EPSG:4214", [108.0, 37.0], "good to 1 to 15 m"),
        ("EPSG:4214", [79.1, 33.9], "for this area no shift of"),
        ("EPSG:32632", [500_000.0, 5_000_000.0], ""),
        ("EPSG:25832", [500_000.0, 5_000_000.0], ""),
    ];
    for (code, place, part) in table {
        let doubt = Crs::from_user(code).expect(code).doubt(near(place)).unwrap_or_default();
        assert!(doubt.contains(part) && doubt.is_empty() == part.is_empty(), "{code} {place:?}: {doubt}");
    }
}
