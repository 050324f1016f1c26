//! `hedgehop farm cancel`: stops what is handed out of a job.

use std::path::PathBuf;

use super::request;
use super::standing::{standing, unfinished};
use crate::exit::{self, Outcome};
use crate::farm::chunk_lock::worker_here;
use crate::farm::job::FarmJob;
use crate::farm::scheduler::{cancel, process};
use crate::farm::submissions::SubmissionRecord;
use hedgehop::Error;

/// Stop the tasks of a job; frames that are finished stay.
#[derive(Debug, clap::Args)]
pub struct CancelArgs {
    /// Folder of the job
    #[arg(value_name = "FRAMES.job")]
    job: PathBuf,
}

/// Runs the command.
pub fn run(args: &CancelArgs) -> Outcome {
    let job = FarmJob::read(&args.job)?;
    let states = standing(&job, &request::of_job(&job)?, &args.job)?;
    let mut open = Vec::new();
    for ((number, state), chunk) in (1..).zip(&states).zip(&job.chunks) {
        if !unfinished(&job, chunk, state)?.is_empty() {
            open.push(number);
        }
    }

    let mut stopped = Vec::new();
    if process::cancel(&args.job)? {
        stopped.push("the processes on this machine".to_owned());
    } else if !open.is_empty() {
        for record in SubmissionRecord::all(&args.job)? {
            stopped.extend(cancel(record.engine, &record.ids)?);
        }
        // Workers whose scheduler is gone.
        for worker in open.iter().filter_map(|number| worker_here(&args.job, *number)) {
            process::stop(worker)?;
            stopped.push(format!("process {worker}"));
        }
    }

    let place = args.job.display();
    if stopped.is_empty() {
        return Err(Error::Configuration(format!(
            "nothing of {place} is known to run; schedulers that this program did not start are stopped by their own commands"
        ))
        .into());
    }
    Ok(exit::print(&format!(
        "{place}: asked {} to stop, which end after the frames in hand; farm retry goes on with it\n",
        stopped.join(", ")
    ))?)
}
