//! Flicker in a slow flight, beyond what moves.
//!
//! ```text
//! for each frame n and each of its pixels that sees ground:
//!     P  = the point seen                                       exact range on level 1
//!     at = where frame n+1 sees P                               known poses
//!     visible = the four pixels around `at` see ground within 2 % of P's distance
//!     residual = colour of n − colour of n+1 at `at`, bilinear  8-bit sRGB codes
//! flicker = root mean square of the residuals over all visible pixels
//! ```
//!
//! Both pictures are compensated by the same exact ranges, so that they are judged over the same pixels.
//!
//! Not even the truth is without residuals: ground that comes nearer shows more, bilinear look-up blurs, and codes are rounded.
//! What is the picture's own is what it has beyond the truth's, which is told beside it and not judged:
//!
//! ```text
//! beyond = root mean square of (residual − residual of the truth)   sRGB codes before they are rounded
//! ```

use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3, Vec3};
use serde::Serialize;

use crate::args::{self, Area, Common};
use crate::engine;
use crate::exact::{one_sample, supersampled};
use crate::measure::exact_codes;
use crate::report::{self, PoseRecord};
use crate::views::low_flight;
use hedgehop::raymarch::ground_height;
use hedgehop::render::RenderOptions;
use hedgehop::space::{Camera, Pose};
use hedgehop::voxel::PageSource;
use hedgehop::{Error, Result, Size};

/// Share of the distance by which ground may differ and still be the same ground.
const SAME_GROUND: f64 = 0.02;

/// Most flicker, as a share of that of one sample per pixel.
const MOST: f64 = 0.5;

/// Measure what flickers in a slow flight, against one sample per pixel.
///
/// The flight is straight and level along the view, over the first pose of low flight that the seed gives.
#[derive(Debug, clap::Args)]
pub struct FlickerArgs {
    /// Databases
    #[arg(value_name = "AREA.hop", required = true)]
    areas: Vec<PathBuf>,

    /// Frames
    #[arg(long, value_name = "N", default_value_t = 120, value_parser = clap::value_parser!(u32).range(2..))]
    frames: u32,

    /// Units flown from frame to frame
    #[arg(long, value_name = "UNITS", default_value = "0.25", value_parser = args::positive)]
    speed: f64,

    /// Picture size, pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "480x270", value_parser = args::size)]
    size: Size,

    /// Also measure pictures with the square of this number of samples per pixel, and what the others have beyond them
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    samples: Option<u32>,

    /// Write the frames to this folder
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,

    #[command(flatten)]
    common: Common,
}

/// sRGB codes of one frame by each way of rendering, 0…255, not rounded.
struct Shots {
    camera: Camera,
    /// Exact ranges, metres.
    range: Vec<f32>,
    /// The engine's, one sample's, and the supersampled one's if wanted.
    pictures: Vec<Vec<Vec3>>,
}

/// Index of the supersampled picture among a frame's.
const TRUTH: usize = 2;

/// Residuals between two frames, or between many.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    /// Residuals of each picture's 8-bit codes.
    raw: [Residual; 3],
    /// Residuals of the engine's and one sample's exact codes, beyond the truth's.
    beyond: [Residual; 2],
}

/// Sum of squares of residuals, and how many.
#[derive(Debug, Clone, Copy, Default)]
struct Residual {
    squares: f64,
    count: usize,
}

#[derive(Debug, Serialize)]
struct AreaRecord {
    area: String,
    first: PoseRecord,
    engine_rms: f64,
    one_sample_rms: f64,
    supersampled_rms: Option<f64>,
    /// The engine's and one sample's beyond the supersampled one's.
    beyond_rms: Option<[f64; 2]>,
    ratio: f64,
    visible_share: f64,
    /// Values of each pair of frames: the engine's, one sample's.
    pairs_rms: Vec<Vec<f64>>,
}

#[derive(Debug, Serialize)]
struct MeasuredFlicker {
    size_px: [u32; 2],
    frames: u32,
    speed_units: f64,
    seed: u64,
    most_ratio: f64,
    within_bounds: bool,
    areas: Vec<AreaRecord>,
}

/// Runs the mode.
pub fn run(args: &FlickerArgs) -> Result<()> {
    report::line(&format!(
        "{:<14} {:>10} {:>10} {:>7} {:>10} {:>10} {:>10} {:>7} {:>8}",
        "area", "engine", "1 ray", "ratio", "supersampl", "engine +", "1 ray +", "ratio", "visible"
    ));
    let mut areas = Vec::new();

    for path in &args.areas {
        let record = fly(args, &Area::open(path)?)?;
        report::line(&record.line());
        areas.push(record);
    }

    let within_bounds = areas.iter().all(|area| area.ratio <= MOST);
    let verdict = if within_bounds { "within" } else { "NOT within" };
    report::line(&format!("{verdict} the bound: a ratio of {MOST} at most, everywhere"));

    let measured = MeasuredFlicker {
        size_px: [args.size.width, args.size.height],
        frames: args.frames,
        speed_units: args.speed,
        seed: args.common.seed,
        most_ratio: MOST,
        within_bounds,
        areas,
    };

    report::json(args.common.json.as_deref(), &measured)
}

impl AreaRecord {
    fn line(&self) -> String {
        let written = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.4}"));
        let supersampled = written(self.supersampled_rms);
        let [engine, one_sample] = [0, 1].map(|picture| written(self.beyond_rms.map(|rms| rms[picture])));
        let beyond =
            self.beyond_rms.map_or("-".into(), |[engine, one_sample]| format!("{:.3}", engine / one_sample));
        format!(
            "{:<14} {:>10.4} {:>10.4} {:>7.3} {supersampled:>10} {engine:>10} {one_sample:>10} {beyond:>7} {:>7.1} %",
            self.area,
            self.engine_rms,
            self.one_sample_rms,
            self.ratio,
            100.0 * self.visible_share
        )
    }
}

/// One flight over one database.
fn fly(args: &FlickerArgs, area: &Area) -> Result<AreaRecord> {
    let poses = slow_flight(args, area)?;
    let farm = args.common.farm()?;
    let options = RenderOptions::default();

    let shoot = |number: usize| -> Result<Shots> {
        let camera = Camera::new(poses[number], args.size.width, args.size.height);
        let exact = one_sample(&area.source, &camera, &options, 0..camera.width, &farm)?;
        let engine = engine::render(&area.source, &camera, &args.common.judged(), &farm)?;
        let mut pictures = vec![exact_codes(&engine.colour), exact_codes(&exact.colour)];
        if let Some(side) = args.samples {
            pictures.push(exact_codes(
                &supersampled(&area.source, &camera, &options, 0..camera.width, &farm, side)?.colour,
            ));
        }
        let shots = Shots { camera, range: exact.range, pictures };
        args.output.as_deref().map_or(Ok(()), |folder| shots.write(folder, &area.name, number))?;
        Ok(shots)
    };

    let mut before = shoot(0)?;
    let mut sums = Sums::default();
    let mut pairs = Vec::new();
    for number in 1..poses.len() {
        let after = shoot(number)?;
        let residuals = residuals(&before, &after);
        pairs.push(residuals.raw[..before.pictures.len()].iter().map(Residual::rms).collect());
        sums.add(&residuals);
        before = after;
    }

    let pixels = args.size.width as usize * args.size.height as usize * (poses.len() - 1);
    Ok(AreaRecord {
        area: area.name.clone(),
        first: poses[0].into(),
        engine_rms: sums.raw[0].rms(),
        one_sample_rms: sums.raw[1].rms(),
        supersampled_rms: args.samples.map(|_| sums.raw[TRUTH].rms()),
        beyond_rms: args.samples.map(|_| [0, 1].map(|picture| sums.beyond[picture].rms())),
        ratio: sums.raw[0].rms() / sums.raw[1].rms(),
        visible_share: sums.raw[0].count as f64 / pixels as f64,
        pairs_rms: pairs,
    })
}

/// Poses of a straight flight at one height, nowhere nearer to the ground than at its start.
fn slow_flight(args: &FlickerArgs, area: &Area) -> Result<Vec<Pose>> {
    let start = low_flight(&area.source, 1, args.common.seed)?[0];
    let (sin_yaw, cos_yaw) = start.attitude.yaw.to_radians().sin_cos();
    let step = DVec2::new(sin_yaw, cos_yaw) * args.speed * area.source.header().grid.spacing;
    let places: Vec<DVec2> =
        (0..args.frames).map(|frame| start.eye.truncate() + step * f64::from(frame)).collect();
    let grounds: Vec<f64> = places
        .iter()
        .map(|&place| Ok(ground_height(&area.source, place)?.unwrap_or(f64::NEG_INFINITY)))
        .collect::<Result<_>>()?;
    let highest = grounds.iter().fold(f64::NEG_INFINITY, |high, &ground| high.max(ground));
    let Some(&first) = grounds.first() else {
        return Err(Error::Configuration("--frames must be at least 2".into()));
    };
    let height = start.eye.z + (highest - first);
    Ok(places.into_iter().map(|place| Pose { eye: place.extend(height), ..start }).collect())
}

impl Shots {
    fn write(&self, folder: &Path, name: &str, number: usize) -> Result<()> {
        for (kind, picture) in ["engine", "one-sample", "supersampled"].iter().zip(&self.pictures) {
            let file = folder.join(format!("{name}-{kind}-{number:04}.png"));
            let rgb: Vec<u8> =
                picture.iter().flat_map(|codes| codes.to_array().map(|code| code.round() as u8)).collect();
            crate::measure::write_png(&file, &rgb, [self.camera.width, self.camera.height])?;
        }
        Ok(())
    }

    /// The four pixels around a screen position, and the position between them; `None` at the edge.
    fn around(&self, at: DVec2) -> Option<([usize; 4], f32, f32)> {
        let (width, height) = (self.camera.width as usize, self.camera.height as usize);
        let corner = at - 0.5;
        let within = corner.x >= 0.0
            && corner.y >= 0.0
            && corner.x < (width - 1) as f64
            && corner.y < (height - 1) as f64;
        if !within {
            return None;
        }
        let first = corner.y as usize * width + corner.x as usize;
        let fraction = corner.fract();
        Some(([first, first + 1, first + width, first + width + 1], fraction.x as f32, fraction.y as f32))
    }
}

/// Codes of a picture from those of four pixels, bilinear.
fn between([a, b, c, d]: [Vec3; 4], u: f32, v: f32) -> Vec3 {
    a.lerp(b, u).lerp(c.lerp(d, u), v)
}

impl Sums {
    fn add(&mut self, other: &Self) {
        let pairs = self.raw.iter_mut().zip(&other.raw).chain(self.beyond.iter_mut().zip(&other.beyond));
        for (sum, residual) in pairs {
            sum.squares += residual.squares;
            sum.count += residual.count;
        }
    }
}

impl Residual {
    fn add(&mut self, residual: Vec3) {
        self.squares += f64::from(residual.length_squared());
        self.count += 1;
    }

    fn rms(&self) -> f64 {
        (self.squares / (3 * self.count).max(1) as f64).sqrt()
    }
}

/// Residuals of each picture between two frames.
fn residuals(before: &Shots, after: &Shots) -> Sums {
    let mut residuals = Sums::default();
    let camera = &before.camera;
    for (pixel, &range) in before.range.iter().enumerate().filter(|(_, range)| range.is_finite()) {
        let (column, row) = (pixel % camera.width as usize, pixel / camera.width as usize);
        let direction = camera.direction(column as f64 + 0.5, row as f64 + 0.5);
        let point: DVec3 = camera.pose.eye + direction * f64::from(range);
        let Some(at) = after.camera.screen_from_world(point) else { continue };
        let Some((four, u, v)) = after.around(at) else { continue };
        let distance = point.distance(after.camera.pose.eye);
        let is_same =
            |&pixel: &usize| (f64::from(after.range[pixel]) - distance).abs() <= SAME_GROUND * distance;
        if !four.iter().all(is_same) {
            continue;
        }

        let residual = |picture: usize, code: fn(Vec3) -> Vec3| {
            let there = between(four.map(|pixel| code(after.pictures[picture][pixel])), u, v);
            code(before.pictures[picture][pixel]) - there
        };
        for (picture, sum) in residuals.raw[..before.pictures.len()].iter_mut().enumerate() {
            sum.add(residual(picture, Vec3::round));
        }

        if before.pictures.len() > TRUTH {
            let exact = |codes| codes;
            let truth = residual(TRUTH, exact);
            for (picture, sum) in residuals.beyond.iter_mut().enumerate() {
                sum.add(residual(picture, exact) - truth);
            }
        }
    }

    residuals
}
