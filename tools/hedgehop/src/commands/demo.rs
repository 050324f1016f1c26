//! `hedgehop demo`: the whole way, from rasters to a film, on data that the program carries.

use std::fs;
use std::path::{Path, PathBuf};

use hedgehop::frame::{FramePattern, FrameRate};
use hedgehop::memory::PageFile;
use hedgehop::modeling::{BuildOptions, NodataFill, build};
use hedgehop::progress::Observer;
use hedgehop::voxel::PageSource;
use hedgehop::{Error, Result};

use crate::args::{self, Size};
use crate::commands::render;
use crate::contact_sheet;
use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;
use crate::progress::{Mode, Reporter};
use crate::view::{FlightArgs, LookArgs, Surface};

const EXAMPLE: &str = "\
Examples:
  hedgehop demo
  hedgehop demo -o /data/hedgehop-demo";

/// A synthetic valley that this project made; its licence lies beside it in `data/`.
const ELEVATION: (&str, &[u8]) =
    ("valley-elevation.tif", include_bytes!("../../../../data/valley-elevation.tif"));
const IMAGERY: (&str, &[u8]) = ("valley-imagery.tif", include_bytes!("../../../../data/valley-imagery.tif"));
const PATH: (&str, &[u8]) = ("valley-path.csv", include_bytes!("../../../../data/valley-path.csv"));

const SIZE: Size = Size { width: 640, height: 360 };
/// Frames that the demo renders at most: ten seconds of film, and well under a minute on two cores.
const MOST_FRAMES: u64 = 120;
const FRAMES_PER_SECOND: u32 = 12;
/// Memory of the build, bytes; the valley needs far less.
const MEMORY: u64 = 256 << 20;
/// Frames on the contact sheet: four in a row.
const SHEET_FRAMES: usize = 12;
const SHEET_COLUMNS: u32 = 4;

/// Build and fly a small valley; needs no files and no network.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct Args {
    /// Folder to write to; it is made if it does not exist
    #[arg(short, long, value_name = "DIR", default_value = "hedgehop-demo")]
    output: PathBuf,

    /// How progress is told on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

/// Runs the command.
pub fn run(args: &Args, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    let folder = &args.output;
    fs::create_dir_all(folder).map_err(|error| Error::io(folder, "create the folder", error))?;
    for (name, bytes) in [ELEVATION, IMAGERY, PATH] {
        let file = folder.join(name);
        fs::write(&file, bytes).map_err(|error| Error::io(&file, "write", error))?;
    }
    exit::print(&format!(
        "1. wrote {}, {} and {} to {}\n",
        ELEVATION.0,
        IMAGERY.0,
        PATH.0,
        folder.display()
    ))?;

    let area = folder.join("valley.hop");
    let report = build(&options(folder, &area), &reporter)?;
    exit::print(&format!(
        "2. built {}: {} x {} voxels of {} m, {:.1} MB in {:.1} s\n",
        area.display(),
        report.grid.nx,
        report.grid.ny,
        report.grid.spacing,
        report.bytes as f64 / 1e6,
        report.seconds
    ))?;
    fly(folder, &area, &reporter)?;
    exit::print(&next(folder, &area)?)?;
    Ok(())
}

fn options(folder: &Path, area: &Path) -> BuildOptions {
    BuildOptions {
        elevation: vec![folder.join(ELEVATION.0)],
        imagery: vec![folder.join(IMAGERY.0)],
        output: area.to_owned(),
        overwrite: true,
        crs: None,
        elevation_crs: None,
        imagery_crs: None,
        local: false,
        spacing: None,
        raw_spacing: None,
        bbox: None,
        src_vdatum: None,
        nodata: Vec::new(),
        nodata_fill: NodataFill::None,
        bands: None,
        memory: MEMORY,
        threads: args::available_cores(),
    }
}

fn fly(folder: &Path, area: &Path, reporter: &Reporter) -> Outcome {
    todo!()
}
