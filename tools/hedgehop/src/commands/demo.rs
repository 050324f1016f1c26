//! `hedgehop demo`: the whole way, from rasters to a film, on data that the program carries.

use std::fs;
use std::path::{Path, PathBuf};

use crate::args;
use crate::camera::CameraArgs;
use crate::commands::build::Order;
use crate::commands::render::{self, FilmArgs};
use crate::contact_sheet::{Entry, WIDTH, sheet, spread};
use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;
use crate::pictures;
use crate::playback::PlaybackArgs;
use crate::program::program;
use crate::progress::{Mode, Reporter};
use crate::screen::ScreenArgs;
use crate::smoothing::SmoothingArgs;
use crate::tracks::TrackArgs;
use crate::view::FlightArgs;
use crate::views::ViewArgs;
use crate::world::WorldArgs;
use hedgehop::encode::FramePattern;
use hedgehop::encode::atomic::write_bytes;
use hedgehop::encode::video::{VideoSettings, check_video};
use hedgehop::memory::PageFile;
use hedgehop::progress::Observer;
use hedgehop::{Error, Result, Size};

const EXAMPLE: &str = "\
Examples:
  hedgehop demo
  hedgehop demo -o /data/hedgehop-demo";

/// The recipe of a synthetic valley that this project made.
const RECIPE: &str = "valley.toml";
const PATH: &str = "valley-path.csv";

/// A file of `data/` with its name; its licence lies beside it there.
macro_rules! carried {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_bytes!(concat!("../../../../data/", $name)).as_slice())),*]
    };
}

/// The recipe, and all that it names.
const FILES: [(&str, &[u8]); 17] = carried![
    "valley.toml",
    "valley-elevation.tif",
    "valley-imagery.tif",
    "valley-land-cover.tif",
    "valley-map.geojson",
    "valley-scan.laz",
    "valley-barn.obj",
    "valley-barn.mtl",
    "valley-chapel.glb",
    "valley-gravel.vox",
    "valley-vineyard.shp",
    "valley-vineyard.shx",
    "valley-vineyard.dbf",
    "valley-vineyard.prj",
    "valley-vineyard.cpg",
    "valley-airfield.gpkg",
    "valley-path.csv",
];

/// Small enough that build, flight and contact sheet take less than a minute on one core.
const SIZE: Size = Size { width: 960, height: 540 };
/// About 240 frames.
const FRAMES_PER_SECOND: &str = "8";
/// Field of view, degrees.
const HFOV: f64 = 65.0;
/// Memory of the build, bytes; the valley needs far less.
const MEMORY: u64 = 256 << 20;
/// Frames on the contact sheet: four in a row.
const SHEET_FRAMES: usize = 12;
const SHEET_COLUMNS: u32 = 4;

/// Build and fly a small valley; needs no files and no network.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct DemoArgs {
    /// Folder to write to; it is made if it does not exist
    #[arg(short, long, value_name = "DIR", default_value = "hedgehop-demo")]
    output: PathBuf,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

/// Runs the command.
pub fn run(args: &DemoArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    let folder = &args.output;
    fs::create_dir_all(folder).map_err(|error| Error::io(folder, "create the folder", error))?;
    let recipe = folder.join(RECIPE);

    // Somebody may have tried another line in one.
    let is_changed = |file: &Path, bytes: &[u8]| fs::read(file).is_ok_and(|there| there != bytes);
    let mut written = 0;
    for (name, bytes) in FILES {
        let file = folder.join(name);
        if is_changed(&file, bytes) {
            let file = file.display();
            reporter.note(&format!("{file} was changed, and stays as it is; without it, it is written anew"));
            continue;
        }
        write_bytes(&file, bytes)?;
        written += 1;
    }

    let all = FILES.len();
    exit::print(&format!("1. wrote {written} of the {all} files of {}\n", recipe.display()))?;

    let mut order = Order::of(&recipe)?;
    let options = &mut order.options;
    (options.overwrite, options.memory, options.threads) = (true, MEMORY, args::available_cores());
    let report = order.fill(&reporter)?;
    let area = order.options.output;

    exit::print(&format!(
        "2. built {}: {} x {} voxels of {} m, {:.1} MB in {:.1} s\n",
        area.display(),
        report.grid.nx,
        report.grid.ny,
        crate::reference::metres(report.grid.spacing),
        report.bytes as f64 / 1e6,
        report.seconds
    ))?;

    let flight = flight(folder, &area)?;
    let done = render::fly(&flight, PageFile::open(&area)?, &reporter)?;
    exit::print(&format!("3. {}", done.sentence()))?;
    let sheet = contact_sheet(folder, &done.files)?;
    exit::print(&format!("4. wrote the contact sheet {}\n", sheet.display()))?;
    if let Some(film) = &flight.film.video {
        exit::print(&format!("5. wrote the film {}\n", film.display()))?;
    }

    exit::print(&next(folder, &area, flight.film.video.is_some()))?;
    Ok(())
}

/// The flight as `hedgehop render` would fly it.
fn flight(folder: &Path, area: &Path) -> Result<render::RenderArgs> {
    let fps = FRAMES_PER_SECOND.parse()?;
    // Without ffmpeg there is no film, which the demo says at its end.
    let film = VideoSettings::new(folder.join("valley.mp4"), fps);
    let video = check_video(&film).is_ok().then_some(film.out);
    let flight = FlightArgs {
        path: Some(folder.join(PATH)),
        eye: None,
        eye_lonlat: false,
        ypr: None,
        alt_mode: None,
        level: false,
        tracks: TrackArgs::default(),
        camera: CameraArgs::default(),
        smoothing: SmoothingArgs::default(),
        playback: PlaybackArgs::default(),
        clearance: None,
        allow_below_ground: false,
        screen: ScreenArgs { hfov: Some(HFOV), size: Some(SIZE), ..ScreenArgs::default() },
        views: ViewArgs::default(),
        world: WorldArgs::default(),
    };

    let output = FramePattern::parse(&folder.join("frames").join("####.png").to_string_lossy())?;
    Ok(render::RenderArgs {
        overwrite: true,
        film: FilmArgs { video, ..FilmArgs::default() },
        ..render::RenderArgs::of_flight(area.to_owned().into(), output, fps, flight)
    })
}

fn contact_sheet(folder: &Path, frames: &[PathBuf]) -> Result<PathBuf> {
    let chosen = spread(frames.len(), SHEET_FRAMES).into_iter().filter_map(|index| frames.get(index));
    let entry = |frame: &PathBuf| Ok(Entry::new(pictures::label(frame), &pictures::open(frame)?, WIDTH));
    let entries = chosen.map(entry).collect::<Result<Vec<_>>>()?;
    let file = folder.join("contact-sheet.png");
    write_bytes(&file, &pictures::png(&sheet(&entries, SHEET_COLUMNS, WIDTH)?, &file)?)?;
    Ok(file)
}

/// Commands to go on with; each works as it stands, and those that render show moments of the demo's own frames.
fn next(folder: &Path, area: &Path, has_film: bool) -> String {
    let me = program();
    let (area, path) = (area.display(), folder.join(PATH));
    let flight = format!("{area} --path {} --fps {FRAMES_PER_SECOND} --hfov {HFOV}", path.display());
    let frames = |folder_name: &str| folder.join(folder_name).join("####.png").display().to_string();

    let film = if has_film {
        String::new()
    } else {
        format!(
            "  (no film: ffmpeg is not installed; once it is:)\n  {me} render {flight} --size {SIZE} -o {} --skip-existing --video {}\n",
            frames("frames"),
            folder.join("valley.mp4").display()
        )
    };

    format!(
        "Next:\n{film}  \
         {me} info {area}\n  \
         {me} render {flight} --frames 60 --surface blocks -o {blocks}\n  \
         {me} render {flight} --frames 60 --visibility 1500 -o {haze}\n  \
         {me} bench {area} --path {path}\n  \
         {me} build {recipe}   (when you have changed a line of it)\n  \
         {me} build --elevation YOUR-DEM.tif --imagery YOUR-ORTHOPHOTO.tif -o your-area.hop\n",
        path = path.display(),
        recipe = folder.join(RECIPE).display(),
        blocks = frames("blocks"),
        haze = frames("haze")
    )
}
