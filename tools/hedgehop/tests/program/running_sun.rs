//! Suns that run with a flight.

use std::fs;

use tempfile::TempDir;

use crate::common::{ends, run};

/// Bytes of a frame of 64 × 36 pixels in a y4m stream, with its marker.
const FRAME: usize = 6 + 64 * 36 * 3 / 2;

/// Film of six frames, 2 h 50 min apart.
const FLY: &str = "render area.hop --path day.csv --duration 6s --fps 1 --size 64x36 --hfov 70";

/// Ridges north of the Alps, and a flight over them that lasts from before a midsummer's sunrise to after its sunset.
fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let height = |row: usize, column: usize| 50 + 40 * usize::from((row / 6 + column / 9).is_multiple_of(3));
    let row =
        |row: usize| (0..96).map(|column| height(row, column).to_string()).collect::<Vec<_>>().join(" ");
    let rows = (0..96).map(row).collect::<Vec<_>>().join("\n");
    let head = "ncols 96\nnrows 96\nxllcorner 600000\nyllcorner 5200000\ncellsize 10";
    write(&folder, "dem.asc", &format!("{head}\n{rows}\n"));

    let fix = |hour: usize| (3 + hour, 600_480 + 5 * hour, 5_200_100 + 20 * hour);
    let dated =
        |(hour, x, y): (usize, usize, usize)| format!("2026-06-21T{hour:02}:00:00Z,{x},{y},200,-15\n");
    let silent = |(hour, x, y): (usize, usize, usize)| format!("{},{x},{y},200,-15\n", 3600 * (hour - 3));
    let fixes =
        |row: &dyn Fn((usize, usize, usize)) -> String| (0..=17).map(fix).map(row).collect::<String>();
    write(&folder, "day.csv", &format!("time,x_m,y_m,alt_msl_m,pitch_deg\n{}", fixes(&dated)));
    write(&folder, "silent.csv", &format!("time_s,x_m,y_m,alt_msl_m,pitch_deg\n{}", fixes(&silent)));

    ends(&run(&folder, "build --elevation dem.asc --elevation-crs EPSG:32632 -o area.hop"), 0);
    folder
}

fn write(folder: &TempDir, name: &str, text: &str) {
    fs::write(folder.path().join(name), text).expect("a file");
}

/// Frames of a film, one after the other.
fn film(site: &TempDir, flags: &str) -> Vec<u8> {
    ends(&run(site, &format!("{FLY} {flags} --overwrite -o film.y4m")), 0);
    let stream = fs::read(site.path().join("film.y4m")).expect("a film");
    let head = stream.iter().position(|byte| *byte == b'\n').expect("a header") + 1;
    stream[head..].to_vec()
}

#[test]
fn each_frame_is_lit_as_if_the_sun_stood_still_at_its_moment() {
    let site = site();
    for look in ["--shadows on", "--engine reference", "--antialias 2 --shutter 180 --shadows on"] {
        let day = film(&site, &format!("{look} --sun track"));
        let frames: Vec<_> = day.chunks(FRAME).collect();
        assert_eq!(frames.len(), 6);
        for (number, time) in [(2, "05:50:00Z"), (4, "13:30:00+02:00"), (6, "17:10Z")] {
            let still = film(&site, &format!("{look} --sun 2026-06-21T{time} --frames {number}"));
            assert!(still == frames[number - 1], "{look}: frame {number}");
        }
        assert!(frames[1] != frames[3]);

        let some = film(&site, &format!("{look} --sun track --frames 2,5 --jobs 1 --in-flight 1"));
        assert!(some == [frames[1], frames[4]].concat(), "{look}");
        assert!(day == film(&site, &format!("{look} --sun track --jobs 3 --in-flight 3")), "{look}");
    }
}

#[test]
fn scenes_and_frames_of_light_have_a_running_sun_too() {
    let site = site();
    let scene = |name: &str, sun: &str| {
        let weather = "[clouds]\nbase_m = 300\ntop_m = 400\ncoverage = 0.5\n[[light]]\nat = [600500, 5200300, 5]\ncandela = 500\n";
        write(&site, name, &format!("[sun]\n{sun}\nshadows = true\n{weather}"));
    };
    scene("track.toml", "time = \"track\"");
    scene("from.toml", "time = 2026-06-21T03:00:00Z\nruns = true");
    scene("night.toml", "time = 2026-06-21T03:00:00Z");
    scene("noon.toml", "time = 2026-06-21T11:30:00Z");
    let frame = |scene: &str, path: &str, number: u32| {
        let flags =
            format!("--scene {scene}.toml --path {path}.csv --frames {number} --overwrite -o x/####.exr");
        ends(&run(&site, &FLY.replace("--path day.csv", &flags)), 0);
        let file = fs::read(site.path().join(format!("x/000{number}.exr"))).expect("a frame");
        // Digests of settings, which are others, stand before this attribute, and light behind it.
        let name = b"hedgehop.vertical_datum";
        let light = file.windows(name.len()).position(|bytes| bytes == name).expect("an attribute");
        file[light..].to_vec()
    };

    for (still, number) in [("night", 1), ("noon", 4)] {
        let still = frame(still, "day", number);
        for (scene, path) in [("track", "day"), ("from", "day"), ("from", "silent")] {
            assert!(frame(scene, path, number) == still, "frame {number} of {scene}, {path}");
        }
    }
    assert!(frame("track", "day", 1) != frame("track", "day", 4));
}

#[test]
fn frames_tell_of_a_sun_that_runs() {
    let site = site();
    let fly = |flags: &str| run(&site, &format!("{FLY} {flags} --skip-existing -o frames/####.png"));
    ends(&fly("--sun track"), 0);
    let text = fs::read_to_string(site.path().join("frames/manifest.json")).expect("a manifest");
    let manifest: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(manifest["settings"]["sun_runs_from"], "2026-06-21T03:00:00Z");
    assert!(manifest["settings"].get("sun_azimuth_elevation_deg").is_none());
    let elevation = |frame: usize| manifest["frames"][frame]["sun_azimuth_elevation_deg"][1].as_f64();
    assert!(elevation(0) < Some(0.0) && elevation(3) > Some(60.0), "{text}");

    assert!(ends(&fly("--sun track"), 0).contains("kept 6"));
    assert!(ends(&fly("--sun 2026-06-21T03:00Z --sun-runs"), 0).contains("kept 6"));
    assert!(ends(&fly("--sun 2026-06-21T03:01Z --sun-runs"), 0).contains("rendered 6 frames"));

    let flight = "area.hop --path day.csv --duration 6s --fps 1 --sun track --shadows on";
    ends(&run(&site, &format!("plan {flight} --no-timing")), 0);
    ends(&run(&site, &format!("bench {flight} --size 64x36 --workers 1,2 --repeats 1")), 0);
    ends(&run(&site, "bake area.hop --sun 200,30 -o baked.hop"), 0);
    let baked = FLY.replace("area", "baked");
    let said = ends(&run(&site, &format!("{baked} --sun track -o baked/####.png")), 0);
    assert!(said.contains("baked.hop holds the shadows") && said.contains("runs with the flight"), "{said}");
}

#[test]
fn suns_that_cannot_run_are_refused_with_the_remedy() {
    let site = site();
    write(&site, "track.toml", "[sun]\ntime = \"track\"\n");
    write(&site, "both.toml", "[sun]\ntime = \"track\"\nruns = true\n");
    write(&site, "angles.toml", "[sun]\nazimuth_deg = 9\nelevation_deg = 9\nruns = true\n");
    write(&site, "mixed.toml", "[sun]\ntime = \"track\"\nelevation_deg = 9\n");
    let igc =
        "AXXX\nHFPLTPILOT:A\nB0300004655000N01018700EA0020000200\nB0301004655100N01018700EA0020000200\n";
    write(&site, "undated.igc", igc);
    let silent = "--path silent.csv";
    for (flags, code, words) in [
        (format!("{silent} --sun track"), 2, ["silent.csv tells no time", "--sun TIME with --sun-runs"]),
        (format!("{silent} --scene track.toml"), 3, ["track.toml: line 2", "runs = true"]),
        ("--path undated.igc --sun track".into(), 2, ["not the date", "--sun-runs"]),
        ("--eye 600500,5200500,200 --sun track".into(), 2, ["--eye and --views tell no time", "--sun TIME"]),
        ("--path day.csv --sun 90,10 --sun-runs".into(), 2, ["--sun-runs needs a TIME", "angles"]),
        ("--path day.csv --sun track --sun-runs".into(), 2, ["--sun-runs needs a TIME", "track"]),
        ("--path day.csv --sun-runs".into(), 2, ["--sun", "required"]),
        ("--path day.csv --sun 2999-12-31T20:00Z --sun-runs".into(), 2, ["the year 3000", "2999"]),
        ("--path day.csv --scene both.toml".into(), 3, ["both.toml: line 3", "leave runs out"]),
        ("--path day.csv --scene angles.toml".into(), 3, ["angles.toml: line 4", "runs needs time"]),
        ("--path day.csv --scene mixed.toml".into(), 3, ["mixed.toml: line 2", "not both"]),
    ] {
        let said = ends(
            &run(&site, &format!("render area.hop {flags} --size 16x9 --fps 1 --frames 1 -o no/####.png")),
            code,
        );
        assert!(words.iter().all(|word| said.contains(word)), "{flags}: {said}");
    }
}
