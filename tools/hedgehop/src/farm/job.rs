//! Job of a farm: a folder that says what is to be made, of what, and in which chunks.
//!
//! ```text
//! FRAMES.job/job.json        flags, what frames are made of, chunks; written once
//!            parts/          records of finished frames, a file for each try of a chunk
//!            logs/           standard error of the workers
//!            submissions/    what the scheduler said of each submission
//! ```

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::cost::CostModel;
use crate::farm::shell::named;
use crate::output::WRITER;
use hedgehop::encode::FrameSet;
use hedgehop::encode::atomic::write_new_bytes;
use hedgehop::encode::sidecar::Manifest;
use hedgehop::{Error, Result};

/// Version of the layout of a job's folder.
pub const LAYOUT: u32 = 1;
const FILE: &str = "job.json";
/// Frames that a chunk has at most.
const MOST_FRAMES: usize = 10_000_000;

/// Job of a farm, as its file says it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FarmJob {
    /// [`LAYOUT`].
    pub layout: u32,
    /// Program that renders.
    pub program: ProgramRecord,
    /// Folder that relative names in the flags count from.
    pub folder: PathBuf,
    /// Folder of the job itself, as seen from there.
    pub place: PathBuf,
    /// Flags of `render`, as the user gave them.
    pub flags: Vec<String>,
    /// Instruction set that all workers use; `None`: the reference marcher, whose bits need none.
    pub simd: Option<String>,
    /// Folder that the frames go to.
    pub frames_folder: PathBuf,
    /// Contact sheet to be made in the end, if one is.
    pub contact_sheet: Option<PathBuf>,
    /// Pages that a worker checks before its first frame.
    pub check: PageCheck,
    /// Manifest of the frames, without any.
    pub made_of: Manifest,
    /// Cores of a process whose times were predicted.
    pub cores: usize,
    /// Model that the chunks were cut by.
    pub cost: CostModel,
    /// Chunks; the first has number 1.
    pub chunks: Vec<FarmChunk>,
}

/// Identity of a program.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProgramRecord {
    /// Name and version.
    pub version: String,
    /// BLAKE3 of the executable file, hexadecimal.
    pub blake3: String,
}

/// Frames that one worker renders in one go.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FarmChunk {
    /// Numbers as `--frames` takes them.
    pub frames: String,
    /// Count of them.
    pub count: u64,
    /// Predicted time of a process, seconds.
    pub predicted_s: f64,
}

/// Pages of the database that a worker checks before its first frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum PageCheck {
    /// All pages
    Whole,
    /// Pages that the worker's frames may touch
    Planned,
}

impl ProgramRecord {
    /// Returns the identity of this program.
    pub fn own() -> Result<Self> {
        let path = std::env::current_exe()
            .map_err(|error| Error::io("hedgehop", "find the program's own file", error))?;
        let bytes =
            fs::read(&path).map_err(|error| Error::io(&path, "read the program's own file", error))?;
        Ok(Self { version: WRITER.to_owned(), blake3: blake3::hash(&bytes).to_hex().to_string() })
    }
}

impl FarmChunk {
    /// Returns the frames.
    pub fn set(&self) -> Result<FrameSet> {
        FrameSet::parse(&self.frames)
    }
}

impl FarmJob {
    /// Reads the job in `folder`.
    ///
    /// # Errors
    /// There is none, or another version's.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(FILE);
        let bytes = fs::read(&path).map_err(|error| {
            Error::io(&path, "read it; name the folder that `farm submit` made, such as frames.job", error)
        })?;
        let job: Self = serde_json::from_slice(&bytes).map_err(|error| {
            Error::invalid(&path, format!("no job of a farm: {error}; submit it again with another --job"))
        })?;
        if job.layout != LAYOUT {
            let what = format!("it has layout {}, and this program reads {LAYOUT}", job.layout);
            return Err(Error::unsupported(&path, what, "use the program that submitted it"));
        }
        for chunk in &job.chunks {
            let frames = chunk.set().map_err(|error| Error::invalid(&path, error.to_string()))?;
            let most = usize::try_from(chunk.count).ok().filter(|count| *count <= MOST_FRAMES);
            if most.is_none_or(|count| frames.iter().take(count + 1).count() != count) {
                let what =
                    format!("chunk {} does not hold {} frames; submit it again", chunk.frames, chunk.count);
                return Err(Error::invalid(&path, what));
            }
        }

        // Workers and scripts go by the place that the job was made in.
        let real = |place: &Path| place.canonicalize().ok();
        let own = real(&job.folder.join(&job.place));
        if own.is_none() || own != real(folder) {
            return Err(Error::Configuration(format!(
                "{} is a job that was submitted as {} in {}; move it back, or submit it anew",
                folder.display(),
                job.place.display(),
                job.folder.display()
            )));
        }
        Ok(job)
    }

    /// Refuses a folder that holds a job already.
    pub fn check_free(folder: &Path) -> Result<()> {
        if folder.join(FILE).exists() {
            return Err(Error::Configuration(format!(
                "{} holds a job already; go on with it by `hedgehop farm retry {}`, remove it, or give another --job",
                folder.display(),
                named(folder)
            )));
        }
        Ok(())
    }

    /// Makes the folder of a job, which must not hold one.
    ///
    /// # Errors
    /// There is a job already; it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        Self::check_free(folder)?;
        for name in [PARTS, LOGS, SUBMISSIONS] {
            let place = folder.join(name);
            fs::create_dir_all(&place).map_err(|error| Error::io(&place, "create the folder", error))?;
        }

        let path = folder.join(FILE);
        let mut text = serde_json::to_vec_pretty(self)
            .map_err(|error| Error::invalid(&path, format!("the job is no JSON: {error}")))?;
        text.push(b'\n');
        write_new_bytes(&path, &text).map_err(|error| match error {
            // Another submission was a moment earlier.
            Error::Configuration(_) => Self::check_free(folder).err().unwrap_or(error),
            other => other,
        })
    }

    /// Returns a chunk by its number, 1…
    ///
    /// # Errors
    /// There is none of that number.
    pub fn chunk(&self, number: u64, folder: &Path) -> Result<&FarmChunk> {
        let index = usize::try_from(number).ok().and_then(|number| number.checked_sub(1));
        index.and_then(|index| self.chunks.get(index)).ok_or_else(|| {
            Error::Configuration(format!(
                "{} has chunks 1 to {}, and none of number {number}",
                folder.display(),
                self.chunks.len()
            ))
        })
    }

    /// Returns the folder of the frames, wherever this process was started.
    pub fn frames(&self) -> PathBuf {
        self.folder.join(&self.frames_folder)
    }

    /// Returns the flags that every worker gets: the user's, the pinned instruction set, and that frames which are there stay.
    pub fn worker_flags(&self) -> Vec<String> {
        let mut flags = self.flags.clone();
        if let Some(simd) = &self.simd {
            flags.extend(["--simd".to_owned(), simd.clone()]);
        }
        flags.push("--skip-existing".to_owned());
        flags
    }
}

const PARTS: &str = "parts";
const LOGS: &str = "logs";
const SUBMISSIONS: &str = "submissions";

/// Returns the folder of the records of a job's frames.
pub fn parts(job: &Path) -> PathBuf {
    job.join(PARTS)
}

/// Returns the folder of what workers say.
pub fn logs(job: &Path) -> PathBuf {
    job.join(LOGS)
}

/// Returns the folder of what schedulers said of submissions.
pub fn submissions(job: &Path) -> PathBuf {
    job.join(SUBMISSIONS)
}
