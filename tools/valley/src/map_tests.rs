//! The map and the scan against what they show.

use std::io::Cursor;

use glam::{DVec2, DVec3, dvec2};

use crate::features::{Feature, Geometry};
use crate::geotiff::ORIGIN;
use crate::grid::{SIDE, around, sample};
use crate::land_cover::Class;
use crate::map::{self, MAST, PYLON};
use crate::outline::area;
use crate::tests::{SAMPLE, densely};
use crate::{path, roads, scan, sites};

fn features() -> Vec<Feature> {
    map::draw(&SAMPLE)
}

fn distance(a: DVec2, b: DVec2) -> f64 {
    (a.x - b.x).hypot(a.y - b.y)
}

/// Whether two segments cross: the ends of each lie on both sides of the other.
fn cross(a: [DVec2; 2], b: [DVec2; 2]) -> bool {
    let side = |[p, q]: [DVec2; 2], r: DVec2| (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
    side(a, b[0]) * side(a, b[1]) < 0.0 && side(b, a[0]) * side(b, a[1]) < 0.0
}

/// Places of a feature a metre apart, corners included.
fn places(feature: &Feature) -> Vec<DVec2> {
    let line = match &feature.geometry {
        Geometry::Point(place) => return vec![*place],
        Geometry::Line(line) => line.clone(),
        Geometry::Polygon(ring) => ring.iter().chain(ring.first()).copied().collect(),
    };
    let between = |pair: &[DVec2]| {
        let (a, b) = (pair[0], pair[1]);
        let count = distance(a, b).ceil() as usize;
        (0..=count).map(move |k| {
            let t = k as f64 / count as f64;
            a + t * (b - a)
        })
    };
    line.windows(2).flat_map(between).collect()
}

#[test]
fn text_is_a_collection_of_a_feature_a_line() {
    let features = features();
    let text = crate::features::to_geojson(&features);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), features.len() + 2);
    assert!(lines[0].contains("urn:ogc:def:crs:EPSG::32632"));
    for line in &lines[1..lines.len() - 1] {
        assert!(line.starts_with("{\"type\":\"Feature\",\"geometry\":{\"type\":\""), "{line}");
        assert_eq!(line.matches('{').count(), line.matches('}').count(), "{line}");
        assert_eq!(line.matches('[').count(), line.matches(']').count(), "{line}");
        assert_eq!(line.matches('"').count() % 2, 0, "{line}");
    }
    let trees = features.iter().filter(|feature| feature.text("natural") == Some("tree")).count();
    assert!((400..=1600).contains(&trees), "{trees} trees");
    assert!(text.len() < 400_000, "{} bytes", text.len());
}

#[test]
fn rings_run_counterclockwise_and_do_not_cross_themselves() {
    let mut waters = 0;
    for feature in features() {
        let Geometry::Polygon(ring) = &feature.geometry else { continue };
        assert!(area(ring) > 20.0, "{} m²", area(ring));
        waters += usize::from(feature.text("natural") == Some("water"));
        let side = |k: usize| [ring[k], ring[(k + 1) % ring.len()]];
        for (k, corner) in ring.iter().enumerate() {
            assert!(distance(side(k)[0], side(k)[1]) > 0.05, "two corners at {corner:?}");
            for other in 0..k {
                assert!(!cross(side(k), side(other)), "sides {other} and {k} cross at {corner:?}");
            }
        }
    }
    assert_eq!(waters, 3, "the lake, and the river on both sides of it");
}

#[test]
fn water_lies_where_it_is_drawn() {
    let features = features();
    let rings: Vec<&Vec<DVec2>> = features
        .iter()
        .filter(|feature| feature.text("natural") == Some("water"))
        .filter_map(|feature| match &feature.geometry {
            Geometry::Polygon(ring) => Some(ring),
            _ => None,
        })
        .collect();

    let total: f64 = rings.iter().map(|ring| area(ring)).sum();
    let wet = SAMPLE.water.outside.iter().filter(|&&outside| outside <= 0.0).count() as f64 * 6.25;
    assert!((total / wet - 1.0).abs() < 0.02, "{total} m² of {wet} m²");
    for place in rings.into_iter().flatten() {
        let pixel = around(place.x.min(SIDE - 1.0), place.y.max(1.0), 0.0).next().unwrap();
        // Rings also run where river and lake meet.
        let off = SAMPLE.water.outside[pixel].abs().min(SAMPLE.water.beside_lake[pixel].abs());
        let at_edge = place.to_array().into_iter().any(|metres| !(2.6..SIDE - 2.6).contains(&metres));
        assert!(off < 3.6 || at_edge, "{off} m off the shore at {place:?}");
    }
}

#[test]
fn buildings_stand_beside_each_other_roads_and_water() {
    let buildings = &SAMPLE.valley.buildings;
    for (k, building) in buildings.iter().enumerate() {
        for other in &buildings[..k] {
            assert!(!building.overlaps(other), "{}, {}", building.x, building.y);
        }
        for road in &SAMPLE.roads {
            let hit = road.line.iter().any(|place| building.covers(place.x, place.y, road.half));
            assert!(!hit, "a road runs through {}, {}", building.x, building.y);
        }
        for DVec2 { x, y } in building.corners(0.0) {
            let pixel = around(x, y, 0.0).next().unwrap();
            assert!(SAMPLE.water.outside[pixel] > 3.0, "in water at {x}, {y}");
        }
    }
}

#[test]
fn what_stands_is_free_of_roads_buildings_and_water() {
    for feature in features() {
        let solid = ["man_made", "barrier", "power"].iter().any(|key| feature.text(key).is_some());
        let is_tree = feature.text("natural") == Some("tree");
        let reach = feature.number("diameter").map_or(0.3, |diameter| diameter / 2.0);
        let stands = match &feature.geometry {
            Geometry::Line(line) if feature.text("power").is_some() => line.clone(),
            _ => places(&feature),
        };

        for DVec2 { x, y } in stands.into_iter().filter(|_| solid || is_tree) {
            let pixel = around(x, y, 0.0).next().unwrap();
            assert!(
                roads::outside(&SAMPLE.roads, pixel) > reach,
                "{:?} on a road at {x}, {y}",
                feature.tags[0].key
            );
            assert!(SAMPLE.water.outside[pixel] > reach, "{:?} in water at {x}, {y}", feature.tags[0].key);
            let inside = SAMPLE.valley.buildings.iter().any(|building| building.covers(x, y, reach));
            assert!(!inside, "{:?} in a building at {x}, {y}", feature.tags[0].key);
        }
    }
}

#[test]
fn bridges_join_their_road_and_cross_the_water() {
    let features = features();
    let lines = |bridge: bool| {
        let roads = features.iter().filter(|feature| feature.text("highway").is_some());
        roads.filter(move |feature| feature.text("bridge").is_some() == bridge).map(|feature| match &feature
            .geometry
        {
            Geometry::Line(line) => line,
            _ => panic!("a road that is no line"),
        })
    };

    assert_eq!(lines(true).count(), 1);
    for bridge in lines(true) {
        let (first, last) = (bridge[0], *bridge.last().unwrap());
        assert!(lines(false).any(|line| line.last() == Some(&first)));
        assert!(lines(false).any(|line| line.first() == Some(&last)));
        for place in [first, last] {
            let pixel = around(place.x, place.y, 0.0).next().unwrap();
            assert!(SAMPLE.water.outside[pixel] > 8.0, "ends in the river at {place:?}");
        }
    }

    // Everywhere else roads stay dry, and below the bridge there is water.
    for feature in features.iter().filter(|feature| feature.text("highway").is_some()) {
        let wet = places(feature).into_iter().any(|place| {
            around(place.x, place.y, 0.0).next().is_some_and(|pixel| SAMPLE.water.outside[pixel] <= 0.0)
        });
        assert_eq!(wet, feature.text("bridge").is_some(), "{:?}", places(feature)[0]);
    }
}

#[test]
fn flight_clears_pylons_wires_and_mast() {
    let bare = &SAMPLE.valley.bare;
    let top = |place: &DVec2, height: f64| place.extend(sample(bare, place.x, place.y) + height);
    let mut tops = vec![top(&map::hilltop(bare), MAST)];
    for pair in sites::LINE.windows(2) {
        let (a, b) = (top(&pair[0], PYLON), top(&pair[1], PYLON));
        // Wires hang below the straight line from top to top.
        tops.extend((0..=20).map(|k| {
            let t = f64::from(k) / 20.0;
            a + t * (b - a)
        }));
    }
    for eye in densely(&path::fly(&SAMPLE.valley.surface)) {
        for &DVec3 { x, y, z: top } in
            tops.iter().filter(|top| distance(eye.truncate(), top.truncate()) < 60.0)
        {
            assert!(eye.z - top >= 20.0, "{} m above {x}, {y}", eye.z - top);
        }
    }
}

#[test]
fn wires_hang_above_the_ground() {
    let bare = &SAMPLE.valley.bare;
    for pair in sites::LINE.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let hung = |place: DVec2| sample(bare, place.x, place.y) + 0.72 * PYLON;
        let sag = 1e-4 * distance(a, b).powi(2);
        for k in 0..=40 {
            let t = f64::from(k) / 40.0;
            let ground = sample(bare, a.x + t * (b.x - a.x), a.y + t * (b.y - a.y));
            let wire = hung(a) + t * (hung(b) - hung(a)) - 4.0 * sag * t * (1.0 - t);
            assert!(wire - ground > 8.0, "{} m between {a:?} and {b:?}", wire - ground);
        }
    }
}

#[test]
fn airstrip_lies_on_grass_and_is_free() {
    let [a, b] = sites::strip_ends();
    for k in 0..=66 {
        let t = f64::from(k) / 66.0;
        let DVec2 { x, y } = a + t * (b - a);
        for pixel in around(x, y, 11.0) {
            assert_eq!(SAMPLE.valley.classes[pixel], Class::Pasture);
            assert!(SAMPLE.valley.surface[pixel] - SAMPLE.valley.bare[pixel] < 0.3, "something at {x}, {y}");
        }
    }
    let standing = features().into_iter().filter(|feature| feature.text("aeroway").is_none());
    for place in standing.flat_map(|feature| places(&feature)) {
        let kept = sites::kept(place.x, place.y);
        let on_strip = matches!(kept, Some(sites::Kept::Strip { .. } | sites::Kept::Verge));
        assert!(!on_strip, "a feature at {place:?}");
    }
}

#[test]
fn scan_joins_the_ground_and_shows_the_farm() {
    let bytes = scan::encode(&scan::take(&SAMPLE.valley)).unwrap();
    assert!(bytes.len() < 350_000, "{} bytes", bytes.len());
    let mut reader = las::Reader::new(Cursor::new(bytes)).unwrap();
    assert!(reader.header().vlrs().iter().any(|record| record.user_id == "LASF_Projection"));
    let mut counts = [0usize; 7];

    for point in reader.read_all().unwrap().points() {
        let point = point.unwrap();
        let (x, y) = (point.x - ORIGIN.x, point.y - ORIGIN.y);
        let (ground, class) = (sample(&SAMPLE.valley.bare, x, y), u8::from(point.classification));
        counts[usize::from(class)] += 1;
        assert!(sites::beside(sites::FARM, x, y) <= 0.01, "beside the farm at {x}, {y}");
        match class {
            scan::GROUND => assert!((point.z - ground).abs() < 0.02, "{} m off the ground", point.z - ground),
            scan::BUILDING => assert!((0.2..12.0).contains(&(point.z - ground)), "{}", point.z - ground),
            _ => assert!((0.2..15.0).contains(&(point.z - ground)), "{}", point.z - ground),
        }
        assert!(point.color.is_some());
    }

    let [_, _, ground, low, _, high, building] = counts;
    assert!(ground > 20_000 && building > 3_000 && high > 2_000 && low > 300, "{counts:?}");
    for pixel in around(1705.0, 1310.0, 38.0) {
        assert_eq!(SAMPLE.valley.classes[pixel], Class::Pasture);
    }

    let inside = |feature: &Feature| {
        places(feature).iter().any(|place| sites::beside(sites::FARM, place.x, place.y) < 0.0)
    };
    assert!(!features().iter().any(inside));
    let nearest =
        SAMPLE.valley.buildings.iter().map(|house| distance(dvec2(house.x, house.y), dvec2(1705.0, 1310.0)));
    assert!(nearest.fold(f64::INFINITY, f64::min) > 250.0);
}
