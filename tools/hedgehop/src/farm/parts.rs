//! Records of finished frames, written as they come, so that a worker which dies loses only frames in flight.
//!
//! ```text
//! parts/0007.RANDOM.jsonl     one for each try of chunk 7, of lines:
//!   {"frame":{…}}             a frame is whole under its name; a later line of the same frame is the more complete one
//!   {"end":{"failure":…}}     the try is over
//! parts/0007.lock             held by whoever works on it, where the file system has locks
//! ```

use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use super::job;
use hedgehop::encode::sidecar::FrameRecord;
use hedgehop::progress::Observer;
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
    pub fn end(&self, failure: Option<String>) -> Result<()> {
        self.write(&PartLine::End(PartEnd { failure }))
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
                Ok(PartLine::Frame(record)) => {
                    self.records.insert(record.frame, *record);
                }
                Ok(PartLine::End(PartEnd { failure })) => {
                    is_open = false;
                    self.failure = failure;
                }
                Err(_) => {}
            }
        }

        self.tries += 1;
        self.open += usize::from(is_open);
        self.touched = self.touched.max(fs::metadata(path).and_then(|found| found.modified()).ok());
        Ok(())
    }
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
        found.push((number, changed, entry.path()));
    }
    found.sort();
    Ok(found.into_iter().map(|(number, _, path)| (number, path)).collect())
}

/// Name of a chunk's files before the first point.
pub fn stem(number: u64) -> String {
    format!("{number:04}")
}

/// Waits until nobody else works on a chunk, and keeps others from it until what it returns is dropped. `None` where the file system has no
/// locks: two workers may then do the same, and write the same bytes.
pub fn lock(job: &Path, number: u64, observer: &dyn Observer) -> Result<Option<File>> {
    let path = job::parts(job).join(format!("{}.lock", stem(number)));
    let file = File::options().create(true).truncate(false).write(true).open(&path);
    let file = file.map_err(|error| Error::io(&path, "open it", error))?;
    match file.try_lock() {
        Ok(()) => return Ok(Some(file)),
        Err(TryLockError::Error(_)) => return Ok(None),
        Err(TryLockError::WouldBlock) => {}
    }

    observer.note(&format!("another worker is at chunk {number}; waiting for what it leaves"));
    loop {
        std::thread::sleep(std::time::Duration::from_millis(200));
        if observer.cancelled() {
            return Err(Error::Interrupted(format!("chunk {number} is left to the worker that is at it")));
        }
        match file.try_lock() {
            Ok(()) => return Ok(Some(file)),
            Err(TryLockError::Error(_)) => return Ok(None),
            Err(TryLockError::WouldBlock) => {}
        }
    }
}

/// Whether somebody works on a chunk now, as far as the file system has locks that say so.
pub fn is_locked(job: &Path, number: u64) -> bool {
    let path = job::parts(job).join(format!("{}.lock", stem(number)));
    let Ok(file) = File::options().write(true).open(path) else { return false };
    matches!(file.try_lock(), Err(TryLockError::WouldBlock))
}
