//! `hedgehop bake`: shadows of one sun into a database's colours.

use std::path::{Path, PathBuf};

use crate::database::{CacheArgs, DatabaseName};
use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;
use crate::making::Making;
use crate::program::program;
use crate::progress::Reporter;
use crate::{area, args};
use hedgehop::sunlight::SunSetting;
use hedgehop::voxel::PageSource;
use hedgehop_modeling::{Baking, bake_shadows};

const EXAMPLE: &str = "\
Examples:
  hedgehop bake area.hop --sun 250,12 -o evening.hop
  hedgehop bake area.hop --sun 2026-06-21T17:30Z -o evening.hop";

/// Put the shadows of one sun into a database's colours.
///
/// The ground's shadows on itself are computed once, and flights need not compute them any more. The new database is rendered under that sun
/// unless --sun says otherwise.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct BakeArgs {
    /// Database to take
    #[arg(value_name = "AREA.hop")]
    area: DatabaseName,

    /// Sun's azimuth clockwise from grid north and elevation above the horizon, degrees, or the time: 2026-06-21T09:30Z
    #[arg(long, value_name = "AZ,EL|TIME", value_parser = args::sun, allow_hyphen_values = true)]
    sun: SunSetting,

    /// Database to write
    #[arg(short, long, value_name = "SHADED.hop")]
    output: PathBuf,

    #[command(flatten)]
    cache: CacheArgs,

    #[command(flatten)]
    making: Making,
}

/// Runs the command.
pub fn run(args: &BakeArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.making.progress, interrupt);
    if let (Ok(area), Ok(output)) = (args.area.canonicalize(), args.output.canonicalize())
        && area == output
    {
        let what = format!("{} is the database to take; name another file with -o", args.output.display());
        return Err(hedgehop::Error::Configuration(what).into());
    }
    if args.output == Path::new("-") {
        let what = "a database cannot go to standard output; name a file with -o, like SHADED.hop";
        return Err(hedgehop::Error::Configuration(what.into()).into());
    }

    let file = args.cache.open(&args.area)?;
    let sun = area::sky(args.sun, file.header())?.sun;
    let baking = Baking {
        source: &file,
        directory: file.directory(),
        sun,
        output: &args.output,
        overwrite: args.making.overwrite,
        steps: false,
        threads: args.making.workers.count(),
    };

    let baked = bake_shadows(&baking, &reporter)?;
    let text = format!(
        "baked {}: {:.1} MB, shadows of a sun {:.1}° from grid north, {:.1}° high\nNext:\n  {} render {} --path TRACK -o frames/####.png\n",
        args.output.display(),
        baked.bytes as f64 / 1e6,
        sun.azimuth,
        sun.elevation,
        program(),
        args.output.display()
    );

    Ok(exit::print(&text)?)
}
