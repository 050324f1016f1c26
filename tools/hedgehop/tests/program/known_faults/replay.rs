//! The program, run on a copy of a fault's inputs.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use image::RgbImage;
use serde_json::Value;
use tempfile::TempDir;

/// Inputs of one fault, in a folder that may be written into.
pub struct Replay {
    here: TempDir,
    from: PathBuf,
}

impl Replay {
    /// Copies the files of a folder.
    pub fn of(folder: &Path) -> Self {
        let here = TempDir::new().expect("a temporary folder");
        for entry in fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
            let from = entry.expect("an entry").path();
            let name = from.file_name().expect("a name");
            let bytes = fs::read(&from).expect("a file that can be read");
            fs::write(here.path().join(name), bytes).expect("a copy");
        }
        Self { here, from: folder.to_owned() }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.here.path().join(name)
    }

    /// Copies a file of another fault, too.
    pub fn borrow(&self, fault: &str, name: &str) {
        let from = self.from.with_file_name(fault).join(name);
        fs::copy(&from, self.path(name)).unwrap_or_else(|error| panic!("{}: {error}", from.display()));
    }

    /// The program with arguments between blanks, and further ones that may hold blanks; to be started.
    pub fn command(&self, line: &str, further: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hedgehop"));
        command
            .current_dir(self.here.path())
            .args(line.split_whitespace())
            .args(further)
            .stdin(Stdio::null());
        command
    }

    #[track_caller]
    fn ended(&self, line: &str, further: &[&str], code: i32) -> String {
        let output = self.command(line, further).output().expect("the program starts");
        let told = told(&output);
        assert_eq!(output.status.code(), Some(code), "{line} {further:?}: {told}");
        told
    }

    /// All that it says, once it has ended well.
    #[track_caller]
    pub fn done(&self, line: &str) -> String {
        self.ended(line, &[], 0)
    }

    /// The same with arguments that hold blanks.
    #[track_caller]
    pub fn done_with(&self, line: &str, further: &[&str]) -> String {
        self.ended(line, further, 0)
    }

    /// Asserts that it ends with a code and one sentence, which has all words.
    #[track_caller]
    pub fn refused(&self, line: &str, code: i32, words: &[&str]) {
        let told = self.ended(line, &[], code);
        let sentence = told.lines().find(|line| line.starts_with("error: ")).unwrap_or("");
        for word in words {
            assert!(sentence.contains(word), "{line}: no {word:?} in: {told}");
        }
    }

    /// Builds a database, and returns what `info --json` tells of it.
    #[track_caller]
    pub fn built(&self, line: &str) -> Value {
        self.done(&format!("build {line} -o built.hop --overwrite"));
        self.info("built.hop")
    }

    #[track_caller]
    pub fn info(&self, area: &str) -> Value {
        serde_json::from_str(&self.done(&format!("info --json {area}"))).expect("JSON")
    }

    /// Asserts heights at places of `built.hop`, within a tolerance in metres.
    #[track_caller]
    pub fn heights(&self, places: &str, expected: &[f64], within: f64) {
        let told = self.done(&format!("height built.hop --json {places}"));
        let places: Vec<Value> = serde_json::from_str(&told).expect("JSON");
        let found: Vec<f64> =
            places.iter().map(|place| place["height_m"].as_f64().unwrap_or(f64::NAN)).collect();
        let are_alike = found.len() == expected.len()
            && found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= within);
        assert!(are_alike, "{found:?}, but should be {expected:?}");
    }

    /// The finest picture of the colours of `built.hop`.
    #[track_caller]
    pub fn colours(&self) -> RgbImage {
        self.done("hillshade built.hop --colour --level 1 -o colours.png");
        self.picture("colours.png")
    }

    #[track_caller]
    pub fn picture(&self, name: &str) -> RgbImage {
        image::open(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}")).to_rgb8()
    }
}

/// Both streams of a run.
pub fn told(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    text(&output.stdout) + &text(&output.stderr)
}

/// Asserts the lowest and the highest surface, metres.
#[track_caller]
pub fn assert_range(info: &Value, expected: [f64; 2], within: f64) {
    let found = [0, 1].map(|end| info["height_range_m"][end].as_f64().expect("a height"));
    let are_alike = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= within);
    assert!(are_alike, "{found:?}, but should be {expected:?}: {}", info["metadata"]);
}
