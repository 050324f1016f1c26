//! `hedgehop continuity`: is the terrain of a database sound?

use std::path::{Path, PathBuf};

use crate::commands::contours::relief;
use crate::database::{CacheArgs, DatabaseName};
use crate::exit::{self, Failure, Outcome};
use crate::faults::{self, FaultKind};
use crate::interrupt::Interrupt;
use crate::places::Places;
use crate::progress::{Mode, Reporter};
use crate::{args, chart, maps, pictures};
use hedgehop::encode::atomic::{check_writable, write_bytes};
use hedgehop::voxel::PageSource;
use hedgehop::{Error, Result};
use hedgehop_query::{ContinuityLimits, MapExtent, continuity};

const EXAMPLE: &str = "\
Examples:
  hedgehop continuity area.hop -o faults.csv --picture faults.png
  hedgehop continuity area.hop --fail-on spikes,pits,seams && echo sound";

/// Look for what is wrong with the terrain of a database.
///
/// Spikes, pits, seams, flat tops, terraces, voids and cracks of the finest level, on the ground under what stands on it. The exit code is 6 if something was found.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct ContinuityArgs {
    /// Database to look at
    #[arg(value_name = "AREA.hop")]
    area: DatabaseName,

    /// Table of all that was found
    #[arg(short, long, value_name = "FAULTS.csv")]
    output: Option<PathBuf>,

    /// Map with marks where something was found
    #[arg(long, value_name = "MAP.png")]
    picture: Option<PathBuf>,

    /// Longer side of the map, pixels
    #[arg(long, value_name = "PIXELS", default_value = "2000", value_parser = clap::value_parser!(u32).range(64..=8192))]
    size: u32,

    /// Faults that make the exit code 6, with commas between [default: all]
    #[arg(long, value_enum, value_name = "KINDS", value_delimiter = ',')]
    fail_on: Option<Vec<FaultKind>>,

    /// Ratio to the roughness around it by which a spike or pit stands out
    #[arg(long, value_name = "FACTOR", value_parser = factor, default_value = "5", allow_negative_numbers = true)]
    spike_factor: f64,

    /// Ratio of a seam's steps to those beside it
    #[arg(long, value_name = "FACTOR", value_parser = factor, default_value = "3", allow_negative_numbers = true)]
    seam_factor: f64,

    #[command(flatten)]
    cache: CacheArgs,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

fn factor(text: &str) -> std::result::Result<f64, String> {
    args::number(text).ok().filter(|value| *value > 1.0).ok_or_else(|| "want a number above 1".into())
}

/// Runs the command.
pub fn run(args: &ContinuityArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    check_outputs(args)?;
    let source = args.cache.open(&args.area)?;
    let limits = ContinuityLimits { spike: args.spike_factor, seam: args.seam_factor };
    let report = continuity(&source, &limits, &reporter)?;
    let places = Places::new(&source, false)?;
    if let Some(path) = &args.output {
        write_bytes(path, faults::table(&report, &places).as_bytes())?;
    }

    if let Some(path) = &args.picture {
        let header = source.header();
        let whole = MapExtent::of_level(&header.grid, 0, maps::WHOLE)?;
        let longer = f64::from(whole.width.max(whole.height)) * whole.pixel;
        let extent = MapExtent::of_pixels(&header.grid, longer / f64::from(args.size), maps::WHOLE)?;
        let unit = (f64::from(extent.width.max(extent.height)) / 1600.0).max(0.75);
        let mut picture = relief(&source, extent, &reporter)?;
        faults::mark(&mut picture, &extent, &report, unit);
        chart::scale(&mut picture, 1.0 / extent.pixel, "", unit);
        write_bytes(path, &pictures::png(&picture, path)?)?;
        maps::write_beside(path, &extent, header, &reporter)?;
    }

    source.intact()?;
    exit::print(&faults::summary(&report, &places))?;
    let kinds = args.fail_on.as_deref().unwrap_or(&FaultKind::ALL);

    if kinds.iter().any(|kind| report.count(kind.fault()) > 0) { Err(Failure::Problems) } else { Ok(()) }
}

fn check_outputs(args: &ContinuityArgs) -> Result<()> {
    let input: &[&Path] = &[&*args.area];
    if let Some(path) = &args.output {
        if !maps::is(path, "csv") {
            let named = path.with_extension("csv");
            return Err(Error::Configuration(format!("the table is a CSV; name it -o {}", named.display())));
        }
        args::check_no_input("-o", path, input)?;
        check_writable(path)?;
    }

    if let Some(path) = &args.picture {
        if !maps::is(path, "png") {
            let named = path.with_extension("png");
            return Err(Error::Configuration(format!(
                "the map is a PNG; name it --picture {}",
                named.display()
            )));
        }
        maps::check_output(path, input)?;
    }

    Ok(())
}
