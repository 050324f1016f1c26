//! `hedgehop info`: what a database is.

use std::path::PathBuf;

use hedgehop::memory::PageFile;
use hedgehop::query::tally;
use hedgehop::voxel::PageSource;

use crate::area;
use crate::args;
use crate::classes;
use crate::exit::{self, Outcome};

const EXAMPLE: &str = "\
Examples:
  hedgehop info area.hop
  hedgehop info --json area.hop
  hedgehop info --classes --bbox 500000,5000000,501000,5001000 area.hop";

/// Say what a database covers, where it comes from and what was assumed.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct Args {
    /// Database to look at
    #[arg(value_name = "AREA.hop")]
    file: PathBuf,

    /// Say what the ground is made of: area by material, by what stands there, by elevation source and by level, and how often each object is placed; reads all pages
    #[arg(long)]
    classes: bool,

    /// Say that of a part of the area, metres of the database's reference system
    #[arg(long, value_name = "W,S,E,N", value_parser = args::bounding_box, allow_hyphen_values = true)]
    bbox: Option<[f64; 4]>,

    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let source = PageFile::open(&args.file)?;
    let header = source.header();
    let asked = args.classes || args.bbox.is_some();
    let tally = asked.then(|| tally(&source, args.bbox)).transpose()?;
    let text = if args.json {
        let mut json = area::json(header, source.directory())?;
        if let Some(tally) = &tally {
            json["classes"] = classes::json(header, tally, args.bbox);
        }
        format!("{json:#}\n")
    } else {
        let (what, stored) = (area::description(header)?, area::stored(header, source.directory()));
        let classes = tally.map(|tally| classes::description(header, &tally)).unwrap_or_default();
        format!("{}: hedgehop database\n{what}{stored}{classes}", args.file.display())
    };
    Ok(exit::print(&text)?)
}
