use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use glam::DVec3;
use tiff::decoder::{Decoder, DecodingResult};

use crate::grid::{SIDE, SIZE, SPACING, sample};
use crate::path::highest_around;
use crate::sample::Sample;
use crate::{Files, files, path, sample as make};

pub static SAMPLE: LazyLock<Sample> = LazyLock::new(make);

/// Files of the sample, with their names.
pub static FILES: LazyLock<Files> = LazyLock::new(|| files(&SAMPLE).unwrap());

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data")
}

/// Samples, and the text of all geographic tags; compressed bytes may differ between deflate implementations.
fn decoded(bytes: &[u8]) -> (Vec<u8>, String) {
    let mut decoder = Decoder::new(std::io::Cursor::new(bytes)).unwrap();
    let tags = [33550u16, 33922, 34735, 42113, 339, 262]
        .map(|tag| format!("{:?}", decoder.find_tag(tiff::tags::Tag::from_u16_exhaustive(tag)).unwrap()));
    let samples = match decoder.read_image().unwrap() {
        DecodingResult::F32(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        DecodingResult::U8(values) => values,
        _ => panic!("another sample type than was written"),
    };
    (samples, tags.join("; "))
}

#[test]
fn committed_files_are_what_the_generator_makes() {
    for (name, made) in FILES.iter() {
        let committed = std::fs::read(data().join(name)).unwrap();
        let same = match name.ends_with(".tif") {
            true => decoded(&committed) == decoded(made),
            false => committed == *made,
        };
        assert!(
            same,
            "{name}: run `cargo run --release -p hedgehop-valley -- data` and update data/README.md"
        );
    }
}

#[test]
fn readme_states_the_hashes_and_the_sample_stays_small() {
    let readme = std::fs::read_to_string(data().join("README.md")).unwrap();
    let mut total = 0;
    for (name, _) in FILES.iter() {
        let bytes = std::fs::read(data().join(name)).unwrap();
        let line = format!("{}  {name}", blake3::hash(&bytes));
        assert!(readme.contains(&line), "data/README.md lacks the line {line}");
        total += bytes.len();
    }
    assert!(total <= 3 << 20, "{total} bytes");
}

/// Places five to each interval of the file.
pub fn densely(places: &[DVec3]) -> Vec<DVec3> {
    places
        .windows(2)
        .flat_map(|pair| {
            let (a, b) = (pair[0], pair[1]);
            (0..5).map(move |k| {
                let t = f64::from(k) / 5.0;
                a + (b - a) * t
            })
        })
        .collect()
}

#[test]
fn flight_clears_everything_beside_and_ahead() {
    let surface = &SAMPLE.valley.surface;
    let places = path::fly(surface);
    for &DVec3 { x, y, z: height } in &densely(&places) {
        let clearance = height - highest_around(surface, x, y);
        assert!(clearance >= 25.0, "{clearance} m at {x}, {y}");
    }

    for pair in places.windows(3) {
        let [a, b, c] = [pair[0], pair[1], pair[2]];
        let heading = |p: DVec3, q: DVec3| (q.x - p.x).atan2(q.y - p.y);
        let turn = (heading(b, c) - heading(a, b) + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
            - std::f64::consts::PI;
        let climb = (c.z - b.z) / (c.x - b.x).hypot(c.y - b.y);
        let bend = climb - (b.z - a.z) / (b.x - a.x).hypot(b.y - a.y);
        // 0.047 rad in half a second at 38 m/s is a bank of 20°.
        assert!(
            turn.abs() < 0.047 && climb.abs() < 0.3 && bend.abs() < 0.06,
            "{turn} {climb} {bend} at {b:?}"
        );
    }
}

/// From every place of the flight, within 50° of the heading, something stands in front of the area's edge.
#[test]
fn end_of_the_world_stays_hidden() {
    let surface = &SAMPLE.valley.surface;
    let places = path::fly(surface);
    for pair in places.windows(2) {
        let DVec3 { x, y, z: height } = pair[0];
        let heading = (pair[1].x - x).atan2(pair[1].y - y);
        for azimuth in -50..=50 {
            let (s, c) = (heading + f64::from(azimuth).to_radians()).sin_cos();
            let mut highest = f64::MIN;
            let mut at_edge = f64::MIN;
            let mut range = 4.0 * SPACING;

            loop {
                let (u, v) = (x + range * s, y + range * c);
                if !(SPACING..SIDE - SPACING).contains(&u) || !(SPACING..SIDE - SPACING).contains(&v) {
                    break;
                }
                at_edge = (sample(surface, u, v) - height) / range;
                highest = highest.max(at_edge);
                range += SPACING;
            }

            assert!(highest > at_edge, "{azimuth}° off the heading at {x}, {y}, {range} m away");
        }
    }
}

#[test]
fn village_has_about_sixty_buildings() {
    let count = SAMPLE.valley.buildings.len();
    assert!((50..=75).contains(&count), "{count}");
}

/// The ground is never above what is seen from above, but where drawings of crowns and slopes are rounded.
#[test]
fn ground_lies_below_the_surface() {
    let valley = &SAMPLE.valley;
    for (pixel, (bare, surface)) in valley.bare.iter().zip(&valley.surface).enumerate() {
        assert!(bare - surface <= 0.3, "{bare} m above {surface} m at pixel {pixel}");
    }
    let standing = valley.bare.iter().zip(&valley.surface).filter(|(bare, surface)| *surface - *bare > 3.0);
    assert!(standing.count() > 50_000);
}

#[test]
fn land_cover_is_made_of_patches() {
    let classes = &SAMPLE.valley.classes;
    let mut counts = BTreeMap::new();
    let mut alone = 0;
    for row in 1..SIZE - 1 {
        for column in 1..SIZE - 1 {
            let pixel = row * SIZE + column;
            let class = classes[pixel];
            *counts.entry(class).or_insert(0) += 1;
            let beside = [pixel - 1, pixel + 1, pixel - SIZE, pixel + SIZE];
            alone += usize::from(beside.iter().all(|&other| classes[other] != class));
        }
    }
    assert_eq!(counts.len(), 14, "{counts:?}");
    assert!(counts.values().all(|&count| count > 300), "{counts:?}");
    assert!(alone < 3000, "{alone} pixels differ from all beside them");
}
