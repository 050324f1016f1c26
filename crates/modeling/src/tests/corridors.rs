//! Strips along routes that are stored more finely than the rest.

use std::path::Path;
use std::sync::LazyLock;

use glam::DVec2;

use super::support::{Area, built, north_up, sheet, terrain, try_build};
use crate::opened::Opened;
use crate::{BuildOptions, Corridor, NodataFill, Place, Route};
use hedgehop::voxel::{Grid, PAGE_SIDE, PageId, PageSource, Relief, verify};
use hedgehop_base::Size;
use hedgehop_base::progress::Silent;
use hedgehop_geo::{Crs, Transform, VerticalDatum};

const ROUTE: [[f64; 2]; 3] = [[-500.0, 300.0], [1900.0, 2100.0], [2600.0, 2100.0]];

fn utm() -> Crs {
    Crs::from_epsg(32633).unwrap()
}

fn route(places: &[[f64; 2]]) -> Route {
    Route { file: "flight.csv".into(), places: places.iter().map(|&[x, y]| Place::Xy(x, y)).collect() }
}

fn corridor(width: f64, spacing: f64) -> Corridor {
    Corridor { route: route(&ROUTE), width, spacing }
}

/// 300 m at 1 m and 900 m at 4 m along the route, 16 m outside.
fn nested(options: &mut BuildOptions) {
    options.corridors = vec![corridor(300.0, 1.0), corridor(900.0, 4.0)];
    options.outside = Some(16.0);
}

fn hill(x: f64, y: f64) -> f64 {
    300.0 + 90.0 * (x * 0.004).sin() * (y * 0.005).cos() + 8.0 * (x * 0.11).sin() * (y * 0.07).sin()
}

/// Columns and rows of the fine raster.
const FINE: (u32, u32) = (2900, 2300);

/// Its heights by rows, southward.
static FINE_HEIGHTS: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let row = |row| (0..FINE.0).map(move |column| hill(f64::from(column) + 0.5, 2499.5 - f64::from(row)));
    (0..FINE.1).flat_map(row).collect()
});

/// Posts of 16 m over 4.8 × 3.2 km, and of 1 m over a part around the route.
fn rasters() -> Vec<Opened<f64>> {
    let local = Crs::local();
    let wide = terrain(&local, north_up(0.0, 3200.0, 16.0), (300, 200), hill);
    let heights = &*FINE_HEIGHTS;
    let fine = sheet(&local, north_up(0.0, 2500.0, 1.0), FINE, |column, row| {
        heights[row as usize * FINE.0 as usize + column as usize]
    });
    vec![fine, wide]
}

/// The nested corridors over those, and all at 1 m.
static NESTED: LazyLock<Area> = LazyLock::new(|| built(rasters(), vec![], nested));
static WHOLE: LazyLock<Area> = LazyLock::new(|| built(rasters(), vec![], |_| {}));

fn present(area: &Area) -> Vec<PageId> {
    area.pages.directory().present().map(|(id, _)| id).collect()
}

/// Least distance of a page's square from the route, by places a metre apart.
fn distance_from_route(grid: &Grid, id: PageId) -> f64 {
    let Size { width, height } = grid.page_size(id).unwrap();
    let side = grid.side(id.level);
    let low = grid.origin + DVec2::new(f64::from(id.px), f64::from(id.py)) * f64::from(PAGE_SIDE) * side;
    let high = low + DVec2::new(f64::from(width), f64::from(height)) * side;
    let mut least = f64::INFINITY;
    for leg in ROUTE.windows(2) {
        let [from, to] = [leg[0], leg[1]].map(DVec2::from_array);
        let steps = from.distance(to).ceil();
        for step in 0..=steps as u32 {
            let at = from.lerp(to, f64::from(step) / steps);
            least = least.min(at.distance(at.clamp(low, high)));
        }
    }
    least
}

#[test]
fn pages_are_stored_where_the_corridor_meets_their_squares() {
    let area = &*NESTED;
    assert_eq!((area.grid.nx, area.grid.ny, area.grid.spacing), (4800, 3200, 1.0));
    let (mut stored, mut absent) = ([0; 2], [0; 2]);
    for id in area.pages.directory().ids() {
        let has = area.pages.has(id);
        if id.level >= 2 {
            assert!(has, "{id}");
            continue;
        }
        let reach = [150.0, 450.0][usize::from(id.level)];
        let distance = distance_from_route(&area.grid, id);
        // Places between those looked at may be nearer by a fraction of a metre.
        assert!(has == (distance <= reach) || (distance - reach).abs() < 0.5, "{id}: {distance} {has}");
        let count = if has { &mut stored } else { &mut absent };
        count[usize::from(id.level)] += 1;
    }

    assert!(stored[0] > 25 && absent[0] > 150 && stored[1] > 5 && absent[1] > 5, "{stored:?} {absent:?}");
    let corridors = &area.pages.header().metadata.corridors;
    assert_eq!(corridors.len(), 2);
    assert_eq!(
        (corridors[1].route.as_str(), corridors[1].width, corridors[1].spacing),
        ("flight.csv", 900.0, 4.0)
    );
}

#[test]
fn a_file_is_as_large_as_its_pages() {
    let area = &*NESTED;
    let pages = present(area);
    let count = |level: u8| pages.iter().filter(|id| id.level == level).count();
    // Heights and colours with aprons, at coarser levels bounds and slopes; attributes at the most for each voxel.
    let (finest, coarse) = (268 * 268 * 5, 268 * 268 * 5 + 256 * 256 * 4 + 266 * 266 * 5);
    let whole =
        |id: &&PageId| area.grid.page_size(**id) == Some(Size { width: PAGE_SIDE, height: PAGE_SIDE });
    let least =
        pages.iter().filter(whole).map(|id| if id.level == 0 { finest } else { coarse }).sum::<usize>();
    let most = count(0) * (finest + 266_500) + (pages.len() - count(0)) * (coarse + 266_500);
    let size = area.bytes.len() - area.pages.directory().len() * 32;
    assert!((least..most).contains(&size), "{least} {size} {most}");
}

#[test]
fn corridors_hold_what_the_whole_database_does() {
    let (whole, area) = (&*WHOLE, &*NESTED);
    assert_eq!(whole.pages.header().heights, area.pages.header().heights);
    let finest: Vec<PageId> = present(area).into_iter().filter(|id| id.level == 0).collect();
    assert!(finest.len() > 25, "{finest:?}");
    for id in finest {
        let page = |area: &Area| area.pages.whole_page(id).unwrap().unwrap().to_buffer();
        assert_eq!(page(area), page(whole), "{id}");
    }
}

#[test]
fn corridor_databases_are_sound() {
    for fill in [NodataFill::None, NodataFill::Interpolate] {
        let local = Crs::local();

        // A void that reaches from the corridor out of it.
        let holed = terrain(&local, north_up(0.0, 3200.0, 16.0), (300, 200), |x, y| {
            if DVec2::new(x - 1500.0, y - 1200.0).length() < 400.0 { f64::NAN } else { hill(x, y) }
        });
        let fine = terrain(&local, north_up(0.0, 2500.0, 1.0), (1400, 2300), hill);
        let area = built(vec![fine, holed], vec![], |options| {
            nested(options);
            options.nodata_fill = fill;
        });
        let report = verify(&area.pages, &Silent).unwrap();
        assert!(report.problems.is_empty(), "{:?}", report.problems[0]);
        assert!(report.absent > report.pages);
        let metadata = &area.pages.header().metadata;
        assert_eq!(metadata.empty_share > 0.0, fill == NodataFill::None);

        // A disc of 400 m, without what the finer raster covers.
        let disc = std::f64::consts::PI * 160_000.0 / (4800.0 * 3200.0);
        assert!((0.4 * disc..disc).contains(&metadata.void_share), "{} {disc}", metadata.void_share);
    }
}

#[test]
fn coarse_voxels_outside_are_means_of_their_sources() {
    // Stripes of 0 and 100 m, two metres wide, have the mean 50 everywhere, and steep slopes.
    let board = || {
        sheet(&Crs::local(), north_up(0.0, 2048.0, 1.0), (2048, 2048), |c, _| f64::from(c / 2 % 2) * 100.0)
    };
    let area = built(vec![board()], vec![], |options| {
        options.corridors = vec![Corridor { route: route(&[[100.0, 100.0]]), width: 20.0, spacing: 1.0 }];
        options.outside = Some(4.0);
    });
    assert_eq!(present(&area).iter().filter(|id| id.level == 0).count(), 1);
    let code = area.pages.header().heights;
    let id = PageId { level: 1, px: 1, py: 1 };
    let (view, bounds) = (area.pages.page(id).unwrap().unwrap(), area.pages.bounds(id).unwrap().unwrap());

    for (x, y) in [(0, 0), (100, 30), (255, 255)] {
        assert!((code.decode(view.heights[view.sample(x, y)]).unwrap() - 50.0).abs() < 0.6);
        let low = bounds.low[(y * 256 + x) as usize];
        assert!(low <= view.heights[view.sample(x, y)] && low > code.encode(20.0));
    }

    // What lies below the size of a voxel shows in its slopes.
    let relief = view.relief[(20 * 266 + 20) as usize];
    assert_ne!(relief, Relief::default());
}

#[test]
fn coarse_voxels_of_coarse_rasters_are_those_rasters() {
    let area = &*NESTED;
    let code = area.pages.header().heights;
    let view = area.pages.page(PageId { level: 2, px: 1, py: 0 }).unwrap().unwrap();
    for (x, y) in [(270, 20), (290, 60), (280, 190)] {
        let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) * 16.0;
        let x = x - PAGE_SIDE;
        let height = code.decode(view.heights[view.sample(x, y)]).unwrap();
        assert!((height - hill(at.x, at.y)).abs() <= code.scale, "{x} {y}: {height}");
        assert_eq!(view.relief[((y + 5) * (view.width + 10) + x + 5) as usize], Relief::default());
    }
}

#[test]
fn outside_is_as_coarse_as_the_coarsest_raster_by_default() {
    for (pixel, level) in [(16.0, 2), (15.9, 1), (63.0, 2), (300.0, 3)] {
        let local = Crs::local();
        let wide = terrain(
            &local,
            north_up(0.0, 6000.0, pixel),
            ((6000.0 / pixel) as u32, (6000.0 / pixel) as u32),
            hill,
        );
        let fine = terrain(&local, north_up(0.0, 600.0, 1.0), (600, 600), hill);
        // Of 300 m the largest multiple is 256, but an area of this size has no such level.
        let area = built(vec![fine, wide], vec![], |options| {
            options.corridors =
                vec![Corridor { route: route(&[[300.0, 300.0]]), width: 100.0, spacing: 1.0 }];
        });
        let finest_outside = (0..4)
            .find(|&level| area.pages.has(PageId { level, px: area.grid.page_dims(level).0 - 1, py: 0 }));
        assert_eq!(finest_outside, Some(level), "{pixel} m");
    }
}

#[test]
fn routes_in_degrees_lie_where_the_ground_does() {
    let degrees = Transform::new(&utm(), &Crs::wgs84()).unwrap();
    let wide = terrain(&utm(), north_up(500_000.0, 5_403_200.0, 16.0), (200, 200), |_, _| 5.0);
    let (longitude, latitude) = degrees.apply(501_000.0, 5_402_000.0).unwrap();
    let mut wide = wide;
    wide.datum = VerticalDatum::Msl;
    let area = built(vec![wide], vec![], |options| {
        let places = vec![Place::LonLat(longitude, latitude)];
        let route = Route { file: "track.gpx".into(), places };
        options.corridors = vec![Corridor { route, width: 2.0, spacing: 1.0 }];
    });
    let finest: Vec<PageId> = present(&area).into_iter().filter(|id| id.level == 0).collect();
    assert_eq!(finest, [PageId { level: 0, px: 1000 / 256, py: 2000 / 256 }]);
}

#[test]
fn threads_and_memory_change_no_byte_of_a_corridor() {
    let with = |threads: usize, memory: u64| {
        built(rasters(), vec![], |options| {
            nested(options);
            (options.threads, options.memory) = (threads, memory);
        })
    };
    let (one, many) = (with(1, 512 << 20), with(5, 200 << 20));
    assert!(one.bytes == many.bytes);
}

#[test]
fn corridors_that_make_no_sense_are_refused() {
    let refused = |adjust: &dyn Fn(&mut BuildOptions)| {
        try_build(rasters(), vec![], |options| {
            nested(options);
            adjust(options);
        })
        .err()
        .expect("an error")
        .to_string()
    };

    for (width, spacing, flag) in [
        (0.0, 1.0, "--width"),
        (f64::NAN, 1.0, "--width"),
        (-5.0, 1.0, "--width"),
        (f64::INFINITY, 1.0, "--width"),
        (5.0, 0.0, "--spacing"),
        (5.0, f64::NAN, "--spacing"),
    ] {
        let error = refused(&|options| options.corridors[0] = corridor(width, spacing));
        assert!(error.contains(flag) && error.contains("positive"), "{error}");
    }

    let error = refused(&|options| options.corridors[1].spacing = 5.0);
    assert!(
        error.contains("--spacing 5 is not 1, 4, 16, 64") && error.contains("4 or 16 would do"),
        "{error}"
    );
    let error = refused(&|options| options.outside = Some(8.0));
    assert!(error.contains("--outside 8") && error.contains("4 or 16 would do"), "{error}");
    let error = refused(&|options| options.outside = Some(4.0));
    assert!(error.contains("--spacing 4 adds nothing") && error.contains("--outside"), "{error}");
    let error = refused(&|options| options.outside = Some(1024.0));
    assert!(
        error.contains("--outside 1024") && error.contains("smaller than a voxel")
            || error.contains("coarsest level"),
        "{error}"
    );
    let error = refused(&|options| options.corridors[0].route = route(&[[-9000.0, 0.0], [-8000.0, 1.0]]));
    assert!(
        error.contains("flight.csv") && error.contains("outside the area") && error.contains("--bbox"),
        "{error}"
    );
    let error = refused(&|options| options.corridors[0].route = route(&[[f64::NAN, 0.0]]));
    assert!(error.contains("fix 1 has no place"), "{error}");
    let error = refused(&|options| options.corridors[0].route = route(&[]));
    assert!(error.contains("no fix"), "{error}");
    let degrees = Route { file: "track.gpx".into(), places: vec![Place::LonLat(15.0, 48.0)] };
    let error = refused(&|options| options.corridors[0].route = degrees.clone());
    assert!(error.contains("track.gpx") && error.contains("plain metres"), "{error}");
    assert!(!Path::new("area.hop").exists());
}

#[test]
fn a_corridor_as_wide_as_the_area_is_the_whole_of_it() {
    let all = built(rasters(), vec![], |options| {
        options.corridors = vec![corridor(1.0e300, 1.0)];
    });
    assert_eq!(present(&all).len(), all.pages.directory().len());
    for id in present(&all) {
        let page = |area: &Area| area.pages.whole_page(id).unwrap().unwrap().to_buffer();
        assert_eq!(page(&all), page(&WHOLE), "{id}");
    }
}
