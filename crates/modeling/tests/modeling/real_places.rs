//! Footprints traced from a real picture, on the real ground below it: what stands, what stays as it is, and what an
//! eye below a roof sees.

use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3, Vec3, dvec2};
use serde_json::Value;

use hedgehop::frame::Frame;
use hedgehop::memory::PageFile;
use hedgehop::progress::Silent;
use hedgehop::raymarch::{Contact, Face, LevelBands, Marcher, SolidHit, Surface};
use hedgehop::render::{RenderOptions, Renderer, render_reference};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::voxel::PageSource;
use hedgehop_modeling::{BuildOptions, FeatureFile, build};
use hedgehop_testing::realdata;

/// What is built: west, south, east, north, metres of UTM zone 11. Hangars, apron and terminal, and neither wood nor fence.
const AREA: [f64; 4] = [239_640.0, 3_813_500.0, 239_906.0, 3_813_870.0];

fn footprints() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/places/airport.geojson")
}

/// The area on voxels of a metre, with the footprints or without.
fn airport(data: &Path, folder: &Path, with: bool) -> PageFile {
    let elevation = data.join("sba_airport/sba_elev32_wgs84_512x512.tif");
    let imagery = data.join("sba_airport/sba_rgb_wgs84_512x512.tif");
    let output = folder.join(format!("airport-{with}.hop"));
    let mut options = BuildOptions::new(vec![elevation], vec![imagery], output);
    options.elevation[0].crs = Some("EPSG:4326".into());
    options.crs = Some("EPSG:32611".into());
    (options.spacing, options.bbox) = (Some(1.0), Some(AREA));
    options.features = with.then(|| FeatureFile::from(footprints())).into_iter().collect();
    build(&options, &Silent).unwrap();
    let pages = PageFile::open(&options.output).unwrap();
    assert_eq!(pages.verify(&Silent).unwrap().problems, []);
    pages
}

/// A row of the file: its places and its tags.
struct Row {
    places: Vec<DVec2>,
    tags: Value,
}

impl Row {
    fn metres(&self, key: &str) -> Option<f64> {
        self.tags[key].as_f64()
    }

    fn edges(&self) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
        self.places.windows(2).map(|ends| (ends[0], ends[1]))
    }

    fn holds(&self, place: DVec2) -> bool {
        let crosses = |(a, b): (DVec2, DVec2)| {
            (a.y > place.y) != (b.y > place.y) && place.x < a.x + (place.y - a.y) / (b.y - a.y) * (b.x - a.x)
        };
        self.edges().filter(|edge| crosses(*edge)).count() % 2 == 1
    }

    /// Distance of a place from its line or outline, metres.
    fn distance(&self, place: DVec2) -> f64 {
        let from = |(a, b): (DVec2, DVec2)| {
            let along = ((place - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            place.distance(a + (b - a) * along)
        };
        self.edges().map(from).chain([place.distance(self.places[0])]).fold(f64::INFINITY, f64::min)
    }

    /// The lowest ground along its outline, metres.
    fn foot(&self, pages: &PageFile) -> f64 {
        let along =
            self.edges().flat_map(|(a, b)| (0..200).map(move |part| a.lerp(b, f64::from(part) / 200.0)));
        along.map(|place| ground(pages, place)).fold(f64::INFINITY, f64::min)
    }
}

/// Rows with a form and a tag.
fn rows(kind: &str, tags: &[&str]) -> Vec<Row> {
    let file: Value = serde_json::from_str(&std::fs::read_to_string(footprints()).unwrap()).unwrap();
    let rows = file["features"].as_array().unwrap().iter().filter(|row| {
        row["geometry"]["type"] == kind && tags.iter().any(|tag| !row["properties"][*tag].is_null())
    });
    let place = |place: &Value| dvec2(place[0].as_f64().unwrap(), place[1].as_f64().unwrap());
    rows.map(|row| {
        let coordinates = &row["geometry"]["coordinates"];
        let places = match kind {
            "Point" => vec![place(coordinates)],
            "Polygon" => coordinates[0].as_array().unwrap().iter().map(place).collect(),
            _ => coordinates.as_array().unwrap().iter().map(place).collect(),
        };
        Row { places, tags: row["properties"].clone() }
    })
    .collect()
}

/// Buildings that lie in the area as a whole.
fn buildings() -> Vec<Row> {
    let mut rows = rows("Polygon", &["building", "building:part"]);
    let [west, south, east, north] = AREA;
    let is_within =
        |place: &DVec2| place.x > west + 2.0 && place.x < east - 1.0 && place.y > south && place.y < north;
    rows.retain(|row| row.places.iter().all(is_within));
    rows
}

/// Places all over the area.
fn lattice(step: f64) -> impl Iterator<Item = DVec2> {
    let [west, south, east, north] = AREA;
    let count = move |length: f64| ((length - 8.0) / step) as u32;
    (0..count(north - south)).flat_map(move |row| {
        (0..count(east - west))
            .map(move |column| dvec2(west, south) + 4.0 + step * dvec2(f64::from(column), f64::from(row)))
    })
}

/// What a ray between two places meets: the first solid, and the ground.
fn met(pages: &PageFile, from: DVec3, to: DVec3) -> (Option<SolidHit>, Option<Contact>) {
    let grid = pages.header().grid;
    let bands = LevelBands::finest_only().with_bare_ground(&grid, 1.0e-9, 0.0, 1.0);
    let mut marcher = Marcher::new(pages, bands, Surface::Smooth);
    let ray = marcher.ray(from, (to - from).normalize());
    let contact = marcher.first_contact(&ray, 0.0).unwrap();
    let mut hits = Vec::new();
    marcher.solids(&ray, contact.as_ref(), &mut hits).unwrap();
    (hits.first().copied(), contact)
}

/// Height of the bare ground, metres.
fn ground(pages: &PageFile, at: DVec2) -> f64 {
    300.0 - met(pages, at.extend(300.0), at.extend(0.0)).1.unwrap().range
}

/// Height of what stands highest, metres.
fn top(pages: &PageFile, at: DVec2) -> Option<f64> {
    met(pages, at.extend(300.0), at.extend(0.0)).0.map(|hit| 300.0 - hit.range)
}

#[test]
fn footprints_stand_as_high_as_they_say() {
    let Some(data) = realdata() else { return };
    let folder = tempfile::tempdir().unwrap();
    let pages = airport(&data, folder.path(), true);
    let buildings = buildings();
    assert!(buildings.len() >= 8, "{} buildings", buildings.len());
    let (mut walls, mut worst) = (0, 0.0_f64);

    for row in &buildings {
        let name = &row.tags["name"];
        let foot = row.foot(&pages);
        let height = row.metres("height").unwrap();
        let roof = row.metres("roof:height").unwrap_or(0.0);
        let inside = lattice(2.3).filter(|place| row.holds(*place) && row.distance(*place) > 1.5);
        let tops: Vec<f64> = inside
            .map(|place| top(&pages, place).unwrap_or_else(|| panic!("{name} has a hole at {place}")) - foot)
            .collect();
        let highest = tops.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let lowest = tops.iter().copied().fold(f64::INFINITY, f64::min);

        // The ground along the outline is looked at every four metres.
        let slack = 0.05;
        assert!(tops.len() > 20, "{name}: {} places", tops.len());
        assert!(
            highest < height + slack && lowest > height - roof - slack,
            "{name}: {lowest} to {highest} m"
        );
        let ridge = height - if roof > 0.0 { 0.3 } else { slack };
        assert!(highest > ridge, "{name}: {highest} m instead of {height} m");

        // Walls, from no farther than the gap between two hangars; canopies have theirs high up.
        let low = row.metres("min_height").unwrap_or(if row.tags["building"] == "roof" {
            height - 0.4
        } else {
            0.0
        });
        let level = foot + low + 0.4 * (height - roof - low);

        for (a, b) in row.edges() {
            let outward = -(b - a).perp().normalize();
            for along in [0.2, 0.5, 0.8] {
                let wall = a.lerp(b, along);
                let from = wall + outward * 0.8;
                if buildings.iter().any(|other| other.holds(from)) || row.holds(from) {
                    continue;
                }
                let (hit, _) = met(&pages, from.extend(level), (wall - outward).extend(level));
                let hit = hit.unwrap_or_else(|| panic!("{name} has no wall at {wall}"));
                assert_eq!(hit.face, Face::Side, "{name} at {wall}");
                worst = worst.max((hit.range - 0.8).abs());
                walls += 1;
            }
        }
    }

    assert!(walls > 80, "{walls} places of walls");
    assert!(worst < 0.05, "walls are off by {worst} m");
}

#[test]
fn the_ground_beside_and_below_buildings_is_that_of_the_elevation() {
    let Some(data) = realdata() else { return };
    let folder = tempfile::tempdir().unwrap();
    let [bare, built] = [false, true].map(|with| airport(&data, folder.path(), with));
    let steps = bare.header().heights.scale + built.header().heights.scale;
    let (buildings, trees) = (buildings(), rows("Point", &["natural"]));
    let ways = rows("LineString", &["aeroway", "highway"]);
    let (mut below, mut beside) = (0, 0);

    for place in lattice(5.3) {
        let is_inside = buildings.iter().any(|row| row.holds(place));
        // Ways are cut into the ground, with embankments.
        let near = |way: &Row| way.distance(place) < 0.5 * way.metres("width").unwrap() + 15.0;
        if !ways.iter().any(near) {
            let [before, after] = [&bare, &built].map(|pages| ground(pages, place));
            assert!((before - after).abs() <= steps, "{place}: {before} and {after}");
            below += u32::from(is_inside);
            beside += u32::from(!is_inside);
        }

        let is_beside = buildings.iter().all(|row| row.distance(place) > 1.5);
        if !is_inside && is_beside && trees.iter().all(|tree| tree.distance(place) > 6.0) {
            assert_eq!(top(&built, place), None, "something stands at {place}");
        }
    }

    assert!(below > 300 && beside > 500, "{below} places below buildings, {beside} beside them");
}

/// Share of the pixels of which the range is more than a hundredth from that of all nine about it of the other frame, and mean
/// difference of colours where it is not from its own.
fn difference(a: &Frame, b: &Frame) -> (f64, f64) {
    let (width, height) = (i64::from(a.camera.width), i64::from(a.camera.height));
    let near = |one: f32, other: f32| one == other || (one - other).abs() <= 0.01 * one.min(other);
    let (mut off, mut sum, mut same) = (0, 0.0, 0);
    for (index, &one) in a.range.iter().enumerate() {
        let (x, y) = (index as i64 % width, index as i64 / width);
        let about = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
        let mut about = about.filter(|(x, y)| (0..width).contains(x) && (0..height).contains(y));
        off += u32::from(!about.any(|(x, y)| near(one, b.range[(y * width + x) as usize])));
        if near(one, b.range[index]) {
            same += 1;
            let [one, other] = [a, b].map(|frame| Vec3::from_array(frame.colour[index]));
            sum += f64::from((one - other).abs().max_element());
        }
    }
    (f64::from(off) / a.range.len() as f64, sum / f64::from(same.max(1)))
}

#[test]
fn an_eye_below_a_canopy_sees_the_deck_above_it_and_the_sky_beside_it() {
    let Some(data) = realdata() else { return };
    let folder = tempfile::tempdir().unwrap();
    let pages = airport(&data, folder.path(), true);
    let all = buildings();
    let canopy = all.iter().find(|row| row.tags["name"] == "canopy").unwrap();
    let offices = all.iter().find(|row| row.tags["name"] == "offices between the hangars").unwrap();
    let [low, high] = [canopy.places[0], canopy.places[2]];
    let eye = (0.5 * (low + high)).extend(canopy.foot(&pages) + 2.0);
    let deck = canopy.metres("min_height").unwrap() - 2.0;
    let (hit, _) = met(&pages, eye, eye + DVec3::Z);
    let hit = hit.expect("a deck");
    assert_eq!(hit.face, Face::Bottom);
    assert!((hit.range - deck).abs() < 0.05, "{hit:?}");
    assert_eq!(met(&pages, eye, eye - 40.0 * DVec3::X).0, None, "nothing stands below the deck");

    let farm = Farm::new(2).unwrap();
    let options = RenderOptions::of(pages.header());
    let (half, wall) = (0.5 * (high.x - low.x), offices.places[0].x - eye.x);
    for [yaw, pitch] in [
        [270.0, 0.0],
        [270.0, 20.0],
        [300.0, 10.0],
        [90.0, 0.0],
        [200.0, -10.0],
        [268.5, 60.0],
        [268.5, 85.0],
    ] {
        let attitude = Attitude { yaw, pitch, roll: 0.0 };
        let camera = Camera::new(Pose { eye, attitude, hfov: 60.0 }, 320, 180);
        let fast = Renderer::new(&pages, &options).frame(&camera, &farm).unwrap().frame;
        let exact = render_reference(&pages, &camera, &options, &farm).unwrap().frame;
        let (off, mean) = difference(&fast, &exact);
        assert!(off < 0.015 && mean < 0.005, "{yaw}, {pitch}: {off} of the pixels, {mean}");

        // Down the middle of the picture westward: the deck as far as it reaches, and the sky from there to the ground.
        for frame in [fast, exact] {
            for y in 0..180 {
                let range = f64::from(frame.range[y * 320 + 160]);
                let rise = pitch.to_radians()
                    + ((90.0 - y as f64 - 0.5) / (160.0 / 30.0_f64.to_radians().tan())).atan();
                let to_deck = deck / rise.sin();

                match (yaw as u32, rise.tan() * half / deck) {
                    (270, share) if share > 1.05 => {
                        assert!((range / to_deck - 1.0).abs() < 0.01, "{y}: {range} m");
                    }
                    (270, share) if (0.02..0.95).contains(&share) => assert_eq!(range, f64::INFINITY, "{y}"),
                    (270, share) if share < -0.2 => assert!(range < 60.0, "{y}: {range} m"),
                    (90, share) if share.abs() < 0.9 && share > -0.4 => {
                        assert!((range * rise.cos() / wall - 1.0).abs() < 0.02, "{y}: {range} m");
                    }
                    _ => {}
                }
            }
        }
    }
}

#[test]
fn a_runway_is_flat_across() {
    let Some(data) = realdata() else { return };
    let folder = tempfile::tempdir().unwrap();
    let [bare, built] = [false, true].map(|with| airport(&data, folder.path(), with));
    let rows = rows("LineString", &["aeroway"]);
    let runway = rows.iter().find(|row| row.tags["aeroway"] == "runway").unwrap();
    let (a, b) = (runway.places[0], runway.places[1]);
    let (half, outward) = (0.5 * runway.metres("width").unwrap(), (b - a).perp().normalize());

    let spread = |pages: &PageFile, along: f64| {
        // The last voxel beside each edge is the embankment's.
        let across = (-20..=20).map(|step| outward * (f64::from(step) / 20.0 * (half - 1.5)));
        let heights: Vec<f64> = across.map(|aside| ground(pages, a.lerp(b, along) + aside)).collect();
        let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
        heights.iter().copied().fold(f64::NEG_INFINITY, f64::max) - low
    };

    let most =
        |pages: &PageFile| (1..20).map(|step| spread(pages, f64::from(step) / 20.0)).fold(0.0, f64::max);
    let [before, after] = [&bare, &built].map(most);
    assert!(before > 0.05, "the ground itself differs by {before} m across");
    assert!(after < 0.03, "the runway differs by {after} m across");
}
