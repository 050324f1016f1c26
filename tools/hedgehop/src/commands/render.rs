//! `hedgehop render`: a flight path through a database, as frames, a stream or a film.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hedgehop::frame::{FramePattern, FrameRate, FrameSet, Target};
use hedgehop::memory::PageFile;
use hedgehop::progress::Observer;
use hedgehop::space::Camera;
use hedgehop::subimage::Farm;
use hedgehop::{Error, Result};

use crate::args::Workers;
use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;
use crate::output::{Film, Files, Stream};
use crate::progress::{Mode, Reporter};
use crate::sequence::{Flown, Sequence};
use crate::view::{self, FlightArgs, LookArgs};

const EXAMPLE: &str = "\
Examples:
  hedgehop render area.hop --path track.gpx -o frames/####.png --video film.mp4
  hedgehop render area.hop --path track.csv --frames 100-200 --skip-existing -o frames/%04d.exr
  hedgehop render area.hop --eye 500120,4180300,850 --ypr 90,-10,0 -o view.png
  hedgehop render area.hop --path track.kml -o - | ffplay -";

/// Workers per encoder thread: a picture takes several times as long to render as to encode.
const WORKERS_PER_ENCODER: usize = 4;

/// Render a flight path, or a single picture.
///
/// Frames are the same, bit by bit, for any number of workers and any subset. Give --path for a flight or --eye for
/// a single picture. Frames are numbered from the start of the path, whichever of them are rendered.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct Args {
    /// Database to fly through
    #[arg(value_name = "AREA.hop")]
    pub area: PathBuf,

    /// Where frames go: frames/####.png, frames/%04d.exr, film.y4m, or - for y4m on standard output
    #[arg(short, long, value_name = "PATTERN", value_parser = FramePattern::parse, allow_hyphen_values = true)]
    pub output: FramePattern,

    /// Frames per second: 30, 29.97, 24000/1001
    #[arg(long, value_name = "RATE", default_value = "30")]
    pub fps: FrameRate,

    /// Frames to render: 1-10,20,30-40:2 [default: all]
    #[arg(long, value_name = "LIST", value_parser = FrameSet::parse)]
    pub frames: Option<FrameSet>,

    /// Keep frames that are whole and were made from the same database, pose and settings
    #[arg(long)]
    pub skip_existing: bool,

    /// Make a film of the frames through an installed ffmpeg
    #[arg(long, value_name = "FILM.mp4")]
    pub video: Option<PathBuf>,

    #[command(flatten)]
    pub workers: Workers,

    #[command(flatten)]
    pub flight: FlightArgs,

    #[command(flatten)]
    pub look: LookArgs,

    /// How progress is told on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    pub progress: Mode,
}

/// What a flight has left behind.
#[derive(Debug)]
pub struct Done {
    /// Files of the frames asked for, rising; the one file of a stream.
    pub files: Vec<PathBuf>,
    rendered: usize,
    kept: usize,
    seconds: f64,
}

/// Runs the command.
pub fn run(args: &Args, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    let source = PageFile::open(&args.area)?;
    let done = fly(args, &source, &reporter)?;
    if args.output.is_standard_output() {
        reporter.note(done.sentence(args).trim_end());
    } else {
        exit::print(&done.sentence(args))?;
    }
    Ok(())
}

impl Done {
    fn sentence(&self, args: &Args) -> String {
        let size = args.flight.size;
        let megapixels = self.rendered as f64 * f64::from(size.width) * f64::from(size.height) / 1e6;
        // A flight that took no measurable time has no rate to speak of.
        let seconds = self.seconds.max(1e-3);
        let kept = if self.kept > 0 { format!(", kept {}", self.kept) } else { String::new() };
        let place = match self.files.as_slice() {
            [] => String::new(),
            [file] => format!(" -> {}", file.display()),
            [first, .., last] => format!(" -> {} to {}", first.display(), last.display()),
        };
        format!(
            "rendered {} frames{kept} in {:.1} s ({:.2} frames/s, {:.2} Mpixel/s){place}\n",
            self.rendered,
            self.seconds,
            self.rendered as f64 / seconds,
            megapixels / seconds
        )
    }
}

/// Renders everything that `args` asks for. Frames that are finished when something goes wrong stay, and are listed.
pub fn fly(args: &Args, source: &PageFile, reporter: &Reporter) -> Result<Done> {
    let begun = Instant::now();
    let is_stream = args.output.target() == Target::Y4m;
    check_combination(args, is_stream)?;
    let cameras = plan(args, source, reporter)?;
    let farm = Farm::new(args.workers.count())?;
    let options = args.look.options();
    let encoders = if is_stream { 1 } else { farm.workers().div_ceil(WORKERS_PER_ENCODER) };
    let sequence = Sequence { source, options: &options, farm: &farm, encoders };
    let done = |files, flown: &Flown, kept| Done {
        files,
        rendered: flown.finished.len(),
        kept,
        seconds: begun.elapsed().as_secs_f64(),
    };
    if is_stream {
        let stream = Stream::open(&args.output, args.flight.size, args.fps)?;
        let flown = sequence.fly(&cameras, &|shot| stream.write(&shot), reporter);
        stream.finish(flown.end.is_ok())?;
        let done = done(vec![args.output.path(1)], &flown, 0);
        return flown.end.map(|()| done);
    }
    let files = Files::new(args, source, &options);
    let (kept, wanted) = files.divide(cameras, args.skip_existing, reporter)?;
    let flown = sequence.fly(&wanted, &|shot| files.write(&shot), reporter);
    // What went wrong comes first, unless nothing did.
    let listed = files.list(&kept, &flown.finished, &wanted);
    flown.end.as_ref().map_or(Ok(()), |_| Ok::<(), Error>(()))?;
    let done = done(files.paths(), &flown, kept.len());
    flown.end.and(listed).map(|()| done)
}
