//! Arguments of `render`.

use std::path::PathBuf;

use super::film_args::{FilmArgs, PRESET_RATES};
use crate::aov::AovArgs;
use crate::args::{Instructions, Overlap, Workers};
use crate::database::{CacheArgs, DatabaseName};
use crate::exit;
use crate::farm::work::WorkArgs;
use crate::finish::FinishArgs;
use crate::labels::LabelArgs;
use crate::memory::{Late, Memory};
use crate::poses::PoseArgs;
use crate::progress::Mode;
use crate::scene::SceneArgs;
use crate::titling::TitlingArgs;
use crate::trails::TrailArgs;
use crate::trust::TrustArgs;
use crate::view::{FlightArgs, LookArgs};
use hedgehop::encode::{FramePattern, FrameSet, Target};
use hedgehop::flight::FrameRate;

/// Render a flight path, views without a path, or a single picture.
///
/// Frames are the same, bit by bit, for any number of workers and any subset. Give --path for a flight, --views for a data set, or --eye for
/// a single picture. Frames are numbered from the start of the path, whichever of them are rendered.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct RenderArgs {
    /// Database to fly through
    #[arg(value_name = "AREA.hop")]
    pub area: DatabaseName,

    /// Output of frames: frames/####.png, frames/%04d.exr, film.y4m, or - for y4m on standard output; with --video they need none
    #[arg(short, long, value_name = "PATTERN", value_parser = FramePattern::parse, required_unless_present = "video")]
    pub output: Option<FramePattern>,

    /// Frames per second: 30, 29.97, 24000/1001
    #[arg(long, value_name = "RATE", default_value = "30", default_value_ifs = PRESET_RATES)]
    pub fps: FrameRate,

    /// Frames to render: 1-10,20,30-40:2 [default: all]
    #[arg(long, value_name = "LIST", value_parser = FrameSet::parse)]
    pub frames: Option<FrameSet>,

    /// Keep frames that are whole and were made from the same database, pose and settings
    #[arg(long)]
    pub skip_existing: bool,

    /// Let frames take the place of those of another render; a folder that holds such frames is refused otherwise
    #[arg(long)]
    pub overwrite: bool,

    #[command(flatten)]
    pub workers: Workers,

    #[command(flatten)]
    pub overlap: Overlap,

    #[command(flatten)]
    pub memory: Memory,

    /// Treatment of pages that are not in memory when a frame begins: wait has the frame wait until they are; coarser has it begin at once, as in a simulator
    /// that does not know its path beforehand, with the next coarser level in their place: what pictures show then depends on how fast
    /// disk and machine are
    #[arg(long, value_enum, value_name = "HOW", default_value = "wait")]
    pub late: Late,

    /// Tell every second how fast frames come and what paging costs, and at the end what it cost in all
    #[arg(long)]
    pub stats: bool,

    /// Draw a map of the database's pages by the first frame that needed them
    #[arg(long, value_name = "MAP.svg")]
    pub traffic: Option<PathBuf>,

    #[command(flatten)]
    pub poses: PoseArgs,

    #[command(flatten)]
    pub aov: AovArgs,

    #[command(flatten)]
    pub labels: LabelArgs,

    #[command(flatten)]
    pub trust: TrustArgs,

    #[command(flatten)]
    pub cache: CacheArgs,

    #[command(flatten)]
    pub instructions: Instructions,

    #[command(flatten)]
    pub flight: FlightArgs,

    #[command(flatten)]
    pub look: LookArgs,

    #[command(flatten)]
    pub scene: SceneArgs,

    #[command(flatten)]
    pub trails: TrailArgs,

    #[command(flatten)]
    pub finish: FinishArgs,
    #[command(flatten)]
    pub titling: TitlingArgs,

    #[command(flatten)]
    pub film: FilmArgs,

    #[command(flatten)]
    pub work: WorkArgs,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    pub progress: Mode,
}

impl RenderArgs {
    /// Asks for all frames of a flight, as they come without further flags.
    pub fn of_flight(area: DatabaseName, output: FramePattern, fps: FrameRate, flight: FlightArgs) -> Self {
        Self {
            area,
            output: Some(output),
            fps,
            frames: None,
            skip_existing: false,
            overwrite: false,
            workers: Workers { jobs: None },
            overlap: Overlap::default(),
            memory: Memory::default(),
            late: Late::default(),
            stats: false,
            traffic: None,
            poses: PoseArgs::default(),
            aov: AovArgs::default(),
            labels: LabelArgs::default(),
            trust: TrustArgs::default(),
            cache: CacheArgs::default(),
            instructions: Instructions::default(),
            flight,
            look: LookArgs::default(),
            scene: SceneArgs::default(),
            trails: TrailArgs::default(),
            finish: FinishArgs::default(),
            titling: TitlingArgs::default(),
            film: FilmArgs::default(),
            work: WorkArgs::default(),
            progress: Mode::Auto,
        }
    }

    /// Returns what kind of file frames become, unless they go into the film alone.
    pub fn target(&self) -> Option<Target> {
        self.output.as_ref().map(FramePattern::target)
    }
}

const EXAMPLE: &str = "\
Examples:
  hedgehop render area.hop --path track.gpx --film 1080p --video film.mp4
  hedgehop render area.hop --path track.gpx -o frames/####.png --video film.mp4
  hedgehop render area.hop --path track.csv --frames 100-200 --skip-existing -o frames/%04d.exr
  hedgehop render area.hop --eye 500120,4180300,850 --ypr 90,-10,0 -o view.png
  hedgehop render area.hop --eye 500120,4180300,3000 --screen orthographic --ground-width 2000 -o map.png
  hedgehop render area.hop --views random --count 500 --heights 30,300 -o views/####.png
  hedgehop render area.hop --path track.csv --screen fisheye --channel 0,90,0 -o dome/####.png
  hedgehop render area.hop --path track.kml -o - | ffplay -";

/// Workers per encoder thread: a picture takes several times as long to render as to encode.
pub(super) const WORKERS_PER_ENCODER: usize = 4;
