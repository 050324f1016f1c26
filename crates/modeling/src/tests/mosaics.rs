//! Several rasters as one.

use super::support::{Area, built, north_up, sheet, terrain};
use hedgehop::voxel::PageSource;
use hedgehop_geo::Crs;

fn plane(x: f64, y: f64) -> f64 {
    100.0 + 0.4 * x + 0.25 * y
}

#[test]
fn abutting_tiles_join_in_a_plane() {
    let local = Crs::local();
    // Pixel-is-area tiles side by side, and point tiles that share a row and a column; the voxels are off their lattice.
    for shared in [0.0, 1.0] {
        let tile = |column: f64, row: f64| {
            let step = 10.0 * (40.0 - shared);
            terrain(&local, north_up(column * step, 1000.0 - row * step, 10.0), (40, 40), plane)
        };
        let tiles = vec![tile(0.0, 0.0), tile(1.0, 0.0), tile(0.0, 1.0), tile(1.0, 1.0)];
        let area = built(tiles, vec![], |options| options.spacing = Some(3.7));

        for (x, y) in area.voxels() {
            let (east, north) = area.centre(x, y);
            let bounds = 800.0 - 10.0 * shared;
            let rim = east.min(bounds - east).min(1000.0 - north).min(north - 1000.0 + bounds);
            let error = area.height(x, y).expect("no gap") - plane(east, north);
            // The outermost half pixel repeats the outermost centres.
            let allowed = if rim < 5.0 { 5.0 * (0.4 + 0.25) } else { area.step() * 1.01 };
            assert!(error.abs() <= allowed, "({east}, {north}): {error}");
        }
    }
}

#[test]
fn tiles_in_degrees_join_after_reprojection() {
    let pixel = 1.0 / 1200.0;
    let ramp = |lon: f64, lat: f64| 1000.0 * (lon - 15.0) + 400.0 * (lat - 48.0);
    let tile = |west: f64| terrain(&Crs::wgs84(), [west, pixel, 0.0, 48.2, 0.0, -pixel], (120, 240), ramp);
    let area = built(vec![tile(15.0), tile(15.1)], vec![], |_| {});
    let whole = terrain(&Crs::wgs84(), [15.0, pixel, 0.0, 48.2, 0.0, -pixel], (240, 240), ramp);
    let one = built(vec![whole], vec![], |_| {});
    assert_eq!(area.grid, one.grid);
    for (x, y) in area.voxels() {
        match (area.height(x, y), one.height(x, y)) {
            (Some(a), Some(b)) => assert!((a - b).abs() <= 4.0 * area.step(), "{x} {y}: {a} {b}"),
            (a, b) => assert_eq!(a.is_some(), b.is_some(), "{x} {y}"),
        }
    }
}

#[test]
fn the_first_raster_wins_and_fades_at_its_edge() {
    let local = Crs::local();
    let patch = terrain(&local, north_up(300.0, 700.0, 5.0), (80, 80), |_, _| 200.0);
    let base = terrain(&local, north_up(0.0, 1000.0, 10.0), (100, 100), |_, _| 100.0);
    let area = built(vec![patch, base], vec![], |_| {});
    assert_eq!(area.grid.spacing, 5.0);
    let row = area.grid.ny / 2;
    let profile: Vec<f64> = (0..area.grid.nx).map(|x| area.height(x, row).unwrap()).collect();
    assert!((profile[100] - 200.0).abs() <= area.step() && (profile[10] - 100.0).abs() <= area.step());
    assert_eq!((area.attributes(100, row).source, area.attributes(10, row).source), (0, 1));
    let steepest = profile.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    assert!(steepest < 100.0 / 8.0, "a step of {steepest} m is a seam");
    // The other way round the patch is under the base and does not show.
    let patch = terrain(&local, north_up(300.0, 700.0, 5.0), (80, 80), |_, _| 200.0);
    let base = terrain(&local, north_up(0.0, 1000.0, 10.0), (100, 100), |_, _| 100.0);
    let area = built(vec![base, patch], vec![], |_| {});
    assert!(area.worst(|_, _| 100.0) <= area.step());
}

#[test]
fn a_lower_raster_fills_the_voids_of_a_higher() {
    let local = Crs::local();
    let geo = north_up(0.0, 600.0, 10.0);
    let hole = |x: f64, y: f64| (x - 300.0).hypot(y - 300.0) < 100.0;
    let upper = terrain(&local, geo, (60, 60), |x, y| if hole(x, y) { f64::NAN } else { plane(x, y) });
    let lower = terrain(&local, geo, (60, 60), plane);
    let area = built(vec![upper, lower], vec![], |options| options.spacing = Some(4.0));
    for (x, y) in area.voxels().filter(|&(x, y)| (2..148).contains(&x) && (2..148).contains(&y)) {
        let (east, north) = area.centre(x, y);
        assert!((area.height(x, y).unwrap() - plane(east, north)).abs() <= area.step() * 1.01);
    }
    let middle = area.attributes(75, 75);
    assert_eq!((middle.source, middle.flags & hedgehop::voxel::Attributes::VOID), (1, 0));
    assert_eq!(area.pages.header().metadata.void_share, 0.0);
}

/// A raster of 110 m with a hole and a ragged diagonal rim, over one of 100 m that goes on all around.
fn ragged(adjust: impl Fn(&mut crate::options::BuildOptions)) -> Area {
    let local = Crs::local();
    let upper = sheet(&local, north_up(0.0, 800.0, 5.0), (160, 160), |column, row| {
        let is_hole = (50..54).contains(&column) && (60..63).contains(&row);
        let is_cut = column + row + row * 7 % 5 > 230;
        if is_hole || is_cut { f64::NAN } else { 110.0 }
    });
    let lower = terrain(&local, north_up(-600.0, 1400.0, 10.0), (200, 200), |_, _| 100.0);
    built(vec![upper, lower], vec![], adjust)
}

#[test]
fn a_raster_fades_towards_its_voids() {
    let area = ragged(|_| {});
    assert_eq!((area.grid.spacing, area.grid.nx), (5.0, 400));
    // Columns and rows of the upper one's pixels.
    let height = |column: u32, row: u32| area.height(120 + column, 279 - row).unwrap();
    let mut steepest = 0.0_f64;
    for (column, row) in (0..160).flat_map(|row| (0..160).map(move |column| (column, row))) {
        let here = height(column, row);
        steepest = steepest.max((height(column + 1, row) - here).abs());
        steepest = steepest.max((height(column, row + 1) - here).abs());
    }
    assert!(steepest > 0.3 && steepest < 10.0 / 8.0, "a step of {steepest} m is a seam");
    // Sixteen pixels from the hole, the rim and the edge it has its own posts, in the hole the lower one's.
    for (column, row) in [(20, 20), (80, 20), (30, 110), (100, 80), (52, 90)] {
        assert!((height(column, row) - 110.0).abs() <= area.step(), "({column}, {row})");
    }
    for (column, row) in [(51, 61), (49, 61), (155, 120)] {
        assert!((height(column, row) - 100.0).abs() <= area.step(), "({column}, {row})");
    }
}

#[test]
fn fading_depends_on_neither_memory_nor_workers() {
    let wide = ragged(|options| options.threads = 1);
    for memory in [100, 400].map(|mib: u64| mib << 20) {
        let narrow = ragged(|options| (options.threads, options.memory) = (3, memory));
        assert!(narrow.bytes == wide.bytes, "{memory} bytes");
    }
}

#[test]
fn what_lies_under_abutting_tiles_does_not_show_at_their_joins() {
    let local = Crs::local();
    let tile = |x: f64, y: f64| terrain(&local, north_up(200.0 + x, 800.0 - y, 5.0), (60, 60), |_, _| 110.0);
    let base = terrain(&local, north_up(0.0, 1000.0, 10.0), (100, 100), |_, _| 100.0);
    let tiles = vec![tile(0.0, 0.0), tile(300.0, 0.0), tile(0.0, 300.0), tile(300.0, 300.0), base];
    let area = built(tiles, vec![], |_| {});
    for (x, y) in area.voxels() {
        let (east, north) = area.centre(x, y);
        let inside = (east - 200.0).min(800.0 - east).min(north - 200.0).min(800.0 - north);
        let height = area.height(x, y).unwrap();
        if inside > 85.0 {
            assert!((height - 110.0).abs() <= area.step(), "({east}, {north}): {height}");
        } else if inside < -5.0 {
            assert!((height - 100.0).abs() <= area.step(), "({east}, {north}): {height}");
        }
    }
}

#[test]
fn overlapping_tiles_fade_as_one() {
    let local = Crs::local();
    for overlap in [5.0, 10.0, 60.0] {
        let tile =
            |x: f64, y: f64| terrain(&local, north_up(200.0 + x, 800.0 - y, 5.0), (60, 60), |_, _| 110.0);
        let base = terrain(&local, north_up(0.0, 1000.0, 10.0), (100, 100), |_, _| 150.0);

        // Like bricks: a joint of the lower two lies in the middle of the upper one.
        let (next, below) = (300.0 - overlap, 300.0 - overlap);
        let tiles = vec![tile(0.0, 0.0), tile(next, 0.0), tile(0.5 * next, below), base];
        let area = built(tiles, vec![], |_| {});
        let height = |x: u32, y: u32| area.height(x, y).unwrap();
        for (x, y) in area.voxels().filter(|(x, y)| *x > 0 && *y > 0) {
            let step = (height(x, y) - height(x - 1, y)).abs().max((height(x, y) - height(x, y - 1)).abs());
            assert!(step <= 40.0 / 8.0, "{step} m at {:?}, overlap {overlap}", area.centre(x, y));
        }

        // Across a joint, far from its ends, and along the rim over one.
        for (east, north, expected) in [(200.0 + next, 650.0, 110.0), (20.0, 20.0, 150.0)] {
            let (x, y) = ((east / area.grid.spacing) as u32, (north / area.grid.spacing) as u32);
            assert!((height(x, y) - expected).abs() <= area.step(), "{east} {north}: {}", height(x, y));
        }

        let rim = |east: f64| height((east / area.grid.spacing) as u32, (780.0 / area.grid.spacing) as u32);
        assert!(
            (rim(200.0 + next + 2.0) - rim(300.0)).abs() < 0.1,
            "{} {}",
            rim(200.0 + next + 2.0),
            rim(300.0)
        );
    }
}

#[test]
fn rasters_apart_leave_nothing_between() {
    let local = Crs::local();
    let tile = |x: f64| sheet(&local, north_up(x, 100.0, 10.0), (10, 10), |_, _| 7.0);
    let area = built(vec![tile(0.0), tile(300.0)], vec![], |options| {
        options.nodata_fill = crate::NodataFill::Interpolate;
    });
    assert_eq!((area.grid.nx, area.grid.ny), (40, 10));
    for (x, y) in area.voxels() {
        assert_eq!(area.height(x, y).is_some(), !(10..30).contains(&x), "{x}");
    }
    let metadata = &area.pages.header().metadata;
    assert_eq!((metadata.empty_share, metadata.void_share), (0.5, 0.0));
}

#[test]
fn files_far_apart_are_told() {
    let notes = |x: f64| {
        let tile = |x: f64| terrain(&Crs::local(), north_up(x, 640.0, 10.0), (64, 64), |_, _| 100.0);
        built(vec![tile(0.0), tile(x)], Vec::new(), |_| {}).pages.header().metadata.notes.join("; ")
    };
    assert!(!notes(640.0).contains("covers less"));
    assert!(notes(12_000.0).contains("covers less than"), "{}", notes(12_000.0));
}

#[test]
fn tiles_on_both_sides_of_the_180th_meridian_make_one_small_area() {
    let pixel = 1.0 / 120.0;
    let tile = |west: f64| {
        terrain(&Crs::wgs84(), north_up(west, -16.0, pixel), (120, 120), |x, y| {
            500.0 + 90.0 * (x.rem_euclid(360.0) - 180.0) + 9.0 * y
        })
    };
    let red =
        |west: f64| sheet(&Crs::wgs84(), north_up(west, -16.0, pixel), (120, 120), |_, _| [200, 10, 10, 255]);

    let whole = built(
        vec![terrain(&Crs::wgs84(), north_up(179.0, -16.0, pixel), (240, 120), |x, y| {
            500.0 + 90.0 * (x - 180.0) + 9.0 * y
        })],
        Vec::new(),
        |options| options.spacing = Some(900.0),
    );

    assert_eq!(whole.pages.header().metadata.crs_epsg, Some(32701));
    for (a, b) in [(179.0, -180.0), (-180.0, 179.0), (179.0, 180.0), (-181.0, -180.0)] {
        let area =
            built(vec![tile(a), tile(b)], vec![red(a), red(b)], |options| options.spacing = Some(900.0));
        let metadata = &area.pages.header().metadata;
        assert_eq!((metadata.crs_epsg, area.grid), (Some(32701), whole.grid), "{a} and {b}");
        assert!(metadata.empty_share < 0.05, "{a} and {b}: {}", metadata.empty_share);
        let middle = area.grid.ny / 2;
        for x in (5..area.grid.nx - 5).step_by(7) {
            let (found, wanted) = (area.height(x, middle).unwrap(), whole.height(x, middle).unwrap());
            assert!((found - wanted).abs() < 0.5, "{a} and {b}, column {x}: {found} and {wanted}");
            assert_eq!(area.colour(x, middle), [200, 10, 10], "{a} and {b}, column {x}");
        }
    }
}
