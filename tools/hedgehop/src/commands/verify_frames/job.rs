//! Job of a farm that frames are of: what it expects of them, and how it renders them again.

use std::path::{Path, PathBuf};

use super::folder::ExpectedFrame;
use crate::args::absolute;
use crate::commands::farm;
use crate::farm::job::FarmJob;
use crate::progress::{Mode, Reporter};
use hedgehop::progress::Observer;
use hedgehop::{Error, Result};

/// A job, and where it lies.
#[derive(Debug)]
pub struct JobOfFrames {
    job: FarmJob,
    place: PathBuf,
}

impl JobOfFrames {
    /// Finds the job of a folder of frames: the one that is named, or the one beside the folder.
    ///
    /// # Errors
    /// The named one is none, or writes to another folder.
    pub fn find(folder: &Path, named: Option<&Path>) -> Result<Option<Self>> {
        let real = folder.canonicalize().map_err(|error| Error::io(folder, "find it", error))?;
        let beside = |folder: &Path| {
            let mut name = folder.as_os_str().to_owned();
            name.push(".job");
            PathBuf::from(name)
        };
        // The folder may be a link to where there is room.
        let near = [beside(&absolute(folder)?), beside(&real)].into_iter().find(|place| place.is_dir());
        let place = match named {
            Some(named) => Some(absolute(named)?),
            None => near,
        };
        let Some(place) = place else { return Ok(None) };

        let job = FarmJob::read(&place)?;
        let is_own = job.frames().canonicalize().is_ok_and(|frames| frames == real);
        if is_own {
            return Ok(Some(Self { job, place }));
        }
        Err(Error::Configuration(format!(
            "{} is a job whose frames go to {}, not to {}; name the right one with --job",
            place.display(),
            job.frames().display(),
            folder.display()
        )))
    }

    /// Returns all frames of the job, as their workers recorded them.
    pub fn expected(&self) -> Result<Vec<ExpectedFrame>> {
        let states = farm::standing(&self.job, &farm::of_job(&self.job)?, &self.place)?;
        let mut frames = Vec::new();
        for (chunk, state) in self.job.chunks.iter().zip(&states) {
            frames.extend(chunk.set()?.iter().map(|number| {
                let record = state.records.get(&number);
                ExpectedFrame {
                    number,
                    file: record.and_then(|record| record.file.clone()),
                    blake3: record.and_then(|record| record.blake3.clone()),
                }
            }));
        }
        frames.sort_by_key(|frame| frame.number);
        Ok(frames)
    }

    /// Renders frames of these numbers again, chunk by chunk, and lists all in the manifest if none is missing then.
    ///
    /// # Errors
    /// Another database, program or setting than the job's; whatever keeps a frame from being rendered.
    pub fn repair(&self, numbers: &[u64], reporter: &Reporter) -> Result<()> {
        if numbers.is_empty() {
            return Ok(());
        }
        let mut chunks = Vec::new();
        for (number, chunk) in (1..).zip(&self.job.chunks) {
            let frames = chunk.set()?;
            if numbers.iter().any(|wrong| frames.contains(*wrong)) {
                chunks.push(number);
            }
        }

        let silent = reporter.with_mode(Mode::Silent);
        reporter.begin("repair", chunks.len() as u64, "chunks");
        for number in chunks {
            farm::work_off(&self.job, &self.place, number, &silent)?;
            reporter.advance(1);
        }
        reporter.end();
        farm::list(&self.job, &self.place)
    }
}
