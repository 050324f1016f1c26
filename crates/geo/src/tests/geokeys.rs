use proptest::prelude::*;

use crate::{Crs, GeoKeys, Transform, VerticalDatum, parse_geokeys};

/// The directory of keys (id, tag, count, value).
fn directory(keys: &[[u16; 4]]) -> Vec<u16> {
    let count = u16::try_from(keys.len()).expect("few keys");
    [1, 1, 0, count].into_iter().chain(keys.iter().flatten().copied()).collect()
}

fn parse(keys: &[[u16; 4]], doubles: &[f64], ascii: &str) -> GeoKeys {
    parse_geokeys(&directory(keys), doubles, ascii).expect("sound keys")
}

fn refused(keys: &[[u16; 4]], doubles: &[f64], ascii: &str) -> String {
    parse_geokeys(&directory(keys), doubles, ascii).expect_err("unsound keys")
}

fn assert_equals(keys: &GeoKeys, code: u32) {
    let (crs, expected) = (keys.crs.as_ref().expect("a system"), Crs::from_epsg(code).expect("a known code"));
    assert!(crs.is_equivalent(&expected), "{:?} is not EPSG:{code} {:?}", crs.proj(), expected.proj());
}

#[test]
fn codes_decide() {
    let geographic =
        parse(&[[1024, 0, 1, 2], [1025, 0, 1, 2], [2048, 0, 1, 4326], [2054, 0, 1, 9102]], &[], "");
    assert_eq!(geographic.crs, Some(Crs::wgs84()));
    assert!(geographic.pixel_is_point);
    let projected =
        parse(&[[1024, 0, 1, 1], [1025, 0, 1, 1], [3072, 0, 1, 32_651], [3076, 0, 1, 9001]], &[], "");
    assert_eq!(projected.crs.as_ref().and_then(Crs::epsg), Some(32_651));
    assert!(!projected.pixel_is_point);
    let without_model = parse(&[[1026, 34_737, 7, 0], [2048, 0, 1, 4326]], &[], "WGS 84|\0");
    assert_eq!(without_model.crs, Some(Crs::wgs84()), "a code without a model type is believed");
}

#[test]
fn local_files_have_no_system() {
    assert_eq!(parse(&[], &[], "").crs, None);
    assert_eq!(parse(&[[1024, 0, 1, 32_767], [1026, 34_737, 6, 0]], &[], "local|").crs, None);
    assert_eq!(parse(&[[1024, 0, 1, 0]], &[], "").crs, None);

    // They may have names and units.
    let in_feet = parse(&[[1024, 0, 1, 32_767], [1026, 34_737, 6, 0], [3076, 0, 1, 9002]], &[], "local|")
        .local
        .expect("a local system");
    assert_eq!((in_feet.name.as_str(), in_feet.metres_per_unit), ("local", 0.3048));
    assert_eq!(parse(&[], &[], "").local, None);
    assert_eq!(parse(&[[1024, 0, 1, 2], [2048, 0, 1, 4326]], &[], "").local, None);
}

/// As written by an old GDAL for SIRGAS 2000 / UTM 25 S, and for ETRS89 LAEA from the IGNF registry.
#[test]
fn parameters_decide_where_codes_are_missing() {
    let utm = [
        [1024, 0, 1, 1],
        [1026, 34_737, 33, 0],
        [2048, 0, 1, 32_767],
        [2050, 0, 1, 32_767],
        [2054, 0, 1, 9102],
        [2056, 0, 1, 32_767],
        [2057, 34_736, 1, 0],
        [2059, 34_736, 1, 1],
        [2061, 34_736, 1, 2],
        [2062, 34_736, 3, 3],
        [3072, 0, 1, 32_767],
        [3074, 0, 1, 16_125],
        [3076, 0, 1, 9001],
        [0, 0, 0, 0],
    ];

    let doubles = [6_378_137.0, 298.257_222_101, 0.0, 0.0, 0.0, 0.0];
    let keys = parse(&utm, &doubles, "UTM Zone 25, Southern Hemisphere|");
    assert_equals(&keys, 31_985);
    assert_eq!(keys.crs.expect("a system").name(), "UTM Zone 25, Southern Hemisphere");

    let laea = [
        [1024, 0, 1, 1],
        [1026, 34_737, 8, 0],
        [2048, 0, 1, 32_767],
        [2050, 0, 1, 32_767],
        [2054, 0, 1, 9102],
        [2056, 0, 1, 7019],
        [3072, 0, 1, 32_767],
        [3074, 0, 1, 32_767],
        [3075, 0, 1, 10],
        [3076, 0, 1, 9001],
        [3082, 34_736, 1, 2],
        [3083, 34_736, 1, 3],
        [3088, 34_736, 1, 1],
        [3089, 34_736, 1, 0],
    ];

    assert_equals(&parse(&laea, &[52.0, 10.0, 4_321_000.0, 3_210_000.0], "unknown|"), 3035);
}

#[test]
fn false_origins_count_in_the_unit_of_the_file() {
    let feet = [
        [1024, 0, 1, 1],
        [2048, 0, 1, 4269],
        [3072, 0, 1, 32_767],
        [3075, 0, 1, 8],
        [3076, 0, 1, 9003],
        [3078, 34_736, 1, 0],
        [3079, 34_736, 1, 1],
        [3084, 34_736, 1, 2],
        [3085, 34_736, 1, 3],
        [3086, 34_736, 1, 4],
    ];
    let doubles = [41.033_333_333_333_33, 40.666_666_666_666_66, -74.0, 40.166_666_666_666_66, 984_250.0];
    assert_equals(&parse(&feet, &doubles, ""), 2263);
}

#[test]
fn esri_strings_decide_with_their_heights() {
    let text = r#"ESRI PE String = PROJCS["USA_Contiguous_Albers_Equal_Area_Conic_USGS_version",GEOGCS["GCS_North_American_1983",DATUM["D_North_American_1983",SPHEROID["GRS_1980",6378137.0,298.257222101]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.017453292519943295]],PROJECTION["Albers"],PARAMETER["false_easting",0.0],PARAMETER["false_northing",0.0],PARAMETER["central_meridian",-96.0],PARAMETER["standard_parallel_1",29.5],PARAMETER["standard_parallel_2",45.5],PARAMETER["latitude_of_origin",23.0],UNIT["Meter",1.0],VERTCS["NAVD_1988",VDATUM["North_American_Vertical_Datum_1988"],PARAMETER["Vertical_Shift",0.0],PARAMETER["Direction",1.0],UNIT["Centimeter",0.01]]]|"#;
    let length = u16::try_from(text.len()).expect("short");
    let keys = parse(&[[1024, 0, 1, 32_767], [3073, 34_737, length, 0], [3076, 0, 1, 9001]], &[], text);
    assert_equals(&keys, 5070);
    assert_eq!(
        (keys.vertical.datum, keys.vertical.metres_per_unit),
        (Some(VerticalDatum::Navd88), Some(0.01))
    );
}

/// Codes of EPSG's table of units, of horizontal and of vertical keys.
#[test]
fn units_of_keys_are_those_of_the_registry() {
    let linear = |code: u16| {
        let keys = [
            [1024, 0, 1, 1],
            [2048, 0, 1, 4326],
            [3072, 0, 1, 32_767],
            [3074, 0, 1, 16_032],
            [3076, 0, 1, code],
        ];
        parse_geokeys(&directory(&keys), &[], "").map(|keys| keys.crs.expect("a system").metres_per_unit())
    };

    let vertical = |code: u16| {
        let keys = [[1024, 0, 1, 2], [2048, 0, 1, 4326], [4096, 0, 1, 5703], [4099, 0, 1, code]];
        parse_geokeys(&directory(&keys), &[], "").map(|keys| keys.vertical.metres_per_unit)
    };

    let known = [
        (0, 1.0),
        (9001, 1.0),
        (9002, 0.3048),
        (9003, 1200.0 / 3937.0),
        (9005, 0.304_797_265_4),
        (9014, 1.8288),
        (9031, 1.000_013_596_5),
        (9041, 0.304_799_471_538_676),
        (9097, 20.1168),
        (9098, 0.201_168),
        (9301, 20.116_756),
        (1033, 0.01),
    ];

    for (code, metres) in known {
        for found in [linear(code), vertical(code)] {
            let found = found.expect("a known unit").expect("a unit");
            assert!((found / metres - 1.0).abs() < 1e-12, "{code}: {found}");
        }
    }

    // Centimetres per year, an angle, none, and one without a size.
    for code in [1034, 9102, 9999, 32_767] {
        for (refusal, key) in
            [(linear(code).expect_err("no length"), ""), (vertical(code).expect_err("no length"), "4099")]
        {
            assert!(refusal.contains("unit") && refusal.contains(key), "{refusal}");
        }
    }
}

#[test]
fn vertical_codes_and_units() {
    let geographic = |more: &[[u16; 4]]| {
        let mut keys = vec![[1024, 0, 1, 2], [2048, 0, 1, 4326]];
        keys.extend_from_slice(more);
        parse(&keys, &[], "a height|")
    };
    let us_foot = 1200.0 / 3937.0;

    for (code, datum, unit) in [
        (5703, VerticalDatum::Navd88, 1.0),
        (6360, VerticalDatum::Navd88, us_foot),
        (8228, VerticalDatum::Navd88, 0.3048),
        (5773, VerticalDatum::Egm96, 1.0),
        (3855, VerticalDatum::Egm2008, 1.0),
        (5030, VerticalDatum::Ellipsoid, 1.0),
        (4979, VerticalDatum::Ellipsoid, 1.0),
    ] {
        let keys = geographic(&[[4096, 0, 1, code]]);
        assert_eq!((keys.vertical.datum, keys.vertical.metres_per_unit), (Some(datum), Some(unit)), "{code}");
    }

    let feet = geographic(&[[4096, 0, 1, 5703], [4099, 0, 1, 9003]]);
    assert_eq!(feet.vertical.metres_per_unit, Some(us_foot), "the unit key decides");
    let unit_only = geographic(&[[4099, 0, 1, 9002]]);
    assert_eq!((unit_only.vertical.datum, unit_only.vertical.metres_per_unit), (None, Some(0.3048)));
    assert_eq!(
        geographic(&[[4096, 0, 1, 5621]]).vertical.name.as_deref(),
        Some("EPSG:5621 (EVRF2007 height)")
    );
    assert_eq!(
        geographic(&[[4096, 0, 1, 32_767], [4097, 34_737, 9, 0]]).vertical.name.as_deref(),
        Some("a height")
    );
}

#[test]
fn refusals_name_the_key() {
    let cases: [(&[[u16; 4]], &str); 9] = [
        (&[[1024, 0, 1, 3]], "1024"),
        (&[[1024, 0, 1, 1]], "3072"),
        (&[[1024, 0, 1, 2], [2048, 0, 1, 1]], "EPSG:1"),
        (&[[1024, 0, 1, 2], [2048, 0, 1, 32_633]], "2048"),
        (&[[1024, 0, 1, 1], [3072, 0, 1, 4326]], "3072"),
        (&[[1024, 0, 1, 1], [3072, 0, 1, 2263], [3076, 0, 1, 9001]], "3076"),
        (&[[1024, 0, 1, 2], [2048, 0, 1, 4326], [2054, 0, 1, 9105]], "2054"),
        (&[[2057, 34_736, 1, 7]], "34736"),
        (&[[1026, 34_737, 5, 100]], "34737"),
    ];
    for (keys, part) in cases {
        let error = refused(keys, &[1.0, 2.0], "text|");
        assert!(error.contains(part), "{keys:?}: {error}");
    }
    assert!(parse_geokeys(&[1, 1, 0], &[], "").is_err_and(|error| error.contains("34735")));
    assert!(parse_geokeys(&[9, 1, 0, 0], &[], "").is_err_and(|error| error.contains("version 9")));
}

/// The directory of a WorldWind elevation export: seven keys announced, six there, and heights that are above the
/// sea although the keys say ellipsoid.
#[test]
fn broken_directories_give_codes_only() {
    let mut words = directory(&[
        [1024, 0, 1, 2],
        [1025, 0, 1, 1],
        [2048, 0, 1, 4326],
        [2054, 0, 1, 9102],
        [4096, 0, 1, 5030],
        [4099, 0, 1, 9001],
    ]);
    words[3] = 7;
    let keys = parse_geokeys(&words, &[], "").expect("sound codes");
    assert_eq!(keys.crs, Some(Crs::wgs84()));
    assert_eq!((keys.vertical.datum, keys.vertical.metres_per_unit), (None, None));
    assert!(keys.vertical.name.is_some());
    let mut words = directory(&[[1024, 0, 1, 1], [2048, 0, 1, 4326], [3072, 0, 1, 32_767], [3075, 0, 1, 1]]);
    words[3] = 9;
    assert!(parse_geokeys(&words, &[], "").is_err_and(|error| error.contains("breaks off")));
}

/// Ids, places, codes and numbers that mean something, so that random keys get far.
fn key() -> impl Strategy<Value = [u16; 4]> {
    let ids = prop_oneof![1024u16..=1026, 2048u16..=2062, 3072u16..=3096, 4096u16..=4099, any::<u16>()];
    let tags = prop_oneof![4 => Just(0u16), 4 => Just(34_736), 1 => Just(34_737), 1 => any::<u16>()];
    let values = prop_oneof![0u16..30, 4000u16..9300, 16_000u16..16_200, 32_600u16..32_800, any::<u16>()];
    (ids, tags, 0u16..8, values).prop_map(|(id, tag, count, value)| [id, tag, count, value])
}

proptest! {
    #[test]
    fn random_keys_never_panic(
        keys in prop::collection::vec(key(), 0..16),
        method in 0u16..32,
        doubles in prop::collection::vec(prop_oneof![-90.0..90.0, Just(0.0), Just(6_378_137.0), any::<f64>()], 0..10),
        ascii in ".{0,40}",
        cut in 0usize..4,
    ) {
        let mut all = vec![[1024, 0, 1, 1], [3075, 0, 1, method], [2056, 0, 1, 7030]];
        all.extend(keys);
        let mut words = directory(&all);
        words.truncate(words.len() - cut);
        if let Ok(GeoKeys { crs: Some(crs), .. }) = parse_geokeys(&words, &doubles, &ascii)
            && let Ok(transform) = Transform::new(&crs, &Crs::wgs84())
            && !transform.is_identity()
        {
            for (x, y) in [(0.0, 0.0), (5e5, 5e6), (-1e7, 1e7)] {
                if let Some((longitude, latitude)) = transform.apply(x, y) {
                    prop_assert!(longitude.is_finite() && latitude.abs() <= 90.0);
                }
            }
        }
    }
}
