//! Pictures of the renderer, and of one sample per pixel, against truth.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::DVec2;
use serde::Serialize;

use crate::args::{self, Area, Common};
use crate::engine;
use crate::exact::one_sample;
use crate::measure::{Nearness, codes, difference, write_png};
use crate::report::{self, PoseRecord};
use crate::truths::Truths;
use crate::views::low_flight;
use hedgehop::flight::{BindOptions, ReadOptions, Trajectory, read_track};
use hedgehop::geo::Crs;
use hedgehop::raymarch::ground_height;
use hedgehop::render::RenderOptions;
use hedgehop::space::{Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::voxel::PageSource;
use hedgehop::{Error, Result, Size};

/// Decibels by which the renderer's PSNR must exceed that of one sample per pixel.
const LEAST_GAIN: f64 = 3.0;

/// Factor by which differences are enlarged in pictures of them.
const DIFFERENCE_GAIN: i32 = 8;

/// Compare pictures with truth, 256 samples per pixel of level 1.
///
/// Writes truth, the renderer's picture, the one with one sample per pixel, and both differences (eight times, around
/// grey) of every view. Views are low flight over each database, or the fixes of a path over a single one.
#[derive(Debug, clap::Args)]
pub struct PictureArgs {
    /// Databases
    #[arg(value_name = "AREA.hop", required = true)]
    areas: Vec<PathBuf>,

    /// Folder for the pictures, and for truths, which are kept for the next run
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,

    /// Random poses over each database
    #[arg(long, value_name = "N", default_value_t = 3)]
    poses: usize,

    /// Look from the fixes of this path instead
    #[arg(long, value_name = "FILE", conflicts_with = "poses")]
    path: Option<PathBuf>,

    /// Picture size, pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "480x270", value_parser = args::size)]
    size: Size,

    /// Truth has the square of this number of samples in each pixel
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=64))]
    samples: u32,

    /// Compare only this many columns, in the middle of each picture: large ones take long
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    columns: Option<u32>,

    #[command(flatten)]
    common: Common,
}

/// One view.
#[derive(Debug, Serialize)]
struct ViewRecord {
    area: String,
    view: PoseRecord,
    engine: Nearness,
    one_sample: Nearness,
    gain_db: f64,
    /// 0 where the truth was kept from an earlier run.
    truth_s: f64,
}

#[derive(Debug, Serialize)]
struct MeasuredPicture {
    size_px: [u32; 2],
    columns: Option<u32>,
    samples_per_pixel: u32,
    seed: u64,
    least_gain_db: f64,
    within_bounds: bool,
    views: Vec<ViewRecord>,
}

/// Runs the mode.
pub fn run(args: &PictureArgs) -> Result<()> {
    let farm = args.common.farm()?;
    let mut views = Vec::new();
    report::line(&format!(
        "{:<14} {:>4} {:>9} {:>9} {:>7} {:>9} {:>9} {:>8}",
        "area", "view", "engine dB", "1 ray dB", "gain", "FLIP", "1 ray", "truth s"
    ));

    for path in &args.areas {
        let area = Area::open(path)?;
        for (index, pose) in poses(args, &area)?.into_iter().enumerate() {
            let view = look(args, &area, &farm, index, pose)?;
            report::line(&view.line(index));
            views.push(view);
        }
    }

    let within_bounds = views.iter().all(ViewRecord::within_bounds);
    let smallest = views.iter().map(|view| view.gain_db).fold(f64::INFINITY, f64::min);
    let verdict = if within_bounds { "within" } else { "NOT within" };
    report::line(&format!(
        "smallest gain {smallest:.2} dB: {verdict} the bounds, {LEAST_GAIN} dB and a lower FLIP in every view"
    ));

    let measured = MeasuredPicture {
        size_px: [args.size.width, args.size.height],
        columns: args.columns,
        samples_per_pixel: args.samples * args.samples,
        seed: args.common.seed,
        least_gain_db: LEAST_GAIN,
        within_bounds,
        views,
    };

    report::json(args.common.json.as_deref(), &measured)
}

impl ViewRecord {
    fn within_bounds(&self) -> bool {
        self.gain_db >= LEAST_GAIN && self.engine.flip < self.one_sample.flip
    }

    fn line(&self, index: usize) -> String {
        format!(
            "{:<14} {index:>4} {:>9.2} {:>9.2} {:>7.2} {:>9.5} {:>9.5} {:>8.1}",
            self.area,
            self.engine.psnr_db,
            self.one_sample.psnr_db,
            self.gain_db,
            self.engine.flip,
            self.one_sample.flip,
            self.truth_s
        )
    }
}

/// Returns some columns of a picture of 8-bit codes that is `width` pixels wide.
fn cut(rgb: &[u8], columns: &Range<u32>, width: u32) -> Vec<u8> {
    let [first, end] = [columns.start, columns.end].map(|column| 3 * column as usize);
    rgb.chunks_exact(3 * width as usize).flat_map(|row| &row[first..end]).copied().collect()
}

/// Poses over `area`, as asked for.
fn poses(args: &PictureArgs, area: &Area) -> Result<Vec<Pose>> {
    match &args.path {
        None => low_flight(&area.source, args.poses, args.common.seed),
        Some(path) if args.areas.len() == 1 => fixes(path, area),
        Some(_) => Err(Error::Configuration("--path needs a single database".into())),
    }
}

/// Poses at the fixes of a path file, 60° wide where it says nothing.
fn fixes(path: &Path, area: &Area) -> Result<Vec<Pose>> {
    let track = read_track(path, &ReadOptions::default())?;
    let metadata = &area.source.header().metadata;
    let crs = Crs::from_record(&metadata.crs_name, metadata.crs_epsg, metadata.crs_proj.as_deref())?;
    let ground = |place: DVec2| ground_height(&area.source, place).ok().flatten();
    let options = BindOptions::default();
    let trajectory = Trajectory::bind(&track, &crs, &ground, &options)?;
    Ok(track.fixes.iter().map(|fix| trajectory.pose_at(fix.time)).collect())
}

/// Renders, compares and writes one view.
fn look(args: &PictureArgs, area: &Area, farm: &Farm, index: usize, pose: Pose) -> Result<ViewRecord> {
    let camera = Camera::new(pose, args.size.width, args.size.height);
    let options = RenderOptions::default();
    let begun = Instant::now();
    let truths = Truths { folder: &args.output, samples: args.samples, columns: args.columns };
    let columns = truths.columns_of(&camera);
    let size = [columns.len() as u32, camera.height];
    let (truth, is_new) = truths.get(&area.source, &camera, &options, farm)?;
    let truth_s = if is_new { begun.elapsed().as_secs_f64() } else { 0.0 };
    let truth = codes(&truth);
    let write = |kind: &str, rgb: &[u8]| {
        write_png(&args.output.join(format!("{}-{index:02}-{kind}.png", area.name)), rgb, size)
    };
    let judge = |kind: &str, picture: Vec<u8>| {
        write(kind, &picture)?;
        write(&format!("{kind}-difference"), &difference(&truth, &picture, DIFFERENCE_GAIN))?;
        Ok::<_, Error>(Nearness::between(&truth, &picture, size))
    };
    write("truth", &truth)?;
    let engine = engine::picture(&area.source, &camera, &args.common.judged(), farm)?;
    let engine = judge("engine", cut(&engine, &columns, camera.width))?;
    let one_sample = one_sample(&area.source, &camera, &options, columns, farm)?;
    let one_sample = judge("one-sample", codes(&one_sample.colour))?;

    Ok(ViewRecord {
        area: area.name.clone(),
        view: pose.into(),
        engine,
        one_sample,
        gain_db: engine.psnr_db - one_sample.psnr_db,
        truth_s,
    })
}
