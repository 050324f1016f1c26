//! Grids, reprojection, pages and threads.

use super::support::{built, north_up, sheet, terrain, try_build};
use hedgehop::voxel::{APRON, PAGE_SIDE, PageId, PageSource};
use hedgehop_geo::{Crs, Transform, VerticalDatum, egm96_undulation};

fn utm() -> Crs {
    Crs::from_epsg(32633).unwrap()
}

#[test]
fn voxels_on_pixels_keep_the_heights() {
    let geo = north_up(500_003.5, 5_400_001.25, 7.0);
    let height = |x: f64, y: f64| ((x * 0.37).sin() * (y * 0.11).cos() * 300.0).round();
    let area = built(vec![terrain(&utm(), geo, (310, 290), height)], vec![], |_| {});
    assert_eq!((area.grid.nx, area.grid.ny, area.grid.spacing), (310, 290, 7.0));
    assert_eq!((area.grid.origin.x, area.grid.origin.y), (500_003.5, 5_400_001.25 - 290.0 * 7.0));
    assert!(area.worst(height) <= area.step());
    assert_eq!(area.pages.header().metadata.crs_epsg, Some(32633));
}

#[test]
fn degrees_become_the_utm_zone_of_the_centre() {
    let degrees_from_world = Transform::new(&utm(), &Crs::wgs84()).unwrap();
    // One arc second; a smooth hill, so that interpolation adds less than what a wrong place would.
    let pixel = 1.0 / 3600.0;
    let hill = |lon: f64, lat: f64| 500.0 + 200.0 * ((lon - 15.1) * 30.0).sin() * ((lat - 48.2) * 20.0).cos();
    let geo = [15.0, pixel, 0.0, 48.3, 0.0, -pixel];
    let area = built(vec![terrain(&Crs::wgs84(), geo, (720, 720), hill)], vec![], |_| {});
    assert_eq!(area.pages.header().metadata.crs_epsg, Some(32633));
    assert!((area.grid.spacing - 25.2).abs() < 0.3, "{}", area.grid.spacing);
    let (mut worst, mut empty) = (0.0_f64, 0);

    for (x, y) in area.voxels() {
        let (east, north) = area.centre(x, y);
        let (lon, lat) = degrees_from_world.apply(east, north).unwrap();
        let within = (15.0..=15.2).contains(&lon) && (48.1..=48.3).contains(&lat);
        match area.height(x, y) {
            // Away from the rim, where half a pixel repeats the outermost centres.
            Some(height) if lon > 15.001 && lon < 15.199 && lat > 48.101 && lat < 48.299 => {
                worst = worst.max((height - hill(lon, lat)).abs());
            }
            Some(_) => {}
            None => {
                empty += 1;
                assert!(!within, "{lon} {lat} has no height");
            }
        }
    }

    // A twentieth of a pixel on a slope of 200 m · 30 per degree.
    assert!(worst < 200.0 * 30.0 * pixel * 0.1 + area.step(), "{worst} m off");
    assert!(empty > 0, "the rectangle's slivers lie outside of the raster");
}

#[test]
fn finer_rasters_are_averaged_by_area() {
    // A checkerboard of 0 and 100 m, ten pixels to a voxel, has the mean 50 everywhere.
    let board = sheet(&utm(), north_up(500_000.0, 5_400_000.0, 1.0), (400, 400), |c, r| {
        f64::from((c + r) % 2) * 100.0
    });
    let area = built(vec![board], vec![], |options| options.spacing = Some(10.0));
    assert_eq!((area.grid.nx, area.grid.ny), (40, 40));
    assert!(area.worst(|_, _| 50.0) < 0.6);
    // A plane stays the plane.
    let plane = |x: f64, y: f64| 0.3 * (x - 500_000.0) + 0.2 * (y - 5_400_000.0);
    let fine = terrain(&utm(), north_up(500_000.0, 5_400_000.0, 1.0), (400, 400), plane);
    let area = built(vec![fine], vec![], |options| options.spacing = Some(8.0));
    for (x, y) in area.voxels().filter(|&(x, y)| (1..49).contains(&x) && (1..49).contains(&y)) {
        let (east, north) = area.centre(x, y);
        let error = area.height(x, y).unwrap() - plane(east, north);
        assert!(error.abs() <= area.step() * 1.01, "{x} {y}: {error}");
    }
}

#[test]
fn turned_rasters_lie_where_their_geotransform_says() {
    let (sin, cos) = 30.0_f64.to_radians().sin_cos();
    let geo = [500_000.0, 10.0 * cos, 10.0 * sin, 5_400_000.0, 10.0 * sin, -10.0 * cos];
    let plane = |x: f64, y: f64| 0.1 * (x - 500_000.0) - 0.05 * (y - 5_400_000.0);
    let area = built(vec![terrain(&utm(), geo, (80, 60), plane)], vec![], |_| {});
    assert!((area.grid.spacing - 10.0).abs() < 1e-9);
    let mut inner = 0;

    for (x, y) in area.voxels() {
        let (east, north) = area.centre(x, y);
        let (u, v) = (east - 500_000.0, north - 5_400_000.0);
        let (column, row) = ((u * cos + v * sin) / 10.0, (u * sin - v * cos) / 10.0);
        let rim = column.min(80.0 - column).min(row).min(60.0 - row);

        match area.height(x, y) {
            Some(height) if rim > 0.5 => {
                inner += 1;
                assert!((height - plane(east, north)).abs() <= area.step() * 1.01);
            }
            Some(_) => assert!(rim > -0.1),
            None => assert!(rim < 0.1, "{x} {y}"),
        }
    }

    assert!(inner > 79 * 59 * 95 / 100);
}

#[test]
fn any_size_of_raster_makes_a_database() {
    for size in [(1, 1), (1, 7), (300, 1), (257, 256), (3, 513)] {
        let plane = |x: f64, y: f64| 10.0 + 0.25 * x + 0.5 * y;
        let area = built(vec![terrain(&Crs::local(), north_up(0.0, 0.0, 2.0), size, plane)], vec![], |_| {});
        assert_eq!((area.grid.nx, area.grid.ny), size);
        assert!(area.worst(plane) <= area.step(), "{size:?}");
    }
}

#[test]
fn aprons_repeat_the_neighbours() {
    let hill = |x: f64, y: f64| 100.0 + 60.0 * (x * 0.013).sin() * (y * 0.021).cos();
    let geo = [15.0, 1.0 / 1200.0, 0.0, 48.5, 0.0, -1.0 / 1200.0];
    let void = |x: f64, y: f64| {
        if ((x * 977.0).sin() * (y * 1313.0).cos()) > 0.8 { f64::NAN } else { hill(x * 900.0, y * 900.0) }
    };
    let area = built(vec![terrain(&Crs::wgs84(), geo, (700, 500), void)], vec![], |options| {
        options.nodata_fill = crate::NodataFill::Interpolate;
    });
    let (columns, rows) = area.grid.page_dims(0);
    assert!(columns > 1 && rows > 1);
    let code = &area.pages.header().heights;

    for py in 0..rows {
        for px in 0..columns {
            let page = area.pages.page(PageId { level: 0, px, py }).unwrap().unwrap();
            for y in 0..page.height + 2 * APRON {
                for x in 0..page.width + 2 * APRON {
                    let at = (y * (page.width + 2 * APRON) + x) as usize;
                    let clamp =
                        |page: u32, i: u32, n: u32| (page * PAGE_SIDE + i).saturating_sub(APRON).min(n - 1);
                    let (i, j) = (clamp(px, x, area.grid.nx), clamp(py, y, area.grid.ny));
                    assert_eq!(
                        code.decode(page.heights[at]),
                        area.height(i, j),
                        "page {px} {py}, sample {x} {y}"
                    );
                    assert_eq!(page.colours[at], area.colour(i, j));
                }
            }
        }
    }
}

#[test]
fn threads_and_memory_change_no_byte() {
    let elevation = || {
        let geo = [15.0, 1.0 / 1200.0, 0.0, 48.5, 0.0, -1.0 / 900.0];
        vec![terrain(&Crs::wgs84(), geo, (500, 400), |x, y| {
            300.0 * (x * 50.0).sin() + 100.0 * (y * 70.0).cos()
        })]
    };
    let imagery = || {
        let geo = [15.05, 1.0 / 7000.0, 0.0, 48.4, 0.0, -1.0 / 7000.0];
        vec![sheet(&Crs::wgs84(), geo, (900, 800), |c, r| {
            [(c % 256) as u8, (r % 256) as u8, (c * r % 256) as u8, 255]
        })]
    };
    let one = built(elevation(), imagery(), |options| options.threads = 1);
    let many = built(elevation(), imagery(), |options| options.threads = 5);
    let small = built(elevation(), imagery(), |options| (options.threads, options.memory) = (1, 80 << 20));
    assert!(one.bytes == many.bytes, "threads");
    assert!(one.bytes == small.bytes, "memory");
}

#[test]
fn ellipsoidal_heights_come_down_to_the_geoid() {
    let mut raster = terrain(&Crs::wgs84(), [15.0, 0.001, 0.0, 48.1, 0.0, -0.001], (100, 100), |_, _| 300.0);
    raster.datum = VerticalDatum::Ellipsoid;
    let area = built(vec![raster], vec![], |_| {});
    let (x, y) = area.centre(area.grid.nx / 2, area.grid.ny / 2);
    let (lon, lat) = Transform::new(&utm(), &Crs::wgs84()).unwrap().apply(x, y).unwrap();
    let height = area.height(area.grid.nx / 2, area.grid.ny / 2).unwrap();
    assert!((height - (300.0 - egm96_undulation(lon, lat))).abs() < 0.05, "{height}");
    assert_eq!(area.pages.header().metadata.vertical_datum, "EGM96 mean sea level");
}

#[test]
fn a_box_is_cut_to_the_data_or_refused() {
    let flat = || vec![terrain(&utm(), north_up(500_000.0, 5_400_000.0, 10.0), (100, 100), |_, _| 5.0)];
    let area = built(flat(), vec![], |options| {
        options.bbox = Some([500_100.0, 5_399_500.0, 500_300.0, 5_500_000.0])
    });
    assert_eq!((area.grid.nx, area.grid.ny), (20, 50));
    assert!(area.pages.header().metadata.notes.iter().any(|note| note.contains("--bbox")));
    let refused =
        |bbox| try_build(flat(), vec![], |options| options.bbox = Some(bbox)).err().unwrap().to_string();
    assert!(refused([0.0, 0.0, 10.0, 10.0]).contains("lies outside"));
    assert!(refused([2.0, 0.0, 1.0, 10.0]).contains("is no area"));
    assert!(refused([f64::NAN, 0.0, 1.0, 10.0]).contains("is no area"));
}

#[test]
fn absurd_sizes_are_refused_with_a_remedy() {
    let flat = || vec![terrain(&utm(), north_up(500_000.0, 5_400_000.0, 10.0), (100, 100), |_, _| 5.0)];
    for spacing in [1.0e-3, 1.0e-9, 1.0e-300, -1.0, 0.0, f64::NAN, f64::INFINITY] {
        let error =
            try_build(flat(), vec![], |options| options.spacing = Some(spacing)).err().unwrap().to_string();
        assert!(error.contains("--spacing"), "{spacing}: {error}");
    }
}

#[test]
fn a_whole_planet_closes_at_the_date_line() {
    let geo = [-180.25, 0.5, 0.0, 90.25, 0.0, -0.5];
    let wave = |lon: f64, lat: f64| 1000.0 * (lon.to_radians() * 2.0).cos() * lat.to_radians().cos();
    let area = built(vec![terrain(&Crs::wgs84(), geo, (720, 361), wave)], vec![], |_| {});
    assert_eq!(area.pages.header().metadata.crs_epsg, Some(4087));
    let per_degree = 6_378_137.0_f64.to_radians();
    let worst = area.worst(|x, y| wave(x / per_degree, y / per_degree));
    assert!(worst < 3.0, "{worst}");
    assert!(area.grid.nx >= 719 && area.grid.ny >= 359, "{:?}", area.grid);
}

#[test]
fn web_mercator_is_not_kept() {
    let mercator = Crs::from_epsg(3857).unwrap();
    let flat = terrain(&mercator, north_up(1_600_000.0, 6_100_000.0, 30.0), (60, 60), |_, _| 5.0);
    let area = built(vec![flat], vec![], |_| {});
    assert_eq!(area.pages.header().metadata.crs_epsg, Some(32633));
    assert!(area.grid.spacing < 21.0, "ground metres, not Mercator's: {}", area.grid.spacing);
}
