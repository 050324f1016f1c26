//! Handing out of chunks: flags that `submit` and `retry` share, and what becomes of them.

use std::path::{Path, PathBuf};

use crate::args::{self, available_cores};
use crate::commands::farm::finish;
use crate::exit::{self, Outcome};
use crate::farm::job::FarmJob;
use crate::farm::scheduler::{Scheduler, Submission, Tasks, local};
use crate::farm::shell::named;
use crate::farm::submissions::SubmissionRecord;
use crate::progress::Reporter;
use hedgehop::progress::Observer;
use hedgehop::{Error, Result};

/// Further tries of a chunk unless the user says how many.
const RETRIES: u32 = 2;

/// Flags of how chunks are handed out.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Scheduler")]
pub struct HandOutArgs {
    /// Tasks at the same time [default: local and parallel: as many as the machine has cores for; others: no bound]
    #[arg(long, value_name = "N", value_parser = args::workers)]
    at_once: Option<usize>,

    /// Cores of a task, and its worker threads [default: --jobs of render, else 1]
    #[arg(long, value_name = "N", value_parser = args::workers)]
    cores: Option<usize>,

    /// Further tries of a chunk whose process failed; of another database, program or setting than the job's there are none [default: 2]
    #[arg(long, value_name = "N")]
    retries: Option<u32>,

    /// Further flag of the scheduler's command, as --pass=--partition=night; may be repeated
    #[arg(long, value_name = "FLAG", allow_hyphen_values = true)]
    pass: Vec<String>,

    /// Program that workers start [default: this one]
    #[arg(long, value_name = "HEDGEHOP")]
    program: Option<PathBuf>,
}

impl HandOutArgs {
    /// Returns the cores of a task; `asked` are the worker threads that the flags of `render` ask for.
    pub fn cores(&self, asked: Option<usize>) -> usize {
        self.cores.or(asked).unwrap_or(1)
    }

    /// Returns how many tasks run at the same time, as far as that is known here.
    pub fn processes(&self, engine: Scheduler, cores: usize) -> usize {
        self.at_once.unwrap_or_else(|| match engine {
            Scheduler::Local | Scheduler::Parallel => processes(cores),
            Scheduler::Hyperqueue | Scheduler::Slurm | Scheduler::Openjd => 1,
        })
    }

    /// Returns the chunks with how they are handed out.
    pub fn tasks(&self, chunks: Vec<u64>, cores: usize, memory: Option<u64>) -> Result<Tasks> {
        let own = || {
            std::env::current_exe()
                .map_err(|error| Error::io("hedgehop", "find the program's own file", error))
        };
        let program = match &self.program {
            // Workers are started elsewhere.
            Some(program) if program.components().count() > 1 => args::absolute(program)?,
            Some(program) => program.clone(),
            None => own()?,
        };
        Ok(Tasks {
            chunks,
            cores,
            at_once: self.at_once,
            retries: self.retries.unwrap_or(RETRIES),
            memory,
            pass: self.pass.clone(),
            program,
        })
    }

    /// Returns chunks that are handed out as others were before, as far as no flag says otherwise.
    pub fn tasks_after(&self, before: Tasks, chunks: Vec<u64>) -> Tasks {
        Tasks {
            chunks,
            cores: self.cores.unwrap_or(before.cores),
            at_once: self.at_once.or(before.at_once),
            retries: self.retries.unwrap_or(before.retries),
            memory: before.memory,
            pass: if self.pass.is_empty() { before.pass } else { self.pass.clone() },
            program: self.program.clone().unwrap_or(before.program),
        }
    }
}

/// Refuses a scheduler whose command is not there.
///
/// # Errors
/// The command is on no path.
pub fn check_engine(engine: Scheduler) -> Result<()> {
    match engine.command() {
        Some(command) if !is_on_path(command) => Err(Error::Configuration(format!(
            "--engine {} needs the program {command}, which is not on the PATH; --prepare writes the job and prints its commands for where it is",
            engine.name()
        ))),
        _ => Ok(()),
    }
}

/// Tasks of so many cores that this machine runs at once.
fn processes(cores: usize) -> usize {
    (available_cores() / cores).max(1)
}

fn is_on_path(command: &str) -> bool {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&folders).any(|folder| folder.join(command).is_file())
}

/// Fate of what would be handed out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Handing {
    /// Printed; nothing is written.
    Printed,
    /// Written and printed.
    Written,
    /// Written and run.
    Run,
}

/// Hands out chunks, or prints how that would be done.
pub fn hand_out(
    engine: Scheduler,
    tasks: Tasks,
    job: &FarmJob,
    place: &Path,
    handing: Handing,
    reporter: &Reporter,
) -> Outcome {
    let at_once = tasks.at_once.unwrap_or_else(|| processes(tasks.cores));
    let limit = if handing == Handing::Run { Submission::limit(engine)? } else { None };
    let submission = Submission::new(engine, &tasks, job, at_once, limit);
    if handing == Handing::Printed {
        return Ok(exit::print(&submission.text())?);
    }

    // What is killed meanwhile goes on with the same.
    submission.write()?;
    let count = tasks.chunks.len();
    let record = SubmissionRecord { engine, tasks, ids: Vec::new() };
    let number = record.write(place)?;
    if handing == Handing::Written {
        return Ok(exit::print(&submission.text())?);
    }

    if engine == Scheduler::Local {
        for chunk in local::run(&record.tasks, job, place, at_once, reporter)? {
            let log = local::log(place, chunk.number);
            reporter.note(&format!("chunk {}: {}; see {}", chunk.number, chunk.what, log.display()));
        }
        return finish::finish(job, place, reporter);
    }

    let keep =
        |ids: &[String]| SubmissionRecord { ids: ids.to_vec(), ..record.clone() }.replace(place, number);
    let ids = submission.run(&keep, reporter).inspect_err(|_| {
        reporter.note(&format!("the job stays; hedgehop farm retry {} hands it out again", named(place)));
    })?;
    match engine {
        // These end when the work is done.
        Scheduler::Parallel | Scheduler::Openjd | Scheduler::Local => finish::finish(job, place, reporter),
        Scheduler::Hyperqueue | Scheduler::Slurm => Ok(exit::print(&format!(
            "submitted {count} chunks as {}; hedgehop farm status {} tells how far they are\n",
            ids.join(", "),
            named(place)
        ))?),
    }
}
