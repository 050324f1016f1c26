//! Schedulers that hand out the chunks of a job, each by its own commands.

mod hyperqueue;
pub mod local;
mod openjd;
mod parallel;
pub mod process;
mod scripts;
mod slurm;
mod submission;

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::job::FarmJob;

pub use submission::{Submission, cancel, has_open_tasks};

/// Program that hands out chunks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Scheduler {
    /// Processes on this machine, which this command starts and waits for
    Local,
    /// GNU parallel, here or over ssh
    Parallel,
    /// HyperQueue, an array of tasks
    Hyperqueue,
    /// Slurm, a job array
    Slurm,
    /// Open Job Description, a template for farms that take one
    Openjd,
}

impl Scheduler {
    /// Name as users write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Local => "local",
            Self::Parallel => "parallel",
            Self::Hyperqueue => "hyperqueue",
            Self::Slurm => "slurm",
            Self::Openjd => "openjd",
        }
    }

    /// Program that takes tasks, if it is another one.
    pub fn command(self) -> Option<&'static str> {
        match self {
            Self::Local => None,
            Self::Parallel => Some("parallel"),
            Self::Hyperqueue => Some("hq"),
            Self::Slurm => Some("sbatch"),
            Self::Openjd => Some("openjd"),
        }
    }
}

/// Command of a scheduler.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Call {
    /// Prints the name of what was submitted, and ends at once.
    Submit(Vec<String>),
    /// Ends when the work is done.
    Wait(Vec<String>),
}

impl Call {
    fn words(&self) -> &[String] {
        match self {
            Self::Submit(words) | Self::Wait(words) => words,
        }
    }
}

/// Chunks that are handed out, and how.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tasks {
    /// Numbers of the chunks.
    pub chunks: Vec<u64>,
    /// Cores of a task.
    pub cores: usize,
    /// Tasks at the same time, if there is a bound.
    pub at_once: Option<usize>,
    /// Further tries of a task that failed.
    pub retries: u32,
    /// Memory of a task, bytes, where schedulers ask for it.
    pub memory: Option<u64>,
    /// Further flags of the scheduler's command, such as a partition.
    pub pass: Vec<String>,
    /// Program that workers start.
    pub program: PathBuf,
}

impl Tasks {
    /// Returns the memory that a scheduler is asked for, bytes: a quarter more than frames are to get along with, which is no hard limit.
    fn memory_asked(&self) -> Option<u64> {
        self.memory.map(|bytes| bytes.saturating_add(bytes / 4))
    }

    /// Returns the command of a worker but for its chunk, which is run in the job's folder of flags.
    pub fn worker(&self, job: &FarmJob) -> Vec<String> {
        let mut command = vec![self.program.display().to_string(), "render".to_owned()];
        command.extend(job.worker_flags());
        command.extend(["--jobs".to_owned(), self.cores.to_string()]);
        command.extend(["--progress".to_owned(), "plain".to_owned()]);
        command.push(format!("--farm={}", job.place.display()));
        command
    }
}
