//! `hedgehop farm cancel`: stops what is handed out of a job.

use std::path::PathBuf;

use crate::exit::{self, Outcome};
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
    FarmJob::read(&args.job)?;
    let mut stopped = Vec::new();
    if process::cancel(&args.job)? {
        stopped.push("the processes on this machine".to_owned());
    }
    for record in SubmissionRecord::all(&args.job)? {
        stopped.extend(cancel(record.engine, &record.ids)?);
    }

    let place = args.job.display();
    if stopped.is_empty() {
        return Err(Error::Configuration(format!(
            "nothing of {place} is known to run; schedulers that this program did not start are stopped by their own commands"
        ))
        .into());
    }
    Ok(exit::print(&format!("{place}: stopped {}; farm retry goes on with it\n", stopped.join(", ")))?)
}
