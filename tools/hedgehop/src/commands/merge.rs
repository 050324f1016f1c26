//! `hedgehop merge`: several databases as one.

use std::path::{Path, PathBuf};

use crate::args::{self, check_no_input};
use crate::database::{CacheArgs, DatabaseName};
use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;
use crate::making::Making;
use crate::progress::Reporter;
use crate::reference;
use hedgehop::{Error, Result};
use hedgehop_modeling::{MergeInput, Merger, OutputFile};

const EXAMPLE: &str = "\
Examples:
  hedgehop merge west.hop east.hop -o whole.hop
  hedgehop merge fine.hop around.hop --feather 200 -o whole.hop";

/// Put several databases together.
///
/// They have one spacing and one reference system, and their voxels lie on each other. Where they overlap, earlier ones lie in front.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct MergeArgs {
    /// Databases, highest priority first
    #[arg(value_name = "AREA.hop", required = true, num_args = 2..)]
    areas: Vec<DatabaseName>,

    /// Width over which an earlier database is blended into a later one that it overlaps, metres
    #[arg(long, value_name = "METRES", value_parser = args::not_negative, default_value = "0", allow_negative_numbers = true)]
    feather: f64,

    /// Database to write
    #[arg(short, long, value_name = "WHOLE.hop")]
    output: PathBuf,

    #[command(flatten)]
    cache: CacheArgs,

    #[command(flatten)]
    making: Making,
}

/// Lists the databases that arguments name; those of this machine may be patterns.
fn named(areas: &[DatabaseName]) -> Result<Vec<DatabaseName>> {
    let mut found = Vec::new();
    for area in areas {
        if area.is_remote() {
            found.push(area.clone());
        } else {
            let files = args::input_files("merge", &[area.to_path_buf()], &["hop"])?;
            found.extend(files.into_iter().map(DatabaseName::from));
        }
    }
    Ok(found)
}

/// Runs the command.
pub fn run(args: &MergeArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.making.progress, interrupt);
    let areas = named(&args.areas)?;
    let inputs: Vec<&Path> = areas.iter().map(|area| &**area).collect();
    check_no_input("-o", &args.output, &inputs)?;
    if args.output == Path::new("-") {
        let what = "a database cannot go to standard output; name a file with -o, like WHOLE.hop";
        return Err(Error::Configuration(what.into()).into());
    }

    let files = areas.iter().map(|area| args.cache.open(area)).collect::<Result<Vec<_>>>()?;
    let names: Vec<String> = inputs.iter().map(|path| path.display().to_string()).collect();
    let databases: Vec<MergeInput<'_>> =
        files.iter().zip(&names).map(|(source, name)| MergeInput { source, name }).collect();
    let merger = Merger::new(&databases, args.feather)?;
    let output = OutputFile { path: &args.output, overwrite: args.making.overwrite };
    let merged = merger.write(output, args.making.workers.count(), &reporter)?;
    let grid = merger.grid();
    let size = (grid.far_corner() - grid.origin) / 1000.0;
    let join = &merged.join;

    let seam = if join.pairs == 0 {
        "the databases do not touch".to_owned()
    } else {
        format!(
            "along the join ({} voxels) the largest step is {:.2} m, at x {:.1} y {:.1}; the mean is {:.2} m",
            join.pairs,
            join.largest,
            join.place.x,
            join.place.y,
            join.mean()
        )
    };

    let text = format!(
        "merged {}: {:.1} MB, {:.2} x {:.2} km, {} x {} voxels of {} m\n{seam}\n",
        args.output.display(),
        merged.bytes as f64 / 1e6,
        size.x,
        size.y,
        grid.nx,
        grid.ny,
        reference::metres(grid.spacing)
    );

    Ok(exit::print(&text)?)
}
