//! The program from outside: what it says, what it leaves behind, and how it ends.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use std::{fs, thread};

use tempfile::TempDir;

const COMMANDS: [&str; 7] = ["build", "render", "plan", "info", "verify", "bench", "demo"];
/// Longest that any step of a test may take before it counts as hung.
const PATIENCE: Duration = Duration::from_secs(120);

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_hedgehop"))
}

fn run<I: AsRef<OsStr>>(args: impl IntoIterator<Item = I>) -> Output {
    program().args(args).stdin(Stdio::null()).output().expect("the program starts")
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Standard error without the notes of what was assumed.
fn complaint(output: &Output) -> String {
    stderr(output)
        .lines()
        .filter(|line| !line.starts_with("note: "))
        .map(|line| format!("{line}\n"))
        .collect()
}

#[track_caller]
fn assert_code(output: &Output, code: i32) {
    assert_eq!(output.status.code(), Some(code), "stdout: {}\nstderr: {}", stdout(output), stderr(output));
    assert!(!stderr(output).contains("panicked"), "{}", stderr(output));
}

/// A folder with an elevation grid of `side`² posts, 10 m apart, and the arguments that build it.
struct Site {
    folder: TempDir,
}

impl Site {
    fn new(side: u32) -> Self {
        let folder = TempDir::new().expect("a temporary folder");
        let mut grid = format!("ncols {side}\nnrows {side}\nxllcorner 0\nyllcorner 0\ncellsize 10\n");
        for row in 0..side {
            let heights: Vec<String> = (0..side)
                .map(|column| {
                    let (x, y) = (f64::from(column) * 0.05, f64::from(row) * 0.07);
                    format!("{:.2}", 100.0 + 40.0 * x.sin() + 30.0 * y.cos())
                })
                .collect();
            grid += &heights.join(" ");
            grid.push('\n');
        }
        fs::write(folder.path().join("dem.asc"), grid).expect("the grid is written");
        Self { folder }
    }

    /// A site with its database and a path of 2 seconds.
    fn built() -> Self {
        let site = Self::new(160);
        assert_code(&site.build(&[]), 0);
        let path = "t_s,x_m,y_m,alt_agl_m\n0,200,700,60\n1,500,800,60\n2,900,820,60\n";
        fs::write(site.path("path.csv"), path).expect("the path is written");
        site
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, args: &[&str]) -> Output {
        program().current_dir(self.folder.path()).args(args).stdin(Stdio::null()).output().expect("it starts")
    }

    fn spawn(&self, args: &[&str], stdout: impl Into<Stdio>) -> Child {
        program()
            .current_dir(self.folder.path())
            .args(args)
            .stdin(Stdio::null())
            .stdout(stdout)
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts")
    }

    fn build(&self, more: &[&str]) -> Output {
        let args = ["build", "--elevation", "dem.asc", "--local", "-o", "area.hop", "--progress", "none"];
        self.run(&[&args, more].concat())
    }

    /// Renders the path at 10 frames per second, small.
    fn render(&self, more: &[&str]) -> Output {
        self.run(&[&render_args(), more].concat())
    }
}

fn render_args() -> [&'static str; 9] {
    ["render", "area.hop", "--path", "path.csv", "--fps", "10", "--size", "96x54", "--progress=none"]
}

fn frames_in(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut frames: Vec<_> = fs::read_dir(folder)
        .expect("the folder is there")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension() == Some(OsStr::new("png")))
        .map(|path| {
            (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(&path).expect("a frame"))
        })
        .collect();
    frames.sort();
    frames
}

#[track_caller]
fn wait_until(what: &str, mut done: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !done() {
        assert!(begun.elapsed() < PATIENCE, "waited in vain for {what}");
        thread::sleep(Duration::from_millis(10));
    }
}

fn finish(mut child: Child) -> Output {
    wait_until("the program's end", || child.try_wait().expect("a status").is_some());
    child.wait_with_output().expect("its output")
}

#[test]
fn every_help_has_an_example_and_the_exit_codes() {
    for command in COMMANDS {
        let output = run([command, "--help"]);
        assert_code(&output, 0);
        let help = stdout(&output);
        assert!(help.contains(&format!("hedgehop {command}")), "{command}: {help}");
        assert!(help.contains("Example") && help.contains("130  interrupted"), "{command}: {help}");
    }
    assert!(stdout(&run(["--help"])).contains("hedgehop demo"));
    assert!(stdout(&run(["--version"])).starts_with("hedgehop "));
}

#[test]
fn the_manual_names_every_flag() {
    let manual = include_str!("../../../../docs/cli.md");
    for command in COMMANDS {
        let help = stdout(&run([command, "--help"]));
        let flags = help
            .lines()
            .filter_map(|line| line.trim_start().strip_prefix('-').map(|_| line))
            .flat_map(str::split_whitespace)
            .filter(|word| word.starts_with("--"));
        for flag in flags.map(|flag| flag.trim_end_matches([',', '.', ';', ':'])) {
            assert!(manual.contains(flag), "docs/cli.md does not mention {flag} of {command}");
        }
    }
}

#[test]
fn wrong_flags_are_usage_errors() {
    for args in [
        &["fly"][..],
        &["build", "-o", "x.hop"],
        &["build", "--elevation", "a.tif", "-o", "x.hop", "--memory", "many"],
        &["build", "--elevation", "a.tif", "-o", "x.hop", "--bbox", "10,0,-10,5"],
        &["build", "--elevation", "a.tif", "-o", "x.hop", "--bands", "1,2,3"],
        &["render", "x.hop", "-o", "f.png"],
        &["render", "x.hop", "--path", "p.csv", "--eye", "1,2,3", "-o", "f.png"],
        &["render", "x.hop", "--path", "p.csv", "-o", "f.gif"],
        &["render", "x.hop", "--path", "p.csv", "-o", "f.png", "--size", "0x9"],
        &["render", "x.hop", "--path", "p.csv", "-o", "f.png", "-j", "0"],
        &["render", "x.hop", "--path", "p.csv", "-o", "f.png", "--screen", "flat"],
        &["render", "x.hop", "--path", "p.csv", "-o", "f.png", "--hfov", "361"],
        &["render", "x.hop", "--path", "p.csv", "-o", "f.png", "--curvature", "2"],
        &["render", "x.hop", "--path", "p.csv", "-o", "f.png", "--simd", "sse"],
        &["bench", "x.hop", "--path", "p.csv", "--workers", "two"],
        &["bench", "x.hop", "--path", "p.csv", "--engine", "reference", "--simd", "portable"],
    ] {
        let output = run(args);
        assert_code(&output, 2);
        assert!(stderr(&output).starts_with("error: "), "{args:?}: {}", stderr(&output));
    }
}

#[test]
fn missing_and_wrong_inputs_are_one_sentence_each() {
    let site = Site::new(8);
    fs::write(site.path("junk.hop"), b"no database at all").unwrap();
    fs::create_dir(site.path("tiles")).unwrap();
    let build = |input: &str| site.run(&["build", "--elevation", input, "-o", "a.hop", "--progress", "none"]);

    for (output, code, word) in [
        (site.run(&["info", "absent.hop"]), 5, "absent.hop"),
        (site.run(&["render", "absent.hop", "--eye", "1,2,3", "-o", "v.png"]), 5, "absent.hop"),
        (site.run(&["info", "junk.hop"]), 3, "junk.hop"),
        (site.run(&["verify", "junk.hop"]), 3, "junk.hop"),
        (build("absent.tif"), 5, "absent.tif"),
        (build("tiles"), 2, "folder"),
        (build("*.tif"), 2, "pattern"),
        (build("dem.asc"), 4, "--local"),
    ] {
        assert_code(&output, code);
        let message = complaint(&output);
        assert!(message.contains(word), "{message}");
        assert!(message.trim_end().lines().count() == 1, "not one sentence: {message}");
    }

    assert!(!site.path("a.hop").exists());
}

#[test]
fn a_database_is_built_described_verified_and_not_overwritten_by_accident() {
    let site = Site::new(40);
    let built = site.build(&[]);
    assert_code(&built, 0);
    assert!(stdout(&built).contains("40 x 40 voxels of 10 m") && stdout(&built).contains("MB/s"));
    assert_code(&site.build(&[]), 2);
    assert_code(&site.build(&["--overwrite"]), 0);

    let info = site.run(&["info", "--json", "area.hop"]);
    assert_code(&info, 0);
    let json: serde_json::Value = serde_json::from_slice(&info.stdout).expect("valid JSON");
    assert_eq!(json["voxels"], serde_json::json!([40, 40]));
    assert_eq!(json["spacing_m"], 10.0);
    assert_code(&site.run(&["info", "area.hop"]), 0);
    assert_code(&site.run(&["verify", "--progress", "none", "area.hop"]), 0);

    // Wherever a byte is wrong, verify notices: as a file that is no database, or as a problem in it.
    let sound = fs::read(site.path("area.hop")).unwrap();
    for place in [sound.len() / 3, sound.len() / 2, sound.len() - 5] {
        let mut damaged = sound.clone();
        damaged[place] ^= 0x10;
        fs::write(site.path("damaged.hop"), &damaged).unwrap();
        let output = site.run(&["verify", "--progress", "none", "damaged.hop"]);
        assert!(matches!(output.status.code(), Some(3 | 6)), "byte {place}: {}", stderr(&output));
    }
}

#[test]
fn frames_do_not_depend_on_workers_or_on_the_subset() {
    let site = Site::built();
    assert_code(&site.render(&["-j", "1", "-o", "one/####.png"]), 0);
    assert_code(&site.render(&["-j", "2", "-o", "two/%04d.png"]), 0);
    let (one, two) = (frames_in(&site.path("one")), frames_in(&site.path("two")));
    assert_eq!(one.len(), 21, "2 s at 10 frames per second, both ends");
    assert!(one == two, "one and two workers differ");

    for (frames, workers, expected) in
        [("3,7-11:2", "2", &[3, 7, 9, 11][..]), ("21", "1", &[21]), ("20-21,1-4:3", "3", &[1, 4, 20, 21])]
    {
        let pattern = format!("some-{workers}/####.png");
        assert_code(&site.render(&["--frames", frames, "-j", workers, "-o", &pattern]), 0);
        let some = frames_in(&site.path(&format!("some-{workers}")));
        let names: Vec<String> = some.iter().map(|(name, _)| name.clone()).collect();
        let expected: Vec<String> = expected.iter().map(|number| format!("{number:04}.png")).collect();
        assert_eq!(names, expected);
        assert!(some.iter().all(|frame| one.contains(frame)), "{frames} differ from the whole");
    }

    for sidecar in ["manifest.json", "poses.csv"] {
        assert!(site.path("some-1").join(sidecar).exists(), "{sidecar}");
    }
}

#[test]
fn progress_as_json_is_json() {
    let site = Site::new(40);
    let output = site.build(&["--progress", "json"]);
    assert_code(&output, 0);
    let text = stderr(&output);
    let events: Vec<serde_json::Value> =
        text.lines().map(|line| serde_json::from_str(line).expect("every line is an object")).collect();
    let count = |name: &str| events.iter().filter(|event| event["event"] == name).count();
    assert!(count("begin") > 0 && count("begin") == count("end"), "{text}");
    let ends: Vec<_> = events.iter().filter(|event| event["event"] == "end").collect();
    assert!(ends.iter().all(|event| event["done"] == event["total"]), "{text}");
}

#[test]
fn outputs_never_take_the_place_of_inputs() {
    let site = Site::built();
    let path = fs::read(site.path("path.csv")).unwrap();
    fs::create_dir(site.path("f")).unwrap();
    fs::write(site.path("f/poses.csv"), &path).unwrap();
    let flown =
        site.run(&["render", "area.hop", "--path", "f/poses.csv", "--size", "9x9", "-o", "f/####.png"]);
    let timed = site.run(&["bench", "area.hop", "--path", "path.csv", "--svg", "./area.hop"]);
    for output in [flown, timed] {
        assert_code(&output, 2);
        assert!(complaint(&output).contains("is an input"));
    }
    assert_eq!(fs::read(site.path("f/poses.csv")).unwrap(), path);
    assert!(!site.path("f/0001.png").exists());
}

#[test]
fn skip_existing_repairs_what_is_not_whole() {
    let site = Site::built();
    assert_code(&site.render(&["-o", "f/####.png"]), 0);
    let sound = frames_in(&site.path("f"));
    fs::write(site.path("f/0004.png"), &sound[3].1[..sound[3].1.len() / 2]).unwrap();
    fs::remove_file(site.path("f/0009.png")).unwrap();
    let untouched = fs::metadata(site.path("f/0001.png")).unwrap().modified().unwrap();
    let output = site.render(&["-o", "f/####.png", "--skip-existing"]);
    assert_code(&output, 0);
    assert!(frames_in(&site.path("f")) == sound, "the repaired frames differ");
    assert_eq!(fs::metadata(site.path("f/0001.png")).unwrap().modified().unwrap(), untouched);
    assert!(stdout(&output).contains("2 frames"), "{}", stdout(&output));
}

#[test]
fn a_single_picture_keeps_its_name_and_can_be_repeated() {
    let site = Site::built();
    let args = ["render", "area.hop", "--eye", "800,300,400", "--ypr", "-10,-20,0", "--size", "64x36", "-o"];
    assert_code(&site.run(&[&args[..], &["view.png"]].concat()), 0);
    assert_code(&site.run(&[&args[..], &["again.png"]].concat()), 0);
    assert_eq!(fs::read(site.path("view.png")).unwrap(), fs::read(site.path("again.png")).unwrap());
    assert_code(&site.run(&[&args[..], &["view.exr"]].concat()), 0);
}

#[test]
fn a_camera_outside_the_area_is_told_the_extents() {
    let site = Site::built();
    let output = site.run(&["render", "area.hop", "--eye", "-50,300,400", "-o", "view.png"]);
    assert_code(&output, 2);
    assert!(stderr(&output).contains("x 0.0 to 1600.0"), "{}", stderr(&output));
    assert!(!site.path("view.png").exists());
}

#[test]
fn an_endless_area_has_no_outside_and_frames_say_so() {
    let site = Site::built();
    let view =
        ["render", "area.hop", "--size", "64x36", "--alt-mode", "agl", "--ypr", "0,-5,0", "--tile-world"];

    // 3 copies to the west and 2 to the north: the same picture.
    for (eye, name) in [("300,500,60", "here/####.png"), ("-4500,3700,60", "there/####.png")] {
        let output = site.run(&[&view[..], &["--eye", eye, "-o", name]].concat());
        assert_code(&output, 0);
        assert!(stderr(&output).contains("160 x 160 voxels are no multiple of 64"), "{}", stderr(&output));
    }

    let picture = |folder: &str| {
        let (_, bytes) = frames_in(&site.path(folder)).remove(0);
        bytes[bytes.windows(4).position(|chunk| chunk == b"IDAT").expect("pixels")..].to_vec()
    };
    assert!(picture("here") == picture("there"));

    let settings = |curvature: &str| {
        let flags = format!("--frames 1 --tile-world --overwrite --curvature {curvature} -o frames/####.png");
        assert_code(&site.render(&flags.split(' ').collect::<Vec<_>>()), 0);
        let text = fs::read(site.path("frames").join("manifest.json")).expect("a manifest");
        serde_json::from_slice::<serde_json::Value>(&text).expect("JSON")["settings"].clone()
    };
    let radius = settings("on")["effective_earth_radius_m"].as_f64().expect("a radius");
    assert!((radius - 7_432_844.0).abs() < 1.0, "{radius}");
    let settings = settings("auto");
    assert_eq!(settings["tile_world"], true);
    assert!(settings["effective_earth_radius_m"].is_null(), "local metres are flat: {settings}");
}

#[test]
fn a_picture_from_nowhere_is_told_both_ways_to_say_where() {
    let site = Site::built();
    let output = site.run(&["render", "area.hop", "-o", "view.png"]);
    assert_code(&output, 2);
    assert!(stderr(&output).contains("--path <FILE>|--eye <X,Y,Z>"), "{}", stderr(&output));
}

#[test]
fn bench_finds_identical_frames_and_writes_its_figures() {
    let site = Site::built();
    let flags = "bench area.hop --path path.csv --workers 2,1 --size 64x36 --repeats 1 --frames 1,5 --json b.json \
                 --svg b.svg --trace t.json --task-size 16,4 --dump-ranges ranges --progress none";
    let output = site.run(&flags.split_whitespace().collect::<Vec<_>>());
    assert_code(&output, 0);
    assert!(stdout(&output).contains("identical frames"), "{}", stdout(&output));
    let json: serde_json::Value = serde_json::from_slice(&fs::read(site.path("b.json")).unwrap()).unwrap();
    assert_eq!(json["results"][0]["workers"], 1);
    assert_eq!(json["identical_frames"], true);
    assert!(stdout(&output).contains("cores, planes on "), "{}", stdout(&output));
    assert_eq!((&json["engine"], json["simd"].is_string()), (&"planes".into(), true));
    assert_eq!(json["frames_by_reference"], 0);
    assert_eq!([1, 2], [0, 1].map(|run| json["results"][run]["in_flight"].as_u64().unwrap()));
    let speed_up = json["prediction"]["speed_up"].as_array().unwrap();
    let workers: Vec<_> = speed_up.iter().map(|line| line["workers"].as_u64().unwrap()).collect();
    assert_eq!(workers, [1, 2, 4, 8, 16, 32, 64, 128, 256]);
    assert!(speed_up[1]["measured"].is_f64() && speed_up[1]["error_percent"].is_f64());
    assert!(speed_up[2]["predicted"].is_f64() && speed_up[2]["measured"].is_null());
    assert!(stdout(&output).contains("256 workers"), "{}", stdout(&output));
    let trace: serde_json::Value = serde_json::from_slice(&fs::read(site.path("t.json")).unwrap()).unwrap();
    let events = trace["traceEvents"].as_array().unwrap();

    // Two frames with one worker and two with two; 80 planes for 64 columns, and 36 rows, make 5 and 9 tasks.
    let tasks = |stage: &str| events.iter().filter(|event| event["args"]["stage"] == stage).count();
    assert_eq!((tasks("march"), tasks("image")), (2 * 2 * 5, 2 * 2 * 9));
    let svg = fs::read_to_string(site.path("b.svg")).unwrap();
    assert!(svg.contains("Mpixel/s") && svg.contains("ideal"));

    for (at, number) in [1, 5].into_iter().enumerate() {
        let frame = &json["results"][0]["fastest_passes"][at];
        assert_eq!(frame["frame"], number);
        assert!(frame["wall_ms"].as_f64().unwrap() > 0.0, "{frame}");
        let ranges = fs::read(site.path(&format!("ranges/range_{number}.f32"))).unwrap();
        let (values, rest) = ranges.as_chunks::<4>();
        assert_eq!((values.len(), rest.len()), (64 * 36, 0));
        assert!(values.iter().all(|&value| f32::from_le_bytes(value) > 0.0));
    }
}

#[cfg(unix)]
mod unix {
    use super::*;

    #[test]
    fn a_killed_build_leaves_nothing_that_opens() {
        let site = Site::new(700);
        let mut child =
            site.spawn(&["build", "--elevation", "dem.asc", "--local", "-o", "area.hop"], Stdio::null());

        // Killed at whatever it is doing; a build that was quicker than this is not killed at all.
        thread::sleep(Duration::from_millis(60));
        child.kill().unwrap();
        child.wait().unwrap();

        for entry in fs::read_dir(site.folder.path()).unwrap() {
            let path = entry.unwrap().path();
            if path.extension() != Some(OsStr::new("asc")) && path.file_name() != Some(OsStr::new("area.hop"))
            {
                assert_ne!(
                    run([OsStr::new("info"), path.as_os_str()]).status.code(),
                    Some(0),
                    "{path:?} opens"
                );
            }
        }

        assert_code(&site.build(&["--overwrite"]), 0);
    }

    #[test]
    fn a_full_disk_is_one_sentence() {
        let site = Site::built();
        let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
        let output = finish(site.spawn(&[&render_args()[..], &["-o", "-"]].concat(), full));
        assert_code(&output, 5);
        let message = complaint(&output);
        assert!(message.contains("standard output") && message.trim_end().lines().count() == 1, "{message}");
    }

    #[test]
    fn a_reader_that_leaves_ends_the_stream_quietly() {
        let site = Site::built();
        let mut child = site.spawn(&[&render_args()[..], &["--fps=100", "-o", "-"]].concat(), Stdio::piped());
        let mut head = [0; 9];
        child.stdout.take().unwrap().read_exact(&mut head).unwrap();
        assert_eq!(&head, b"YUV4MPEG2");
        let output = finish(child);
        assert_code(&output, 141);
        assert_eq!(complaint(&output), "");
    }

    fn signal(child: &Child, name: &str) {
        let status = Command::new("kill").args(["-s", name, &child.id().to_string()]).status();
        assert!(status.expect("kill runs").success());
    }

    #[test]
    fn ctrl_c_is_answered_while_a_frame_is_in_hand() {
        let large = ["--engine=reference", "-j1", "--size=3000x2000", "-o", "f/####.png"];
        let site = Site::built();
        let mut child = site.spawn(&[&render_args()[..], &large].concat(), Stdio::null());
        thread::sleep(Duration::from_secs(1));
        signal(&child, "INT");
        let mut said = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
        assert!(said.any(|line| line.contains("press Ctrl-C again")));
        assert!(child.try_wait().unwrap().is_none(), "the frame takes seconds");
        signal(&child, "INT");
        assert_code(&finish(child), 130);
    }

    #[test]
    fn ctrl_c_leaves_the_film_that_was_there() {
        let site = Site::built();
        fs::write(site.path("film.avi"), b"earlier film").unwrap();
        let args =
            [&render_args()[..], &["--fps", "2000", "--size", "320x180", "--video", "film.avi"]].concat();
        let child = site.spawn(&args, Stdio::null());
        let files = || fs::read_dir(site.path(".")).unwrap().flatten().map(|entry| entry.path());
        let is_begun = |file: PathBuf| {
            let name = file.to_string_lossy().into_owned();
            name.contains("film.avi.") && fs::metadata(file).is_ok_and(|file| file.len() > 50_000)
        };
        wait_until("a frame", || files().any(is_begun));
        signal(&child, "INT");
        let output = finish(child);
        assert_code(&output, 130);
        assert!(complaint(&output).contains("film.avi was not written"), "{}", stderr(&output));
        assert_eq!(fs::read(site.path("film.avi")).unwrap(), b"earlier film");
        assert!(!files().any(|file| file.to_string_lossy().contains(".part")));
    }

    #[test]
    fn ctrl_c_leaves_whole_frames() {
        let site = Site::built();
        let args = [&render_args()[..], &["--fps", "2000", "--size", "320x180", "-o", "f/####.png"]].concat();
        let child = site.spawn(&args, Stdio::null());
        wait_until("a frame", || site.path("f/0002.png").exists());
        signal(&child, "INT");
        let output = finish(child);
        assert_code(&output, 130);
        assert!(stderr(&output).contains("interrupted"), "{}", stderr(&output));
        let frames = frames_in(&site.path("f"));
        assert!(frames.len() >= 2 && frames.len() < 4000, "{}", frames.len());
        for (name, bytes) in &frames {
            image::load_from_memory(bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
        }
        let poses = fs::read_to_string(site.path("f/poses.csv")).expect("poses of what exists");
        assert!(poses.lines().filter(|line| !line.starts_with('#')).count() > frames.len());
        assert!(site.path("f/manifest.json").exists());
    }
}
