//! `hedgehop verify`: is a database whole?

use std::path::PathBuf;

use hedgehop::voxel::verify;
use serde_json::json;

use crate::exit::{self, Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::progress::{Mode, Reporter};

const EXAMPLE: &str = "\
Examples:
  hedgehop verify area.hop && echo sound
  hedgehop verify --json area.hop";

/// Check a database from end to end.
///
/// Reads every page, compares checksums, heights of all levels and the content hash, and lists each problem.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct Args {
    /// Database to check
    #[arg(value_name = "AREA.hop")]
    file: PathBuf,

    /// Print one JSON object
    #[arg(long)]
    json: bool,

    /// How progress is told on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

/// Runs the command.
pub fn run(args: &Args, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    todo!()
}
