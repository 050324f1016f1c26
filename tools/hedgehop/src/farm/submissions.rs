//! Records of what was handed out of a job, so that it can be handed out again alike, or stopped.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::job;
use super::scheduler::{Scheduler, Tasks};
use hedgehop::encode::atomic::{write_bytes, write_new_bytes};
use hedgehop::{Error, Result};

/// Record of a submission.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SubmissionRecord {
    /// Scheduler that has the tasks.
    pub engine: Scheduler,
    /// Tasks that it has.
    pub tasks: Tasks,
    /// Names that it gave them; none of one that ends when they do.
    pub ids: Vec<String>,
}

impl SubmissionRecord {
    /// Writes the record into the folder of a job; returns its number.
    pub fn write(&self, place: &Path) -> Result<usize> {
        let number = files(place)?.iter().filter_map(|path| number(path)).max().unwrap_or(0) + 1;
        let path = file(place, number);
        write_new_bytes(&path, &self.text(&path)?).map(|()| number)
    }

    /// Writes the record in the place of an earlier one.
    pub fn replace(&self, place: &Path, number: usize) -> Result<()> {
        let path = file(place, number);
        write_bytes(&path, &self.text(&path)?)
    }

    fn text(&self, path: &Path) -> Result<Vec<u8>> {
        serde_json::to_vec_pretty(self).map_err(|error| Error::io(path, "write it", error.into()))
    }

    /// Reads the records of a job, the oldest first.
    pub fn all(place: &Path) -> Result<Vec<Self>> {
        let read = |path: PathBuf| {
            let bytes = fs::read(&path).map_err(|error| Error::io(&path, "read it", error))?;
            let wrong =
                |what: String| Error::invalid(&path, format!("no record of a submission: {what}; remove it"));
            let record: Self = serde_json::from_slice(&bytes).map_err(|error| wrong(error.to_string()))?;
            let Tasks { cores, at_once, .. } = &record.tasks;
            if *cores == 0 || *at_once == Some(0) {
                return Err(wrong("tasks of no cores, or none at once".into()));
            }
            Ok(record)
        };
        files(place)?.into_iter().map(read).collect()
    }
}

/// Number of a record, by its file's name.
fn number(path: &Path) -> Option<usize> {
    path.file_stem()?.to_str()?.parse().ok()
}

fn file(place: &Path, number: usize) -> PathBuf {
    job::submissions(place).join(format!("{number:04}.json"))
}

fn files(place: &Path) -> Result<Vec<PathBuf>> {
    let folder = job::submissions(place);
    let refused = |error| Error::io(&folder, "list it", error);
    let mut files = Vec::new();
    for entry in fs::read_dir(&folder).map_err(refused)? {
        let path = entry.map_err(refused)?.path();
        if path.extension().is_some_and(|kind| kind == "json") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}
