//! `hedgehop plan`: what a flight needs of a database and of the machine, without flying it.

mod levels;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Serialize;

use crate::args::{self, Overlap, Workers};
use crate::bound_flight::{BoundFlight, FilmRequest};
use crate::commands::farm::cost_samples;
use crate::commands::render::{RenderArgs, survey};
use crate::database::{CacheArgs, DatabaseName};
use crate::exit::{self, Failure, Outcome};
use crate::farm::cost::{CostModel, CostPrediction};
use crate::interrupt::Interrupt;
use crate::memory::{self, Frames, Memory, amount};
use crate::page_list;
use crate::product::Product;
use crate::progress::{Mode, Reporter};
use crate::scene::{self, SceneArgs};
use crate::traffic::{self, Traffic};
use crate::view::{FlightArgs, LookArgs};
use hedgehop::encode::{FramePattern, FrameSet};
use hedgehop::flight::FrameRate;
use hedgehop::memory::{LOOKAHEAD, PageFile, PagePlan};
use hedgehop::render::{Engine, FlightPlan, NumberedCamera, RenderOptions, Renderer};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{PageId, PageSource};
use hedgehop::{Error, Result};
use levels::{LevelNeeds, levels};

const EXAMPLE: &str = "\
Examples:
  hedgehop plan area.hop --path track.gpx
  hedgehop plan area.hop --path track.csv --size 1920x1080 --fps 60 --traffic pages.svg
  hedgehop plan area.hop --path track.csv --json";

const MIB: u64 = 1 << 20;

/// Time for which the disk is measured.
const TIMED: Duration = Duration::from_secs(1);

/// Say what a flight needs: pages, memory, disk, the ground about its path; and whether this machine can do it.
///
/// Nothing is rendered without --times. Pages are planned as `render` does it, from bounds of coarse voxels: some that are counted will not be touched,
/// none is touched that is not counted.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct PlanArgs {
    /// Database to fly through
    #[arg(value_name = "AREA.hop")]
    area: DatabaseName,

    /// Frames per second: 30, 29.97, 24000/1001
    #[arg(long, value_name = "RATE", default_value = "30")]
    fps: FrameRate,

    /// Frames to plan: 1-10,20,30-40:2 [default: all]
    #[arg(long, value_name = "LIST", value_parser = FrameSet::parse)]
    frames: Option<FrameSet>,

    /// Print one JSON object, with the needs of every frame
    #[arg(long)]
    json: bool,

    /// Draw a map of the pages by the first frame that needs them
    #[arg(long, value_name = "MAP.svg")]
    traffic: Option<PathBuf>,

    /// Write which bytes of the database the flight needs, as a table: for a copy that holds no more
    #[arg(long, value_name = "LIST.csv")]
    page_list: Option<PathBuf>,

    /// Say what becomes of the flight with so much memory, as `render --memory`: bytes with suffix K, M or G
    #[arg(long, value_name = "BYTES", value_parser = args::bytes)]
    memory: Option<u64>,

    /// Render a few frames to predict how long each takes on this machine, as a PNG
    #[arg(long)]
    times: bool,

    /// Do not read from the disk to see how fast it is; that of a database behind a URL is never read
    #[arg(long)]
    no_timing: bool,

    #[command(flatten)]
    workers: Workers,

    #[command(flatten)]
    overlap: Overlap,

    #[command(flatten)]
    flight: FlightArgs,

    #[command(flatten)]
    look: LookArgs,

    #[command(flatten)]
    scene: SceneArgs,

    #[command(flatten)]
    cache: CacheArgs,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

/// Resources of this machine.
#[derive(Debug, Serialize)]
struct Machine {
    /// Memory that a program may take, bytes; null where the system does not say.
    memory_bytes: Option<u64>,
    /// Speed of the disk with this flight's pages, bytes per second; null if it was not timed.
    disk_bytes_per_s: Option<f64>,
}

/// The whole answer.
#[derive(Debug, Serialize)]
struct PlanReport {
    area: String,
    frames: u64,
    fps: String,
    size: [u32; 2],
    /// Frames whose pages are not known: the reference marcher renders them.
    frames_by_reference: u64,
    /// The most that one frame needs.
    view_bytes_most: u64,
    /// The most that a frame and the 30 after it need together.
    ahead_bytes_most: u64,
    /// All that some frame needs.
    flight_bytes: u64,
    /// Bytes that must be read before the first frame.
    first_frame_bytes: u64,
    /// Bytes that must be read later if all is kept, and if only what is known to be needed is.
    later_bytes: u64,
    later_bytes_least_memory: u64,
    /// The most that a second of the flight reads with the least memory, bytes.
    second_bytes_most: u64,
    /// `--memory` that holds the fullest 30 frames, and the fullest single one.
    memory_bytes: u64,
    memory_bytes_least: u64,
    /// The `--memory` that was asked about; null if none was.
    memory_bytes_given: Option<u64>,
    levels: Vec<LevelNeeds>,
    machine: Machine,
    /// Time of all frames, as predicted, seconds; absent without --times.
    #[serde(skip_serializing_if = "Option::is_none")]
    predicted_s: Option<f64>,
    /// Model of that time; absent without --times.
    #[serde(skip_serializing_if = "Option::is_none")]
    cost: Option<CostModel>,
    /// Why this machine cannot fly it without waiting; empty if it can.
    obstacles: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    by_frame: Vec<ByFrame>,
}

/// A frame of the JSON object.
#[derive(Debug, Serialize)]
struct ByFrame {
    frame: u64,
    #[serde(flatten)]
    needs: hedgehop::memory::FrameNeeds,
    /// Time that it takes behind another, as predicted, seconds; absent without --times.
    #[serde(skip_serializing_if = "Option::is_none")]
    predicted_s: Option<f64>,
}

/// Runs the command.
pub fn run(args: &PlanArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    if let Some(map) = &args.traffic {
        let mut inputs: Vec<&Path> = vec![&args.area];
        inputs.extend(args.flight.path.as_deref());
        traffic::check(map, &inputs)?;
    }
    if let Some(list) = &args.page_list {
        let inputs = std::iter::once(&*args.area).chain(args.flight.path.as_deref());
        page_list::check(list, &inputs.collect::<Vec<_>>())?;
    }

    let scene = args.scene.read(&reporter)?;
    let file = args.cache.open(&args.area)?;
    let finish = scene.as_ref().map(|scene| scene.finish).unwrap_or_default();
    let setup = args.flight.screen.setup()?.behind_lens(finish.distortion)?;
    let choose = |count| Ok(args.frames.clone().unwrap_or_else(|| FrameSet::all(count)));
    let request = FilmRequest {
        file: &args.area,
        source: &file,
        setup: &setup,
        fps: args.fps,
        scene: scene.as_ref(),
        sun: args.look.running_sun(scene.as_ref())?,
    };
    let cameras = BoundFlight::bind(&args.flight, &request, choose, &reporter)?.cameras;

    let cameras: Vec<_> = cameras
        .into_iter()
        .map(|NumberedCamera { number, camera, sky }| {
            let is_enlarged = finish.antialias > 1;
            let camera = if is_enlarged { camera.enlarged(finish.antialias) } else { camera };
            NumberedCamera { number, camera, sky }
        })
        .collect();
    let options = args.flight.world.apply(file.header(), args.look.options(scene.as_ref(), file.header())?);
    let planned = planned(&file, &cameras, &options, &reporter)?;
    if let Some(map) = &args.traffic {
        let first_use = &planned.plan.pages();
        Traffic { header: file.header(), cameras: &cameras, first_use }.write(map)?;
    }
    if let Some(list) = &args.page_list {
        page_list::write(list, &file, &planned.plan, &cameras)?;
    }

    let farm = Farm::new(args.workers.count())?;
    let frames = Frames {
        has_objects: scene::has_objects(scene.as_ref()),
        aov_bytes: 0,
        size: setup.size,
        product: Product::Picture,
        gathered: if finish.is_developed() || finish.gathers() { finish.antialias } else { 0 },
        in_flight: farm.in_flight(args.overlap.in_flight),
        encoders: 1,
    };

    if let Some(memory) = args.memory {
        Memory::of(memory).shares(frames)?;
    }
    let times = if args.times { Some(predicted(args, &file, &reporter)?) } else { None };
    let report = report(args, &file, &cameras, &planned, frames, times)?;

    let text = if args.json {
        format!(
            "{:#}\n",
            serde_json::to_value(&report).map_err(|error| Failure::Unforeseen(error.to_string()))?
        )
    } else {
        report.text()
    };

    Ok(exit::print(&text)?)
}

/// Predicts the time of each frame.
fn predicted(args: &PlanArgs, file: &PageFile, reporter: &Reporter) -> Result<CostPrediction> {
    if !args.flight.is_sequence() {
        return Err(Error::Configuration("--times is of a flight: give --path or --views".into()));
    }
    let output = FramePattern::parse("####.png")?;
    let render = || {
        Ok(RenderArgs {
            frames: args.frames.clone(),
            workers: Workers { jobs: args.workers.jobs },
            overlap: args.overlap,
            look: args.look.clone(),
            scene: args.scene.clone(),
            cache: args.cache.clone(),
            ..RenderArgs::of_flight(args.area.clone(), output.clone(), args.fps, args.flight.clone())
        })
    };
    let survey = survey(&render()?, file, reporter)?;
    let places = cost_samples::usual_places(survey.numbers.len());
    let samples = cost_samples::take(&render, &survey, places, reporter)?.samples;
    Ok(CostPrediction::fit(&survey.numbers, &survey.loads, &samples))
}

/// A plan, and how many frames it knows nothing of.
struct Planned {
    plan: PagePlan,
    by_reference: u64,
}

fn planned(
    file: &PageFile,
    cameras: &[NumberedCamera],
    options: &RenderOptions,
    reporter: &Reporter,
) -> Result<Planned> {
    let renderer = Renderer::new(file, options);
    let mut by_reference = 0;
    for NumberedCamera { camera, .. } in cameras {
        by_reference += u64::from(renderer.engine_for(camera)? == Engine::Reference);
    }
    if by_reference == cameras.len() as u64 {
        return Err(Error::Configuration(
            "the reference marcher renders all of these frames, and what it needs is not known beforehand; plan with --screen \
             planar, cylindrical, equirectangular or fisheye, without --tile-world and --surface blocks"
                .into(),
        ));
    }
    let farm = Farm::new(1)?;
    let planner = FlightPlan::new(&renderer, &farm, cameras);
    let plan = PagePlan::new(file, cameras.len() as u32, &planner, reporter)?;
    Ok(Planned { plan, by_reference })
}

fn report(
    args: &PlanArgs,
    file: &PageFile,
    cameras: &[NumberedCamera],
    Planned { plan, by_reference }: &Planned,
    frames: Frames,
    times: Option<CostPrediction>,
) -> Result<PlanReport> {
    let most =
        |of: &dyn Fn(&hedgehop::memory::FrameNeeds) -> u64| plan.frames.iter().map(of).max().unwrap_or(0);
    let later =
        |of: &dyn Fn(&hedgehop::memory::FrameNeeds) -> u64| plan.frames.iter().skip(1).map(of).sum::<u64>();
    let (view, ahead) = (most(&|needs| needs.bytes), most(&|needs| needs.ahead_bytes));
    let first_frame_bytes = plan.frames.first().map_or(0, |needs| needs.first_bytes);
    let second = args.fps.per_second().ceil() as usize;
    let pages: Vec<PageId> = plan.pages().iter().map(|(id, _)| *id).collect();
    let disk =
        if args.no_timing || args.area.is_remote() { None } else { Some(file.time_reading(&pages, TIMED)?) };

    let mut report = PlanReport {
        area: args.area.display().to_string(),
        frames: cameras.len() as u64,
        fps: args.fps.to_string(),
        size: [frames.size.width, frames.size.height],
        frames_by_reference: *by_reference,
        view_bytes_most: view,
        ahead_bytes_most: ahead,
        flight_bytes: first_frame_bytes + later(&|needs| needs.first_bytes),
        first_frame_bytes,
        later_bytes: later(&|needs| needs.first_bytes),
        later_bytes_least_memory: later(&|needs| needs.read_bytes),
        second_bytes_most: plan.read_within(second),
        memory_bytes: frames.memory_for(ahead),
        memory_bytes_least: frames.memory_for(view),
        memory_bytes_given: args.memory,
        levels: levels(file, cameras, &pages),
        machine: Machine {
            memory_bytes: memory::available(),
            disk_bytes_per_s: disk.map(|(bytes, time)| bytes as f64 / time.as_secs_f64().max(1e-9)),
        },
        predicted_s: times.as_ref().map(|times| times.frames.iter().sum()),
        cost: times.as_ref().map(|times| times.model.clone()),
        obstacles: Vec::new(),
        by_frame: Vec::new(),
    };

    report.obstacles = report.obstacles();
    if args.json {
        let frames = cameras.iter().zip(&plan.frames).enumerate();
        report.by_frame = frames
            .map(|(index, (seen, needs))| ByFrame {
                frame: seen.number,
                needs: *needs,
                predicted_s: times.as_ref().and_then(|times| times.frames.get(index).copied()),
            })
            .collect();
    }

    Ok(report)
}

impl PlanReport {
    fn obstacles(&self) -> Vec<String> {
        let mut obstacles = Vec::new();
        let wanted = self.memory_bytes_given.map_or(self.memory_bytes, |given| given.min(self.memory_bytes));
        if let Some(given) = self.memory_bytes_given.filter(|given| *given < self.memory_bytes_least) {
            obstacles.push(format!(
                "all pages that may be visible in the fullest frame do not fit into --memory {}: it may wait, or meet demand misses; \
                 give {}M, or a smaller --size",
                amount(given),
                mib_up(self.memory_bytes_least)
            ));
        }

        if let Some(free) = self.machine.memory_bytes
            && free < wanted
        {
            obstacles.push(format!(
                "it needs {} of memory and {} is free: a smaller --size, or frames will wait for the disk",
                amount(wanted),
                amount(free)
            ));
        }

        if let Some(rate) = self.machine.disk_bytes_per_s
            && rate < self.second_bytes_most as f64
        {
            obstacles.push(format!(
                "it reads up to {}/s and the disk gives {}/s: copy the database to a faster disk, fly slower, or render without a clock",
                amount(self.second_bytes_most),
                amount(rate as u64)
            ));
        }

        obstacles
    }

    fn text(&self) -> String {
        let mut text = format!(
            "{}: {} frames of {}x{} at {} frames/s\n",
            self.area, self.frames, self.size[0], self.size[1], self.fps
        );
        let mut line = |name: &str, value: String| {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "  {name:<11} {value}");
        };

        if self.frames_by_reference > 0 {
            line(
                "not known",
                format!("{} frames: the reference marcher renders them", self.frames_by_reference),
            );
        }

        line("one view", format!("up to {}", amount(self.view_bytes_most)));
        line("with ahead", format!("up to {} for {LOOKAHEAD} frames more", amount(self.ahead_bytes_most)));
        line("the flight", format!("{} in all", amount(self.flight_bytes)));

        line(
            "memory",
            format!(
                "--memory {}M looks {LOOKAHEAD} frames ahead, {}M holds all pages that may be visible in the fullest frame",
                mib_up(self.memory_bytes),
                mib_up(self.memory_bytes_least)
            ),
        );

        line(
            "disk",
            format!(
                "{} before the first frame, then {} in all; with the least memory {}, up to {} in a second",
                amount(self.first_frame_bytes),
                amount(self.later_bytes),
                amount(self.later_bytes_least_memory),
                amount(self.second_bytes_most)
            ),
        );

        if let Some(given) = self.memory_bytes_given {
            let holds = if given >= self.memory_bytes {
                format!("holds {LOOKAHEAD} frames ahead")
            } else if given >= self.memory_bytes_least {
                format!("holds every frame, but not always {LOOKAHEAD} ahead")
            } else {
                "does not hold the fullest frame".into()
            };
            line("given", format!("--memory {} {holds}", amount(given)));
        }

        for level in self.levels.iter().filter(|level| level.pages > 0) {
            line(
                &format!("level {}", level.level),
                format!(
                    "{} pages, {} of {}, {:.1} km², up to {:.1} km from the path",
                    level.pages,
                    amount(level.bytes),
                    amount(level.bytes_stored),
                    level.area_km2,
                    level.reach_m / 1000.0
                ),
            );
        }

        if let (Some(seconds), Some(cost)) = (self.predicted_s, &self.cost) {
            line("time", format!("{seconds:.1} s in one process{}", cost.errors_told()));
        }

        let machine = [
            self.machine.memory_bytes.map(|free| format!("{} of memory free", amount(free))),
            self.machine
                .disk_bytes_per_s
                .map(|rate| format!("reads {}/s of these pages", amount(rate as u64))),
        ];
        line("this machine", machine.into_iter().flatten().collect::<Vec<_>>().join(", "));
        match self.obstacles.as_slice() {
            [] => line("verdict", "can do it".into()),
            obstacles => obstacles.iter().for_each(|obstacle| line("verdict", obstacle.clone())),
        }

        text
    }
}

fn mib_up(bytes: u64) -> u64 {
    bytes.div_ceil(MIB)
}
