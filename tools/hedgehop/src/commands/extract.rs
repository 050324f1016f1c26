//! `hedgehop extract`: a part of a database as a database of its own.

use std::path::{Path, PathBuf};

use crate::args::{self, check_no_input};
use crate::database::{CacheArgs, DatabaseName};
use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;
use crate::making::Making;
use crate::progress::Reporter;
use crate::reference;
use hedgehop::geo::{Crs, Transform};
use hedgehop::progress::Observer;
use hedgehop::voxel::{Header, PageId, PageSource};
use hedgehop::{Error, Result};
use hedgehop_modeling::{ExtractPart, OutputFile, extract};

const EXAMPLE: &str = "\
Examples:
  hedgehop extract area.hop --bbox 447000,4466000,452000,4471000 -o part.hop
  hedgehop extract area.hop --lon-lat -105.6,40.3,-105.5,40.4 -o part.hop";

/// Points along each side of a box in degrees, whose sides bend in the database's reference system.
const SIDE_POINTS: u32 = 17;

/// Cut a part out of a database.
///
/// The part has the pages that the box touches, voxel for voxel as they are; coarser levels are made anew. So it grows to whole pages.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
#[command(group(clap::ArgGroup::new("box").required(true).args(["bbox", "lon_lat"])))]
pub struct ExtractArgs {
    /// Database to take
    #[arg(value_name = "AREA.hop")]
    area: DatabaseName,

    /// The part, metres of the database's reference system
    #[arg(long, value_name = "W,S,E,N", value_parser = args::bounding_box, allow_hyphen_values = true)]
    bbox: Option<[f64; 4]>,

    /// The part, longitude and latitude, degrees (WGS 84)
    #[arg(long, value_name = "W,S,E,N", value_parser = args::bounding_box, allow_hyphen_values = true)]
    lon_lat: Option<[f64; 4]>,

    /// Database to write
    #[arg(short, long, value_name = "PART.hop")]
    output: PathBuf,

    #[command(flatten)]
    cache: CacheArgs,

    #[command(flatten)]
    making: Making,
}

/// Runs the command.
pub fn run(args: &ExtractArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.making.progress, interrupt);
    check_no_input("-o", &args.output, &[&*args.area])?;
    if args.output == Path::new("-") {
        let what = "a database cannot go to standard output; name a file with -o, like PART.hop";
        return Err(Error::Configuration(what.into()).into());
    }

    let source = args.cache.open(&args.area)?;
    let header = source.header();
    let bounds = match (args.bbox, args.lon_lat) {
        (Some(bounds), _) => bounds,
        (None, Some(degrees)) => metres(degrees, header)?,
        (None, None) => return Err(Error::Configuration("give --bbox or --lon-lat".into()).into()),
    };
    let pages: Vec<PageId> = source.directory().present().map(|(id, _)| id).collect();
    let part = ExtractPart::around(&header.grid, &pages, bounds)?;
    let (near, far) = (part.grid.origin, part.grid.far_corner());
    reporter.note(&format!(
        "grown to whole pages: x {:.1} to {:.1}, y {:.1} to {:.1}, {} x {} voxels",
        near.x, far.x, near.y, far.y, part.grid.nx, part.grid.ny
    ));
    let output = OutputFile { path: &args.output, overwrite: args.making.overwrite };
    let (_, bytes) = extract(&source, &pages, &part, output, args.making.workers.count(), &reporter)?;
    let size = (far - near) / 1000.0;

    let text = format!(
        "extracted {}: {:.1} MB, {:.2} x {:.2} km\n",
        args.output.display(),
        bytes as f64 / 1e6,
        size.x,
        size.y
    );

    Ok(exit::print(&text)?)
}

/// A box in metres of the database's system around one in degrees.
fn metres([west, south, east, north]: [f64; 4], header: &Header) -> Result<[f64; 4]> {
    let crs = reference::crs(header)?;
    if crs.is_local() {
        let what = "--lon-lat: the database has no place on Earth; give --bbox in its metres";
        return Err(Error::Configuration(what.into()));
    }

    let transform = Transform::new(&Crs::wgs84(), &crs)?;
    let shares = (0..SIDE_POINTS).map(|point| f64::from(point) / f64::from(SIDE_POINTS - 1));
    let points = shares.flat_map(|t| [(t, 0.0), (t, 1.0), (0.0, t), (1.0, t)]);
    let places =
        points.filter_map(|(u, v)| transform.apply(west + (east - west) * u, south + (north - south) * v));
    let bounds = places
        .map(|(x, y)| [x, y, x, y])
        .reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]);

    bounds.ok_or_else(|| {
        let what = format!(
            "--lon-lat {west},{south},{east},{north} lies nowhere in the reference system of the database"
        );
        Error::Configuration(what)
    })
}
