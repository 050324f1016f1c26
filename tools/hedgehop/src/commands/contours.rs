//! `hedgehop contours`: contour lines, as lines or drawn on a map.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use image::{Rgb, RgbImage};

use crate::database::{CacheArgs, DatabaseName};
use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;
use crate::lines::ContourSpacing;
use crate::places::Places;
use crate::progress::{Mode, Reporter};
use crate::{args, chart, lines, maps, pictures, reference};
use hedgehop::encode::atomic::{write_bytes, write_with};
use hedgehop::encode::geotiff::{TILE, write_full_geotiff};
use hedgehop::memory::PageFile;
use hedgehop::progress::Observer;
use hedgehop::sunlight::Sun;
use hedgehop::voxel::{Header, HeightRange, PageSource};
use hedgehop::{Error, Result};
use hedgehop_query::{
    Contour, GroundMap, Hillshade, MapExtent, Sheet, contour_range, contours, fitting_interval,
};

const EXAMPLE: &str = "\
Examples:
  hedgehop contours area.hop -o lines.geojson
  hedgehop contours area.hop --interval 10 --index 5 -o map.png
  hedgehop contours area.hop --size 8192 -o map.tif
  hedgehop contours area.hop --bbox 447000,4466000,452000,4471000 --level 4 -o lines.geojson";

/// Sun of relief on maps.
const MAP_SUN: Sun = Sun { azimuth: 315.0, elevation: 45.0 };
/// Colours of ground in light and in shadow, and of none.
const LIGHT: [f32; 3] = [255.0, 254.0, 246.0];
const SHADOW: [f32; 3] = [158.0, 160.0, 168.0];
const NO_GROUND: Rgb<u8> = Rgb([226, 226, 222]);
/// Rows that are shaded at once.
const STRIP: u32 = 128;
/// Decimals of degrees: a centimetre.
const DECIMALS: i32 = 7;

/// Draw contour lines of a database.
///
/// Lines of the ground under what stands on it, by marching squares on the posts of a level. GeoJSON has them in longitude and latitude; a .tif or .png is a map with relief, and figures on index lines.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct ContoursArgs {
    /// Database to draw
    #[arg(value_name = "AREA.hop")]
    area: DatabaseName,

    /// Lines or map to write
    #[arg(short, long, value_name = "LINES.geojson|MAP.tif|MAP.png")]
    output: PathBuf,

    /// Metres from line to line [default: round, for about 10 to 25 lines]
    #[arg(long, value_name = "METRES", value_parser = args::positive, allow_negative_numbers = true)]
    interval: Option<f64>,

    /// Every Nth line is an index line
    #[arg(long, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u32).range(1..=1000))]
    index: u32,

    /// Part of the area, metres of its reference system [default: all of it]
    #[arg(long, value_name = "W,S,E,N", value_parser = args::bounding_box, allow_hyphen_values = true)]
    bbox: Option<[f64; 4]>,

    /// Level whose posts are taken: 1, 4, 16, 64, … [default: 1; of a map the coarsest that is finer than its pixels]
    #[arg(long, value_name = "LEVEL")]
    level: Option<u32>,

    /// Longer side of a map, pixels
    #[arg(long, value_name = "PIXELS", default_value = "2000", value_parser = clap::value_parser!(u32).range(64..=8192))]
    size: u32,

    #[command(flatten)]
    cache: CacheArgs,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

/// File format of the lines.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Lines,
    Tiff,
    Png,
}

impl Form {
    fn of(output: &Path) -> Result<Self> {
        let known = [
            ("geojson", Self::Lines),
            ("json", Self::Lines),
            ("tif", Self::Tiff),
            ("tiff", Self::Tiff),
            ("png", Self::Png),
        ];
        let found = known.iter().find(|(extension, _)| maps::is(output, extension));
        found.map(|(_, form)| *form).ok_or_else(|| {
            let what = format!("{}: contour lines are a .geojson, or a map, .tif or .png", output.display());
            Error::Configuration(what)
        })
    }
}

/// Runs the command.
pub fn run(args: &ContoursArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    let form = Form::of(&args.output)?;
    let source = args.cache.open(&args.area)?;
    let header = source.header();
    let bounds = args.bbox.unwrap_or(maps::WHOLE);
    let extent = map_extent(header, bounds, args.size)?;
    let level = match args.level {
        Some(level) => maps::level_index(level, header)?,
        None if form != Form::Lines => finer_than(extent.pixel, header),
        None => 0,
    };
    let HeightRange { low, high } = header.height_range;
    let interval = args.interval.unwrap_or_else(|| fitting_interval(low, high));
    maps::check_output(&args.output, &[&*args.area])?;
    let found = contours(&source, level, bounds, interval, &reporter)?;
    let spacing = ContourSpacing { interval, index: i64::from(args.index) };

    match form {
        Form::Lines => write_geojson(args, &source, &found, spacing, &reporter)?,
        Form::Tiff => {
            let picture = map(&source, extent, &found, spacing, &reporter)?;
            write_tiff(&args.output, &picture, &extent, header, &reporter)?;
        }
        Form::Png => {
            let picture = map(&source, extent, &found, spacing, &reporter)?;
            write_bytes(&args.output, &pictures::png(&picture, &args.output)?)?;
            maps::write_beside(&args.output, &extent, header, &reporter)?;
        }
    }

    source.intact()?;
    let (lowest, highest) = (found.first(), found.last());
    let range = lowest.zip(highest).map_or(String::new(), |(low, high)| {
        let elevation = |line: &Contour| lines::text(line.number as f64 * interval, interval);
        format!(" from {} to {} m", elevation(low), elevation(high))
    });
    let count = if found.is_empty() { "no".to_owned() } else { found.len().to_string() };
    let mut text =
        format!("{}: {count} lines every {} m{range}", args.output.display(), reference::metres(interval));
    if found.is_empty() {
        text += &why_none(contour_range(&source, level, bounds)?, header.grid.side(level));
    }

    Ok(exit::print(&(text + "\n"))?)
}

/// Why ground whose posts are so far apart, and between such heights, has no lines; `None`: there is none.
fn why_none(heights: Option<[f64; 2]>, side: f64) -> String {
    match heights {
        None => format!(
            ": in the box there is a gap of the data, or less than two by two posts, which are {} m apart",
            reference::metres(side)
        ),
        Some([low, high]) if low == high => format!(": the ground is level, {low:.2} m"),
        Some([low, high]) => {
            format!(
                ": the ground lies between two of them, from {low:.2} to {high:.2} m; give a smaller --interval"
            )
        }
    }
}

/// A map of a part of the area whose longer side has so many pixels.
fn map_extent(header: &Header, bounds: [f64; 4], size: u32) -> Result<MapExtent> {
    // In pixels of the finest voxels first, for its sides.
    let whole = MapExtent::of_level(&header.grid, 0, bounds)?;
    let longer = f64::from(whole.width.max(whole.height)) * whole.pixel;
    MapExtent::of_pixels(&header.grid, longer / f64::from(size), bounds)
}

/// The coarsest level that is no coarser than a pixel.
fn finer_than(pixel: f64, header: &Header) -> u8 {
    (0..header.level_count).rev().find(|level| header.grid.side(*level) <= pixel).unwrap_or(0)
}

/// The ground in soft light, to draw on.
pub fn relief(source: &PageFile, extent: MapExtent, observer: &dyn Observer) -> Result<RgbImage> {
    let map = GroundMap::new(source, extent, Sheet::Bare);
    let shade = Hillshade::new(MAP_SUN, 1.0);
    let mut picture = RgbImage::from_pixel(extent.width, extent.height, NO_GROUND);
    observer.begin("relief", u64::from(extent.height), "rows");

    for first in (0..extent.height).step_by(STRIP as usize) {
        if observer.cancelled() {
            return Err(Error::Interrupted("the map was not written".into()));
        }

        let rows = first..extent.height.min(first + STRIP);
        let light =
            shade.light(&map, 0..i64::from(extent.width), i64::from(rows.start)..i64::from(rows.end))?;
        let pixels = rows.clone().flat_map(|row| (0..extent.width).map(move |column| (column, row)));

        for ((column, row), light) in pixels.zip(light).filter(|(_, light)| !light.is_nan()) {
            let channel =
                |index: usize| (SHADOW[index] + (LIGHT[index] - SHADOW[index]) * light.sqrt()) as u8;
            picture.put_pixel(column, row, Rgb([0, 1, 2].map(channel)));
        }

        observer.advance(u64::from(rows.end - rows.start));
    }

    observer.end();
    Ok(picture)
}

/// Relief, the lines on it, and a scale.
fn map(
    source: &PageFile,
    extent: MapExtent,
    found: &[Contour],
    spacing: ContourSpacing,
    observer: &dyn Observer,
) -> Result<RgbImage> {
    let unit = (f64::from(extent.width.max(extent.height)) / 1600.0).max(0.75);
    let mut picture = relief(source, extent, observer)?;
    lines::draw(&mut picture, &extent, found, spacing, unit);
    let text = format!("CONTOURS {} m", reference::metres(spacing.interval));
    chart::scale(&mut picture, 1.0 / extent.pixel, &text, unit);
    Ok(picture)
}

/// A map as Cloud Optimized GeoTIFF. All of it is data, also where there is no ground.
fn write_tiff(
    output: &Path,
    picture: &RgbImage,
    extent: &MapExtent,
    header: &Header,
    observer: &dyn Observer,
) -> Result<()> {
    let tiff = maps::geotiff(extent, 3, header, observer)?;
    let mut tile = |[column, row]: [u32; 2]| {
        let side = TILE as usize;
        let mut samples = vec![0; side * side * 3];
        for (down, line) in samples.chunks_exact_mut(side * 3).enumerate() {
            for (right, pixel) in line.chunks_exact_mut(3).enumerate() {
                let at = [column * TILE + right as u32, row * TILE + down as u32];
                if let Some(Rgb(colour)) = picture.get_pixel_checked(at[0], at[1]) {
                    pixel.copy_from_slice(colour);
                }
            }
        }
        Ok(samples)
    };
    write_full_geotiff(output, &tiff, &mut tile, observer)
}

/// All lines as a collection of features (RFC 7946).
fn write_geojson(
    args: &ContoursArgs,
    source: &PageFile,
    found: &[Contour],
    spacing: ContourSpacing,
    observer: &dyn Observer,
) -> Result<()> {
    let places = Places::new(source, false)?;
    if reference::crs(source.header())?.is_local() {
        observer
            .note("the area has no place on Earth: coordinates are its metres, not longitude and latitude");
    }
    write_with(&args.output, |file| {
        let mut file = BufWriter::new(file);
        write!(file, "{{\"type\":\"FeatureCollection\",\"features\":[")?;
        for (number, line) in found.iter().enumerate() {
            if number > 0 {
                write!(file, ",")?;
            }
            write_line(&mut file, &places, line, spacing)?;
        }
        writeln!(file, "\n]}}")?;
        file.flush()
    })
}

fn write_line(
    file: &mut impl Write,
    places: &Places<'_>,
    line: &Contour,
    spacing: ContourSpacing,
) -> io::Result<()> {
    let ContourSpacing { interval, index } = spacing;
    let elevation = lines::text(line.number as f64 * interval, interval);
    let is_index = line.number % index == 0;
    write!(
        file,
        "\n{{\"type\":\"Feature\",\"properties\":{{\"elevation\":{elevation},\"index\":{is_index}}},\"geometry\":{{\"type\":\"LineString\",\"coordinates\":["
    )?;
    let factor = 10.0_f64.powi(DECIMALS);
    for (number, point) in line.points.iter().enumerate() {
        let [x, y] = match places.lonlat(*point) {
            Some(degrees) => degrees.map(|degrees| (degrees * factor).round() / factor),
            None => point.to_array().map(|metres| (metres * 1000.0).round() / 1000.0),
        };
        let comma = if number > 0 { "," } else { "" };
        write!(file, "{comma}[{x},{y}]")?;
    }
    write!(file, "]}}}}")
}
