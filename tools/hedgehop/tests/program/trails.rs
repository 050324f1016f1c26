//! `--trail`, `--tail` and `--other` from outside.

use std::fs;

use tempfile::TempDir;

use crate::common::{ends, run};
use hedgehop::voxel::{Arrays, Grid, Metadata, write_arrays};

/// A folder with a level database, a path that looks back, and another flight beside it.
fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let grid = Grid { nx: 160, ny: 160, spacing: 10.0, origin: glam::DVec2::ZERO };
    let (heights, colours) = (vec![100.0; 160 * 160], vec![[60, 90, 50]; 160 * 160]);
    let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
    let metadata = Metadata { crs_name: "local".into(), ..Metadata::default() };
    write_arrays(&folder.path().join("area.hop"), &arrays, &metadata, false).expect("a database");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    // Round a circle, with a view of its other side.
    let fix = |second: u32| {
        let turn = 0.2 * f64::from(second);
        let (x, y) = (800.0 + 200.0 * turn.sin(), 700.0 + 200.0 * turn.cos());
        format!("{second},{x},{y},{},{},-8\n", 60 + second, (turn.to_degrees() + 180.0) % 360.0)
    };
    let fixes: String = (0..=20).map(fix).collect();
    write("path.csv", &format!("t_s,x_m,y_m,alt_agl_m,yaw_deg,pitch_deg\n{fixes}"));
    write("b.csv", "t_s,x_m,y_m,alt_agl_m\n0,760,300,50\n20,760,820,50\n");
    write("one.csv", "t_s,x_m,y_m,alt_agl_m\n0,760,300,50\n");
    folder
}

const FLY: &str = "render area.hop --path path.csv --fps 1 --size 160x90";

#[test]
fn trails_of_flights_are_as_long_as_asked_for() {
    let site = site();
    let orange = |args: &str, number: u32| {
        ends(&run(&site, &format!("{FLY} --frames {number} {args} --overwrite -o frames/####.png")), 0);
        let frame = site.path().join(format!("frames/{number:04}.png"));
        let pixels = image::open(frame).expect("a frame").into_rgb8().into_raw();
        let is_orange = |rgb: &&[u8]| rgb[0] > 180 && rgb[1] < 170 && rgb[2] < 120;
        pixels.chunks_exact(3).filter(is_orange).count()
    };
    assert_eq!(orange("", 20), 0);
    let [early, late, tail] = [("", 12), ("", 20), ("--tail 5s", 20)]
        .map(|(args, number)| orange(&format!("--trail #ff6000 {args}"), number));
    assert!(early < late / 2 && late > 150 && tail == 0, "{early} {late} {tail}");
    assert!(orange("--trail altitude", 20) < late / 4);
}

#[test]
fn other_flights_are_objects_and_their_files_count() {
    let site = site();
    let again = format!("{FLY} --frames 20 --other b.csv --other b.csv --skip-existing -o two/####.exr");
    let said = ends(&run(&site, &again), 0);
    assert!(said.contains("b.csv begins with the flight"), "{said}");
    let manifest = fs::read_to_string(site.path().join("two/manifest.json")).expect("a manifest");
    let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
    assert_eq!(manifest["settings"]["scene"]["objects"], serde_json::json!(["b", "b 2"]));
    assert!(ends(&run(&site, &again), 0).contains("kept 1"));
    fs::write(site.path().join("b.csv"), "t_s,x_m,y_m,alt_agl_m\n0,760,300,50\n20,760,830,50\n").expect("b");
    assert!(ends(&run(&site, &again), 0).contains("rendered 1 frame"));
}

#[test]
fn what_has_no_trail_is_refused() {
    let site = site();
    for (args, code, part) in [
        ("--tail 3s", 2, "--trail or --other"),
        ("--trail height", 2, "altitude, speed, climb"),
        ("--other one.csv", 3, "single fix"),
        ("--other none.csv", 5, "none.csv"),
    ] {
        let said = ends(&run(&site, &format!("{FLY} {args} -o x/####.png")), code);
        assert!(said.contains(part), "{args}: {said}");
    }
    let eye = "render area.hop --eye 800,400,200 --trail climb -o x.png";
    assert!(ends(&run(&site, eye), 2).contains("--path"));
}
