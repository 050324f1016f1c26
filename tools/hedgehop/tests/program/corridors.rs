//! `build --corridor` from outside: what is stored, what `info` and `render` say of it, and flags that do not fit.

use std::fs;
use std::path::PathBuf;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;

use crate::common::run_args;

/// A folder with elevation of 1600 × 1200 m in posts of 2 m, and a route through it.
struct Site {
    folder: TempDir,
}

impl Site {
    fn new() -> Self {
        let folder = TempDir::new().expect("a temporary folder");
        let (columns, rows) = (800, 600);
        let mut grid = format!("ncols {columns}\nnrows {rows}\nxllcorner 0\nyllcorner 0\ncellsize 2\n");
        for row in 0..rows {
            let height = |column: i32| {
                let (x, y) = (f64::from(column) * 0.02, f64::from(row) * 0.03);
                format!("{:.2}", 100.0 + 40.0 * x.sin() + 30.0 * y.cos())
            };
            grid += &(0..columns).map(height).collect::<Vec<_>>().join(" ");
            grid.push('\n');
        }
        fs::write(folder.path().join("dem.asc"), grid).expect("the elevation is written");
        let path = "t_s,x_m,y_m,alt_agl_m\n0,100,120,40\n3,800,120,40\n6,1500,120,40\n";
        fs::write(folder.path().join("route.csv"), path).expect("the route is written");
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, args: &[&str]) -> Output {
        run_args(&self.folder, args)
    }

    fn build(&self, more: &[&str]) -> Output {
        let args = ["build", "--elevation", "dem.asc", "--local", "-o", "area.hop", "--progress", "none"];
        self.run(&[&args, more].concat())
    }

    fn info(&self) -> Value {
        let output = self.run(&["info", "--json", "area.hop"]);
        assert_code(&output, 0);
        serde_json::from_slice(&output.stdout).expect("JSON")
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[track_caller]
fn assert_code(output: &Output, code: i32) {
    assert_eq!(output.status.code(), Some(code), "{}{}", text(&output.stdout), text(&output.stderr));
}

const CORRIDOR: [&str; 6] = ["--corridor", "route.csv", "--width", "200", "--spacing", "2"];

#[test]
fn a_corridor_is_stored_and_told() {
    let site = Site::new();
    let built = site.build(&[&CORRIDOR[..], &["--outside", "32"]].concat());
    assert_code(&built, 0);
    let info = site.info();
    let pages = |level: usize| (&info["stored"][level]["pages"], &info["stored"][level]["pages_of_grid"]);
    // Squares of 512 m: the southern one of three rows and all columns; of 2048 m there is one.
    assert_eq!(pages(0), (&Value::from(4), &Value::from(12)));
    assert_eq!(pages(1), (&Value::from(1), &Value::from(1)));
    assert_eq!(info["metadata"]["corridors"][0]["route"], "route.csv");
    let shown = text(&site.run(&["info", "area.hop"]).stdout);
    assert!(shown.contains("200 m wide at 2 m along route.csv"), "{shown}");
    assert!(shown.contains("level 1: 4 of 12 pages (33.3333 %)"), "{shown}");
    assert_code(&site.run(&["verify", "area.hop", "--progress", "none"]), 0);
    let bytes: u64 = (0..4).map(|level| info["stored"][level]["bytes"].as_u64().unwrap()).sum();
    let size = fs::metadata(site.path("area.hop")).unwrap().len();
    assert!(size > bytes && size < bytes + 40_000 + 32 * 20, "{size} {bytes}");
}

#[test]
fn rendering_says_how_much_was_coarser_than_it_should_be() {
    let site = Site::new();
    assert_code(&site.build(&[&CORRIDOR[..], &["--outside", "32"]].concat()), 0);
    let render = |more: &[&str]| {
        let args = ["render", "area.hop", "--size", "96x54", "--progress", "none", "--curvature", "off"];
        let output = site.run(&[&args, more].concat());
        assert_code(&output, 0);
        text(&output.stderr)
    };

    for engine in ["planes", "reference"] {
        let looks = |eye: &str, ypr: &str| {
            render(&["--eye", eye, "--ypr", ypr, "-o", "v.png", "--engine", engine, "--alt-mode", "agl"])
        };
        // Straight down in the middle of the corridor, and where the nearest stored page is a level coarser.
        let (inside, outside) = (looks("800,200,60", "0,-90,0"), looks("800,900,60", "0,-90,0"));
        assert!(!inside.contains("more coarsely"), "{engine}: {inside}");
        assert!(
            outside.contains("100.000 % of the rays met ground that is stored more coarsely"),
            "{engine}: {outside}"
        );
    }

    fs::create_dir(site.path("frames")).unwrap();
    render(&["--path", "route.csv", "--fps", "1", "-o", "frames/####.png"]);
    let manifest: Value =
        serde_json::from_slice(&fs::read(site.path("frames/manifest.json")).unwrap()).unwrap();
    let shares: Vec<f64> =
        manifest["frames"].as_array().unwrap().iter().map(|f| f["coarser_share"].as_f64().unwrap()).collect();
    assert_eq!(shares.len(), 7);
    assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)), "{shares:?}");

    // Without corridors there is nothing to tell.
    assert_code(&site.build(&["--overwrite"]), 0);
    let note = render(&["--eye", "800,900,60", "--ypr", "0,-30,0", "-o", "v.png", "--alt-mode", "agl"]);
    assert!(!note.contains("more coarsely"), "{note}");
}

#[test]
fn altitudes_count_from_the_finest_ground_there_is() {
    let site = Site::new();
    assert_code(&site.build(&[&CORRIDOR[..], &["--outside", "32"]].concat()), 0);
    let path = "t_s,x_m,y_m,alt_agl_m\n0,800,1000,50\n1,802,1000,50\n";
    fs::write(site.path("beside.csv"), path).unwrap();
    let args =
        ["render", "area.hop", "--path", "beside.csv", "--fps", "1", "--size", "32x18", "--progress=none"];
    let output = site.run(&[&args[..], &["-o", "f/####.png"]].concat());
    assert_code(&output, 0);
    let poses = fs::read_to_string(site.path("f/poses.csv")).unwrap();
    let z: f64 = poses.lines().nth(1).unwrap().split(',').nth(4).unwrap().parse().unwrap();
    let ground = 100.0 + 40.0 * (400.0_f64 * 0.02).sin() + 30.0 * (100.0_f64 * 0.03).cos();
    assert!((z - ground - 50.0).abs() < 3.0, "{z} over {ground}");
}

#[test]
fn flags_that_make_no_corridor_are_refused_in_a_sentence() {
    let site = Site::new();
    fs::write(site.path("away.csv"), "t_s,x_m,y_m,alt_agl_m\n0,90000,0,40\n1,90100,0,40\n").unwrap();
    let refused = |more: &[&str], code: i32, words: &[&str]| {
        let output = site.build(more);
        assert_code(&output, code);
        let said = text(&output.stderr);
        assert!(words.iter().all(|word| said.contains(word)), "{more:?}: {said}");
        assert!(!site.path("area.hop").exists());
    };

    refused(&["--corridor", "route.csv"], 2, &["--width"]);
    refused(&["--width", "200"], 2, &["--corridor"]);
    refused(&["--outside", "32"], 2, &["--corridor"]);
    refused(&["--corridor", "route.csv", "--width", "200"], 2, &["1 --width and 0 --spacing"]);
    refused(&[&CORRIDOR[..], &["--width", "400"]].concat(), 2, &["2 --width and 1 --spacing", "same order"]);
    for width in ["0", "-3", "nan", "inf", "wide"] {
        refused(&["--corridor", "route.csv", "--width", width, "--spacing", "2"], 2, &["--width", "above 0"]);
    }

    refused(
        &[&CORRIDOR[..], &["--width", "400", "--spacing", "5"]].concat(),
        2,
        &["--spacing 5", "2 or 8 would do"],
    );
    refused(&[&CORRIDOR[..], &["--outside", "33"]].concat(), 2, &["--outside 33", "32 or 128 would do"]);

    // Everything is stored at 2 m anyway.
    refused(&CORRIDOR, 2, &["adds nothing", "--outside"]);
    refused(
        &["--corridor", "away.csv", "--width", "200", "--spacing", "2", "--outside", "32"],
        2,
        &["away.csv", "outside the area"],
    );
    refused(&["--corridor", "none.csv", "--width", "200", "--spacing", "2"], 5, &["none.csv"]);
    refused(&[&CORRIDOR[..], &["--outside", "32", "--memory", "60M"]].concat(), 2, &["--memory"]);
}

#[test]
fn widths_nest_in_any_order_and_a_huge_one_is_all() {
    let site = Site::new();
    let nested = ["--width", "1e12", "--spacing", "8", "--outside", "32", "-j", "1"];
    assert_code(&site.build(&[&CORRIDOR[..], &nested].concat()), 0);
    let info = site.info();
    let pages = |level: usize| info["stored"][level]["pages"].as_u64().unwrap();
    assert_eq!((pages(0), pages(1), pages(2)), (4, 1, 1));
    assert_eq!(info["metadata"]["corridors"].as_array().unwrap().len(), 2);
}
