use crate::{Crs, GridNorth, Transform, grid_convergence};

/// EPSG code, longitude and latitude on the system's own datum (degrees), easting and northing by PROJ 9.5.1.
const PROJ_9_5: [(u32, [f64; 2], [f64; 2]); 19] = [
    (32_633, [15.5, 47.2], [537_870.671_096, 5_227_511.019_152]),
    (32_633, [12.1, -3.0], [177_604.046_169, -332_020.464_192]),
    (32_719, [-70.6, -33.4], [351_205.064_622, 6_303_223.750_659]),
    (3857, [-122.4, 37.7], [-13_625_505.673_097, 4_537_132.130_043]),
    (3857, [180.0, 85.0], [20_037_508.342_789, 19_971_868.880_409]),
    (3035, [-3.1, 54.5], [3_477_442.782_688, 3_564_981.811_345]),
    (3035, [25.0, 60.0], [5_152_827.253_890, 4_188_383.611_105]),
    (31_985, [-34.9, -8.0], [290_584.397_709, 9_115_218.772_919]),
    (4087, [12.5, 45.25], [1_391_493.634_916, 5_037_206.958_396]),
    (2154, [2.35, 48.85], [652_301.564_831, 6_861_302.725_900]),
    (5070, [-105.6, 40.3], [-807_606.753_114, 1_961_414.802_435]),
    (3995, [30.0, 75.0], [819_391.619_204, -1_419_227.915_757]),
    (3031, [-60.0, -75.0], [-1_419_227.915_757, 819_391.619_204]),
    (32_661, [45.0, 86.0], [2_314_145.219_066, 1_685_854.780_934]),
    (32_761, [-120.0, -85.0], [1_518_959.788_343, 1_722_271.304_309]),
    (2263, [-73.98, 40.75], [989_791.457_349, 212_522.519_239]),
    (3395, [10.0, 50.0], [1_113_194.907_933, 6_413_524.594_164]),
    (28_992, [5.4, 52.2], [155_844.967_081, 467_877.110_879]),
    (2193, [174.8, -41.3], [1_750_697.521_334, 5_426_376.623_168]),
];

/// Farthest from PROJ that a forward transform may come to lie, units of the system. The values above have six decimals.
const FORWARD: f64 = 2e-6;
/// Farthest that a place may be after going there and back, degrees (1 mm).
const THERE_AND_BACK: f64 = 1e-8;

fn crs(code: u32) -> Crs {
    Crs::from_epsg(code).expect("a known code")
}

/// The geographic system on the datum of `crs`.
fn geographic(crs: &Crs) -> Crs {
    const KEYS: [&str; 8] = ["+datum=", "+ellps=", "+a=", "+b=", "+rf=", "+R=", "+towgs84=", "+pm="];
    let words = crs.proj().expect("a placed system").split(' ');
    let datum: Vec<&str> = words.filter(|word| KEYS.iter().any(|key| word.starts_with(key))).collect();
    let datum = datum.join(" ");
    Crs::from_proj(&format!("+proj=longlat {datum}"), "geographic").expect("a sound definition")
}

#[test]
fn projections_agree_with_proj() {
    for (code, [longitude, latitude], [x, y]) in PROJ_9_5 {
        let projected = crs(code);
        let geographic = geographic(&projected);
        let forward = Transform::new(&geographic, &projected).expect("a transform");
        let found = forward.apply(longitude, latitude).expect("inside the domain");
        assert!((found.0 - x).hypot(found.1 - y) < FORWARD, "EPSG:{code}: {found:?}, not {x} {y}");
        let back = Transform::new(&projected, &geographic).expect("a transform").apply(x, y);
        let back = back.expect("inside the domain");
        assert!(
            (back.0 - longitude).hypot(back.1 - latitude) < THERE_AND_BACK,
            "EPSG:{code}: back at {back:?}"
        );
    }
}

/// Helmert shifts by PROJ 9.5.1 with the same `+towgs84`; the height is taken as 0, which moves places by millimetres.
#[test]
fn datum_shifts_agree_with_proj() {
    let to_britain = Transform::new(&Crs::wgs84(), &crs(27_700)).expect("a transform");
    let (x, y) = to_britain.apply(-1.5, 53.2).expect("inside the domain");
    assert!((x - 433_498.111_6).hypot(y - 367_108.033_3) < 0.005, "{x} {y}");

    // NAD27 to WGS 84 (6), which PROJ takes west of 90° W.
    let from_nad27 = Transform::new(&crs(26_711), &Crs::wgs84()).expect("a transform");
    let (longitude, latitude) = from_nad27.apply(440_720.0, 3_751_320.0).expect("inside the domain");
    let off = (longitude + 117.642_042_793_35).hypot(latitude - 33.902_368_370_19);
    assert!(off < THERE_AND_BACK, "NAD27 must take the shift of the place, not none: {longitude} {latitude}");
}

#[test]
fn a_whole_planet_keeps_its_borders() {
    let world = crs(4087);
    let there = Transform::new(&Crs::wgs84(), &world).expect("a transform");
    let back = Transform::new(&world, &Crs::wgs84()).expect("a transform");
    let (east, north) = (20_037_508.342_789_244, 10_018_754.171_394_622);

    for (sx, sy) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
        let (x, y) = there.apply(sx * 180.0, sy * 90.0).expect("the corner of the map");
        assert!((x - sx * east).abs() < 1e-6 && (y - sy * north).abs() < 1e-6, "{x} {y}");
        let (longitude, latitude) = back.apply(sx * east, sy * north).expect("the corner of the map");
        assert!(
            (longitude - sx * 180.0).abs() < 1e-9 && (latitude - sy * 90.0).abs() < 1e-9,
            "{longitude} {latitude}"
        );
        let (longitude, _) = back.apply(sx * 20_037_508.34, 0.0).expect("the border");
        assert!((longitude - sx * 180.0).abs() < 1e-7, "{longitude}");
    }

    // A row or column that reaches half a pixel over the border stays beside its neighbour.
    let (x, _) = there.apply(-180.041_666, 0.0).expect("just beyond the border");
    assert!((x + 20_042_146.0).abs() < 20.0, "{x}");
    assert_eq!(there.apply(0.0, 90.041_666), None, "beyond the pole is nowhere");
}

#[test]
fn longitudes_follow_the_raster() {
    let zone_1 = crs(32_601);
    let back = Transform::new(&zone_1, &Crs::wgs84()).expect("a transform").centred_on(180.0);
    let there = Transform::new(&Crs::wgs84(), &zone_1).expect("a transform");
    for longitude in [179.5, 180.5, 183.0] {
        let (x, y) = there.apply(longitude, 65.0).expect("near the zone");
        let found = back.apply(x, y).expect("inside the domain");
        assert!((found.0 - longitude).abs() < THERE_AND_BACK, "{longitude} became {}", found.0);
    }
}

#[test]
fn what_is_nowhere_is_none() {
    let utm = Transform::new(&Crs::wgs84(), &crs(32_633)).expect("a transform");
    let back = Transform::new(&crs(32_633), &Crs::wgs84()).expect("a transform");
    let mercator = Transform::new(&Crs::wgs84(), &crs(3857)).expect("a transform");
    for (x, y) in [(f64::NAN, 0.0), (0.0, f64::INFINITY), (15.0, 90.1), (15.0, -1e9), (1e300, 0.0)] {
        assert_eq!(utm.apply(x, y), None, "{x} {y}");
    }
    assert_eq!(mercator.apply(10.0, 90.0), None);
    assert_eq!(back.apply(1e9, 1e9), None);
    let mut points = [[15.0, 47.0], [15.0, 91.0], [f64::NAN, 1.0]];
    utm.apply_many(&mut points);
    assert_eq!(points.map(|[x, y]| x.is_finite() && y.is_finite()), [true, false, false]);
}

#[test]
fn equivalent_systems_pass_unchanged() {
    let same = [
        ("EPSG:31985", "+proj=tmerc +lat_0=0 +lon_0=-33 +k=0.9996 +x_0=500000 +y_0=10000000 +ellps=GRS80"),
        (
            "EPSG:3035",
            "+proj=laea +lat_0=52 +lon_0=10 +x_0=4321000 +y_0=3210000 +a=6378137 +rf=298.257222101",
        ),
        ("EPSG:4326", "EPSG:4258"),
        ("EPSG:32632", "EPSG:25832"),
        ("EPSG:3857", "EPSG:900913"),
        (
            "EPSG:2263",
            "+proj=lcc +lat_1=41.03333333333333 +lat_2=40.66666666666666 +lat_0=40.16666666666666 +lon_0=-74 +x_0=300000 +datum=NAD83 +to_meter=0.304800609601219",
        ),
        ("local", "local"),
    ];

    for (one, two) in same {
        let (one, two) = (Crs::from_user(one).expect(one), Crs::from_user(two).expect(two));
        let transform = Transform::new(&one, &two).expect("a transform");
        assert!(transform.is_identity(), "{one:?} {two:?}");
        assert_eq!(transform.apply(1.5, -2.5), Some((1.5, -2.5)));
    }

    // NAD83 counts as WGS 84, but lies a metre or two from it in Hawaii.
    for (one, two) in [("EPSG:4326", "EPSG:4269"), ("EPSG:32604", "EPSG:26904")] {
        let (one, two) = (Crs::from_user(one).expect(one), Crs::from_user(two).expect(two));
        assert!(one.is_equivalent(&two) && !Transform::new(&one, &two).expect("a transform").is_identity());
    }

    let different = [
        ("EPSG:32633", "EPSG:32634"),
        ("EPSG:32633", "EPSG:32733"),
        ("EPSG:4326", "EPSG:4267"),
        ("EPSG:3857", "EPSG:3395"),
        ("EPSG:2263", "EPSG:32118"),
        ("EPSG:4326", "+proj=longlat +R=6371000"),
    ];

    for (one, two) in different {
        let (one, two) = (Crs::from_user(one).expect(one), Crs::from_user(two).expect(two));
        assert!(!Transform::new(&one, &two).expect("a transform").is_identity(), "{one:?} {two:?}");
    }

    let error = Transform::new(&Crs::local(), &crs(4326)).expect_err("local coordinates have no place");
    assert!(error.to_string().contains("--local"), "{error}");
}

/// Meridian convergence by PROJ 9.5.1 (`Proj.get_factors`): the grid's north from true north; a heading changes the other way.
#[test]
fn headings_turn_with_the_grid() {
    let utm = grid_convergence(&crs(32_633), 280_356.995_987, 5_231_469.944_402);
    assert!((utm - 2.128_663).abs() < 1e-4, "{utm}");
    let europe = grid_convergence(&crs(3035), 3_477_442.782_688, 3_564_981.811_345);
    assert!((europe - 10.568_989).abs() < 0.05, "an equal-area map turns east and north unequally: {europe}");
    let south = grid_convergence(&crs(3031), -1_419_227.915_757, 819_391.619_204);
    assert!((south + 60.0).abs() < 1e-4, "{south}");
    for plain in [Crs::local(), Crs::wgs84()] {
        assert_eq!(GridNorth::new(&plain).expect("no computation").convergence(10.0, 50.0), 0.0);
    }
}

#[test]
fn threads_share_transforms() {
    fn shared<T: Sync + Send>() {}
    shared::<Transform>();
    shared::<Crs>();
    shared::<GridNorth>();
}
