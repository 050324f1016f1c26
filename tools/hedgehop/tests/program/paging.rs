//! What a flight needs and takes of its database: `plan`, and the flags of `render` and `bench` about memory.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use tempfile::TempDir;

/// A database of 2.4 km of hills with posts 3 m apart, and a path over it.
struct Site(TempDir);

impl Site {
    fn built() -> Self {
        let site = Self(TempDir::new().expect("a temporary folder"));
        let side = 800;
        let mut grid = format!("ncols {side}\nnrows {side}\nxllcorner 0\nyllcorner 0\ncellsize 3\n");
        for row in 0..side {
            let height = |column: i32| {
                100.0 + 40.0 * (f64::from(column) * 0.02).sin() + 30.0 * (f64::from(row) * 0.03).cos()
            };
            let heights: Vec<String> = (0..side).map(|column| format!("{:.2}", height(column))).collect();
            grid += &heights.join(" ");
            grid.push('\n');
        }
        fs::write(site.path("dem.asc"), grid).expect("the grid is written");
        let path = "t_s,x_m,y_m,alt_agl_m\n0,300,400,60\n2,900,900,60\n4,1500,1400,60\n";
        fs::write(site.path("path.csv"), path).expect("the path is written");
        let output = site.run("build", &["--elevation", "dem.asc", "--local", "-o", "area.hop"]);
        assert!(output.status.success(), "{}", said(&output));
        site
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, command: &str, args: &[&str]) -> Output {
        let program = env!("CARGO_BIN_EXE_hedgehop");
        Command::new(program).current_dir(self.0.path()).arg(command).args(args).output().expect("it starts")
    }

    /// A flight at 5 frames a second in small pictures.
    fn fly(&self, command: &str, args: &[&str]) -> Output {
        let flight = ["area.hop", "--path", "path.csv", "--size", "160x90", "--fps", "5", "--level"];
        self.run(command, &[&flight[..], args].concat())
    }

    fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&fs::read(self.path(name)).expect("it is there")).expect("it is JSON")
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[test]
fn a_plan_tells_what_the_flight_then_reads() {
    let site = Site::built();
    let planned = site.fly("plan", &["--json", "--traffic", "plan.svg"]);
    assert!(planned.status.success(), "{}", said(&planned));
    let plan: serde_json::Value = serde_json::from_slice(&planned.stdout).expect("it is JSON");

    for level in plan["levels"].as_array().expect("levels") {
        // The area is a square of 2.4 km.
        let (reach, ground) =
            (level["reach_m"].as_f64().expect("metres"), level["area_km2"].as_f64().expect("km²"));
        assert!(reach <= 2400.0 * 2.0_f64.sqrt() && ground <= 5.7601, "{level}");
    }

    let rendered = site.fly("render", &["-o", "frames/####.png", "--stats", "--traffic", "flown.svg"]);
    assert!(rendered.status.success(), "{}", said(&rendered));
    let manifest = site.json("frames/manifest.json");
    let frames = manifest["frames"].as_array().expect("frames");
    assert_eq!(plan["frames"].as_u64(), Some(frames.len() as u64));
    assert_eq!(plan["by_frame"].as_array().map(Vec::len), Some(frames.len()));

    // Pages that the path's heights above ground were read from are there before the first frame.
    let read: u64 =
        frames.iter().map(|frame| frame["cost"]["paging"]["bytes_read"].as_u64().expect("bytes")).sum();
    let needed = plan["flight_bytes"].as_u64().expect("bytes");
    assert!(read > needed / 4 && read <= needed, "{read} of {needed}");
    let misses: u64 =
        frames.iter().map(|frame| frame["cost"]["paging"]["demand_misses"].as_u64().expect("count")).sum();
    assert_eq!(misses, 0);
    for map in ["plan.svg", "flown.svg"] {
        let svg = fs::read_to_string(site.path(map)).expect("the map is there");
        assert!(svg.starts_with("<svg") && svg.contains("level 1:") && svg.matches("<rect").count() > 10);
    }

    let text = said(&site.fly("plan", &["--no-timing"]));
    for line in ["one view", "with ahead", "--memory", "level 1 ", "verdict"] {
        assert!(text.contains(line), "{line}: {text}");
    }
}

#[test]
fn the_memory_that_a_plan_names_is_enough() {
    let site = Site::built();
    let planned = site.fly("plan", &["--json", "--no-timing", "-j", "2"]);
    let plan: serde_json::Value = serde_json::from_slice(&planned.stdout).expect("it is JSON");
    let memory = plan["memory_bytes"].as_u64().expect("bytes").to_string();
    let rendered = site.fly("render", &["-o", "frames/####.png", "-j", "2", "--stats", "--memory", &memory]);
    assert!(rendered.status.success(), "{}", said(&rendered));
    assert!(said(&rendered).contains(" 0 demand misses"), "{}", said(&rendered));
    let unlimited = site.fly("render", &["-o", "free/####.png", "-j", "1"]);
    assert!(unlimited.status.success());
    assert!(!said(&unlimited).contains("demand misses"), "{}", said(&unlimited));
    for frame in ["0001.png", "0011.png", "0021.png"] {
        assert_eq!(
            fs::read(site.path("frames").join(frame)).expect("frame"),
            fs::read(site.path("free").join(frame)).expect("frame")
        );
    }
}

#[test]
fn a_plan_says_what_a_budget_holds() {
    let site = Site::built();
    let plan = |memory: &str| site.fly("plan", &["--no-timing", "-j", "2", "--memory", memory]);
    let enough = plan("500M");
    assert!(enough.status.success(), "{}", said(&enough));
    assert!(said(&enough).contains("--memory 500 MiB holds 30 frames ahead"), "{}", said(&enough));
    let little = plan("8M");
    assert_eq!(little.status.code(), Some(2), "{}", said(&little));
    assert!(said(&little).contains("--memory of 8 MiB is too little"), "{}", said(&little));
}

#[test]
fn a_preloaded_database_is_read_once_and_before() {
    let site = Site::built();
    let rendered = site.fly("render", &["-o", "frames/####.png", "--preload"]);
    assert!(rendered.status.success(), "{}", said(&rendered));
    let frames = site.json("frames/manifest.json");
    for frame in frames["frames"].as_array().expect("frames") {
        assert_eq!(frame["cost"]["paging"]["pages_read"].as_u64(), Some(0), "{frame}");
        assert_eq!(frame["cost"]["paging"]["demand_misses"].as_u64(), Some(0), "{frame}");
    }
}

#[test]
fn what_cannot_be_planned_is_refused() {
    let site = Site::built();
    for (args, wanted) in [
        (&["--screen", "orthographic", "--ground-width", "900"][..], "reference marcher"),
        (&["--surface", "blocks"][..], "reference marcher"),
        (&["--traffic", "area.hop"][..], "--traffic would replace"),
        (&["--frames", "500"][..], "frame"),
    ] {
        let output = site.fly("plan", args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", said(&output));
        assert!(said(&output).contains(wanted), "{args:?}: {}", said(&output));
    }
}

#[test]
fn frames_that_never_wait_say_how_much_was_late() {
    let site = Site::built();
    let rendered = site.fly("render", &["--late", "coarser", "--stats", "-o", "live/####.png"]);
    assert!(rendered.status.success(), "{}", said(&rendered));
    let told = said(&rendered);
    assert!(
        told.contains("since its pages came late; most in frame")
            && told.contains(" late, added up over the frames"),
        "{told}"
    );
    let manifest = site.json("live/manifest.json");
    assert_eq!(manifest["settings"]["late"], "coarser");
    let frames = manifest["frames"].as_array().expect("frames");
    let shares: Vec<f64> = frames.iter().map(|f| f["coarser_share"].as_f64().expect("a share")).collect();
    assert!(shares[0] > 0.0 && shares.iter().all(|share| (0.0..=1.0).contains(share)), "{shares:?}");
    for count in ["demand_misses", "demand_waits", "demand_wait_ns", "frame_wait_ns"] {
        assert!(frames.iter().all(|frame| frame["cost"]["paging"][count] == 0), "{count}: {told}");
    }

    let late = frames.iter().map(|frame| frame["cost"]["paging"]["pages_late"].as_u64().expect("pages"));
    assert!(late.sum::<u64>() > 0, "{told}");
}

#[test]
fn with_everything_in_memory_nothing_is_late() {
    let site = Site::built();
    for (film, how) in
        [("wait.y4m", &["--late", "wait"][..]), ("live.y4m", &["--late", "coarser", "--preload"])]
    {
        let rendered = site.fly("render", &[how, &["-o", film]].concat());
        assert!(rendered.status.success(), "{}", said(&rendered));
        assert!(!said(&rendered).contains("late"), "{}", said(&rendered));
    }
    let films = ["wait.y4m", "live.y4m"].map(|film| fs::read(site.path(film)).expect("it is there"));
    assert!(films[0] == films[1]);
}
