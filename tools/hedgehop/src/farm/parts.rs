//! Records of finished frames, written as they come, so that a worker which dies loses only frames in flight.
//!
//! ```text
//! parts/0007.RANDOM.jsonl     one for each try of chunk 7, of lines:
//!   {"frame":{…}}             a frame is whole under its name; a later line of the same frame is the more complete one
//!   {"end":{"failure":…}}     the try is over
//! ```

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use super::job;
use hedgehop::encode::sidecar::FrameRecord;
use hedgehop::{Error, Result};

/// Line of a file of records.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum PartLine {
    Frame(Box<FrameRecord>),
    End(PartEnd),
}

/// End of a try.
#[derive(Debug, Default, Serialize, Deserialize)]
struct PartEnd {
    /// Sentence of what ended it early.
    failure: Option<String>,
    /// Whether somebody asked it to stop.
    #[serde(default)]
    is_stopped: bool,
}

/// File of records that a worker writes.
#[derive(Debug)]
pub struct PartLog {
    path: PathBuf,
    file: Mutex<File>,
}

impl PartLog {
    /// Begins a file of records for a try of chunk `number`.
    pub fn begin(job: &Path, number: u64) -> Result<Self> {
        let folder = job::parts(job);
        let made = tempfile::Builder::new()
            .prefix(&format!("{}.", stem(number)))
            .suffix(".jsonl")
            .disable_cleanup(true)
            .tempfile_in(&folder)
            .map_err(|error| Error::io(&folder, "begin a file of records in it", error))?;
        let (file, path) = made.into_parts();
        Ok(Self { path: path.to_path_buf(), file: Mutex::new(file) })
    }

    /// Adds a frame that is whole under its name.
    pub fn append(&self, record: FrameRecord) -> Result<()> {
        self.write(&PartLine::Frame(Box::new(record)))
    }

    /// Says that the try is over.
    pub fn end(&self, failure: Option<&Error>) -> Result<()> {
        let is_stopped = matches!(failure, Some(Error::Interrupted(_)));
        self.write(&PartLine::End(PartEnd { failure: failure.map(ToString::to_string), is_stopped }))
    }

    fn write(&self, line: &PartLine) -> Result<()> {
        let refused = |error| Error::io(&self.path, "write it", error);
        let mut text = serde_json::to_vec(line).map_err(|error| refused(error.into()))?;
        text.push(b'\n');
        self.file.lock().unwrap_or_else(PoisonError::into_inner).write_all(&text).map_err(refused)
    }
}

/// State of a chunk, as its files tell it.
#[derive(Debug, Default)]
pub struct ChunkState {
    /// Records of its frames that are finished, by number.
    pub records: BTreeMap<u64, FrameRecord>,
    /// Tries so far.
    pub tries: usize,
    /// Tries whose end nobody told: they run, or were killed.
    pub open: usize,
    /// Sentence of the failure that ended the last try that came to an end.
    pub failure: Option<String>,
    /// Whether somebody asked that try to stop.
    pub is_stopped: bool,
    /// Time of the last record.
    pub touched: Option<SystemTime>,
}

impl ChunkState {
    /// Reads the files of chunk `number`.
    pub fn read(job: &Path, number: u64) -> Result<Self> {
        let mut state = Self::default();
        for (_, path) in files(job)?.into_iter().filter(|(of, _)| *of == number) {
            state.add(&path)?;
        }
        Ok(state)
    }

    /// Reads the files of all `count` chunks.
    pub fn read_all(job: &Path, count: usize) -> Result<Vec<Self>> {
        let mut states: Vec<Self> = Vec::new();
        states.resize_with(count, Self::default);
        for (number, path) in files(job)? {
            let index = usize::try_from(number).ok().and_then(|number| number.checked_sub(1));
            if let Some(state) = index.and_then(|index| states.get_mut(index)) {
                state.add(&path)?;
            }
        }
        Ok(states)
    }

    /// Adds what one try tells. A line that was cut short tells nothing.
    fn add(&mut self, path: &Path) -> Result<()> {
        let bytes = fs::read(path).map_err(|error| Error::io(path, "read it", error))?;
        let mut is_open = true;
        for line in bytes.split(|byte| *byte == b'\n') {
            match serde_json::from_slice(line) {
                Ok(PartLine::Frame(record)) if is_name(record.file.as_deref()) => {
                    self.records.insert(record.frame, *record);
                }
                Ok(PartLine::End(PartEnd { failure, is_stopped })) => {
                    is_open = false;
                    (self.failure, self.is_stopped) = (failure, is_stopped);
                }
                Ok(PartLine::Frame(_)) | Err(_) => {}
            }
        }

        self.tries += 1;
        self.open += usize::from(is_open);
        self.touched = self.touched.max(fs::metadata(path).and_then(|found| found.modified()).ok());
        Ok(())
    }
}

/// Whether a file holds the bytes that a record tells of.
pub fn holds(record: &FrameRecord, file: &Path) -> bool {
    let Some(blake3) = &record.blake3 else { return false };
    fs::read(file).is_ok_and(|bytes| blake3::hash(&bytes).to_hex().as_str() == blake3)
}

/// Whether a record names a file in the folder of the frames, and none elsewhere.
fn is_name(file: Option<&str>) -> bool {
    let mut parts = Path::new(file.unwrap_or_default()).components();
    matches!((parts.next(), parts.next()), (Some(Component::Normal(_)), None))
}

/// Lists files of records with the numbers of their chunks, the oldest first.
fn files(job: &Path) -> Result<Vec<(u64, PathBuf)>> {
    let folder = job::parts(job);
    let refused = |error| Error::io(&folder, "list it", error);
    let mut found = Vec::new();
    for entry in fs::read_dir(&folder).map_err(refused)? {
        let entry = entry.map_err(refused)?;
        let name = entry.file_name();
        let number = name
            .to_str()
            .filter(|name| name.ends_with(".jsonl"))
            .and_then(|name| name.split('.').next()?.parse().ok());
        let Some(number) = number else { continue };
        let changed = entry.metadata().and_then(|found| found.modified()).ok();
        if entry.file_type().is_ok_and(|kind| kind.is_file()) {
            found.push((number, changed, entry.path()));
        }
    }
    found.sort();
    Ok(found.into_iter().map(|(number, _, path)| (number, path)).collect())
}

/// Name of a chunk's files before the first point.
fn stem(number: u64) -> String {
    format!("{number:04}")
}
