//! `hedgehop farm submit`: cuts a flight into chunks and hands them to a scheduler.

use std::path::{Path, PathBuf};

use super::cost_samples;
use super::handing_out::{HandOutArgs, Handing, check_engine, hand_out};
use super::request;
use crate::args::absolute;
use crate::commands::render::{self, RenderArgs, Survey};
use crate::exit::Outcome;
use crate::farm::chunks::cut;
use crate::farm::cost::CostPrediction;
use crate::farm::job::{FarmChunk, FarmJob, LAYOUT, PageCheck, ProgramRecord};
use crate::farm::scheduler::Scheduler;
use crate::frame_ranges::ranges;
use crate::interrupt::Interrupt;
use crate::memory::Late;
use crate::pictures;
use crate::playback::duration;
use crate::progress::{Mode, Reporter};
use hedgehop::encode::sidecar::Manifest;
use hedgehop::encode::{FramePattern, Target};
use hedgehop::progress::Observer;
use hedgehop::render::Engine;
use hedgehop::{Error, Result};

/// Databases of up to so many bytes are checked whole by each worker, unless the user says otherwise.
const CHECKED_WHOLE: u64 = 1 << 30;
/// Chunks for each process, where their number is known: what one takes longer than another then matters little.
const CHUNKS_A_PROCESS: usize = 4;

/// Cut a flight into chunks of equal predicted cost and hand them to a scheduler.
///
/// The flags of `render` stand behind `--`, or in a TOML file with a key for each: area, path, output, size and so on. A few frames are rendered first to see what frames cost.
#[derive(Debug, clap::Args)]
#[command(after_help = super::EXAMPLE)]
pub struct SubmitArgs {
    /// File with the flags of `render`; names in it count from its folder
    #[arg(value_name = "JOB.toml")]
    request: Option<PathBuf>,

    /// Scheduler that hands out the chunks
    #[arg(long, value_enum, value_name = "ENGINE")]
    engine: Scheduler,

    #[command(flatten)]
    hand_out: HandOutArgs,

    /// Folder of the job, which must not hold one yet [default: that of the frames, with .job behind its name]
    #[arg(long, value_name = "FRAMES.job")]
    job: Option<PathBuf>,

    /// Number of chunks [default: as many as --chunk-time asks for, and at least four for each process]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    chunks: Option<u32>,

    /// Time that a chunk is to take, predicted: 90s, 5min
    #[arg(long, value_name = "TIME", value_parser = chunk_time, default_value = "60s", conflicts_with = "chunks")]
    chunk_time: f64,

    /// Places of the flight where sample frames are rendered; 0: chunks have equal counts of frames [default: 9 to 40, one for 40 frames]
    #[arg(long, value_name = "N")]
    samples: Option<usize>,

    /// Pages of the database that each worker checks before its first frame: whole, or planned, those that its frames may touch
    /// [default: whole up to 1 GiB]
    #[arg(long, value_enum, value_name = "PAGES")]
    check: Option<PageCheck>,

    /// Contact sheet to make once all frames are there
    #[arg(long, value_name = "SHEET.png")]
    contact_sheet: Option<PathBuf>,

    /// Print what would be submitted, and write nothing
    #[arg(long)]
    dry_run: bool,

    /// Write the job and print its commands, but do not run them
    #[arg(long, conflicts_with = "dry_run")]
    prepare: bool,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,

    /// Flags of `render`
    #[arg(last = true, value_name = "RENDER FLAGS")]
    flags: Vec<String>,
}

/// Time that a chunk is to take, seconds.
fn chunk_time(text: &str) -> Result<f64, String> {
    duration(text).map_err(|_| "want how long a chunk is to take, such as 90s or 5min".into())
}

/// Runs the command.
pub fn run(args: &SubmitArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    let names = SubmitNames::of(args)?;
    let flags = flags(args)?;
    let render_args = || request::parse(&flags, "the flags of render");
    let asked = render_args()?;
    let pattern = check(&asked)?;
    let place = place(args, &names, pattern)?;
    if let Some(sheet) = &names.contact_sheet {
        pictures::check_png(sheet, "a contact sheet")?;
    }

    if args.engine == Scheduler::Slurm && here()?.join(&place).to_string_lossy().contains('\\') {
        let what = "Slurm drops backslashes from names of files; give a --job without, in a folder without";
        return Err(Error::Configuration(format!("{}: {what}", place.display())).into());
    }
    let handing = match (args.dry_run, args.prepare) {
        (true, _) => Handing::Printed,
        (false, true) => Handing::Written,
        (false, false) => Handing::Run,
    };
    if handing == Handing::Run {
        check_engine(args.engine)?;
    }
    if handing != Handing::Printed {
        FarmJob::check_free(&place)?;
    }

    let file = asked.cache.open_trusting(&asked.area, asked.trust.trust())?;
    let survey = render::survey(&asked, &file, &reporter)?;
    let places = args.samples.unwrap_or_else(|| cost_samples::usual_places(survey.numbers.len()));
    let cores = args.hand_out.cores(asked.workers.jobs);
    let of_worker = || {
        let mut args = render_args()?;
        args.workers.jobs = Some(cores);
        Ok(args)
    };
    let sampled = cost_samples::take(&of_worker, &survey, places, &reporter)?;
    let prediction = match places {
        0 => CostPrediction::equal(survey.numbers.len()),
        _ => CostPrediction::fit(&survey.numbers, &survey.loads, &sampled.samples),
    };

    check_folder(&asked, pattern, &sampled.made_of)?;

    // All of a database behind a URL would have to be fetched.
    let is_whole = file.file_length() <= CHECKED_WHOLE && !asked.area.is_remote();
    let simd =
        (asked.instructions.engine() == Engine::Planes).then(|| asked.instructions.isa().name().into());
    let job = FarmJob {
        layout: LAYOUT,
        program: ProgramRecord::own()?,
        folder: here()?,
        place: place.clone(),
        flags: flags.clone(),
        simd,
        frames_folder: pattern.folder().map(Path::to_owned).unwrap_or_default(),
        contact_sheet: names.contact_sheet.clone(),
        check: args.check.unwrap_or(if is_whole { PageCheck::Whole } else { PageCheck::Planned }),
        made_of: sampled.made_of,
        cores,
        chunks: chunks(args, cores, &survey, &prediction),
        cost: prediction.model,
    };

    reporter.note(&told(&job, places > 0));
    if handing != Handing::Printed {
        job.write(&place)?;
    }
    let numbers = (1..=job.chunks.len() as u64).collect();
    let tasks = args.hand_out.tasks(numbers, cores, asked.memory.bytes())?;
    hand_out(args.engine, tasks, &job, &place, handing, &reporter)
}

/// Collects the flags of `render`; names then count from this folder.
fn flags(args: &SubmitArgs) -> Result<Vec<String>> {
    let Some(path) = &args.request else {
        if args.flags.is_empty() {
            let what = "name a file with the flags of render, or give them behind --: \
                        hedgehop farm submit --engine local -- area.hop --path track.gpx -o frames/####.png";
            return Err(Error::Configuration(what.into()));
        }
        return Ok(args.flags.clone());
    };

    let mut flags = request::read(path)?;
    request::parse(&flags, &path.display().to_string())?;
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::env::set_current_dir(folder).map_err(|error| Error::io(folder, "go into the folder", error))?;
    }
    flags.extend(args.flags.iter().cloned());
    Ok(flags)
}

/// Refuses what no farm can do; returns where frames go.
fn check(args: &RenderArgs) -> Result<&FramePattern> {
    let refuse = |what: &str| Err(Error::Configuration(format!("{what}, so that no farm can render it")));
    let pattern = match &args.output {
        Some(pattern) if pattern.target() != Target::Y4m => pattern,
        _ => {
            return Err(Error::Configuration(
                "a farm writes frames in files: give -o frames/####.png; --video makes a film of them in the end".into(),
            ));
        }
    };

    if !args.flight.is_sequence() {
        return refuse("a single picture has no frames to share out");
    }
    if args.area.has_secret() {
        return Err(Error::Configuration(format!(
            "{} was given with a password or a signature, which a job would show to all who read it; give an address without, or a copy",
            args.area.display()
        )));
    }
    if args.late == Late::Coarser {
        return refuse("pictures of --late coarser depend on how fast a machine is");
    }
    if args.trust.leaves_out_damaged() {
        return refuse("pictures of --damaged coarser depend on which pages are damaged on each machine");
    }
    if args.work.is_worker() {
        return refuse("--farm and --chunk are flags of workers");
    }
    if args.traffic.is_some() {
        return refuse("--traffic draws the pages of one process");
    }
    Ok(pattern)
}

/// Refuses a folder with frames of another render, unless these may be replaced.
fn check_folder(args: &RenderArgs, pattern: &FramePattern, made_of: &Manifest) -> Result<()> {
    let folder = pattern.folder().unwrap_or(Path::new(""));
    let Some(earlier) = Manifest::read(folder)?.filter(|_| !args.overwrite) else { return Ok(()) };
    let is_there = |file: &String| folder.join(file).is_file();
    let has_frames = earlier.frames.iter().filter_map(|frame| frame.file.as_ref()).any(is_there);
    match made_of.difference(&earlier).filter(|_| has_frames) {
        Some(what) => Err(Error::Configuration(format!(
            "{} holds frames of another render: {what}; give another folder to -o, or --overwrite",
            folder.display()
        ))),
        None => Ok(()),
    }
}

/// Returns the folder of the job.
fn place(args: &SubmitArgs, names: &SubmitNames, pattern: &FramePattern) -> Result<PathBuf> {
    if let Some(job) = &names.job {
        return Ok(job.clone());
    }
    let folder = pattern.folder().filter(|folder| !folder.as_os_str().is_empty());
    let Some(name) = folder.and_then(Path::file_name) else {
        return Err(Error::Configuration(
            "the folder of -o has no name of its own; say with --job where the job is to be kept".into(),
        ));
    };
    let mut name = name.to_owned();
    name.push(".job");
    let place = folder.unwrap_or(Path::new("")).with_file_name(name);
    // Whoever named a file elsewhere does not stand in its folder.
    if args.request.is_some() { absolute(&place) } else { Ok(place) }
}

/// Names on the command line, which count from where the user stands, also if a file's count from elsewhere.
#[derive(Debug)]
struct SubmitNames {
    job: Option<PathBuf>,
    contact_sheet: Option<PathBuf>,
}

impl SubmitNames {
    fn of(args: &SubmitArgs) -> Result<Self> {
        let here = |name: &Option<PathBuf>| match (name, &args.request) {
            (Some(name), Some(_)) => absolute(name).map(Some),
            (name, _) => Ok(name.clone()),
        };
        Ok(Self { job: here(&args.job)?, contact_sheet: here(&args.contact_sheet)? })
    }
}

/// Returns this folder.
fn here() -> Result<PathBuf> {
    std::env::current_dir().map_err(|error| Error::io(".", "tell its name", error))
}

fn chunks(args: &SubmitArgs, cores: usize, survey: &Survey, prediction: &CostPrediction) -> Vec<FarmChunk> {
    let total: f64 = prediction.frames.iter().sum();
    let count = match args.chunks {
        Some(count) => count as usize,
        None => {
            let by_time = (total / args.chunk_time).ceil() as usize;
            by_time.max(CHUNKS_A_PROCESS * args.hand_out.processes(args.engine, cores))
        }
    };
    cut(&prediction.frames, count)
        .into_iter()
        .map(|run| FarmChunk {
            frames: ranges(&survey.numbers[run.clone()]),
            count: run.len() as u64,
            predicted_s: prediction.run_s(&survey.loads, run),
        })
        .collect()
}

/// Says what the job is, in a sentence.
fn told(job: &FarmJob, is_predicted: bool) -> String {
    let count: u64 = job.chunks.iter().map(|chunk| chunk.count).sum();
    let place = job.place.display();
    if !is_predicted {
        return format!("{place}: {count} frames in {} chunks of equal counts", job.chunks.len());
    }

    let seconds = || job.chunks.iter().map(|chunk| chunk.predicted_s);
    let (total, longest) = (seconds().sum::<f64>(), seconds().fold(0.0, f64::max));
    let mean = total / job.chunks.len().max(1) as f64;
    format!(
        "{place}: {count} frames in {} chunks of {mean:.1} s, the longest {:.2} of that; {total:.0} s of one process{}",
        job.chunks.len(),
        longest / mean.max(1e-9),
        job.cost.errors_told(),
    )
}
