//! Flags of commands that make a database.

use clap::Args;

use crate::args::Workers;
use crate::progress::Mode;

/// Flags of commands that make a database: workers, replacement, progress.
#[derive(Debug, Clone, Args)]
pub struct Making {
    #[command(flatten)]
    pub workers: Workers,

    /// Replace the database if it exists
    #[arg(long)]
    pub overwrite: bool,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    pub progress: Mode,
}
