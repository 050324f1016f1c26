//! `hedgehop farm retry`: hands out again what is not finished.

use std::path::PathBuf;

use super::finish::finish;
use super::handing_out::{HandOutArgs, Handing, check_engine, hand_out};
use super::request;
use super::standing::{standing, unsound};
use crate::exit::Outcome;
use crate::farm::job::FarmJob;
use crate::farm::scheduler::{Scheduler, has_open_tasks};
use crate::farm::submissions::SubmissionRecord;
use crate::interrupt::Interrupt;
use crate::progress::{Mode, Reporter};
use hedgehop::Error;
use hedgehop::progress::Observer;

/// Hand out the chunks that are not finished once more, and no others.
///
/// Frames that are finished stay. A chunk that another worker is still at is waited for, not done twice.
#[derive(Debug, clap::Args)]
pub struct RetryArgs {
    /// Folder of the job
    #[arg(value_name = "FRAMES.job")]
    job: PathBuf,

    /// Scheduler that hands out the chunks [default: the one before]
    #[arg(long, value_enum, value_name = "ENGINE")]
    engine: Option<Scheduler>,

    #[command(flatten)]
    hand_out: HandOutArgs,

    /// Print what would be submitted, and write nothing
    #[arg(long)]
    dry_run: bool,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

/// Runs the command.
pub fn run(args: &RetryArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    let job = FarmJob::read(&args.job)?;
    let states = standing(&job, &request::of_job(&job)?, &args.job)?;
    let wrong = unsound(&job, &states, &reporter)?;
    let chunks: Vec<u64> =
        (1..).zip(&wrong).filter(|(_, frames)| !frames.is_empty()).map(|(number, _)| number).collect();
    if chunks.is_empty() {
        reporter.note("no frame is missing");
        if args.dry_run {
            return Ok(());
        }
        return finish(&job, &args.job, &reporter);
    }

    let last = SubmissionRecord::all(&args.job)?.pop();
    if let Some(last) = last.as_ref().filter(|last| has_open_tasks(last.engine, &last.ids)) {
        return Err(Error::Configuration(format!(
            "{} has tasks of {} that wait or run ({}); wait until they have ended, or stop them with farm cancel",
            args.job.display(),
            last.engine.name(),
            last.ids.join(", ")
        ))
        .into());
    }
    let before = last.as_ref().map(|last| last.engine);
    let engine = args.engine.or(before).unwrap_or(Scheduler::Local);
    let tasks = match last {
        Some(last) => args.hand_out.tasks_after(last.tasks, chunks),
        None => args.hand_out.tasks(chunks, args.hand_out.cores(None), None)?,
    };
    let handing = if args.dry_run { Handing::Printed } else { Handing::Run };
    if handing == Handing::Run {
        check_engine(engine)?;
    }
    hand_out(engine, tasks, &job, &args.job, handing, &reporter)
}
