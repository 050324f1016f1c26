//! `hedgehop info`: what a database is.

use serde_json::json;

use crate::database::{CacheArgs, DatabaseName};
use crate::exit::{self, Outcome};
use crate::{area, args, classes};
use hedgehop::memory::PageFile;
use hedgehop::voxel::{Header, PageSource};
use hedgehop::{Error, Result};
use hedgehop_query::{MapExtent, Tally, tally};

const EXAMPLE: &str = "\
Examples:
  hedgehop info area.hop
  hedgehop info --json area.hop
  hedgehop info --classes --bbox 500000,5000000,501000,5001000 area.hop";

/// Say what a database covers, where it comes from and what was assumed.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct InfoArgs {
    /// Database to look at
    #[arg(value_name = "AREA.hop")]
    file: DatabaseName,

    /// Say what the ground is made of: area by material, by what stands there, by elevation source and by level, and how often each object is placed; reads all pages
    #[arg(long)]
    classes: bool,

    /// Say that of a part of the area, metres of the database's reference system; --classes need not be given
    #[arg(long, value_name = "W,S,E,N", value_parser = args::bounding_box, allow_hyphen_values = true)]
    bbox: Option<[f64; 4]>,

    #[command(flatten)]
    cache: CacheArgs,

    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &InfoArgs) -> Outcome {
    let source = args.cache.open(&args.file)?;
    let header = source.header();
    let found = match args.bbox {
        Some(bbox) => Some(part(&source, bbox)?),
        None => args.classes.then(|| tally(&source, None)).transpose()?,
    };

    let text = if args.json {
        let mut json = area::json(header, source.directory())?;
        if let Some(found) = &found {
            json["classes"] = classes::json(header, found, args.bbox);
            json["classes"]["heights_m"] = json!(found.heights);
        }
        format!("{json:#}\n")
    } else {
        let (what, stored) = (area::description(header)?, area::stored(header, source.directory()));
        let classes = found.map(|found| {
            let part = args.bbox.map(|bbox| title(header, &found, bbox)).unwrap_or_default();
            part + &classes::description(header, &found)
        });
        let classes = classes.unwrap_or_default();
        format!("{}: hedgehop database\n{what}{stored}{classes}", args.file.display())
    };

    Ok(exit::print(&text)?)
}

/// Counts what there is in a part of the area.
///
/// # Errors
/// It lies outside of it, or between the centres of its voxels; a page that is damaged.
fn part(source: &PageFile, bbox: [f64; 4]) -> Result<Tally> {
    MapExtent::of_level(&source.header().grid, 0, bbox)?;
    let found = tally(source, Some(bbox))?;
    if found.area + found.empty > 0.0 {
        return Ok(found);
    }
    let [west, south, east, north] = bbox;
    Err(Error::Configuration(format!(
        "no voxel that is stored there has its centre in the box {west},{south},{east},{north}; give a larger --bbox"
    )))
}

/// The row above what is told of a part.
fn title(header: &Header, found: &Tally, [west, south, east, north]: [f64; 4]) -> String {
    let heights = found.heights.map_or("without a surface".into(), |[low, high]| {
        format!("heights {low:.1} to {high:.1} m above {}", header.metadata.vertical_datum)
    });
    format!("  part      {west},{south},{east},{north}: {heights}, and in it\n")
}
