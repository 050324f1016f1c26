//! A classified cloud: ground, a house, a tree, a wire.

use glam::{DVec2, dvec2};

use super::scene::{Village, database, ground, met, options, top, write};
use hedgehop::memory::PageFile;
use hedgehop::voxel::PageSource;

fn village(name: &str, format: u8) -> (tempfile::TempDir, PageFile) {
    let folder = tempfile::tempdir().unwrap();
    let cloud = folder.path().join(name);
    write(&cloud, format, &Village::marks());
    let pages = database(&options(&cloud, folder.path().join("area.hop")));
    (folder, pages)
}

/// Places on the open ground, under the house and under the tree.
fn places(step: f64) -> impl Iterator<Item = DVec2> {
    let count = (Village::SIDE / step) as usize;
    (0..count * count).map(move |index| step * (dvec2((index % count) as f64, (index / count) as f64) + 0.5))
}

fn is_in_house(place: DVec2, more: f64) -> bool {
    let [west, south, east, north] = Village::HOUSE;
    place.x > west - more && place.x < east + more && place.y > south - more && place.y < north + more
}

#[test]
fn the_ground_lies_where_its_points_lie_also_under_what_stands_on_it() {
    let (_folder, pages) = village("town.laz", 7);
    assert_eq!(pages.header().metadata.crs_epsg, Some(32633));
    let (mut worst, mut hidden) = (0.0_f64, 0.0_f64);
    for place in places(0.7) {
        let off = (ground(&pages, place).unwrap() - Village::ground(place)).abs();
        if is_in_house(place, 2.0) {
            hidden = hidden.max(off);
        } else if (2.0..78.0).contains(&place.x) && (2.0..78.0).contains(&place.y) {
            worst = worst.max(off);
        }
    }
    assert!(worst < 0.02, "open ground is {worst} m off");
    assert!(hidden < 0.25, "ground under the roof is {hidden} m off");
}

#[test]
fn roofs_are_smooth_and_walls_stand_within_a_voxel() {
    let (_folder, pages) = village("town.las", 3);
    let step = pages.header().heights.scale;
    for place in places(0.7).filter(|place| is_in_house(*place, -0.5)) {
        let top = top(&pages, place).unwrap_or_else(|| panic!("no roof at {place}"));
        assert!((top - Village::ROOF).abs() <= step, "{place}: {top}");
    }
    let [west, south, east, north] = Village::HOUSE;
    for aside in [south + 0.3, 0.5 * (south + north), north - 0.3] {
        for (from, wall) in [(0.0, west), (60.0, east)] {
            let (hits, _) = met(&pages, dvec2(from, aside).extend(108.0), dvec2(27.0, aside).extend(108.0));
            let hit = hits.first().expect("a wall");
            assert!(((from - wall).abs() - hit.range).abs() <= 1.0, "{aside}: {hit:?}");
        }
    }
    let colours = pages.header().metadata.notes.join(" ");
    assert!(!colours.contains("no imagery"), "{colours}");
}

#[test]
fn one_sees_through_below_a_crown_and_not_through_it() {
    let (_folder, pages) = village("town.laz", 6);
    let foot = Village::ground(Village::TREE);
    let through = |height: f64| {
        let from = (Village::TREE - dvec2(20.0, 0.0)).extend(foot + height);
        met(&pages, from, (Village::TREE + dvec2(20.0, 0.0)).extend(foot + height)).0
    };
    let crown = through(0.5 * (Village::CROWN[0] + Village::CROWN[1]));
    let first = crown.first().expect("a crown").range;
    assert!((first - (20.0 - Village::RADIUS)).abs() <= 1.5, "{first}");
    assert!(through(3.0).is_empty(), "{:?}", through(3.0));

    // It has no holes.
    let inner = places(0.5).filter(|place| place.distance(Village::TREE) < Village::RADIUS - 1.5);
    for place in inner {
        let top = top(&pages, place).unwrap_or_else(|| panic!("a hole in the crown at {place}"));
        let height = top - Village::ground(place);
        assert!((9.0..=13.0).contains(&height), "{place}: {height}");
    }

    // And nothing stands where there is nothing.
    let open = places(0.9).filter(|place| {
        place.distance(Village::TREE) > Village::RADIUS + 2.0
            && !is_in_house(*place, 1.5)
            && (place.x - Village::WIRE[0]).abs() > 1.5
    });
    for place in open {
        assert_eq!(top(&pages, place), None, "{place}");
    }
}

#[test]
fn wires_hang_where_their_points_hang() {
    let (_folder, pages) = village("town.laz", 7);
    let [x, height] = Village::WIRE;
    let mut seen = 0;
    for step in 4..76 {
        let y = f64::from(step) + 0.5;
        let (hits, _) = met(&pages, dvec2(x - 6.0, y).extend(height), dvec2(x, y).extend(height));
        let Some(hit) = hits.first() else { continue };
        assert!((hit.range - 6.0).abs() < 0.3, "{y}: {hit:?}");
        seen += 1;
    }
    assert!(seen >= 70, "the wire is seen at {seen} of 72 places");
}

#[test]
fn a_database_depends_on_its_cloud_alone() {
    let folder = tempfile::tempdir().unwrap();
    let cloud = folder.path().join("town.laz");
    write(&cloud, 7, &Village::marks());
    let bytes = |name: &str, threads: usize, memory: u64, spacing: f64| {
        let mut options = options(&cloud, folder.path().join(name));
        (options.threads, options.memory, options.spacing) = (threads, memory << 20, Some(spacing));
        database(&options);
        std::fs::read(&options.output).unwrap()
    };
    for spacing in [1.0, 0.3] {
        let one = bytes(&format!("one-{spacing}.hop"), 1, 512, spacing);
        assert!(one == bytes(&format!("four-{spacing}.hop"), 4, 512, spacing), "threads make a difference");
        assert!(one == bytes(&format!("less-{spacing}.hop"), 3, 90, spacing), "memory makes a difference");
    }
}

#[test]
fn a_part_of_the_area_is_as_in_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let cloud = folder.path().join("town.laz");
    write(&cloud, 7, &Village::marks());
    let whole = database(&options(&cloud, folder.path().join("whole.hop")));
    let mut part = options(&cloud, folder.path().join("part.hop"));
    // Other tiles, and other rims.
    part.bbox = Some([500_013.0, 5_000_011.0, 500_075.0, 5_000_070.0]);
    let part = database(&part);
    for place in
        places(1.0).filter(|place| place.x > 16.0 && place.x < 72.0 && place.y > 14.0 && place.y < 67.0)
    {
        let [a, b] = [&whole, &part].map(|pages| top(pages, place));
        let off = a.unwrap_or(0.0) - b.unwrap_or(0.0);
        let step = whole.header().heights.scale + part.header().heights.scale;
        assert!(off.abs() <= step, "{place}: {a:?} and {b:?}");
    }
}

#[test]
fn the_ground_can_be_taken_alone() {
    let folder = tempfile::tempdir().unwrap();
    let cloud = folder.path().join("town.laz");
    write(&cloud, 7, &Village::marks());
    let mut options = options(&cloud, folder.path().join("area.hop"));
    options.clouds[0].ground_only = true;
    let pages = database(&options);
    for place in places(1.1) {
        assert_eq!(top(&pages, place), None, "{place}");
    }
}

#[test]
fn what_has_no_colours_takes_those_of_imagery() {
    let folder = tempfile::tempdir().unwrap();
    let cloud = folder.path().join("town.las");
    write(&cloud, 6, &Village::marks());
    let ortho = folder.path().join("ortho.png");
    image::RgbImage::from_pixel(80, 80, image::Rgb([10, 200, 30])).save(&ortho).unwrap();
    std::fs::write(folder.path().join("ortho.pgw"), "1\n0\n0\n-1\n500000.5\n5000079.5\n").unwrap();
    let mut options = options(&cloud, folder.path().join("area.hop"));
    options.imagery = vec![ortho.into()];
    options.imagery[0].crs = Some("EPSG:32633".into());
    let pages = database(&options);
    for place in [dvec2(27.0, 25.0), Village::TREE] {
        let (hits, _) = met(&pages, place.extend(900.0), place.extend(0.0));
        assert_eq!(hits.first().expect("a roof or a crown").span.top, [10, 200, 30], "{place}");
    }
    let [x, height] = Village::WIRE;
    let (hits, _) = met(&pages, dvec2(x - 6.0, 40.5).extend(height), dvec2(x, 40.5).extend(height));
    assert_ne!(hits.first().expect("a wire").span.top, [10, 200, 30]);
}
