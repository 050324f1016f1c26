//! Arguments of `bench`.

use std::path::PathBuf;

use crate::args::{self, Instructions, Overlap};
use crate::database::{CacheArgs, DatabaseName};
use crate::exit;
use crate::memory::Memory;
use crate::progress::Mode;
use crate::scene::SceneArgs;
use crate::trust::TrustArgs;
use crate::view::{FlightArgs, LookArgs};
use hedgehop::encode::FrameSet;
use hedgehop::flight::FrameRate;
use hedgehop::subimage::TaskSize;

/// Measure how fast this machine renders a path.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct BenchArgs {
    /// Database to fly through
    #[arg(value_name = "AREA.hop")]
    pub(super) area: DatabaseName,

    /// Numbers of worker threads to measure [default: 1, 2, 4, … up to one per core]
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', value_parser = args::workers)]
    pub(super) workers: Vec<usize>,

    /// Frames to render: 1-10,20,30-40:2 [default: up to 12, spread over the path]
    #[arg(long, value_name = "LIST", value_parser = FrameSet::parse)]
    pub(super) frames: Option<FrameSet>,

    /// Frames per second of the path
    #[arg(long, value_name = "RATE", default_value = "30")]
    pub(super) fps: FrameRate,

    /// Timed passes over the frames for each number of workers; the median counts
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(super) repeats: u32,

    /// Write the figures as JSON; - is standard output, instead of the table
    #[arg(long, value_name = "FILE|-")]
    pub(super) json: Option<PathBuf>,

    /// Write a plot as SVG
    #[arg(long, value_name = "FILE")]
    pub(super) svg: Option<PathBuf>,

    /// Write when each worker did which task, for Perfetto or chrome://tracing
    #[arg(long, value_name = "FILE.json")]
    pub(super) trace: Option<PathBuf>,

    /// Scan lines of a march task and screen rows of an image task [default: 8,8; of planes 32,18]
    #[arg(long, value_name = "LINES,ROWS", value_parser = args::task_size)]
    pub(super) task_size: Option<TaskSize>,

    /// Write the ranges of every frame N, metres along the ray, to FOLDER/range_N.f32 (raw float32, infinity = sky)
    #[arg(long, value_name = "FOLDER")]
    pub(super) dump_ranges: Option<PathBuf>,

    #[command(flatten)]
    pub(super) overlap: Overlap,

    #[command(flatten)]
    pub(super) memory: Memory,

    #[command(flatten)]
    pub(super) trust: TrustArgs,

    #[command(flatten)]
    pub(super) cache: CacheArgs,

    #[command(flatten)]
    pub(super) instructions: Instructions,

    #[command(flatten)]
    pub(super) flight: FlightArgs,

    #[command(flatten)]
    pub(super) look: LookArgs,

    #[command(flatten)]
    pub(super) scene: SceneArgs,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    pub(super) progress: Mode,
}

const EXAMPLE: &str = "\
Examples:
  hedgehop bench area.hop --path track.gpx
  hedgehop bench area.hop --path track.gpx --workers 1,2,4,8 --size 1920x1080 --json bench.json --svg bench.svg";

/// Frames of the path that are rendered if --frames does not say, spread evenly.
pub(super) const DEFAULT_FRAMES: u64 = 12;
