//! `hedgehop build`: elevation and imagery in, a database out.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use hedgehop::Error;
use hedgehop::geo::VerticalDatum;
use hedgehop::memory::PageFile;
use hedgehop::modeling::{BuildOptions, BuildReport, NodataFill, build};
use hedgehop::voxel::PageSource;

use crate::area;
use crate::args::{self, Workers};
use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;
use crate::program::program;
use crate::progress::{Mode, Reporter};

const EXAMPLE: &str = "\
Examples:
  hedgehop build --elevation dem.tif --imagery ortho.tif -o area.hop
  hedgehop build --elevation fine.tif tiles/*.hgt --imagery sat.tif --spacing 10 \\
      --bbox 480000,5120000,520000,5160000 --nodata-fill interp -o alps.hop
  hedgehop build --elevation heights.png --local --spacing 2 -o model.hop";

/// Build a database from elevation rasters and imagery.
///
/// Inputs may be in any reference system; the database is in metres. Give several files in order of
/// priority: where they overlap, the first one that has data counts. Memory stays bounded for inputs of any size.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct Args {
    /// Elevation rasters, highest priority first: GeoTIFF, SRTM .hgt, DTED, Esri ASCII, 16-bit PNG, raw float32
    #[arg(long, value_name = "FILE", num_args = 1.., required = true)]
    elevation: Vec<PathBuf>,

    /// Imagery, highest priority first: GeoTIFF, PNG or JPEG with world file [default: none, colour follows height]
    #[arg(long, value_name = "FILE", num_args = 1..)]
    imagery: Vec<PathBuf>,

    /// Database to write
    #[arg(short, long, value_name = "AREA.hop")]
    output: PathBuf,

    /// Reference system of the database, in metres: EPSG:32633, a PROJ string, a .prj file [default: UTM zone of the centre]
    #[arg(long, value_name = "CRS", allow_hyphen_values = true)]
    crs: Option<String>,

    /// Reference system of elevation files that state none
    #[arg(long, value_name = "CRS", allow_hyphen_values = true)]
    elevation_crs: Option<String>,

    /// Reference system of imagery files that state none
    #[arg(long, value_name = "CRS", allow_hyphen_values = true, requires = "imagery")]
    imagery_crs: Option<String>,

    /// Take coordinates of files without a reference system as plain metres
    #[arg(long)]
    local: bool,

    /// Side of the finest voxel in metres, and pixel size of inputs without georeferencing [default: pixel size of the finest elevation file]
    #[arg(long, value_name = "METRES", value_parser = args::positive, allow_negative_numbers = true)]
    spacing: Option<f64>,

    /// Area to build, metres in the database's reference system [default: all that elevation covers]
    #[arg(long, value_name = "W,S,E,N", value_parser = args::bounding_box, allow_hyphen_values = true)]
    bbox: Option<[f64; 4]>,

    /// What heights of files that state no vertical datum are measured from [default: msl]
    #[arg(long, value_name = "DATUM")]
    src_vdatum: Option<Datum>,

    /// Elevation values that mean "no data", besides those that the files declare
    #[arg(long, value_name = "VALUE", value_parser = args::number, value_delimiter = ',', allow_hyphen_values = true)]
    nodata: Vec<f64>,

    /// What becomes of voids: none (no surface there), interp (from the heights around), or a height in metres
    #[arg(long, value_name = "none|interp|METRES", default_value = "none", value_parser = nodata_fill, allow_hyphen_values = true)]
    nodata_fill: NodataFill,

    /// Imagery bands to take as red, green and blue, counted from 1 [default: as the file says]
    #[arg(long, value_name = "R,G,B", value_parser = args::bands, requires = "imagery")]
    bands: Option<[u32; 3]>,

    /// Memory that the build may hold, bytes with suffix K, M or G
    #[arg(long, value_name = "BYTES", default_value = "512M", value_parser = args::bytes)]
    memory: u64,

    #[command(flatten)]
    workers: Workers,

    /// Replace the database if it exists
    #[arg(long)]
    overwrite: bool,

    /// How progress is told on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

/// Vertical datums as users name them.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Datum {
    /// Mean sea level, not further specified
    Msl,
    /// EGM96 geoid (SRTM)
    Egm96,
    /// EGM2008 geoid (Copernicus)
    Egm2008,
    /// WGS 84 ellipsoid
    Ellipsoid,
    /// NAVD88 (United States)
    Navd88,
}

impl From<Datum> for VerticalDatum {
    fn from(datum: Datum) -> Self {
        match datum {
            Datum::Msl => Self::Msl,
            Datum::Egm96 => Self::Egm96,
            Datum::Egm2008 => Self::Egm2008,
            Datum::Ellipsoid => Self::Ellipsoid,
            Datum::Navd88 => Self::Navd88,
        }
    }
}

fn nodata_fill(text: &str) -> Result<NodataFill, String> {
    match text.trim() {
        "none" => Ok(NodataFill::None),
        "interp" => Ok(NodataFill::Interpolate),
        other => args::number(other)
            .map(NodataFill::Value)
            .map_err(|_| "want none, interp or a height in metres".into()),
    }
}

impl Args {
    fn options(&self) -> BuildOptions {
        BuildOptions {
            elevation: self.elevation.clone(),
            imagery: self.imagery.clone(),
            output: self.output.clone(),
            overwrite: self.overwrite,
            crs: self.crs.clone(),
            elevation_crs: self.elevation_crs.clone(),
            imagery_crs: self.imagery_crs.clone(),
            local: self.local,
            spacing: self.spacing,
            raw_spacing: self.spacing,
            bbox: self.bbox,
            src_vdatum: self.src_vdatum.map(VerticalDatum::from),
            nodata: self.nodata.clone(),
            nodata_fill: self.nodata_fill,
            bands: self.bands,
            memory: self.memory,
            threads: self.workers.count(),
        }
    }
}

/// Runs the command.
pub fn run(args: &Args, interrupt: &Interrupt) -> Outcome {
    args::check_inputs("--elevation", &args.elevation, "*.tif")?;
    args::check_inputs("--imagery", &args.imagery, "*.tif")?;
    if args.output.exists() && !args.overwrite {
        return Err(Error::Configuration(format!(
            "{} exists; --overwrite replaces it",
            args.output.display()
        ))
        .into());
    }
    let reporter = Reporter::new(args.progress, interrupt);
    let report = build(&args.options(), &reporter)?;
    exit::print(&summary(&args.output, &report)?)?;
    Ok(())
}

/// What was built, and what to try next.
pub fn summary(output: &Path, report: &BuildReport) -> hedgehop::Result<String> {
    let source = PageFile::open(output)?;
    let megabytes = report.bytes as f64 / 1e6;
    let voxels = f64::from(report.grid.nx) * f64::from(report.grid.ny) / 1e6;
    // A build that took no measurable time has no rate to speak of.
    let seconds = report.seconds.max(1e-3);
    let mut text = format!(
        "built {}: {megabytes:.1} MB in {:.1} s ({:.1} MB/s, {:.2} million voxels/s)\n",
        output.display(),
        report.seconds,
        megabytes / seconds,
        voxels / seconds
    );
    text += &area::description(source.header())?;
    let [x, y, z] = area::viewpoint(source.header()).to_array();
    // Writing to a String cannot fail.
    let _ = write!(
        text,
        "Next:\n  {me} render {file} --eye {x:.0},{y:.0},{z:.0} --ypr 0,-15,0 -o view.png\n  \
         {me} render {file} --path TRACK -o frames/####.png\n",
        me = program(),
        file = output.display()
    );
    Ok(text)
}
