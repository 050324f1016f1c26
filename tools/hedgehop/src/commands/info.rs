//! `hedgehop info`: what a database is.

use std::path::PathBuf;

use hedgehop::memory::PageFile;
use hedgehop::voxel::PageSource;

use crate::area;
use crate::exit::{self, Outcome};

const EXAMPLE: &str = "\
Examples:
  hedgehop info area.hop
  hedgehop info --json area.hop";

/// Say what a database covers, where it comes from and what was assumed.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct Args {
    /// Database to look at
    #[arg(value_name = "AREA.hop")]
    file: PathBuf,

    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let source = PageFile::open(&args.file)?;
    let header = source.header();
    let text = if args.json {
        format!("{:#}\n", area::json(header, source.directory())?)
    } else {
        let (what, stored) = (area::description(header)?, area::stored(header, source.directory()));
        format!("{}: hedgehop database\n{what}{stored}", args.file.display())
    };
    Ok(exit::print(&text)?)
}
