//! Data sets of views without a path: `--views`.

use std::fs;

use tempfile::TempDir;

use crate::common::{ends, run};
use hedgehop::voxel::{Arrays, Grid, Metadata, write_arrays};

/// A folder with a database of a slope, 640 m wide, that rises 100 m eastward.
fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let grid = Grid { nx: 64, ny: 64, spacing: 10.0, origin: glam::DVec2::new(1000.0, 2000.0) };
    let heights: Vec<f64> = (0..64 * 64).map(|index| 100.0 * f64::from(index % 64) / 64.0).collect();
    let arrays = Arrays { grid, heights: &heights, colours: &vec![[90, 140, 60]; 64 * 64], attributes: None };
    let metadata = Metadata { crs_name: "local".into(), ..Metadata::default() };
    write_arrays(&folder.path().join("area.hop"), &arrays, &metadata, false).expect("a database");
    folder
}

const RANDOM: &str =
    "render area.hop --size 32x18 --views random --heights 20,120 --pitches=-80,-20 --seed 5";

fn text(site: &TempDir, name: &str) -> String {
    fs::read_to_string(site.path().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Numbers of a row of poses: frame, t_s, x_m, y_m, z_m, yaw_deg, pitch_deg, roll_deg.
fn rows(poses: &str) -> Vec<Vec<f64>> {
    let row = |line: &str| {
        let fields = line.split(',').filter(|field| !field.is_empty());
        fields.map(|field| field.parse().expect("a number")).collect()
    };
    poses.lines().skip(1).map(row).collect()
}

#[test]
fn parts_of_random_views_are_those_of_the_whole() {
    let site = site();
    let fly = |args: &str| ends(&run(&site, &format!("{RANDOM} {args}")), 0);
    fly("--count 12 -o whole/####.png --poses transforms,tum --fps 1");
    let poses = text(&site, "whole/poses.csv");
    let rows = rows(&poses);
    assert_eq!(rows.len(), 12);
    for row in &rows {
        let [x, y, z, pitch] = [row[2], row[3], row[4], row[6]];
        assert!((1000.0..1640.0).contains(&x) && (2000.0..2640.0).contains(&y), "{row:?}");
        // Posts lie in the middle of voxels; at the edges the ground is level.
        let ground = (100.0 * ((x - 1000.0) / 10.0 - 0.5) / 64.0).clamp(0.0, 100.0 * 63.0 / 64.0);
        assert!((20.0 - 0.1..120.0 + 0.1).contains(&(z - ground)), "{row:?}");
        assert!((-80.0..=-20.0).contains(&pitch) && row[7] == 0.0, "{row:?}");
    }
    assert_eq!((rows[0][1], rows[11][1]), (0.0, 11.0));
    assert!(text(&site, "whole/manifest.json").contains("\"kind\": \"random\""));
    assert!(text(&site, "whole/poses.tum").lines().filter(|line| !line.starts_with('#')).count() == 12);

    // In parts, on one worker, and of a smaller set that grows.
    fly("--count 6 -o parts/####.png --frames 3-5 --fps 1 -j 1");
    let said = fly("--count 12 -o parts/####.png --skip-existing --poses transforms,tum --fps 1");
    assert!(said.contains("kept 3"), "{said}");
    for name in ["poses.csv", "transforms.json", "poses.tum", "0004.png", "0011.png"] {
        let bytes = |folder: &str| fs::read(site.path().join(folder).join(name)).expect("a file");
        assert!(bytes("whole") == bytes("parts"), "{name}");
    }
    assert!(ends(&run(&site, "verify parts"), 0).contains("sound"));

    let other = format!("{} --count 12 --fps 1 -o whole/####.png", RANDOM.replace("--seed 5", "--seed 6"));
    assert!(ends(&run(&site, &other), 2).contains("views is another one"));
}

#[test]
fn grids_and_orbits_stand_where_they_are_put() {
    let site = site();
    let render = "render area.hop --size 16x9 --fps 1";
    let grid = "--views grid --spacing 300 --heights 50 --headings 0,90 -o grid/####.png";
    ends(&run(&site, &format!("{render} {grid}")), 0);
    let places: Vec<_> = rows(&text(&site, "grid/poses.csv"))
        .into_iter()
        .map(|row| [row[2], row[3], row[5], row[6]])
        .collect();
    assert_eq!(places.len(), 8);
    assert_eq!(places[0], [1170.0, 2170.0, 0.0, -90.0]);
    assert_eq!(places[3], [1470.0, 2170.0, 90.0, -90.0]);
    assert_eq!(places[4], [1170.0, 2470.0, 0.0, -90.0]);

    let orbit = "--views orbit --look-at 1320,2320 --radius 100 --heights 20,60 --count 4 -o orbit/####.png";
    let said = ends(&run(&site, &format!("{render} {orbit}")), 0);
    assert!(!said.contains("raised"), "{said}");
    let rows = rows(&text(&site, "orbit/poses.csv"));
    assert_eq!(rows.len(), 8);
    assert!((rows[1][2] - 1420.0).abs() < 1e-9 && (rows[1][5] - 270.0).abs() < 1e-9, "{:?}", rows[1]);
    assert!((rows[7][4] - rows[0][4] - 40.0).abs() < 1e-9);
    ends(&run(&site, "plan area.hop --views random --count 20 --heights 50 --size 64x36 --no-timing"), 0);
}

#[test]
fn views_that_make_no_sense_are_refused_in_a_sentence() {
    let site = site();
    for (args, part) in [
        ("random --heights 20", "--views random needs --count N"),
        ("random --count 3", "--views random needs --heights METRES"),
        ("grid --heights 20", "--views grid needs --spacing METRES"),
        ("orbit --heights 20 --count 3 --look-at 1320,2320", "--views orbit needs --radius METRES"),
        ("orbit --heights 20 --count 3 --radius 9", "--views orbit needs --look-at X,Y[,Z]"),
        ("grid --heights 20 --spacing 99 --seed 1", "no use for --seed, which is of --views random"),
        ("random --heights 20 --count 3 --radius 9", "no use for --radius, which is of --views orbit"),
        ("random --heights 120,20 --count 3", "--heights of --views random is a range"),
        ("random --heights 1,2,3 --count 3", "--heights of --views random is a range"),
        ("random --heights 0,20 --count 3", "give some above 0"),
        ("random --heights 20 --count 3 --pitches=-100,0", "want degrees from -90"),
        ("random --heights 20 --count 3 --pitches 0 --look-at 1320,2320", "--pitches and --headings are of"),
        ("random --heights 20 --count 3 --look-at tower", "--look-at tower: --views looks at a place"),
        ("random --heights 20 --count 3 --bbox 0,0,9,9", "found no ground for view 1"),
        ("grid --heights 20 --spacing 5 --bbox 0,0,9,9", "view 1 of --views grid has no ground"),
        ("orbit --heights 500 --count 3 --look-at 1320,2320 --radius 900", "take a smaller --radius"),
        ("random --heights 20 --count 3 --frames 2-4", "--views has frames 1-3"),
        ("random --heights 20 --count 3 --shutter 180", "--shutter blurs"),
        ("random --heights 20 --count 3 --hud=all", "text and figures tell of a flight"),
        ("random --heights 20 --count 3 --pitch 5", "cannot be used with"),
        ("random --heights 20 --count 3 --sort", "--path FILE"),
        ("random --heights 20 --count 3 --eye 1,2,3", "cannot be used with"),
        (
            "random --heights 20 --count 3 --screen orthographic --ground-width 9 --pitches 0",
            "a map is seen from above",
        ),
    ] {
        let said = ends(&run(&site, &format!("render area.hop --views {args} -o no/####.png")), 2);
        assert!(said.contains(part), "{args}: {said}");
    }

    // Channels of EXR, and flags of views without any.
    let motion = "render area.hop --views random --heights 20 --count 3 --aov motion -o no/####.exr";
    assert!(ends(&run(&site, motion), 2).contains("--aov motion tells how the picture moves"));
    let said = ends(&run(&site, "render area.hop --eye 1,2,3 --count 3 -o no.png"), 2);
    assert!(said.contains("--count is of --views random or orbit; give --views"), "{said}");
    assert!(!site.path().join("no").exists());
}
