//! `hedgehop bench`: how fast this machine renders a path, for several numbers of workers.
//!
//! ```text
//! warm up: every frame once (pages into memory); remember the hash of each
//! repeat R times: for each worker count: every frame, timed; compare hashes
//! report medians over the repeats
//! ```
//! Worker counts are interleaved, so that a machine that slows down slows all of them.

mod frames;
mod ranges;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hedgehop::frame::atomic::write_bytes;
use hedgehop::frame::{Frame, FrameInfo, FrameRate, FrameSet, encode_frame};
use hedgehop::memory::PageFile;
use hedgehop::progress::Observer;
use hedgehop::render::{RenderOptions, StageTimes, render_frame};
use hedgehop::space::Camera;
use hedgehop::subimage::Farm;
use hedgehop::voxel::PageSource;
use hedgehop::{Error, Result};

use crate::args::{self, check_no_input};
use crate::exit::{self, Failure, Outcome};
use crate::figures::{Figures, Report};
use crate::interrupt::Interrupt;
use crate::output::WRITER;
use crate::plot;
use crate::progress::{Mode, Reporter};
use crate::view::{FlightArgs, LookArgs};

use frames::{Clocks, FrameTimes};

const EXAMPLE: &str = "\
Examples:
  hedgehop bench area.hop --path track.gpx
  hedgehop bench area.hop --path track.gpx --workers 1,2,4,8 --size 1920x1080 --json bench.json --svg bench.svg";

/// Frames of the path that are rendered if --frames does not say, spread evenly.
const DEFAULT_FRAMES: u64 = 12;

/// Measure how fast this machine renders a path.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct Args {
    /// Database to fly through
    #[arg(value_name = "AREA.hop")]
    area: PathBuf,

    /// Numbers of worker threads to measure [default: 1, 2, 4, … up to one per core]
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', value_parser = args::workers)]
    workers: Vec<usize>,

    /// Frames to render: 1-10,20,30-40:2 [default: up to 12, spread over the path]
    #[arg(long, value_name = "LIST", value_parser = FrameSet::parse)]
    frames: Option<FrameSet>,

    /// Frames per second of the path
    #[arg(long, value_name = "RATE", default_value = "30")]
    fps: FrameRate,

    /// Timed passes over the frames for each number of workers; the median counts
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeats: u32,

    /// Write the figures as JSON; - is standard output, instead of the table
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,

    /// Write a plot as SVG
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,

    /// Write the ranges of every frame N, metres along the ray, to FOLDER/range_N.f32 (raw float32, infinity = sky)
    #[arg(long, value_name = "FOLDER")]
    dump_ranges: Option<PathBuf>,

    #[command(flatten)]
    flight: FlightArgs,

    #[command(flatten)]
    look: LookArgs,

    /// How progress is told on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

/// One pass over all frames.
struct Pass {
    wall: Duration,
    encode: Duration,
    stages: StageTimes,
    hashes: Vec<blake3::Hash>,
    frames: Vec<FrameTimes>,
}

/// Runs the command.
pub fn run(args: &Args, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    let inputs: Vec<&Path> =
        std::iter::once(&args.area).chain(&args.flight.path).map(PathBuf::as_path).collect();
    for (flag, file) in [("--svg", &args.svg), ("--json", &args.json)] {
        file.iter().try_for_each(|file| check_no_input(flag, file, &inputs))?;
    }
    let source = PageFile::open(&args.area)?;
    let choose = |count| args.frames.clone().map_or_else(|| FrameSet::parse(&spread(count)), Ok);
    let cameras = args.flight.cameras(&args.area, &source, args.fps, choose, &reporter)?;
    let report = measure(args, &source, &cameras, &reporter)?;
    if let Some(file) = &args.svg {
        let svg = plot::bench(&report)
            .map_err(|error| Error::Configuration(format!("--svg: cannot draw the plot: {error}")))?;
        write_bytes(file, svg.as_bytes())?;
    }
    let json = format!("{}\n", serde_json::to_string_pretty(&report).unwrap_or_default());
    match args.json.as_deref() {
        Some(file) if file == Path::new("-") => exit::print(&json)?,
        Some(file) => {
            write_bytes(file, json.as_bytes())?;
            exit::print(&table(&report))?;
        }
        None => exit::print(&table(&report))?,
    }
    if report.identical_frames {
        Ok(())
    } else {
        Err(Failure::Unforeseen("frames differ between numbers of workers; this is a bug in hedgehop".into()))
    }
}

/// Up to [`DEFAULT_FRAMES`] of `1..=count`, evenly spread, as `--frames` takes them.
fn spread(count: u64) -> String {
    let step = count.div_ceil(DEFAULT_FRAMES).max(1);
    format!("1-{}:{step}", count.max(1))
}

/// 1, 2, 4, … and the number of cores.
fn default_workers() -> Vec<usize> {
    let cores = args::available_cores();
    let mut counts: Vec<usize> =
        std::iter::successors(Some(1_usize), |n| n.checked_mul(2)).take_while(|&n| n < cores).collect();
    counts.push(cores);
    counts
}

fn measure(args: &Args, source: &PageFile, cameras: &[(u64, Camera)], reporter: &Reporter) -> Result<Report> {
    let mut counts = if args.workers.is_empty() { default_workers() } else { args.workers.clone() };
    counts.sort_unstable();
    counts.dedup();
    let farms = counts.iter().map(|&count| Farm::new(count)).collect::<Result<Vec<_>>>()?;
    let options = args.look.options();
    let fastest =
        farms.last().ok_or_else(|| Error::Configuration("--workers: give at least one number".into()))?;

    let passes = 1 + u64::from(args.repeats) * counts.len() as u64;
    reporter.begin("bench", passes * cameras.len() as u64, "frames");
    let reference = pass(source, cameras, &options, fastest, reporter, args.dump_ranges.as_deref())?.hashes;
    let mut timed: Vec<Vec<Pass>> = counts.iter().map(|_| Vec::new()).collect();
    for _ in 0..args.repeats {
        for (farm, passes) in farms.iter().zip(&mut timed) {
            passes.push(pass(source, cameras, &options, farm, reporter, None)?);
        }
    }
    reporter.end();

    let identical_frames = timed.iter().flatten().all(|pass| pass.hashes == reference);
    let size = args.flight.size;
    let pixels = f64::from(size.width) * f64::from(size.height);
    let mut results: Vec<Figures> = counts
        .iter()
        .zip(&timed)
        .map(|(&workers, passes)| figures(workers, passes, cameras.len() as f64, pixels))
        .collect();
    set_efficiency(&mut results);
    Ok(Report {
        hedgehop: env!("CARGO_PKG_VERSION"),
        cores: args::available_cores(),
        area: args.area.display().to_string(),
        content_hash: source.header().content_hash.to_string(),
        size: [size.width, size.height],
        frames: cameras.iter().map(|(number, _)| *number).collect(),
        repeats: args.repeats,
        identical_frames,
        results,
    })
}

fn pass(
    source: &PageFile,
    cameras: &[(u64, Camera)],
    options: &RenderOptions,
    farm: &Farm,
    reporter: &Reporter,
    dump_ranges: Option<&Path>,
) -> Result<Pass> {
    let mut pass = Pass {
        wall: Duration::ZERO,
        encode: Duration::ZERO,
        stages: StageTimes::default(),
        hashes: Vec::with_capacity(cameras.len()),
        frames: Vec::with_capacity(cameras.len()),
    };
    for (number, camera) in cameras {
        if reporter.cancelled() {
            return Err(Error::Interrupted("nothing was measured".into()));
        }
        let clocks = Clocks::start();
        let rendered = render_frame(source, camera, options, farm)?;
        let (wall, cpu) = clocks.elapsed();
        pass.frames.push(FrameTimes { number: *number, wall, cpu, stages: rendered.times });
        pass.wall += wall;
        pass.stages.march += rendered.times.march;
        pass.stages.shade += rendered.times.shade;
        pass.stages.image += rendered.times.image;
        pass.encode += encode(&rendered.frame, *number)?;
        pass.hashes.push(hash(&rendered.frame));
        if let Some(folder) = dump_ranges {
            ranges::dump(folder, *number, &rendered.frame)?;
        }
        reporter.advance(1);
    }
    Ok(pass)
}

/// Time to make a PNG in memory.
fn encode(frame: &Frame, number: u64) -> Result<Duration> {
    let info = FrameInfo {
        frame: number,
        seconds: 0.0,
        database_hash: String::new(),
        database_file: String::new(),
        crs_name: String::new(),
        vertical_datum: String::new(),
        settings_digest: String::new(),
        writer: WRITER.to_owned(),
    };
    let begun = Instant::now();
    let bytes = encode_frame(Path::new("bench.png"), frame, &info)?;
    let elapsed = begun.elapsed();
    std::hint::black_box(bytes);
    Ok(elapsed)
}

/// A hash of all planes, bit by bit.
fn hash(frame: &Frame) -> blake3::Hash {
    let floats = frame.colour.iter().chain(&frame.normal).flatten().chain(&frame.range);
    let mut bytes: Vec<u8> = floats.flat_map(|value| value.to_bits().to_le_bytes()).collect();
    bytes.extend_from_slice(&frame.level);
    bytes.extend(frame.id.iter().flat_map(|id| id.to_le_bytes()));
    blake3::hash(&bytes)
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    match (values.len(), values.len() / 2) {
        (0, _) => 0.0,
        (len, middle) if len % 2 == 1 => values[middle],
        (_, middle) => 0.5 * (values[middle - 1] + values[middle]),
    }
}

fn figures(workers: usize, passes: &[Pass], frames: f64, pixels: f64) -> Figures {
    let seconds = median(passes.iter().map(|pass| pass.wall.as_secs_f64()));
    let per_frame = |time: fn(&Pass) -> Duration| {
        median(passes.iter().map(|pass| time(pass).as_secs_f64())) * 1000.0 / frames
    };
    let frames_per_s = frames / seconds;
    Figures {
        workers,
        frames_per_s,
        mpixel_per_s: frames_per_s * pixels / 1e6,
        efficiency: 1.0,
        march_ms: per_frame(|pass| pass.stages.march),
        shade_ms: per_frame(|pass| pass.stages.shade),
        image_ms: per_frame(|pass| pass.stages.image),
        encode_ms: per_frame(|pass| pass.encode),
        fastest_passes: frames::fastest(passes.iter().map(|pass| pass.frames.as_slice())),
    }
}

fn set_efficiency(results: &mut [Figures]) {
    let per_worker = |figures: &Figures| figures.frames_per_s / figures.workers as f64;
    let Some(base) = results.first().map(per_worker) else { return };
    for figures in results {
        figures.efficiency = per_worker(figures) / base;
    }
}

fn table(report: &Report) -> String {
    let [width, height] = report.size;
    let mut text = format!(
        "{}: {} frames of {width}x{height}, median of {}, {} cores\n\n\
         workers  frames/s  Mpixel/s  efficiency  march ms  shade ms  image ms  encode ms\n",
        report.area,
        report.frames.len(),
        report.repeats,
        report.cores
    );
    for f in &report.results {
        text += &format!(
            "{:>7}  {:>8.2}  {:>8.2}  {:>8.0} %  {:>8.1}  {:>8.1}  {:>8.1}  {:>9.1}\n",
            f.workers,
            f.frames_per_s,
            f.mpixel_per_s,
            f.efficiency * 100.0,
            f.march_ms,
            f.shade_ms,
            f.image_ms,
            f.encode_ms
        );
    }
    let base = report.results.first().map_or(1, |figures| figures.workers);
    text += &format!(
        "\nefficiency: speed per worker against {base}; march, shade and image: time per frame, summed over workers;\n\
         encode: PNG to memory on one thread, not part of frames/s\n"
    );
    text += if report.identical_frames {
        "all numbers of workers gave identical frames\n"
    } else {
        "FRAMES DIFFER between numbers of workers\n"
    };
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_spread_over_the_path() {
        let numbers = |count| FrameSet::parse(&spread(count)).unwrap().iter().collect::<Vec<u64>>();
        assert_eq!(numbers(3), [1, 2, 3]);
        assert_eq!(numbers(36), [1, 4, 7, 10, 13, 16, 19, 22, 25, 28, 31, 34]);
        assert!((6..=12).contains(&numbers(1_000_003).len()));
    }

    #[test]
    fn the_median_of_an_even_number_lies_between() {
        assert_eq!(median([4.0, 1.0, 3.0, 2.0].into_iter()), 2.5);
        assert_eq!(median([3.0, 1.0, 2.0].into_iter()), 2.0);
    }
}
