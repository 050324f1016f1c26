//! `hedgehop farm`: a flight on many machines, by the scheduler that a site has.

mod cancel;
pub mod cost_samples;
mod finish;
mod handing_out;
mod request;
mod retry;
mod standing;
mod status;
mod submit;

pub use finish::{list, work_off};
pub use request::of_job;
pub use standing::standing;

use clap::Subcommand;

use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;

const EXAMPLE: &str = "\
Examples:
  hedgehop farm submit --engine local -- area.hop --path track.gpx -o frames/####.png --video film.mp4
  hedgehop farm submit --engine slurm --dry-run night.toml
  hedgehop farm status frames.job
  hedgehop farm retry frames.job
  hedgehop farm cancel frames.job";

/// Render a flight on many machines, by the scheduler that a site has.
///
/// Frames are cut into chunks of equal predicted cost; a task of the scheduler renders a chunk by an ordinary `render`, which keeps frames that are there. Who
/// dies takes nothing along: what is missing is done again.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct FarmArgs {
    #[command(subcommand)]
    command: FarmCommand,
}

#[derive(Debug, Subcommand)]
enum FarmCommand {
    Submit(submit::SubmitArgs),
    Status(status::StatusArgs),
    Retry(retry::RetryArgs),
    Cancel(cancel::CancelArgs),
    Finish(finish::FinishJobArgs),
}

/// Runs the command.
pub fn run(args: &FarmArgs, interrupt: &Interrupt) -> Outcome {
    match &args.command {
        FarmCommand::Submit(args) => submit::run(args, interrupt),
        FarmCommand::Status(args) => status::run(args),
        FarmCommand::Retry(args) => retry::run(args, interrupt),
        FarmCommand::Cancel(args) => cancel::run(args),
        FarmCommand::Finish(args) => finish::run(args, interrupt),
    }
}
