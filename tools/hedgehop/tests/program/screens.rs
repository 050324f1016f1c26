//! `--screen` and `--detail` from outside: every projection, what files say of it, and flags that do not fit.

use std::fs;
use std::path::PathBuf;
use std::process::Output;

use tempfile::TempDir;

use crate::common::run_args;
use hedgehop::voxel::{Arrays, Grid, Metadata, write_arrays};

/// A folder with a database of hills and a path of 2 seconds.
struct Site {
    folder: TempDir,
}

impl Site {
    fn built() -> Self {
        let folder = TempDir::new().expect("a temporary folder");
        let grid = Grid { nx: 160, ny: 160, spacing: 10.0, origin: glam::DVec2::ZERO };
        let heights: Vec<f64> = (0..160 * 160)
            .map(|post| 100.0 + 40.0 * f64::from(post % 160).sin() + f64::from(post / 160))
            .collect();
        let colours = vec![[90, 140, 60]; heights.len()];
        let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
        let metadata = Metadata { crs_name: "local".into(), ..Metadata::default() };
        write_arrays(&folder.path().join("area.hop"), &arrays, &metadata, false).expect("a database");
        let path = "t_s,x_m,y_m,alt_agl_m\n0,200,700,60\n1,500,800,60\n2,900,820,60\n";
        fs::write(folder.path().join("path.csv"), path).expect("the path is written");
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, args: &[&str]) -> Output {
        run_args(&self.folder, args)
    }

    /// Renders the path at 10 frames per second, small.
    fn fly(&self, more: &[&str]) -> Output {
        let args = ["render", "area.hop", "--path", "path.csv", "--fps", "10", "--size", "96x54"];
        self.run(&[&args, more].concat())
    }
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[track_caller]
fn assert_code(output: &Output, code: i32) {
    assert_eq!(output.status.code(), Some(code), "stdout: {}\nstderr: {}", stdout(output), stderr(output));
}

#[test]
fn every_screen_makes_a_picture_and_says_which() {
    let site = Site::built();
    let view = |more: &[&str]| {
        let args = ["render", "area.hop", "--eye", "800,300,400", "--ypr", "-10,-20,0", "-o", "view.png"];
        let output = site.run(&[&args[..], &["--size", "64x36", "--progress=none"], more].concat());
        assert_code(&output, 0);
        String::from_utf8_lossy(&fs::read(site.path("view.png")).unwrap()).into_owned()
    };

    for (screen, said) in [
        (&["--hfov", "50"][..], "planar hfov_deg=50"),
        (&["--screen", "cylindrical"], "cylindrical hfov_deg=180"),
        (&["--screen", "equirectangular", "--vfov", "90"], "equirectangular hfov_deg=360 vfov_deg=90"),
        (&["--screen", "fisheye", "--channel", "0,90,0"], "fisheye fov_deg=180"),
        (&["--screen", "orthographic", "--ground-width", "900"], "orthographic width_m=900"),
    ] {
        assert!(view(screen).contains(said), "{screen:?}");
    }

    let wrong = |more: &[&str], remedy: &str| {
        let output =
            site.run(&[&["render", "area.hop", "--eye", "800,300,400", "-o", "no.png"], more].concat());
        assert_code(&output, 2);
        assert!(stderr(&output).contains(remedy), "{}", stderr(&output));
    };
    wrong(&["--hfov", "180"], "--screen cylindrical");
    wrong(&["--screen", "orthographic"], "--ground-width");
    wrong(&["--vfov", "90"], "--screen equirectangular");
    let missing =
        site.run(&["render", "area.hop", "--eye", "8,3,4", "-o", "no.png", "--screen", "table:no.exr"]);
    assert_code(&missing, 5);
    assert!(stderr(&missing).contains("no.exr"), "{}", stderr(&missing));
    assert!(!site.path("no.png").exists());
}

#[test]
fn a_map_follows_the_path_from_above_and_records_what_it_is() {
    let site = Site::built();
    let map = ["--screen", "orthographic", "--ground-width", "500", "--frames", "1,9", "-o", "map/####.png"];
    let output = site.fly(&map);
    assert_code(&output, 0);
    assert!(stderr(&output).contains("above all ground"), "{}", stderr(&output));
    let manifest = fs::read_to_string(site.path("map/manifest.json")).unwrap();
    assert!(manifest.contains("\"screen\": \"orthographic width_m=500\""), "{manifest}");
    assert!(
        manifest.contains("\"pitch_deg\": -90.0") && manifest.contains("\"hfov_deg\": null"),
        "{manifest}"
    );
    let again = site.fly(&[&map[..], &["--skip-existing"]].concat());
    assert!(stdout(&again).contains("kept 2"), "{}", stdout(&again));
    let other = [&map[..3], &["600"], &map[4..], &["--skip-existing"]].concat();
    assert!(!stdout(&site.fly(&other)).contains("kept"), "another width is another picture");
}

#[test]
fn what_scan_planes_do_not_serve_is_said() {
    let site = Site::built();
    let look = |command: &[&str], more: &[&str]| {
        let view = ["area.hop", "--eye", "300,500,400", "--size", "64x36"];
        let output = site.run(&[command, &view, &["--simd", "portable"], more].concat());
        assert_code(&output, 0);
        output
    };

    for (more, marcher, count) in [
        (&["--ypr", "0,-10,0"][..], "planes on portable", 0),
        (&["--ypr", "0,-89,0"], "planes on portable", 0),
        (&["--screen", "orthographic", "--ground-width", "500"], "planes on portable, 1 by the reference", 1),
    ] {
        let bench = look(&["bench", "--repeats", "1", "--workers", "1", "--json", "b.json"], more);
        assert!(stdout(&bench).contains(&format!("cores, {marcher}\n")), "{}", stdout(&bench));
        let json: serde_json::Value =
            serde_json::from_slice(&fs::read(site.path("b.json")).unwrap()).unwrap();
        assert_eq!((&json["engine"], &json["simd"]), (&"planes".into(), &"portable".into()));
        assert_eq!(json["frames_by_reference"], count);
        let notes = stderr(&look(&["render", "-o", "view.png"], more));
        assert_eq!(notes.contains("do not serve 1 of 1 frames"), count == 1, "{notes}");
    }

    let flags = "bench area.hop --eye 300,500,400 --size 64x36 --engine reference --repeats 1 --workers 1 --json b.json";
    let bench = site.run(&flags.split_whitespace().collect::<Vec<_>>());
    assert!(stdout(&bench).contains("cores, reference engine\n"), "{}", stdout(&bench));
    let json: serde_json::Value = serde_json::from_slice(&fs::read(site.path("b.json")).unwrap()).unwrap();
    assert_eq!((&json["engine"], json["simd"].is_null()), (&"reference".into(), true));
    assert_eq!(json["frames_by_reference"], 1);
}

#[test]
fn detail_changes_pictures_and_is_recorded() {
    let site = Site::built();
    let frame = |detail: &str, folder: &str| {
        let output = site.fly(&["--frames", "1", "--detail", detail, "-o", &format!("{folder}/%04d.png")]);
        assert_code(&output, 0);
        let manifest = fs::read_to_string(site.path(&format!("{folder}/manifest.json"))).expect("a manifest");
        assert!(manifest.contains(&format!("\"detail\": {detail}")), "{manifest}");
        fs::read(site.path(&format!("{folder}/0001.png"))).expect("a frame")
    };
    assert_ne!(frame("0.5", "coarse"), frame("8.0", "fine"));
    let refused = site.fly(&["--detail", "0", "-o", "none/%04d.png"]);
    assert_code(&refused, 2);
    assert!(stderr(&refused).contains("0.1 (coarse and fast) to 16"), "{}", stderr(&refused));
}
