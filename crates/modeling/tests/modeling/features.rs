//! Features on the ground of a database, against what they say: by rays of the reference marcher.

use std::fs;
use std::path::Path;

use glam::{DVec2, DVec3, dvec2};

use hedgehop::earth::Curvature;
use hedgehop::memory::PageFile;
use hedgehop::progress::Silent;
use hedgehop::raymarch::{Contact, Face, LevelBands, Marcher, SolidHit, Surface};
use hedgehop::sunlight::Sun;
use hedgehop::voxel::{PageId, PageSource, Span};
use hedgehop_modeling::{Baking, BuildOptions, FeatureFile, bake_shadows, build};
use hedgehop_query::{Ground, Sight, sight};

/// South-west corner of the area, metres of UTM zone 32, and its side.
const CORNER: DVec2 = dvec2(500_000.0, 5_000_000.0);
const SIDE: u32 = 600;

/// A database of voxels of a metre: ground that rises northward by `slope`, with features as GeoJSON.
fn area(folder: &Path, slope: f64, features: &[String]) -> PageFile {
    let row = |row: u32| {
        let north = f64::from(SIDE - row) - 0.5;
        vec![format!("{:.3}", 100.0 + slope * north); SIDE as usize].join(" ")
    };
    let rows: Vec<_> = (0..SIDE).map(row).collect();
    let head =
        format!("ncols {SIDE}\nnrows {SIDE}\nxllcorner {}\nyllcorner {}\ncellsize 1\n", CORNER.x, CORNER.y);
    fs::write(folder.join("dem.asc"), head + &rows.join("\n") + "\n").unwrap();
    let crs = r#""crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::32632"}}"#;
    let text = format!(r#"{{"type":"FeatureCollection",{crs},"features":[{}]}}"#, features.join(","));
    fs::write(folder.join("town.geojson"), text).unwrap();
    let mut options = BuildOptions::new(vec![folder.join("dem.asc")], Vec::new(), folder.join("area.hop"));
    options.elevation[0].crs = Some("EPSG:32632".into());
    options.features = vec![FeatureFile::from(folder.join("town.geojson"))];
    build(&options, &Silent).unwrap();
    let pages = PageFile::open(&folder.join("area.hop")).unwrap();
    assert_eq!(pages.verify(&Silent).unwrap().problems, []);
    assert!(pages.header().has_spans);

    pages
}

fn feature(kind: &str, places: &[DVec2], tags: &str) -> String {
    let place = |at: &DVec2| format!("[{},{}]", CORNER.x + at.x, CORNER.y + at.y);
    let list: Vec<_> = places.iter().map(place).collect();
    let coordinates = match kind {
        "Polygon" => format!("[[{},{}]]", list.join(","), list[0]),
        "Point" => list[0].clone(),
        _ => format!("[{}]", list.join(",")),
    };
    format!(
        r#"{{"type":"Feature","properties":{{{tags}}},"geometry":{{"type":"{kind}","coordinates":{coordinates}}}}}"#
    )
}

/// What a ray between two places (metres from the corner) meets: the first solid, and the ground.
fn met(pages: &PageFile, from: DVec3, to: DVec3) -> (Option<SolidHit>, Option<Contact>) {
    let grid = pages.header().grid;
    let bands = LevelBands::finest_only().with_bare_ground(&grid, 1.0e-9, 0.0, 1.0);
    let mut marcher = Marcher::new(pages, bands, Surface::Smooth);
    let ray = marcher.ray(from + CORNER.extend(0.0), (to - from).normalize());
    let contact = marcher.first_contact(&ray, 0.0).unwrap();
    let mut hits = Vec::new();
    marcher.solids(&ray, contact.as_ref(), &mut hits).unwrap();
    (hits.first().copied(), contact)
}

/// Height of the bare ground, metres.
fn ground(pages: &PageFile, at: DVec2) -> f64 {
    let high = 900.0;
    let (_, contact) = met(pages, at.extend(high), at.extend(0.0));
    high - contact.unwrap().range
}

/// Height of what stands highest, metres.
fn top(pages: &PageFile, at: DVec2) -> Option<f64> {
    let high = 900.0;
    let (hit, _) = met(pages, at.extend(high), at.extend(0.0));
    hit.map(|hit| high - hit.range)
}

/// A rectangle about a middle, turned by an angle in radians.
fn rectangle(middle: DVec2, half: DVec2, turn: f64) -> Vec<DVec2> {
    let corners = [dvec2(-1.0, -1.0), dvec2(1.0, -1.0), dvec2(1.0, 1.0), dvec2(-1.0, 1.0)];
    corners.map(|corner| middle + DVec2::from_angle(turn).rotate(corner * half)).to_vec()
}

#[test]
fn edges_through_the_middles_of_voxels_are_the_same_for_all_pages() {
    let folder = tempfile::tempdir().unwrap();
    // Beside the edge of pages, where two of them decide about the same voxel.
    let ring = |low: DVec2, high: DVec2| {
        [low, dvec2(high.x, low.y), high, dvec2(low.x + 3.0, high.y), dvec2(low.x, high.y - 7.0)]
    };
    let lake = ring(dvec2(200.5, 180.5), dvec2(256.5, 257.5));
    let house = ring(dvec2(255.5, 300.5), dvec2(262.5, 320.5));
    let wood = ring(dvec2(100.5, 254.5), dvec2(190.5, 330.5));
    let features = [
        feature("Polygon", &lake, r#""natural":"water""#),
        feature("Polygon", &house, r#""building":"yes","height":8"#),
        feature("Polygon", &wood, r#""natural":"wood""#),
    ];
    // Sound, or it is not opened.
    let pages = area(folder.path(), 0.02, &features);
    assert!((top(&pages, dvec2(258.0, 310.0)).unwrap() - 106.0).abs() < 9.0);
}

#[test]
fn houses_have_their_walls_corners_and_heights() {
    let folder = tempfile::tempdir().unwrap();
    let half = dvec2(15.0, 8.0);
    let houses: Vec<(DVec2, f64)> =
        (0..6).map(|index| (dvec2(80.3 + 80.0 * f64::from(index), 150.7), f64::from(index) * 0.31)).collect();
    let tags = r#""building":"yes","height":12.5,"roof:shape":"flat""#;
    let features: Vec<_> = houses
        .iter()
        .map(|(middle, turn)| feature("Polygon", &rectangle(*middle, half, *turn), tags))
        .collect();
    let pages = area(folder.path(), 0.0, &features);
    let step = pages.header().heights.scale;
    let mut worst: f64 = 0.0;

    for (middle, turn) in houses {
        assert!((top(&pages, middle).unwrap() - 112.5).abs() <= step, "a roof lies where it is said to lie");
        // The walls, from four sides at a few places each.
        for quarter in 0..4 {
            let normal = DVec2::from_angle(turn + f64::from(quarter) * std::f64::consts::FRAC_PI_2);
            let [distance, width] = if quarter % 2 == 0 { [half.x, half.y] } else { [half.y, half.x] };
            for aside in [-1.0, -0.4, 0.1, 0.6, 1.0] {
                let beside = normal.perp() * (aside * (width - 0.1));
                let from = middle + beside + normal * 35.0;
                let (hit, _) = met(&pages, from.extend(105.0), (middle + beside).extend(105.0));
                let hit = hit.unwrap();
                assert_eq!(hit.face, Face::Side);
                worst = worst.max((hit.range - (35.0 - distance)).abs());
            }
        }

        // A twentieth of a voxel outside of a corner nothing stands, so much inside of it the house does.
        for (x, y) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
            let corner = |more: f64| middle + DVec2::from_angle(turn).rotate((half + more) * dvec2(x, y));
            assert_eq!(top(&pages, corner(0.05)), None, "outside of a corner");
            assert!(top(&pages, corner(-0.05)).is_some(), "inside of it");
        }
    }

    assert!(worst < 0.05, "walls are off by {worst} m");
}

#[test]
fn what_reaches_far_beyond_the_area_is_built_within_it() {
    let folder = tempfile::tempdir().unwrap();
    let square = |half: f64| rectangle(dvec2(300.0, 300.0), DVec2::splat(half), 0.0);
    let features = [
        feature("Polygon", &square(1.0e7), r#""landuse":"forest""#),
        feature("Polygon", &square(1.0e12), r#""highway":"pedestrian","area":"yes""#),
    ];
    let pages = area(folder.path(), 0.0, &features);
    let trees =
        (0..100).filter(|step| top(&pages, dvec2(5.9 * f64::from(*step) + 3.3, 200.7)).is_some()).count();
    assert!(trees > 50, "{trees} places of a hundred have a crown above them");
}

#[test]
fn trees_of_a_wood_are_stored_once_and_placed() {
    let square = |half: f64| rectangle(dvec2(300.0, 300.0), DVec2::splat(half), 0.0);
    let wood =
        |half: f64| feature("Polygon", &square(half), r#""landuse":"forest","leaf_type":"needleleaved""#);

    let [few, many] = [30.0, 290.0].map(|half| {
        let folder = tempfile::tempdir().unwrap();
        let pages = area(folder.path(), 0.1, &[wood(half)]);
        let objects = pages.header().objects.len();
        let ids = (0..9).map(|page| PageId { level: 0, px: page % 3, py: page / 3 }.bare());
        let views: Vec<_> = ids.filter_map(|id| pages.spans(id).unwrap()).collect();
        assert!(views.iter().all(|view| view.all().is_empty()), "no tree has spans of its own");
        let mut placed: Vec<_> = views
            .iter()
            .enumerate()
            .flat_map(|(page, view)| view.placements().iter().map(move |placement| (page, *placement)))
            .collect();
        placed.sort_unstable();
        placed.dedup();

        // The lower part of a crown hangs in the air, and its top is the surface's.
        let crowns = (0..200).filter_map(|step| {
            let at = dvec2(300.0 - half + 0.01 * half * f64::from(step), 311.3);
            top(&pages, at).map(|top| top - ground(&pages, at))
        });
        let crowns: Vec<f64> = crowns.collect();
        assert!(crowns.iter().all(|height| (3.0..27.0).contains(height)), "{crowns:?}");
        assert!(crowns.len() > 100, "{} of 200 places have a crown above them", crowns.len());

        (placed.len(), objects)
    });

    // 180 trees a hectare; those on the seams of pages count twice.
    assert!((50..110).contains(&few.0), "{few:?}");
    assert!((5500..7500).contains(&many.0), "{many:?}");
    assert_eq!(few.1, many.1, "what there is of trees does not depend on how many stand");
    assert!(many.1 < 80, "{many:?}");
}

#[test]
fn shadows_are_baked_into_a_place_with_buildings_and_trees() {
    let folder = tempfile::tempdir().unwrap();
    let pages = area(
        folder.path(),
        0.0,
        &[
            feature(
                "Polygon",
                &rectangle(dvec2(200.0, 200.0), dvec2(30.0, 10.0), 0.0),
                r#""building":"yes","height":30,"building:colour":"white""#,
            ),
            feature(
                "Polygon",
                &rectangle(dvec2(400.0, 300.0), DVec2::splat(60.0), 0.0),
                r#""landuse":"forest""#,
            ),
        ],
    );

    // The sun is in the south: the building darkens what lies north of it.
    let sun = Sun { azimuth: 180.0, elevation: 30.0 };
    let path = folder.path().join("baked.hop");

    let baking = Baking {
        source: &pages,
        directory: pages.directory(),
        sun,
        output: &path,
        overwrite: false,
        steps: false,
        threads: 2,
    };

    bake_shadows(&baking, &Silent).unwrap();
    let baked = PageFile::open(&path).unwrap();
    assert_eq!(baked.verify(&Silent).unwrap().problems, []);
    assert_eq!(baked.header().objects, pages.header().objects);
    assert_eq!(baked.directory().present().count(), pages.directory().present().count());
    let id = PageId { level: 0, px: 0, py: 0 }.bare();
    let [before, after] = [&pages, &baked].map(|pages| {
        let (view, spans) = (pages.page(id).unwrap().unwrap(), pages.spans(id).unwrap().unwrap());
        let colour = |y: u32| i32::from(view.colours[view.sample(200, y)][1]);
        ([colour(225), colour(150)], spans.at(200, 200).iter().next().unwrap().top)
    });
    assert!(after.0[0] < before.0[0] - 20, "{before:?} {after:?}");
    assert_eq!((after.0[1], after.1), (before.0[1], before.1), "what the sun shines on stays as it is");
}

#[test]
fn gables_rise_to_their_ridge() {
    let folder = tempfile::tempdir().unwrap();
    let (middle, half, turn) = (dvec2(300.4, 299.8), dvec2(14.0, 6.0), 0.4);
    let tags = r#""building":"house","height":13,"roof:shape":"gabled","roof:height":4"#;
    let pages = area(folder.path(), 0.0, &[feature("Polygon", &rectangle(middle, half, turn), tags)]);
    let mut worst: f64 = 0.0;
    for along in -6..=6 {
        for across in -5..=5 {
            let (along, across) = (f64::from(along) * 2.0 + 0.13, f64::from(across) + 0.07);
            let at = middle + DVec2::from_angle(turn).rotate(dvec2(along, across));
            let roof = 113.0 - 4.0 * across.abs() / half.y;
            worst = worst.max((top(&pages, at).unwrap() - roof).abs());
        }
    }
    // Slopes are stored in steps of 1/32 over half a voxel.
    assert!(worst < 0.5 / 32.0 + pages.header().heights.scale, "roofs are off by {worst} m");
}

#[test]
fn roads_are_as_wide_as_they_say_and_lakes_are_level() {
    let folder = tempfile::tempdir().unwrap();
    let features = [
        feature("LineString", &[dvec2(50.0, 100.3), dvec2(550.0, 100.3)], r#""highway":"primary","width":9"#),
        feature("Polygon", &rectangle(dvec2(300.0, 400.0), dvec2(60.0, 40.0), 0.3), r#""natural":"water""#),
    ];
    let folder_path = folder.path();
    let row = area_of_ground(folder_path, 0.1, &features);
    // Asphalt from 95.8 to 104.8 m: voxels whose centres lie there.
    let asphalt = (0..SIDE).filter(|&y| row.material(300, y) == 2).count() as f64;
    assert!((asphalt - 9.0).abs() <= 0.5, "{asphalt} m");
    let lake: Vec<f64> =
        (380..420).flat_map(|y| (260..340).map(move |x| (x, y))).map(|(x, y)| row.height(x, y)).collect();
    assert!(lake.iter().all(|height| *height == lake[0]), "a lake is level");
    let shore = 100.0 + 0.1 * 400.0;
    assert!((lake[0] - shore).abs() < 6.0, "{} m", lake[0]);
}

/// The surface of a database on which nothing stands: voxels of level 1.
struct Voxels(PageFile);

fn area_of_ground(folder: &Path, slope: f64, features: &[String]) -> Voxels {
    // One post far away, so that something stands.
    let mut features = features.to_vec();
    features.push(feature("Point", &[dvec2(590.0, 590.0)], r#""man_made":"mast","height":20"#));
    Voxels(area(folder, slope, &features))
}

impl Voxels {
    fn page(&self, x: u32, y: u32) -> (hedgehop::voxel::PageView<'_>, [u32; 2]) {
        let id = hedgehop::voxel::PageId { level: 0, px: x / 256, py: y / 256 };
        (self.0.page(id).unwrap().unwrap(), [x % 256, y % 256])
    }

    fn material(&self, x: u32, y: u32) -> u8 {
        let (page, [x, y]) = self.page(x, y);
        page.attributes_at(x, y).material
    }

    fn height(&self, x: u32, y: u32) -> f64 {
        let (page, [x, y]) = self.page(x, y);
        self.0.header().heights.decode(page.heights[page.sample(x, y)]).unwrap()
    }
}

#[test]
fn wires_sag_and_hang_free_and_bridges_are_open_below() {
    let folder = tempfile::tempdir().unwrap();
    let features = [
        feature(
            "LineString",
            &[dvec2(100.0, 300.0), dvec2(400.0, 300.0)],
            r#""power":"line","cables":"3","voltage":"110000""#,
        ),
        feature(
            "LineString",
            &[dvec2(450.0, 150.0), dvec2(540.0, 150.0)],
            r#""highway":"secondary","bridge":"yes","layer":"1","width":8"#,
        ),
    ];

    let pages = area(folder.path(), 0.0, &features);
    // Looking along y at the wires from beside, from low to high: something thin hangs, with air below.
    let heights = |x: f64| {
        let looks = (0..2500).map(|step| 101.0 + 0.02 * f64::from(step));
        let seen =
            looks.filter(|z| met(&pages, dvec2(x, 270.0).extend(*z), dvec2(x, 330.0).extend(*z)).0.is_some());
        seen.collect::<Vec<f64>>()
    };
    let [near, middle] = [130.3, 250.3].map(heights);
    let lowest = |seen: &[f64]| seen.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(!near.is_empty() && !middle.is_empty(), "wires are seen");
    let sag = lowest(&near) - lowest(&middle);

    // A parabola: at 30.3 m of 300 m the wire hangs 4 · 0.101 · 0.899 of its sag below its ends.
    let whole = sag / (1.0 - 4.0 * 0.101 * 0.899);
    assert!((1.0..20.0).contains(&whole) && lowest(&middle) > 104.0, "a sag of {whole} m");
    let share = |x: f64| (lowest(&near) - lowest(&heights(x))) / whole + 4.0 * 0.101 * 0.899;
    for (x, expected) in [(175.3, 4.0 * 0.251 * 0.749), (325.3, 4.0 * 0.751 * 0.249)] {
        assert!((share(x) - expected).abs() < 0.05, "{x}: {} instead of {expected}", share(x));
    }

    // The bridge's deck, and the ground under it.
    let deck = top(&pages, dvec2(495.5, 150.5)).unwrap();
    assert!(deck > 102.0, "{deck}");
    assert!((ground(&pages, dvec2(495.5, 150.5)) - 100.0).abs() < 0.1);
    let under = 100.3;
    let (hit, _) = met(&pages, dvec2(495.5, 100.0).extend(under), dvec2(495.5, 200.0).extend(under));
    assert_eq!(hit.map(|hit| hit.span), None::<Span>, "one flies under it");
}

/// What two places (metres from the corner) see of each other.
fn looked(pages: &PageFile, from: DVec3, to: DVec3) -> Sight {
    let corner = CORNER.extend(0.0);
    sight(pages, from + corner, to + corner, Curvature::FLAT).unwrap()
}

#[test]
fn lines_of_sight_go_under_bridges_and_end_at_their_decks() {
    let folder = tempfile::tempdir().unwrap();
    let bridge = feature(
        "LineString",
        &[dvec2(200.0, 300.0), dvec2(400.0, 300.0)],
        r#""highway":"secondary","bridge":"yes","layer":"1","width":8"#,
    );
    let pages = area(folder.path(), 0.0, &[bridge]);
    let middle = dvec2(300.5, 300.5);
    let deck = top(&pages, middle).unwrap();
    let (hit, _) = met(&pages, middle.extend(100.1), middle.extend(200.0));
    let lower = 100.1 + hit.unwrap().range;
    assert!(102.0 < lower && lower < deck - 0.5, "a deck from {lower} m to {deck} m");
    let across = |height: f64| {
        let [from, to] = [250.0, 350.0].map(|y| dvec2(middle.x, y).extend(height));
        looked(&pages, from, to)
    };
    let under = across(0.5 * (100.0 + lower));
    assert_eq!((under.blocked, under.missing), (None, 0.0), "one sees under it");
    let through = across(0.5 * (lower + deck));
    let place = through.blocked.expect("the deck hides").place - CORNER;

    // Its edge is four metres beside its middle.
    assert!((295.0..297.0).contains(&place.y), "{place}");
    let concrete = pages.header().metadata.material_name(through.material.expect("a material"));
    assert!(["concrete", "asphalt"].contains(&concrete.as_str()), "{concrete}");
    let over = across(deck + 4.0);
    assert_eq!(over.blocked, None);
    let raised = across(0.5 * (lower + deck)).missing;
    assert!((0.0..8.0).contains(&raised) && raised > 0.0, "{raised} m");

    // Bare ground is below the deck, which is the highest surface.
    let place = middle + CORNER;
    let [highest, bare] =
        [Ground::Highest, Ground::Bare].map(|ground| ground.height_at(&pages, place).unwrap().unwrap());
    assert!((highest - deck).abs() < 0.1 && (bare - 100.0).abs() < 0.1, "{highest} {bare}");
}

#[test]
fn crowns_hide_and_one_sees_past_their_stems() {
    let folder = tempfile::tempdir().unwrap();
    let tree = feature(
        "Point",
        &[dvec2(300.0, 300.0)],
        r#""natural":"tree","height":16,"diameter_crown":10,"leaf_type":"broadleaved""#,
    );
    let pages = area(folder.path(), 0.0, &[tree]);
    // Two metres beside the stem.
    let across =
        |height: f64| looked(&pages, dvec2(260.0, 302.2).extend(height), dvec2(340.0, 302.2).extend(height));
    assert_eq!(across(101.7).blocked, None, "below the crown there is air");
    let hidden = across(110.0);
    let place = hidden.blocked.expect("the crown hides").place - CORNER;
    assert!((294.0..300.0).contains(&place.x), "{place}");
    assert_eq!(pages.header().metadata.material_name(hidden.material.unwrap()), "broadleaf");
    // The far point would have to be so much higher that the line, here half way, clears the crown.
    assert!((116.0 - 3.0..117.5).contains(&(110.0 + 0.5 * hidden.missing)), "{hidden:?}");
    assert_eq!(across(117.0).blocked, None, "one sees over it");
}

#[test]
fn wires_have_no_gaps_whatever_their_direction() {
    let folder = tempfile::tempdir().unwrap();
    let half = 60.0;
    let lines = [(20.0_f64, dvec2(150.3, 120.7)), (37.0, dvec2(300.1, 300.4)), (63.0, dvec2(450.8, 480.2))];
    let ends = |(degrees, middle): (f64, DVec2)| {
        let along = DVec2::from_angle(degrees.to_radians()) * half;
        [middle - along, middle + along]
    };
    let tags = r#""power":"minor_line","cables":"1","height":8.5"#;

    // On a slope of 600 m, for steps of height of which a wire's thickness is no multiple.
    let pages = area(folder.path(), 1.0, &lines.map(|line| feature("LineString", &ends(line), tags)));
    for line in lines {
        let [a, b] = ends(line);
        let aside = -(b - a).perp() / (b - a).length();
        for step in 1..400 {
            // Not where poles stand.
            let share = 0.03 + 0.94 * f64::from(step) / 400.0;
            let place = a.lerp(b, share);
            let sag = 2.5e-4 * (2.0 * half).powi(2);
            let height = 100.0 + place.y + 8.5 - 4.0 * sag * share * (1.0 - share);
            let (hit, _) = met(&pages, (place + 15.0 * aside).extend(height), place.extend(height));
            let hit = hit.unwrap_or_else(|| panic!("nothing at {share} of the wire at {}°", line.0));
            assert!((hit.range - 15.0).abs() < 0.1, "{hit:?} at {share} of the wire at {}°", line.0);
            assert_eq!(hit.opacity, 1.0, "at {share} of the wire at {}°", line.0);
        }
    }
}
