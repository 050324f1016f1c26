//! `hedgehop hillshade`: relief by light, as a picture for maps.

use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

use crate::database::{CacheArgs, DatabaseName};
use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;
use crate::maps::{self, PartArgs};
use crate::progress::{Mode, Reporter};
use crate::{area, args, reference};
use hedgehop::colour::{linear_of_codes, srgb8_from_linear};
use hedgehop::encode::atomic::write_with;
use hedgehop::encode::geotiff::{NO_DATA, TILE, write_geotiff};
use hedgehop::progress::Observer;
use hedgehop::sunlight::SunSetting;
use hedgehop::voxel::PageSource;
use hedgehop::{Error, Result};
use hedgehop_query::{GroundMap, Hillshade, Sheet};

const EXAMPLE: &str = "\
Examples:
  hedgehop hillshade area.hop -o shade.tif
  hedgehop hillshade area.hop --pixel 30 --colour -o shade.png
  hedgehop hillshade area.hop --bbox 447000,4466000,452000,4471000 --sun 300,30 --exaggeration 1.5 -o part.png";

/// Rows of a PNG that are made at once.
const STRIP: u32 = 128;
/// Most pixels, and in a row or column, of a PNG and of a GeoTIFF.
const MOST_PNG: (u64, u32) = (400_000_000, 32_768);
const MOST_TIFF: (u64, u32) = (40_000_000_000, 1 << 20);
/// Light that ground in shadow still has with --colour, of that of level ground.
const AMBIENT: f64 = 0.25;

/// Draw the relief of a database by light.
///
/// Slopes by Horn's method (1981); each pixel has the cosine between sun and ground. A .tif is a Cloud Optimized GeoTIFF; a .png gets a world file (.pgw) and a .prj beside it.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct HillshadeArgs {
    /// Database to draw
    #[arg(value_name = "AREA.hop")]
    area: DatabaseName,

    /// Picture to write
    #[arg(short, long, value_name = "SHADE.tif|.png")]
    output: PathBuf,

    #[command(flatten)]
    part: PartArgs,

    /// The sun, degrees: clockwise from grid north, above the horizon; or a time
    #[arg(long, value_name = "AZ,EL|TIME", value_parser = args::sun, default_value = "315,45", allow_hyphen_values = true)]
    sun: SunSetting,

    /// Factor on heights
    #[arg(long, value_name = "FACTOR", value_parser = args::positive, default_value = "1", allow_negative_numbers = true)]
    exaggeration: f64,

    /// Light on the database's colours, not grey
    #[arg(long)]
    colour: bool,

    /// The ground under what stands on it, of level 1
    #[arg(long)]
    bare: bool,

    #[command(flatten)]
    cache: CacheArgs,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

/// Runs the command.
pub fn run(args: &HillshadeArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    let is_tiff = maps::is(&args.output, "tif") || maps::is(&args.output, "tiff");
    if !is_tiff && !maps::is(&args.output, "png") {
        let what = format!("{}: a hillshade is a .tif or a .png", args.output.display());
        return Err(Error::Configuration(what).into());
    }

    let source = args.cache.open(&args.area)?;
    let header = source.header();
    let sun = area::sky(args.sun, header)?.sun;
    if !sun.is_up() {
        let what = format!("at {:.1}° the sun lights no ground; choose one above the horizon", sun.elevation);
        return Err(Error::Configuration(what).into());
    }

    let extent = args.part.extent(header)?;
    let (kind, (most, side)) = if is_tiff { ("a GeoTIFF", MOST_TIFF) } else { ("a PNG", MOST_PNG) };
    maps::check_size(&extent, kind, most, side)?;
    maps::check_output(&args.output, &[&*args.area])?;
    let sheet = if args.bare { Sheet::Bare } else { Sheet::Surface };
    let map = GroundMap::new(&source, extent, sheet);
    let picture = Picture { map, shade: Hillshade::new(sun, args.exaggeration), has_colour: args.colour };

    if is_tiff {
        picture.write_tiff(args, header, &reporter)?;
    } else {
        picture.write_png(args, &reporter)?;
        maps::write_beside(&args.output, &extent, header, &reporter)?;
    }

    source.intact()?;
    let text = format!(
        "{}: {}x{} pixels of {} m\n",
        args.output.display(),
        extent.width,
        extent.height,
        reference::metres(extent.pixel)
    );

    Ok(exit::print(&text)?)
}

/// Picture to be drawn.
struct Picture<'s> {
    map: GroundMap<'s>,
    shade: Hillshade,
    has_colour: bool,
}

impl Picture<'_> {
    fn bands(&self) -> usize {
        if self.has_colour { 3 } else { 1 }
    }

    /// Samples of pixels, `[rows][columns][bands]`, the northernmost row first; 0 without ground, else 1 to 255.
    fn samples(&self, columns: std::ops::Range<i64>, rows: std::ops::Range<i64>) -> Result<Vec<u8>> {
        let light = self.shade.light(&self.map, columns.clone(), rows.clone())?;
        if !self.has_colour {
            let grey = |light: &f32| if light.is_nan() { NO_DATA } else { 1 + (light * 254.0).round() as u8 };
            return Ok(light.iter().map(grey).collect());
        }
        let colours = self.map.colours(columns, rows)?;
        let (linear, level) = (linear_of_codes(), self.shade.of_level_ground());
        let pixel = |(light, colour): (&f32, &[u8; 3])| {
            if light.is_nan() {
                return [NO_DATA; 3];
            }
            let factor = AMBIENT + (1.0 - AMBIENT) * f64::from(*light) / level;
            colour.map(|code| srgb8_from_linear(linear[usize::from(code)] * factor as f32).max(1))
        };
        Ok(light.iter().zip(&colours).flat_map(pixel).collect())
    }

    fn write_tiff(
        &self,
        args: &HillshadeArgs,
        header: &hedgehop::voxel::Header,
        observer: &dyn Observer,
    ) -> Result<()> {
        let tiff = maps::geotiff(self.map.extent(), self.bands(), header, observer)?;
        let side = i64::from(TILE);
        let mut tile = |at: [u32; 2]| {
            let [column, row] = at.map(|at| i64::from(at) * side);
            self.samples(column..column + side, row..row + side)
        };
        write_geotiff(&args.output, &tiff, &mut tile, observer)
    }

    /// A PNG with what has no ground clear, strip by strip.
    fn write_png(&self, args: &HillshadeArgs, observer: &dyn Observer) -> Result<()> {
        let extent = *self.map.extent();
        let mut failed = None;
        let written = write_with(&args.output, |file| {
            let mut encoder = png::Encoder::new(BufWriter::new(file), extent.width, extent.height);
            encoder.set_color(if self.has_colour {
                png::ColorType::Rgba
            } else {
                png::ColorType::GrayscaleAlpha
            });
            let mut writer = encoder.write_header().map_err(io::Error::from)?;
            let mut stream = writer.stream_writer().map_err(io::Error::from)?;
            observer.begin("hillshade", u64::from(extent.height), "rows");

            for first in (0..extent.height).step_by(STRIP as usize) {
                let rows = i64::from(first)..i64::from(extent.height.min(first + STRIP));
                let samples = if observer.cancelled() {
                    Err(Error::Interrupted(format!("{} was not written", args.output.display())))
                } else {
                    self.samples(0..i64::from(extent.width), rows.clone())
                };
                let samples = samples.map_err(|error| {
                    failed = Some(error);
                    io::Error::other("the ground")
                })?;
                let pixels = samples.chunks_exact(self.bands());
                let clear = |pixel: &[u8]| if pixel[0] == NO_DATA { 0 } else { u8::MAX };
                let bytes: Vec<u8> =
                    pixels.flat_map(|pixel| pixel.iter().copied().chain([clear(pixel)])).collect();
                stream.write_all(&bytes)?;
                observer.advance((rows.end - rows.start) as u64);
            }

            stream.finish().map_err(io::Error::from)?;
            writer.finish().map_err(io::Error::from)
        });

        observer.end();
        failed.map_or(written, Err)
    }
}
