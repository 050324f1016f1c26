//! `hedgehop shadow-heights`: heights of buildings from their shadows.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use crate::args::{self, Workers};
use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;
use crate::progress::{Mode, Reporter};
use hedgehop::Error;
use hedgehop::encode::atomic::{check_writable, write_bytes};
use hedgehop::progress::Observer;
use hedgehop::sunlight::SunSetting;
use hedgehop_modeling::features::LayerOptions;
use hedgehop_modeling::shadow_height::{Answer, Origin, ShadowOptions, ShadowReport, shadow_heights};
use hedgehop_modeling::{ElevationFile, ImageryFile};

const EXAMPLE: &str = "\
Examples:
  hedgehop shadow-heights buildings.geojson --time 2024-10-05T15:12:00Z --imagery ortho.tif --elevation dem.tif -o heights.geojson
  hedgehop shadow-heights measured.csv --sun 231,28.5 -o measured-heights.csv";

/// Find the heights of buildings by their shadows in a photograph.
///
/// Rows may state the length of their shadow, `shadow_length`, or the place of its tip, `shadow_tip`; of others it is measured in --imagery. What is written are the
/// same rows with `height`, ready for [[features]] of a recipe.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
#[command(group(clap::ArgGroup::new("when").required(true).args(["time", "sun"])))]
pub struct ShadowHeightsArgs {
    /// Outlines of buildings: GeoJSON, a Shapefile, a GeoPackage, or a table (.csv) with a column `polygon`
    #[arg(value_name = "BUILDINGS")]
    buildings: PathBuf,

    /// Time at which the photograph was taken, with an offset from UTC: 2024-10-05T15:12:00Z
    #[arg(long, value_name = "TIME", value_parser = time)]
    time: Option<SunSetting>,

    /// Sun's azimuth clockwise from grid north of the buildings' system and elevation above the horizon, degrees
    #[arg(long, value_name = "AZ,EL", value_parser = args::sun, allow_hyphen_values = true)]
    sun: Option<SunSetting>,

    /// Orthophotos, highest priority first [default: none, rows state their shadows]
    #[arg(long, value_name = "FILE", num_args = 1..)]
    imagery: Vec<PathBuf>,

    /// Elevation of the bare ground, highest priority first [default: none, the ground is level]
    #[arg(long, value_name = "FILE", num_args = 1..)]
    elevation: Vec<PathBuf>,

    /// GeoJSON or table to write, by its name
    #[arg(short, long, value_name = "HEIGHTS.geojson|.csv")]
    output: PathBuf,

    /// Reference system of the buildings, if their file states none [default: longitude and latitude for GeoJSON and tables]
    #[arg(long, value_name = "CRS", allow_hyphen_values = true)]
    crs: Option<String>,

    /// Table of a GeoPackage [default: all that have features]
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,

    /// Reference system of elevation files that state none
    #[arg(long, value_name = "CRS", allow_hyphen_values = true, requires = "elevation")]
    elevation_crs: Option<String>,

    /// Reference system of imagery files that state none
    #[arg(long, value_name = "CRS", allow_hyphen_values = true, requires = "imagery")]
    imagery_crs: Option<String>,

    /// Take coordinates of rasters without a reference system as plain metres; the buildings need `--crs local` then
    #[arg(long)]
    local: bool,

    /// Pixel size of rasters without any georeferencing, metres
    #[arg(long, value_name = "METRES", value_parser = args::positive, allow_negative_numbers = true)]
    spacing: Option<f64>,

    /// Elevation values that mean "no data", besides those that the files declare
    #[arg(long, value_name = "VALUE", value_parser = args::number, value_delimiter = ',', allow_hyphen_values = true)]
    nodata: Vec<f64>,

    /// Edges of an image without georeferencing: degrees, or metres of --imagery-crs or of elevation
    #[arg(long, value_name = "W,S,E,N", value_parser = args::bounding_box, requires = "imagery", allow_hyphen_values = true)]
    imagery_extent: Option<[f64; 4]>,

    /// Imagery bands to take as red, green and blue, counted from 1 [default: as the file says]
    #[arg(long, value_name = "R,G,B", value_parser = args::bands, requires = "imagery")]
    bands: Option<[u32; 3]>,

    /// Highest that a building may be, metres: so far shadows are looked for
    #[arg(long, value_name = "METRES", default_value = "100", value_parser = args::positive, allow_negative_numbers = true)]
    highest: f64,

    /// Measure rows that state a height, too
    #[arg(long)]
    all: bool,

    #[command(flatten)]
    workers: Workers,

    /// Replace the output if it exists
    #[arg(long)]
    overwrite: bool,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

fn time(text: &str) -> Result<SunSetting, String> {
    let wrong = || "want a date and time with an offset from UTC, such as 2024-10-05T15:12:00Z or 2024-10-05T17:12+02:00";
    SunSetting::parse_time(text).map(SunSetting::Time).ok_or_else(|| wrong().to_owned())
}

/// Runs the command.
pub fn run(args: &ShadowHeightsArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    let as_table = check_output(args)?;
    let Some(sun) = args.time.or(args.sun) else {
        return Err(
            Error::Configuration("say when the picture was taken with --time, or --sun".into()).into()
        );
    };

    let elevation =
        args::input_files("--elevation", &args.elevation, &args::endings(args::elevation_formats()))?;
    let elevation = elevation.iter().map(|path| ElevationFile {
        path: path.clone(),
        crs: args.elevation_crs.clone(),
        nodata: args.nodata.clone(),
        ..ElevationFile::default()
    });
    let imagery = args::input_files("--imagery", &args.imagery, &args::endings(args::imagery_formats()))?;

    let imagery = imagery.iter().map(|path| ImageryFile {
        path: path.clone(),
        crs: args.imagery_crs.clone(),
        bands: args.bands,
        extent: args.imagery_extent,
    });

    let options = ShadowOptions {
        buildings: args.buildings.clone(),
        layer: LayerOptions { crs: args.crs.clone(), table: args.layer.clone(), ..LayerOptions::default() },
        sun,
        elevation: elevation.collect(),
        imagery: imagery.collect(),
        local: args.local,
        raw_spacing: args.spacing,
        highest_m: args.highest,
        all: args.all,
        threads: args.workers.count(),
    };

    let report = shadow_heights(&options, &reporter)?;
    report.notes.iter().for_each(|note| reporter.note(note));
    let text = if as_table { report.csv()? } else { report.geojson()? };
    write_bytes(&args.output, text.as_bytes())?;

    Ok(exit::print(&summary(&report, &args.output))?)
}

/// Whether the output is a table.
///
/// # Errors
/// An output that is no file of a known kind, is an input, exists already or cannot be written.
fn check_output(args: &ShadowHeightsArgs) -> hedgehop::Result<bool> {
    let output = &args.output;
    let wrong = |what: String| Err(Error::Configuration(what));
    let extension = output.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    let as_table = match extension.to_ascii_lowercase().as_str() {
        "csv" => true,
        "geojson" | "json" => false,
        _ => return wrong(format!("{}: heights are written as .geojson or .csv", output.display())),
    };
    let rasters = args.imagery.iter().chain(&args.elevation);
    let inputs: Vec<&Path> = rasters.chain([&args.buildings]).map(PathBuf::as_path).collect();
    args::check_no_input("-o", output, &inputs)?;
    if output.exists() && !args.overwrite {
        return wrong(format!("{} exists; --overwrite replaces it", output.display()));
    }
    check_writable(output)?;
    Ok(as_table)
}

/// Says what was found, in a few lines.
fn summary(report: &ShadowReport, output: &Path) -> String {
    let found: Vec<_> = report
        .answers
        .iter()
        .filter_map(|answer| match answer {
            Answer::Height(found) => Some(found),
            Answer::Kept | Answer::Nothing(_) => None,
        })
        .collect();

    let stated = found.iter().filter(|found| found.origin == Origin::Stated).count();
    let kept = report.answers.iter().filter(|answer| **answer == Answer::Kept).count();
    let (all, sun) = (report.answers.len(), report.sun);

    let mut text = format!(
        "sun: {:.1}° from north, {:.1}° above the horizon\n{} of {all} buildings have got a height: {} from the picture, {stated} from stated shadows\n",
        sun.azimuth,
        sun.elevation,
        found.len(),
        found.len() - stated
    );

    let mut heights: Vec<f64> = found.iter().map(|found| found.height_m).collect();
    let mut errors: Vec<f64> = found.iter().map(|found| found.error_m).collect();
    [&mut heights, &mut errors].into_iter().for_each(|values| values.sort_unstable_by(f64::total_cmp));

    // Writing to a string does not fail.
    if let ([low, ..], [.., high]) = (heights.as_slice(), heights.as_slice()) {
        let middle = heights.len() / 2;
        let _ = writeln!(
            text,
            "heights: {low:.1} to {high:.1} m, median {:.1} m; median error {:.2} m",
            heights[middle], errors[middle]
        );
    }

    if kept > 0 {
        let _ = writeln!(text, "{kept} stated a height already, and kept it (--all measures them, too)");
    }
    let without = all - found.len() - kept;
    if without > 0 {
        let _ = writeln!(text, "{without} are left without; shadow_note says why");
    }

    let _ = writeln!(text, "wrote {}", output.display());
    text
}
