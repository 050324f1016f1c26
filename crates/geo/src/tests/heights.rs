use crate::{VerticalDatum, VerticalShift, egm96_undulation};

/// Longitude, latitude, undulation: the test values that NGA published with its EGM96 programs (F477, WW15MGH), metres.
const PUBLISHED: [(f64, f64, f64); 6] = [
    (269.779_155_0, 38.628_155_0, -31.628),
    (305.021_1, -14.621_217_0, -2.969),
    (102.448_729_5, 46.874_319_0, -43.575),
    (133.874_712_0, -23.617_446_0, 15.871),
    (359.999_500_0, 38.625_473_0, 50.066),
    (0.002_300_0, -0.466_744_0, 17.329),
];

/// What interpolation may add, metres (it is 8 mm in the mean, and up to 0.12 m over the steepest geoid).
const INTERPOLATION: f64 = 0.03;

#[test]
fn undulations_are_the_published_ones() {
    for (longitude, latitude, published) in PUBLISHED {
        let found = egm96_undulation(longitude, latitude);
        assert!((found - published).abs() < INTERPOLATION, "{found}, not {published}");
    }
}

#[test]
fn undulations_are_one_around_the_globe() {
    let close = |one: f64, two: f64| (one - two).abs() < 1e-9;
    assert!(close(egm96_undulation(-90.220_845, 38.628_155), egm96_undulation(269.779_155, 38.628_155)));
    assert!(close(egm96_undulation(180.0, 10.0), egm96_undulation(-180.0, 10.0)));
    assert!(close(egm96_undulation(0.0, 90.0), egm96_undulation(123.25, 90.0)));
    assert!((egm96_undulation(0.0, 90.0) - 13.606).abs() < 0.01, "{}", egm96_undulation(0.0, 90.0));
    assert!((egm96_undulation(0.0, -90.0) + 29.534).abs() < 0.01, "{}", egm96_undulation(0.0, -90.0));
    // A node, and a hair's breadth to either side of it.
    let (west, at, east) = (
        egm96_undulation(10.249_999_9, 45.0),
        egm96_undulation(10.25, 45.0),
        egm96_undulation(10.250_000_1, 45.0),
    );
    assert!((west - at).abs() < 1e-4 && (east - at).abs() < 1e-4);
    assert!(egm96_undulation(f64::NAN, 0.0).is_nan());
}

#[test]
fn datums_convert_or_say_why_not() {
    use VerticalDatum::{Egm96, Egm2008, Ellipsoid, Msl, Navd88};

    for datum in [Msl, Egm96, Egm2008, Ellipsoid, Navd88] {
        assert_eq!(VerticalDatum::parse(datum.key()).expect("its own key"), datum);
        assert_eq!(VerticalDatum::conversion(datum, datum).expect("the same"), VerticalShift::None);
    }

    assert_eq!(
        VerticalDatum::conversion(Ellipsoid, Egm96).expect("computed"),
        VerticalShift::MinusEgm96Undulation
    );
    assert_eq!(
        VerticalDatum::conversion(Msl, Ellipsoid).expect("computed"),
        VerticalShift::PlusEgm96Undulation
    );
    for (from, to) in [(Navd88, Msl), (Egm2008, Ellipsoid), (Egm96, Navd88), (Navd88, Egm2008)] {
        let error = VerticalDatum::conversion(from, to).expect_err("no grid").to_string();
        assert!(error.contains("--src-vdatum") && error.contains(from.label()), "{error}");
    }

    let error = VerticalDatum::parse("egm69").expect_err("unknown").to_string();
    assert!(error.contains("egm96, egm2008, ellipsoid, navd88, msl"), "{error}");
}

#[test]
fn ellipsoid_heights_come_down_to_the_sea() {
    let (longitude, latitude, published) = PUBLISHED[4];
    let height = VerticalDatum::Ellipsoid.to_msl(longitude, latitude, 150.066).expect("computed");
    assert!((height - (150.066 - published)).abs() < INTERPOLATION, "{height}");
    assert_eq!(VerticalDatum::Egm96.to_msl(longitude, latitude, 100.0).expect("the same"), 100.0);
    assert!(VerticalDatum::Navd88.to_msl(longitude, latitude, 100.0).is_err());
}
