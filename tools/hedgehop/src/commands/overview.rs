//! `hedgehop overview`: an area and a flight over it, seen from straight above.

use std::path::{Path, PathBuf};

use glam::DVec2;
use image::{Rgb, RgbImage};

use crate::args::{self, AltitudeMode, Workers, check_no_input};
use crate::camera::CameraArgs;
use crate::chart::{Chart, Footprint};
use crate::database::{CacheArgs, DatabaseName};
use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;
use crate::playback::PlaybackArgs;
use crate::progress::{Mode, Reporter};
use crate::screen::ScreenArgs;
use crate::smoothing::SmoothingArgs;
use crate::tracks::TrackArgs;
use crate::view::FlightArgs;
use crate::views::ViewArgs;
use crate::world::WorldArgs;
use crate::{pictures, reference};
use hedgehop::colour::srgb8_picture;
use hedgehop::encode::atomic::{check_writable, write_bytes};
use hedgehop::flight::Trajectory;
use hedgehop::frame::Frame;
use hedgehop::memory::PageFile;
use hedgehop::progress::Observer;
use hedgehop::render::{Engine, RenderOptions, Renderer, render_frame};
use hedgehop::space::{Attitude, Camera, Pose, Screen};
use hedgehop::subimage::Farm;
use hedgehop::sunlight::Sun;
use hedgehop::voxel::{Header, PageSource};
use hedgehop::{Error, Result, Size};

const EXAMPLE: &str = "\
Examples:
  hedgehop overview area.hop -o map.png
  hedgehop overview area.hop --path track.gpx -o map.png
  hedgehop overview area.hop --path track.csv --whole --footprints 12 --size 2400 -o map.png";

/// Sun of relief on maps, from the upper left: lit from below, hills look like holes.
const MAP_SUN: Sun = Sun { azimuth: 315.0, elevation: 45.0 };
/// Colour of what has no ground.
const NO_GROUND: [u8; 3] = [226, 226, 222];
/// Rows of the map that are rendered at once.
const STRIP: u32 = 64;
/// Places of the path that are drawn at most.
const MOST_PLACES: usize = 4000;
/// Share of the path's extents that is shown around it, and least metres.
const AROUND: f64 = 0.15;
const LEAST_AROUND: f64 = 100.0;
/// Most that one side of a map is as long as the other.
const LONGEST: f64 = 1.6;
/// Size of the frames that tell which ground is visible: 16 by 9, as a picture.
const FOOTPRINT_SIZE: Size = Size { width: 64, height: 36 };

/// Draw a map of a database with a flight over it.
///
/// The ground is seen from straight above with relief, north up; on it the path from its start (a disc) to its end (a square), the visible ground of some
/// frames, and a scale.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct OverviewArgs {
    /// Database to draw
    #[arg(value_name = "AREA.hop")]
    area: DatabaseName,

    /// Picture to write
    #[arg(short, long, value_name = "MAP.png")]
    output: PathBuf,

    /// Flight path: CSV, JSBSim CSV, KML gx:Track, GPX or IGC
    #[arg(long, value_name = "FILE")]
    path: Option<PathBuf>,

    /// Surface that altitudes are measured from where the path file does not say [default: msl]
    #[arg(long, value_enum, value_name = "MODE", requires = "path")]
    alt_mode: Option<AltitudeMode>,

    #[command(flatten)]
    tracks: TrackArgs,

    /// All of the area, not the part around the path
    #[arg(long)]
    whole: bool,

    /// Frames of the path whose visible ground is drawn, evenly spread; 0: none
    #[arg(long, value_name = "N", default_value = "6", value_parser = clap::value_parser!(u32).range(0..=100))]
    footprints: u32,

    /// Horizontal field of view of these frames, degrees [default: as the path says, or 60]
    #[arg(long, value_name = "DEGREES", value_parser = args::field_of_view, allow_negative_numbers = true)]
    hfov: Option<f64>,

    /// Longer side of the map, pixels
    #[arg(long, value_name = "PIXELS", default_value = "1200", value_parser = clap::value_parser!(u32).range(64..=8192))]
    size: u32,

    #[command(flatten)]
    workers: Workers,

    #[command(flatten)]
    cache: CacheArgs,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

/// Runs the command.
pub fn run(args: &OverviewArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    pictures::check_png(&args.output, "a map")?;
    let inputs: Vec<&Path> = std::iter::once(&*args.area).chain(args.path.as_deref()).collect();
    check_no_input("-o", &args.output, &inputs)?;
    args.tracks.check(args.path.is_some(), "--path")?;
    let source = args.cache.open(&args.area)?;
    check_writable(&args.output)?;
    let farm = Farm::new(args.workers.count())?;
    let flight = args.path.as_ref().map(|_| flight(args, &source, &reporter)).transpose()?;
    let places = flight.as_ref().map(|flight| places(&flight.trajectory)).unwrap_or_default();
    let camera = camera(source.header(), if args.whole { &[] } else { &places }, args.size);
    let picture = relief(&source, &camera, &farm, &reporter)?;
    let footprints = match &flight {
        Some(flight) => footprints(args.footprints, &source, flight, &farm, &reporter)?,
        None => Vec::new(),
    };
    let made = Chart { camera: &camera, path: &places, footprints: &footprints }.draw(picture);
    write_bytes(&args.output, &pictures::png(&made, &args.output)?)?;

    let text = format!(
        "{}: {}x{} pixels of {} m\n",
        args.output.display(),
        made.width(),
        made.height(),
        reference::metres((1000.0 / camera.focal_px()).round() / 1000.0)
    );

    Ok(exit::print(&text)?)
}

/// A flight over the database.
struct OverviewFlight {
    /// Path of the eye over the database.
    trajectory: Trajectory,
    /// Flags of the flight, with the screen of its frames.
    args: FlightArgs,
}

/// Binds the path to the database.
fn flight(args: &OverviewArgs, source: &PageFile, observer: &dyn Observer) -> Result<OverviewFlight> {
    let flight = FlightArgs {
        path: args.path.clone(),
        eye: None,
        eye_lonlat: false,
        ypr: None,
        alt_mode: args.alt_mode,
        level: false,
        tracks: args.tracks,
        camera: CameraArgs::default(),
        smoothing: SmoothingArgs::default(),
        playback: PlaybackArgs::default(),
        clearance: None,
        allow_below_ground: false,
        screen: ScreenArgs { hfov: args.hfov, size: Some(FOOTPRINT_SIZE), ..ScreenArgs::default() },
        views: ViewArgs::default(),
        world: WorldArgs::default(),
    };
    let trajectory = flight.bind(source, &flight.screen.setup()?, observer)?;
    Ok(OverviewFlight { trajectory, args: flight })
}

/// Places of a path, in order.
fn places(trajectory: &Trajectory) -> Vec<DVec2> {
    let last = MOST_PLACES as f64 - 1.0;
    let place = |index: usize| trajectory.pose_at(trajectory.duration() * index as f64 / last).eye.truncate();
    let mut places: Vec<_> = (0..MOST_PLACES).map(place).collect();
    places.dedup();
    places
}

/// Builds the camera that looks down on the ground around `places`, or on all of it, if there are none.
fn camera(header: &Header, places: &[DVec2], longer: u32) -> Camera {
    let grid = &header.grid;
    let whole = [grid.origin, grid.far_corner()];
    let [low, high] = match places {
        [] => whole,
        places => {
            let [low, high] =
                places.iter().fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], place| {
                    [low.min(*place), high.max(*place)]
                });
            let around = ((high - low).max_element() * AROUND).max(LEAST_AROUND).max(8.0 * grid.spacing);
            // Not beyond the area, but as far as the path goes.
            [(low - around).max(whole[0]).min(low), (high + around).min(whole[1]).max(high)]
        }
    };

    // What is added for a handy shape lies in the area.
    let handy = DVec2::splat((high - low).max_element() / LONGEST).min(whole[1] - whole[0]);
    let sides = (high - low).max(handy);
    let reach = 0.5 * sides.min(whole[1] - whole[0]);
    let middle = (0.5 * (low + high)).clamp(whole[0] + reach, whole[1] - reach);
    let middle = middle.clamp(high - 0.5 * sides, low + 0.5 * sides);
    let metres = sides.max_element() / f64::from(longer);

    // At least a pixel.
    let [width, height] = (sides / metres).round().max(DVec2::ONE).to_array().map(|pixels| pixels as u32);
    look_down(header, middle, metres, [width, height])
}

/// A view from above of so many pixels about a place, each so many metres wide.
fn look_down(header: &Header, middle: DVec2, metres: f64, [width, height]: [u32; 2]) -> Camera {
    let attitude = Attitude { yaw: 0.0, pitch: -90.0, roll: 0.0 };
    let pose = Pose { eye: middle.extend(header.height_range.high + 1.0), attitude, hfov: 60.0 };
    Camera::with_screen(pose, Screen::Orthographic { width: f64::from(width) * metres }, width, height)
}

/// The ground as a camera from above sees it, without air.
fn relief(source: &PageFile, camera: &Camera, farm: &Farm, observer: &dyn Observer) -> Result<RgbImage> {
    let header = source.header();
    let baked = header.metadata.baked_sun.map(|[azimuth, elevation]| Sun { azimuth, elevation });
    let options = RenderOptions {
        visibility: f64::INFINITY,
        sun: baked.unwrap_or(MAP_SUN),
        engine: Engine::Reference,
        ..RenderOptions::default()
    };
    let (width, height, metres) = (camera.width, camera.height, 1.0 / camera.focal_px());
    let mut pixels = Vec::with_capacity(width as usize * height as usize * 3);
    observer.begin("map", u64::from(height), "rows");

    for first in (0..height).step_by(STRIP as usize) {
        if observer.cancelled() {
            return Err(Error::Interrupted("the map was not written".into()));
        }

        let rows = STRIP.min(height - first);
        let down = f64::from(first) + 0.5 * f64::from(rows) - 0.5 * f64::from(height);
        let middle = camera.pose.eye.truncate() - DVec2::Y * (down * metres);
        let frame =
            render_frame(source, &look_down(header, middle, metres, [width, rows]), &options, farm)?.frame;
        let mut rgb = srgb8_picture(&frame.colour);
        for (pixel, _) in frame.level.iter().enumerate().filter(|(_, level)| **level == Frame::SKY_LEVEL) {
            rgb[3 * pixel..3 * pixel + 3].copy_from_slice(&NO_GROUND);
        }

        pixels.extend(rgb);
        observer.advance(u64::from(rows));
    }

    observer.end();
    // There are as many pixels as the strips have together.
    Ok(RgbImage::from_raw(width, height, pixels)
        .unwrap_or_else(|| RgbImage::from_pixel(width, height, Rgb(NO_GROUND))))
}

/// Returns the visible ground of evenly spread frames of a flight.
fn footprints(
    count: u32,
    source: &PageFile,
    flight: &OverviewFlight,
    farm: &Farm,
    observer: &dyn Observer,
) -> Result<Vec<Footprint>> {
    let OverviewFlight { trajectory, args } = flight;
    let (setup, options) = (args.screen.setup()?, RenderOptions::of(source.header()));
    let renderer = Renderer::new(source, &options);
    let mut footprints = Vec::new();
    observer.begin("visible ground", u64::from(count), "frames");
    for index in 0..count {
        if observer.cancelled() {
            return Err(Error::Interrupted("the map was not written".into()));
        }
        // Neither at the very start nor at the very end, where marks are.
        let share = (f64::from(index) + 0.5) / f64::from(count);
        let camera = setup.camera(trajectory.pose_at(trajectory.duration() * share));
        let frame = renderer.frame(&camera, farm)?.frame;
        footprints.push(Footprint::of(&frame));
        observer.advance(1);
    }
    observer.end();
    Ok(footprints)
}
