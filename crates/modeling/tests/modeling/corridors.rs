//! Views of a database with a corridor: inside they are those of the whole database, across its border nothing gapes.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::LazyLock;

use glam::{DVec2, DVec3};

use hedgehop::frame::Frame;
use hedgehop::progress::Silent;
use hedgehop::raymarch::ground_height;
use hedgehop::render::{Engine, Rays, RenderOptions, Renderer, render_reference};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{MemPages, PageId, PageSource};
use hedgehop_modeling::{BuildOptions, Corridor, Place, Route, build};
use hedgehop_query::{ContinuityLimits, Fault, continuity};

/// Posts of a side, and metres between them.
const SIDE: u32 = 1500;
const SPACING: f64 = 2.0;

fn hill(x: f64, y: f64) -> f64 {
    let rough = 4.0 * (x * 0.31).sin() * (y * 0.27).cos();
    200.0 + 60.0 * (x * 0.006).sin() * (y * 0.008).cos() + rough
}

struct Areas {
    whole: MemPages,
    /// Voxels of 2 m up to 100 m from y = 300, of 8 m up to 300 m from it, of 32 m elsewhere.
    corridor: MemPages,
}

/// A grid of `side` × `side` posts, as text.
fn grid(side: u32, height: impl Fn(f64, f64) -> f64) -> String {
    let mut grid = format!("ncols {side}\nnrows {side}\nxllcorner 0\nyllcorner 0\ncellsize {SPACING}\n");
    for row in 0..side {
        for column in 0..side {
            let (x, y) = (f64::from(column) + 0.5, f64::from(side - row) - 0.5);
            write!(grid, "{:.2} ", height(x * SPACING, y * SPACING)).unwrap();
        }
        grid.push('\n');
    }
    grid
}

/// A database of a grid.
fn built(grid: &str, corridors: Vec<Corridor>, outside: f64) -> MemPages {
    let folder = tempfile::tempdir().unwrap();
    let [elevation, output] = ["dem.asc", "area.hop"].map(|name| folder.path().join(name));
    std::fs::write(&elevation, grid).unwrap();
    let options = BuildOptions {
        local: true,
        corridors,
        outside: Some(outside),
        ..BuildOptions::new(vec![elevation], vec![], output.clone())
    };
    build(&options, &Silent).unwrap();

    MemPages::from_bytes(Path::new("area.hop"), &std::fs::read(output).unwrap()).unwrap()
}

static AREAS: LazyLock<Areas> = LazyLock::new(|| {
    let places = vec![Place::Xy(0.0, 300.0), Place::Xy(3000.0, 300.0)];
    let route = Route { file: "route.csv".into(), places };
    let strip = |width, spacing| Corridor { route: route.clone(), width, spacing };
    let grid = grid(SIDE, hill);
    Areas {
        whole: built(&grid, vec![], 32.0),
        corridor: built(&grid, vec![strip(200.0, 2.0), strip(600.0, 8.0)], 32.0),
    }
});

fn camera(place: DVec2, height: f64, yaw: f64, pitch: f64) -> Camera {
    let ground = ground_height(&AREAS.whole, place).unwrap().unwrap();
    let attitude = Attitude { yaw, pitch, roll: 0.0 };
    Camera::new(Pose { eye: place.extend(ground + height), attitude, hfov: 60.0 }, 240, 136)
}

fn options(engine: Engine) -> RenderOptions {
    RenderOptions { engine, ..RenderOptions::default() }
}

fn see(pages: &MemPages, engine: Engine, camera: &Camera) -> (Frame, Rays) {
    let farm = Farm::new(2).unwrap();
    let rendered = Renderer::new(pages, &options(engine)).frame(camera, &farm).unwrap();
    (rendered.frame, rendered.account.rays)
}

#[test]
fn two_levels_are_absent_beside_the_corridor() {
    let has = |level, px, py| AREAS.corridor.has(PageId { level, px, py });
    assert!(has(0, 3, 0) && !has(0, 3, 1), "pages of 512 m, 200 m about y = 300");
    assert!(has(1, 0, 0) && !has(1, 0, 1), "pages of 2048 m, 600 m about y = 300");
}

#[test]
fn views_of_the_corridor_alone_are_those_of_the_whole() {
    for engine in [Engine::Planes, Engine::Reference] {
        for (x, yaw) in [(700.0, 0.0), (1500.0, 70.0), (2200.0, 200.0)] {
            let camera = camera(DVec2::new(x, 250.0), 120.0, yaw, -90.0);
            let (whole, all) = see(&AREAS.whole, engine, &camera);
            let (corridor, rays) = see(&AREAS.corridor, engine, &camera);
            // Planes read lines as far apart as suits the height above the coarse ground, which comes from elsewhere outside.
            // What is above the highest surface decides where rays are looked at first: rounding.
            let bound = if engine == Engine::Planes { 1e-3 } else { 1e-6 };
            let apart = |(a, b): (&f32, &f32)| (a - b).abs() <= bound * b;
            assert!(whole.range.iter().zip(&corridor.range).all(apart), "{engine:?} at {x}");
            // Haze counts from the lowest ground of a database, which lies elsewhere.
            let light = |frame: &Frame| frame.colour.iter().flatten().sum::<f32>();
            assert!((light(&whole) - light(&corridor)).abs() <= 2e-3 * light(&whole), "{engine:?} at {x}");
            assert_eq!((all.coarser, rays.coarser), (0, 0));
            assert!(rays.all > 0);
        }
    }
}

#[test]
fn rays_that_meet_a_level_that_stands_in_are_counted() {
    for (y, pitch, least, most) in
        [(2500.0, -90.0, 1.0, 1.0), (560.0, -20.0, 0.2, 1.0), (120.0, -10.0, 0.02, 0.9)]
    {
        let camera = camera(DVec2::new(1500.0, y), 60.0, 0.0, pitch);
        let shares = [Engine::Planes, Engine::Reference]
            .map(|engine| see(&AREAS.corridor, engine, &camera).1.coarser_share());
        assert!((least..=most).contains(&shares[1]), "{y}: {shares:?}");
        // Whole blocks of planes take the coarser level where one page is absent.
        assert!((shares[0] - shares[1]).abs() < 0.05, "{y}: {shares:?}");
    }
}

#[test]
fn borders_of_a_corridor_do_not_gape() {
    let farm = Farm::new(2).unwrap();
    let mut apart = 0;
    let mut errors = Vec::new();
    for step in 0..24 {
        let (x, y) = (300.0 + 100.0 * f64::from(step), 150.0 + 110.0 * f64::from(step % 7));
        for (yaw, pitch) in [(15.0 * f64::from(step), -8.0), (37.0 * f64::from(step), -30.0)] {
            let camera = camera(DVec2::new(x, y), 15.0 + 12.0 * f64::from(step % 5), yaw, pitch);
            let fine = |engine| RenderOptions { detail: 20.0, ..options(engine) };
            let truth =
                render_reference(&AREAS.corridor, &camera, &fine(Engine::Reference), &farm).unwrap().frame;
            let whole =
                render_reference(&AREAS.whole, &camera, &fine(Engine::Reference), &farm).unwrap().frame;
            let found =
                Renderer::new(&AREAS.corridor, &fine(Engine::Planes)).frame(&camera, &farm).unwrap().frame;

            for (pixel, (truth, found)) in truth.range.iter().zip(&found.range).enumerate() {
                apart += u32::from(truth.is_finite() != found.is_finite());
                if truth.is_finite() && found.is_finite() {
                    errors.push(f64::from((truth - found).abs() / truth));
                }

                // A gap would show the sky, or ground far behind, below what is near in the whole database; not at the area's own edge.
                let row = pixel / camera.width as usize;
                let is_near = |up: usize| whole.range[pixel - up * camera.width as usize] < 400.0;
                if row > camera.height as usize * 3 / 4 && (0..4).all(is_near) {
                    assert!(
                        *truth < 900.0 && *found < 900.0,
                        "{step}: {truth} {found} for {}",
                        whole.range[pixel]
                    );
                }
            }
        }
    }

    errors.sort_by(f64::total_cmp);
    let at = |share: f64| errors[(errors.len() as f64 * share) as usize];
    let share = f64::from(apart) / errors.len() as f64;

    // Beside the border planes may see the coarser level where rays see the finer one.
    assert!(
        at(0.5) <= 1.5e-4 && at(0.95) <= 2e-2 && share <= 3e-3,
        "{} {} {} {share}",
        at(0.5),
        at(0.95),
        at(0.99)
    );
}

#[test]
fn frames_tell_the_level_that_stands_in_and_its_slopes() {
    let place = DVec2::new(1500.0, 2700.0);
    // Without what voxels of 32 m leave out.
    let (x, y) = (place.x * 0.006, place.y * 0.008);
    let slope = DVec2::new(0.36 * x.cos() * y.cos(), -0.48 * x.sin() * y.sin());
    let normal = (-slope).extend(1.0).normalize();
    assert!(normal.angle_between(DVec3::Z) > 0.25);
    for engine in [Engine::Planes, Engine::Reference] {
        let (frame, _) = see(&AREAS.corridor, engine, &camera(place, 60.0, 0.0, -90.0));
        assert!(frame.level.iter().all(|level| *level == 2), "{engine:?}");
        let off = |found: &[f32; 3]| DVec3::from_array(found.map(f64::from)).angle_between(normal);
        let worst = frame.normal.iter().map(off).fold(0.0, f64::max);
        assert!(worst < 0.12, "{engine:?}: {worst}");
    }
}

#[test]
fn ground_beside_the_corridor_is_that_of_the_level_there() {
    let height = |y: f64| ground_height(&AREAS.corridor, DVec2::new(1500.0, y)).unwrap().unwrap();
    assert!((height(300.0) - hill(1500.0, 300.0)).abs() < 0.5);
    for y in [900.0, 2700.0] {
        assert!((height(y) - hill(1500.0, y)).abs() < 10.0, "{y}: {}", height(y));
    }
    assert_eq!(ground_height(&AREAS.corridor, DVec2::new(1500.0, 3100.0)).unwrap(), None);
}

#[test]
fn corridors_over_smooth_ground_have_neither_seams_nor_cracks() {
    let smooth = |x: f64, y: f64| 200.0 + 40.0 * (x * 0.006).sin() * (y * 0.008).cos();
    let report = |height: &dyn Fn(f64, f64) -> f64| {
        // Across corners of pages, so that their border has steps.
        let places = vec![Place::Xy(100.0, 100.0), Place::Xy(1700.0, 1500.0)];
        let route = Route { file: "route.csv".into(), places };
        let area = built(&grid(900, height), vec![Corridor { route, width: 40.0, spacing: 2.0 }], 8.0);
        continuity(&area, &ContinuityLimits::default(), &Silent).unwrap()
    };
    let sound = report(&smooth);
    assert!((4..16).contains(&sound.pages), "{}", sound.pages);
    assert_eq!(sound.findings, []);
    // A step of the ground itself is found there.
    let stepped = report(&|x, y| smooth(x, y) + if x >= 700.0 { 5.0 } else { 0.0 });
    assert_eq!((stepped.count(Fault::Seam), stepped.count(Fault::Crack)), (1, 0));
}
