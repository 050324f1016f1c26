//! Ranges of the renderer against exact intersection with the level-1 surface, at random pixels of random poses.
//!
//! ```text
//! for each pose:  frame = renderer under test
//!     for each random pixel:  exact = first contact with level 1 through the pixel's centre
//!         one sees ground and the other sky → a disagreement
//!         both see ground                   → relative error |range − exact| / exact
//! ```
//!
//! An eye that is under the surface of a coarser level sees range 0; that is an error of 1 like any other.

use std::path::PathBuf;
use std::time::Instant;

use serde::Serialize;

use crate::args::{self, Area, Common};
use crate::engine;
use crate::exact::ExactEye;
use crate::random::Random;
use crate::report::{self, PoseRecord};
use crate::views::any_flight;
use hedgehop::raymarch::scan::Upright;
use hedgehop::render::RenderOptions;
use hedgehop::sensor::VisualSensor;
use hedgehop::sensor::radiance::Radiance;
use hedgehop::space::{Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::{Error, Result, Size};

/// Bounds that are asked for: median, 99 %, 99.6 % of the relative errors; share of disagreements.
const BOUNDS: [f64; 4] = [1.5e-4, 3.0e-3, 1.0e-2, 1.0e-3];

/// Compare ranges with exact intersection of the level-1 surface.
///
/// Poses are 0.5 to 2000 units above ground, any yaw, pitch -90 to 30 and any roll (every fifth pose level), with
/// fields of view from 20 to 110 degrees. The same seed gives the same poses and pixels.
#[derive(Debug, clap::Args)]
pub struct TruthArgs {
    /// Database
    #[arg(value_name = "AREA.hop")]
    area: PathBuf,

    /// Random poses
    #[arg(long, value_name = "N", default_value_t = 50)]
    poses: usize,

    /// Random pixels in each pose
    #[arg(long, value_name = "N", default_value_t = 2000)]
    pixels: usize,

    /// Picture size, pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1920x1080", value_parser = args::size)]
    size: Size,

    /// Number of the worst pixels to list
    #[arg(long, value_name = "N", default_value_t = 10)]
    worst: usize,

    /// Only this pose, counted from 0
    #[arg(long, value_name = "POSE")]
    only: Option<usize>,

    /// Only this pixel of that pose
    #[arg(long, value_name = "COLUMN,ROW", value_parser = args::pixel, requires = "only")]
    pixel: Option<[u32; 2]>,

    #[command(flatten)]
    common: Common,
}

/// One pixel compared. Ranges in metres; JSON has none for the sky.
#[derive(Debug, Clone, Copy, Serialize)]
struct Comparison {
    pose: usize,
    pixel: [u32; 2],
    range: f64,
    exact: f64,
}

/// Figures of a set of pixels.
#[derive(Debug, Clone, Copy, Serialize)]
struct Figures {
    pixels: usize,
    both_ground: usize,
    median: f64,
    p99: f64,
    p996: f64,
    largest: f64,
    disagreements: usize,
}

#[derive(Debug, Serialize)]
struct PoseFigures {
    pose: usize,
    view: PoseRecord,
    figures: Figures,
    render_s: f64,
    exact_s: f64,
}

#[derive(Debug, Serialize)]
struct MeasuredTruth {
    area: String,
    size_px: [u32; 2],
    seed: u64,
    bounds: [f64; 4],
    all: Figures,
    level_flight: Figures,
    upright: Figures,
    upright_poses: usize,
    within_bounds: bool,
    poses: Vec<PoseFigures>,
    worst: Vec<Comparison>,
}

impl Comparison {
    /// Relative error where both see ground.
    fn error(&self) -> Option<f64> {
        let both = self.range.is_finite() && self.exact.is_finite();
        let difference = (self.range - self.exact).abs();
        both.then(|| if difference == 0.0 { 0.0 } else { difference / self.exact })
    }

    /// Returns the key to sort by: disagreements are worst.
    fn badness(&self) -> f64 {
        let agree_on_sky = self.range.is_infinite() && self.exact.is_infinite();
        self.error().unwrap_or(if agree_on_sky { 0.0 } else { f64::INFINITY })
    }
}

impl Figures {
    fn of<'a>(pixels: impl Iterator<Item = &'a Comparison>) -> Self {
        let (mut errors, mut count, mut disagreements) = (Vec::new(), 0, 0);
        for pixel in pixels {
            count += 1;
            errors.extend(pixel.error());
            disagreements += usize::from(pixel.range.is_finite() != pixel.exact.is_finite());
        }

        errors.sort_unstable_by(f64::total_cmp);
        let quantile = |share: f64| {
            let last = errors.len().saturating_sub(1);
            errors.get((share * last as f64).ceil() as usize).copied().unwrap_or(0.0)
        };

        Self {
            pixels: count,
            both_ground: errors.len(),
            median: quantile(0.5),
            p99: quantile(0.99),
            p996: quantile(0.996),
            largest: quantile(1.0),
            disagreements,
        }
    }

    fn disagreement(&self) -> f64 {
        self.disagreements as f64 / self.pixels.max(1) as f64
    }

    fn within_bounds(&self) -> bool {
        let found = [self.median, self.p99, self.p996, self.disagreement()];
        found.iter().zip(BOUNDS).all(|(found, bound)| *found <= bound)
    }

    fn columns(&self) -> String {
        format!(
            "{:>8} {:>9.2e} {:>9.2e} {:>9.2e} {:>9.2e} {:>7.3} %",
            self.both_ground,
            self.median,
            self.p99,
            self.p996,
            self.largest,
            100.0 * self.disagreement()
        )
    }
}

/// Runs the mode.
pub fn run(args: &TruthArgs) -> Result<()> {
    let area = Area::open(&args.area)?;
    let farm = args.common.farm()?;
    let poses = any_flight(&area.source, args.poses, args.common.seed)?;
    if args.only.is_some_and(|only| only >= poses.len()) {
        return Err(Error::Configuration(format!("--only counts poses from 0 to {}", poses.len() - 1)));
    }

    let (mut compared, mut per_pose) = (Vec::new(), Vec::new());
    report::line(&format!(
        "{:>5} {:>8} {:>6} {:>7} {:>6} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9}",
        "pose",
        "eye z m",
        "pitch",
        "roll",
        "hfov",
        "ground",
        "median",
        "99 %",
        "99.6 %",
        "largest",
        "sky differs"
    ));

    for (index, pose) in
        poses.iter().enumerate().filter(|(index, _)| args.only.is_none_or(|only| only == *index))
    {
        let (pixels, figures) = compare(args, &area, &farm, index, *pose)?;
        report::line(&figures.line());
        compared.extend(pixels);
        per_pose.push(figures);
    }

    finish(args, &area, &poses, compared, per_pose)
}

/// All pixels of one pose.
fn compare(
    args: &TruthArgs,
    area: &Area,
    farm: &Farm,
    index: usize,
    pose: Pose,
) -> Result<(Vec<Comparison>, PoseFigures)> {
    let camera = Camera::new(pose, args.size.width, args.size.height);
    let options = RenderOptions::default();
    let begun = Instant::now();
    let frame = engine::render(&area.source, &camera, &args.common.judged(), farm)?;
    let rendered = Instant::now();
    let mut random = Random::new(args.common.seed ^ (index as u64 + 1).rotate_left(32));
    let mut chosen = || {
        let side = |share: f64, side: u32| (share * f64::from(side)) as u32;
        [side(random.unit(), camera.width), side(random.unit(), camera.height)]
    };
    let pixels: Vec<[u32; 2]> = match args.pixel {
        Some([column, row]) if column < camera.width && row < camera.height => vec![[column, row]],
        Some(_) => return Err(Error::Configuration("--pixel lies outside of the picture".into())),
        None => (0..args.pixels).map(|_| chosen()).collect(),
    };
    let radiance = Radiance::new(VisualSensor::new(options.sun));
    let mut eye = ExactEye::new(&area.source, &radiance, &camera, &options);

    let compared: Vec<Comparison> = pixels
        .into_iter()
        .map(|pixel| {
            let [column, row] = pixel;
            let range = f64::from(frame.range[row as usize * camera.width as usize + column as usize]);
            let exact = eye.range(f64::from(column) + 0.5, f64::from(row) + 0.5)?;
            Ok(Comparison { pose: index, pixel, range, exact })
        })
        .collect::<Result<_>>()?;

    let figures = PoseFigures {
        pose: index,
        view: pose.into(),
        figures: Figures::of(compared.iter()),
        render_s: (rendered - begun).as_secs_f64(),
        exact_s: rendered.elapsed().as_secs_f64(),
    };

    Ok((compared, figures))
}

impl PoseFigures {
    fn line(&self) -> String {
        let [_, pitch, roll] = self.view.yaw_pitch_roll_deg;
        format!(
            "{:>5} {:>8.1} {:>6.1} {:>7.1} {:>6.1} {}",
            self.pose,
            self.view.eye_m[2],
            pitch,
            roll,
            self.view.hfov_deg,
            self.figures.columns()
        )
    }
}

/// Totals, the worst pixels, JSON.
fn finish(
    args: &TruthArgs,
    area: &Area,
    poses: &[Pose],
    mut compared: Vec<Comparison>,
    per_pose: Vec<PoseFigures>,
) -> Result<()> {
    let is_level = |pixel: &&Comparison| {
        let attitude = poses[pixel.pose].attitude;
        attitude.pitch == 0.0 && attitude.roll == 0.0
    };
    let all = Figures::of(compared.iter());
    let level_flight = Figures::of(compared.iter().filter(is_level));

    // Steep poses are seen by planes around the eye, in finer steps.
    let is_upright: Vec<bool> = poses
        .iter()
        .map(|pose| Upright::new(&Camera::new(*pose, args.size.width, args.size.height)).is_some())
        .collect();
    let upright = Figures::of(compared.iter().filter(|pixel| is_upright[pixel.pose]));
    let upright_poses = per_pose.iter().filter(|figures| is_upright[figures.pose]).count();
    let within_bounds = all.within_bounds();
    report::line(&format!("{:<36} {}", "all", all.columns()));
    report::line(&format!("{:<36} {}", "level flight", level_flight.columns()));
    let title = format!("planes of the screen ({upright_poses} poses)");
    report::line(&format!("{title:<36} {}", upright.columns()));
    let verdict = if within_bounds { "within" } else { "NOT within" };

    report::line(&format!(
        "{verdict} the bounds: median {:e}, 99 % {:e}, 99.6 % {:e}, sky {} %",
        BOUNDS[0],
        BOUNDS[1],
        BOUNDS[2],
        100.0 * BOUNDS[3]
    ));

    compared.sort_by(|a, b| b.badness().total_cmp(&a.badness()));
    compared.truncate(args.worst);
    for Comparison { pose, pixel: [column, row], range, exact } in &compared {
        report::line(&format!(
            "worst: range {range:.4} m, exact {exact:.4} m; replay with --seed {} --size {}x{} --poses {} --only {pose} --pixel {column},{row}",
            args.common.seed, args.size.width, args.size.height, args.poses
        ));
    }

    let measured = MeasuredTruth {
        area: area.name.clone(),
        size_px: [args.size.width, args.size.height],
        seed: args.common.seed,
        bounds: BOUNDS,
        all,
        level_flight,
        upright,
        upright_poses,
        within_bounds,
        poses: per_pose,
        worst: compared,
    };

    report::json(args.common.json.as_deref(), &measured)
}
