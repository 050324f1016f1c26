//! A folder with a small database and a flight, and what jobs there have made.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use tempfile::TempDir;

use crate::common::ends;

/// Name of a folder that shells, patterns and templates would take for more than a name.
pub const HOSTILE: &str = r#"it's a $HOME %A %d {} {{x}} {1} `id` "q""#;
/// A flight of 21 small frames.
pub const FLIGHT: &[&str] = &["area.hop", "--path", "path.csv", "--fps", "5", "--size", "160x90", "--level"];
/// The same flight in 81 frames that take longer, so that there is time to kill a process.
pub const LONG: &[&str] = &["area.hop", "--path", "path.csv", "--fps", "20", "--size", "480x270", "--level"];
/// Longest wait for anything.
const PATIENCE: Duration = Duration::from_secs(60);

/// Files of a folder of frames by name: pictures and poses as they are, the manifest without what frames cost.
#[derive(PartialEq, Eq)]
pub struct Frames(BTreeMap<String, Vec<u8>>);

/// A folder that jobs are submitted in.
pub struct Site {
    _around: TempDir,
    pub folder: PathBuf,
}

impl Site {
    /// Makes the folder `name` in one of its own.
    pub fn new(name: &str) -> Self {
        static AREA: OnceLock<Vec<u8>> = OnceLock::new();
        let around = TempDir::new().expect("a temporary folder");
        let folder = around.path().join(name);
        fs::create_dir(&folder).expect("the folder is made");
        let path = "t_s,x_m,y_m,alt_agl_m\n0,300,400,60\n2,900,900,60\n4,1500,1400,60\n";
        fs::write(folder.join("path.csv"), path).expect("the path is written");
        fs::write(folder.join("area.hop"), AREA.get_or_init(area)).expect("the database is written");
        Self { _around: around, folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    pub fn command(&self, program: impl AsRef<OsStr>) -> Command {
        let mut command = Command::new(program);
        command.current_dir(&self.folder).stdin(Stdio::null());
        command
    }

    pub fn run(&self, args: &[&str]) -> Output {
        self.command(env!("CARGO_BIN_EXE_hedgehop")).args(args).output().expect("the program starts")
    }

    /// Starts it; nobody reads what it says.
    pub fn start(&self, args: &[&str]) -> Child {
        let mut command = self.command(env!("CARGO_BIN_EXE_hedgehop"));
        command.args(args).stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().expect("the program starts")
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.path(name)).expect("it is there")).expect("it is JSON")
    }

    /// Status of a job.
    pub fn status(&self, job: &str) -> Value {
        let output = self.run(&["farm", "status", "--json", job]);
        ends(&output, 0);
        serde_json::from_slice(&output.stdout).expect("it is JSON")
    }

    /// Stages of a job's chunks.
    pub fn stages(&self, job: &str) -> Vec<String> {
        let chunks = self.status(job)["chunks"].as_array().expect("chunks").clone();
        chunks.iter().map(|chunk| chunk["stage"].as_str().expect("a stage").to_owned()).collect()
    }

    /// Whether a job has given the frames that one process gives, in files of that pattern.
    #[track_caller]
    pub fn assert_frames(&self, pattern: &str, flight: &[&str]) {
        let (folder, name) = pattern.rsplit_once('/').expect("a folder");
        let alone = TempDir::new().expect("a temporary folder");
        let output = alone.path().join(name).display().to_string();
        ends(&self.run(&[&["render"], flight, &["-o", &output]].concat()), 0);
        Frames::of(&self.path(folder)).assert_same(&Frames::of(alone.path()));
    }

    /// Frames of each try of a job's chunks: the chunk's number, and those that the try has told of.
    pub fn tries(&self, job: &str) -> Vec<(u64, Vec<u64>)> {
        let mut tries = Vec::new();
        for entry in fs::read_dir(self.path(job).join("parts")).expect("records").flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let Some((chunk, _)) = name.split_once('.').filter(|_| name.ends_with(".jsonl")) else {
                continue;
            };
            let text = fs::read_to_string(entry.path()).expect("records");
            let lines = text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
            let mut frames: Vec<u64> = lines.filter_map(|line| line["frame"]["frame"].as_u64()).collect();
            frames.sort_unstable();
            frames.dedup();
            tries.push((chunk.parse().expect("a number"), frames));
        }
        tries.sort();
        tries
    }

    /// Frames that a chunk has told of.
    pub fn told(&self, job: &str, chunk: u64) -> usize {
        self.tries(job).into_iter().filter(|(of, _)| *of == chunk).map(|(_, frames)| frames.len()).sum()
    }

    /// Whether each of so many frames was rendered by one try and no other.
    #[track_caller]
    pub fn assert_once(&self, job: &str, count: u64) {
        let mut frames: Vec<u64> = self.tries(job).into_iter().flat_map(|(_, frames)| frames).collect();
        frames.sort_unstable();
        assert_eq!(frames, (1..=count).collect::<Vec<_>>(), "{:?}", self.tries(job));
    }

    /// Workers of this folder's jobs that are alive: process and chunk.
    pub fn workers(&self) -> Vec<(u32, u64)> {
        let folder = fs::canonicalize(&self.folder).expect("the folder");
        let mut workers = Vec::new();
        for entry in fs::read_dir("/proc").expect("processes").flatten() {
            let Ok(process) = entry.file_name().to_string_lossy().parse() else { continue };
            if fs::read_link(entry.path().join("cwd")).ok().as_ref() != Some(&folder) {
                continue;
            }
            let words = fs::read_to_string(entry.path().join("cmdline")).unwrap_or_default();
            let words: Vec<&str> = words.split('\0').collect();
            let chunk = words.iter().position(|word| *word == "--chunk").filter(|_| words[1] == "render");
            if let Some(at) = chunk {
                workers.push((process, words[at + 1].parse().expect("a number")));
            }
        }
        workers
    }
}

/// A test that fails leaves no worker behind.
impl Drop for Site {
    fn drop(&mut self) {
        for (process, _) in self.workers() {
            signal(process, Signal::KILL);
        }
    }
}

/// Sends a signal to a process, which may have ended.
pub fn signal(process: u32, signal: Signal) {
    let process = Pid::from_raw(process.try_into().expect("a number")).expect("a process");
    let _ = kill_process(process, signal);
}

impl Frames {
    /// Reads a folder; hidden files are no frames.
    pub fn of(folder: &Path) -> Self {
        let mut files = BTreeMap::new();
        for entry in fs::read_dir(folder).expect("the folder").flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.starts_with('.') {
                continue;
            }
            let mut bytes = fs::read(entry.path()).expect("a file");
            if name == "manifest.json" {
                bytes = without_costs(&bytes);
            }
            files.insert(name, bytes);
        }
        Self(files)
    }

    /// Whether they are those, file by file.
    #[track_caller]
    pub fn assert_same(&self, expected: &Self) {
        assert!(expected.0.contains_key("manifest.json") && expected.0.contains_key("poses.csv"));
        let names = |frames: &Self| frames.0.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(self), names(expected));
        for (name, bytes) in &self.0 {
            assert!(*bytes == expected.0[name], "{name} differs");
        }
    }
}

fn without_costs(manifest: &[u8]) -> Vec<u8> {
    let mut manifest: Value = serde_json::from_slice(manifest).expect("it is JSON");
    for frame in manifest["frames"].as_array_mut().expect("frames") {
        assert!(frame.as_object_mut().expect("a frame").remove("cost").is_some(), "{frame}");
    }
    format!("{manifest:#}").into_bytes()
}

/// Returns the bytes of a database of 2.4 km of hills with posts 6 m apart.
fn area() -> Vec<u8> {
    let folder = TempDir::new().expect("a temporary folder");
    let side = 400;
    let mut grid = format!("ncols {side}\nnrows {side}\nxllcorner 0\nyllcorner 0\ncellsize 6\n");
    for row in 0..side {
        let height = |column: i32| {
            100.0 + 40.0 * (f64::from(column) * 0.04).sin() + 30.0 * (f64::from(row) * 0.06).cos()
        };
        let heights: Vec<String> = (0..side).map(|column| format!("{:.2}", height(column))).collect();
        grid += &heights.join(" ");
        grid.push('\n');
    }
    fs::write(folder.path().join("dem.asc"), grid).expect("the grid is written");
    let build = "build --elevation dem.asc --local -o area.hop";
    ends(&crate::common::run(&folder, build), 0);
    fs::read(folder.path().join("area.hop")).expect("the database is there")
}

/// Flags of `farm submit` with those of a flight behind them.
pub fn submission<'a>(flags: &[&'a str], flight: &[&'a str], output: &'a str) -> Vec<&'a str> {
    [&["farm", "submit"], flags, &["--progress", "none", "--"], flight, &["-o", output]].concat()
}

/// Calls `found` until it finds something.
pub fn wait_for<T>(what: &str, mut found: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(found) = found() {
            return found;
        }
        assert!(begun.elapsed() < PATIENCE, "no {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}
