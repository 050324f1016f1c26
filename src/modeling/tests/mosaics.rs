//! Several rasters as one.

use super::support::{built, north_up, sheet, terrain};
use crate::geo::Crs;
use crate::voxel::PageSource;

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
    assert_eq!((middle.source, middle.flags & crate::voxel::Attributes::VOID), (1, 0));
    assert_eq!(area.pages.header().metadata.void_share, 0.0);
}

#[test]
fn rasters_apart_leave_nothing_between() {
    let local = Crs::local();
    let tile = |x: f64| sheet(&local, north_up(x, 100.0, 10.0), (10, 10), |_, _| 7.0);
    let area = built(vec![tile(0.0), tile(300.0)], vec![], |options| {
        options.nodata_fill = crate::modeling::NodataFill::Interpolate;
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
