//! `hedgehop render`: a flight path through a database, as frames, a stream or a film.

mod flags;
mod notes;
mod replacing;

pub use flags::RenderArgs;

use crate::commands::render::flags::WORKERS_PER_ENCODER;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::{Value, json};

use crate::aov::{Aov, Further};
use crate::area;
use crate::args::check_no_input;
use crate::exit::{self, Outcome, STDOUT};
use crate::finish::{self, Finishing, Motion};
use crate::interrupt::Interrupt;
use crate::memory::{self, Frames, Late};
use crate::output::{Files, Origin, Stdout, Stream, WRITER, unfinished};
use crate::product::Product;
use crate::progress::Reporter;
use crate::scene::{self, Playing};
use crate::screen::Setup;
use crate::sequence::{Fineness, Sequence};
use crate::traffic::{self, Traffic};
use crate::trust;
use hedgehop::encode::atomic::write_with;
use hedgehop::encode::video::{check_video, encode_video};
use hedgehop::encode::{FrameSet, Target, sidecar};
use hedgehop::memory::{PageFile, Paging, ResidentPages};
use hedgehop::progress::Observer;
use hedgehop::render::{NumberedCamera, RenderOptions, Renderer};
use hedgehop::scene::Scene;
use hedgehop::subimage::Farm;
use hedgehop::voxel::{PageId, PageSource};
use hedgehop::{Error, Result, Size};

/// Result of a flight.
#[derive(Debug)]
pub struct Done {
    /// Files of the frames asked for, rising; the one file of a stream.
    pub files: Vec<PathBuf>,
    size: Size,
    /// Cost of paging.
    pub paging: Paging,
    /// Pages that coarser levels stood in for, and where each begins in the database.
    damaged: Vec<(PageId, u64)>,
    /// Fineness of the ground that was seen.
    fineness: Fineness,
    /// Whether the database stores all pages of all levels.
    is_whole: bool,
    rendered: usize,
    kept: usize,
    seconds: f64,
}

/// Runs the command.
pub fn run(args: &RenderArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    args.instructions.check()?;
    let done = fly(args, PageFile::open_trusting(&args.area, args.trust.trust())?, &reporter)?;
    if args.stats {
        reporter.note(&memory::sentence(&done.paging));
    }
    trust::sentence(&args.area, &done.damaged).iter().for_each(|sentence| reporter.note(sentence));
    let elsewhere = notes::elsewhere(done.is_whole, !done.damaged.is_empty());
    if let Some(note) = notes::coarser(&done.fineness, args.late, elsewhere) {
        reporter.note(&note);
    }
    if args.output.is_standard_output() {
        reporter.note(done.sentence().trim_end());
    } else {
        exit::print(&done.sentence())?;
    }
    Ok(())
}

impl Done {
    /// Says what was done, for people.
    pub fn sentence(&self) -> String {
        let size = self.size;
        let megapixels = self.rendered as f64 * f64::from(size.width) * f64::from(size.height) / 1e6;

        // A flight that took no measurable time has no rate to speak of.
        let seconds = self.seconds.max(1e-3);
        let kept = if self.kept > 0 { format!(", kept {}", self.kept) } else { String::new() };
        let plural = if self.rendered == 1 { "" } else { "s" };
        let place = match self.files.as_slice() {
            [] => String::new(),
            [file] => format!(" -> {}", file.display()),
            [first, .., last] => format!(" -> {} to {}", first.display(), last.display()),
        };
        if self.rendered == 0 {
            return format!("rendered nothing{kept}{place}\n");
        }

        format!(
            "rendered {} frame{plural}{kept} in {:.1} s ({:.2} frames/s, {:.2} Mpixel/s){place}\n",
            self.rendered,
            self.seconds,
            self.rendered as f64 / seconds,
            megapixels / seconds
        )
    }
}

/// Renders everything that `args` asks for. Frames that are finished when something goes wrong stay, and are listed.
pub fn fly(args: &RenderArgs, file: PageFile, reporter: &Reporter) -> Result<Done> {
    let scene = args.scene.read(reporter)?;
    let scene = scene.as_ref();
    let (finish, hud) = (args.finish.finish(scene)?, args.finish.hud(scene));
    let setup = args.flight.screen.setup()?.behind_lens(finish.distortion)?;
    check_combination(args, scene, setup.size)?;
    args.aov.check(args.output.target(), &setup)?;
    let product = if args.output.target() == Target::Exr { Product::Frame } else { Product::Picture };
    let farm = Farm::new(args.workers.count())?;
    let encoders = farm.workers().div_ceil(WORKERS_PER_ENCODER);
    let in_flight = farm.in_flight(args.overlap.in_flight);
    let has_objects = scene::has_objects(scene);
    let further = args.aov.pixel_bytes();

    let shares = args.memory.shares(Frames {
        size: setup.size,
        product,
        gathered: if finish.gathers() || finish.is_developed() && product == Product::Picture {
            finish.antialias
        } else {
            0
        },
        has_objects,
        further,
        in_flight,
        encoders,
    })?;

    let pages = ResidentPages::new(file, shares.map(|shares| shares.pages));
    let source = &pages;
    let choose = |count| Ok(args.frames.clone().unwrap_or_else(|| FrameSet::all(count)));
    let (trajectory, cameras) = match args.late {
        Late::Wait => args.flight.flight(&args.area, source, &setup, args.fps, choose, reporter)?,
        // Ground under the path is not to be in memory because the path is known.
        Late::Coarser => args.flight.flight(&args.area, source.file(), &setup, args.fps, choose, reporter)?,
    };
    finish::check_lens(&cameras, &finish)?;
    let playing = scene.map(|scene| match args.late {
        Late::Wait => Playing::new(scene, source, args.flight.world, args.fps, reporter),
        Late::Coarser => Playing::new(scene, source.file(), args.flight.world, args.fps, reporter),
    });
    let playing = playing.transpose()?;
    if let Some(note) = scene.filter(|_| setup.is_map()).and_then(scene::left_out_of_map) {
        reporter.note(&note);
    }

    let look = args.look.options(scene, source.header())?;
    let matte = args.aov.has(Aov::Cryptomatte);
    let look = RenderOptions { engine: args.instructions.engine(), matte, ..look };
    let options = args.flight.world.apply(source.header(), look);
    if let Some(note) = notes::other_sun(&args.area, source.header(), options.sun) {
        reporter.note(&note);
    }

    let mut renderer = Renderer::new(source, &options).with_isa(args.instructions.isa());
    if let Some(shares) = shares {
        renderer = renderer.with_memory(shares.derived as usize);
    }

    notes::left_to_reference(&renderer, &options, &cameras, finish.antialias, reporter)?;
    // Heights of a path above ground were read before.
    let before = source.paging();
    args.memory.preload(source, shares, reporter)?;

    // Pages that are loaded before take no frame's time.
    let begun = Instant::now();
    let numbers = cameras.iter().map(|frame| frame.number);
    let motion = args.aov.has(Aov::Motion);
    let partners =
        motion.then(|| args.flight.partners(source.file(), &setup, args.fps, numbers)).transpose()?;
    let material = args.aov.has(Aov::Material);
    let names = matte.then(|| playing.as_ref().map(Playing::names).unwrap_or_default());
    let further = Further { names, partners, material, curvature: options.curvature };
    if product == Product::Frame && (finish.is_developed() || !hud.is_empty()) {
        reporter.note("EXR holds linear light: exposure, curves, vignette and instruments are left out");
    }

    let map = match args.late {
        _ if product == Product::Frame => None,
        Late::Wait => finish::mini_map(&hud, source, &trajectory)?,
        Late::Coarser => finish::mini_map(&hud, source.file(), &trajectory)?,
    };
    let motion = Motion { trajectory: &trajectory, fps: args.fps };
    let finishing = Finishing { finish, hud, map, motion, setup: &setup, world: args.flight.world };
    let is_finished = finish.is_developed() || finish.gathers() || !hud.is_empty();

    let sequence = Sequence {
        pages: source,
        renderer: &renderer,
        product,
        farm: &farm,
        in_flight,
        encoders,
        live: (args.late == Late::Coarser).then_some(args.fps),
        stats: args.stats,
        playing: playing.as_ref(),
        further: &further,
        motion,
        finishing: is_finished.then_some(&finishing),
    };

    let (files, (rendered, fineness)) = if args.output.target() == Target::Y4m {
        check_frames(args, scene, &[args.output.path(1)])?;
        let stream = Sequence { encoders: 1, ..sequence };
        (vec![args.output.path(1)], fly_stream(args, setup.size, &stream, &cameras, reporter)?)
    } else {
        let origin = Origin {
            area: &args.area,
            header: source.header(),
            path: args.flight.path.as_deref(),
            fps: args.fps,
            settings: {
                let mut settings = settings(args, scene, &setup, &options);
                finish::record(&finish, &hud, product == Product::Frame, &mut settings);
                settings
            },
        };

        let files = Files::new(origin, &args.output);
        let paths: Vec<_> = cameras.iter().map(|frame| files.path(frame.number)).collect();
        check_frames(args, scene, &paths)?;
        let is_listed = replacing::check(args, &files, &cameras, reporter)?;

        (paths, fly_files(args, &sequence, (&files, is_listed), &cameras, reporter)?)
    };

    if let Some(map) = &args.traffic {
        Traffic { header: source.header(), cameras: &cameras, first_use: &source.first_use() }.write(map)?;
    }
    if let Some(film) = &args.video {
        encode_video(files.iter().cloned(), args.fps, film, reporter)?;
    }

    Ok(Done {
        files,
        size: setup.size,
        rendered,
        fineness,
        is_whole: area::shares(source.header(), source.file().directory())
            .iter()
            .all(|share| share.stored == share.all),
        paging: source.paging().since(&before),
        damaged: source.file().damaged(),
        kept: cameras.len() - rendered,
        seconds: begun.elapsed().as_secs_f64(),
    })
}

/// Refuses frames that would take the place of what they are made of.
fn check_frames(args: &RenderArgs, scene: Option<&Scene>, frames: &[PathBuf]) -> Result<()> {
    let mut inputs: Vec<&Path> = vec![&args.area];
    inputs.extend(args.flight.path.as_deref());
    inputs.extend(args.flight.screen.table());
    inputs.extend(scene::inputs(scene));
    frames.iter().try_for_each(|frame| check_no_input("-o", frame, &inputs))
}

/// Refuses before the first frame what would fail, or destroy an input, after the last one.
fn check_combination(args: &RenderArgs, scene: Option<&Scene>, size: Size) -> Result<()> {
    let is_stream = args.output.target() == Target::Y4m;
    let mut inputs: Vec<&Path> = args.flight.path.as_deref().into_iter().collect();
    inputs.extend(scene::inputs(scene));
    if let (Some(_), Some(folder), false) = (&args.flight.path, args.output.folder(), is_stream) {
        for name in [sidecar::POSES, sidecar::MANIFEST] {
            check_no_input("-o", &folder.join(name), &inputs)?;
        }
        sidecar::Manifest::check_folder(folder)?;
    }

    if let Some(map) = &args.traffic {
        inputs.push(&args.area);
        traffic::check(map, &inputs)?;
    }

    if is_stream && args.skip_existing {
        return Err(Error::Configuration(
            "--skip-existing needs frames in files; a y4m stream is always written whole".into(),
        ));
    }

    match &args.video {
        Some(_) if is_stream => Err(Error::Configuration(
            "--video is made from frames in files; write them with -o frames/####.png".into(),
        )),
        Some(_) if size.width.min(size.height) < 2 => Err(Error::Configuration(
            "--video has pictures of even sizes, 2x2 pixels at least; ask for a larger --size".into(),
        )),
        Some(film) => check_video(film),
        None => Ok(()),
    }
}

/// Everything that decides the pictures besides database and path.
fn settings(args: &RenderArgs, scene: Option<&Scene>, setup: &Setup, options: &RenderOptions) -> Value {
    let (flight, look) = (&args.flight, &args.look);
    let mut settings = json!({
        "renderer": WRITER,
        "fps": args.fps.to_string(),
        "size_px": [setup.size.width, setup.size.height],
        "screen": setup.record(),
        "level": flight.level,
        "clearance_m": flight.clearance,
        "alt_mode": flight.alt_mode.map(|mode| format!("{mode:?}").to_lowercase()),
        "surface": format!("{:?}", look.surface).to_lowercase(),
        "visibility_m": options.visibility,
        "sun_azimuth_elevation_deg": [options.sun.azimuth, options.sun.elevation],
        "shadows": options.shadows,
        "detail": options.detail,
        "effective_earth_radius_m": options.curvature.radius(),
        "tile_world": options.tile_world,

        "engine": format!("{:?}", options.engine).to_lowercase(),
    });

    args.trust.record(&mut settings);
    args.late.record(&mut settings);
    scene::record(scene, &mut settings);
    scene::record_weather(&options.weather, &mut settings);
    args.aov.record(flight.path.as_deref(), &mut settings);

    settings
}

/// Returns how many frames were rendered, and how finely.
fn fly_files(
    args: &RenderArgs,
    sequence: &Sequence<'_>,
    (files, is_listed): (&Files<'_>, bool),
    cameras: &[NumberedCamera],
    reporter: &Reporter,
) -> Result<(usize, Fineness)> {
    let is_kept =
        |frame: &NumberedCamera| args.skip_existing && files.is_whole(frame.number, &frame.camera, reporter);
    let (mut whole, wanted): (Vec<_>, Vec<_>) = cameras.iter().cloned().partition(is_kept);
    let flown = sequence.fly(&wanted, &|shot| files.write(shot), reporter);
    whole.extend(wanted.into_iter().filter(|frame| flown.finished.contains(&frame.number)));
    whole.sort_unstable_by_key(|frame| frame.number);
    let damaged = sequence.pages.file().damaged();
    let listed = if is_listed { files.list(&whole, &flown, &damaged) } else { Ok(()) };
    // What ended the flight explains more than what then happened to the list.
    let summed = flown.summed();
    flown.end?;
    listed?;
    Ok(summed)
}

fn fly_stream(
    args: &RenderArgs,
    size: Size,
    sequence: &Sequence<'_>,
    cameras: &[NumberedCamera],
    reporter: &Reporter,
) -> Result<(usize, Fineness)> {
    if args.output.is_standard_output() {
        let stream = Stream::new(Stdout, Path::new(STDOUT), size, args.fps)?;
        let flown = sequence.fly(cameras, &|shot| stream.write(shot), reporter);
        let summed = flown.summed();
        return flown.end.map(|()| summed);
    }

    let file = args.output.path(1);
    let mut outcome = Ok((0, Fineness::default()));
    let written = write_with(&file, |target| {
        outcome = Stream::new(target, &file, size, args.fps).and_then(|stream| {
            let flown = sequence.fly(cameras, &|shot| stream.write(shot), reporter);
            let summed = flown.summed();
            flown.end.map(|()| summed)
        });
        // Any error keeps the unfinished file from taking its name; the cause is in `outcome`.
        outcome.as_ref().map(drop).map_err(|_| io::Error::other("unfinished"))
    });

    let rendered = outcome.map_err(|error| unfinished(&file, error))?;
    written.map(|()| rendered)
}
