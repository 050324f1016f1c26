//! `hedgehop render`: a flight path through a database, or views of it, as frames, a stream or a film.

mod conflicts;
mod film_args;
mod filming;
mod flags;
mod notes;
mod replacing;
mod request;
mod settings;
mod survey;

pub use film_args::FilmArgs;
pub use flags::RenderArgs;
pub use survey::{Survey, survey};

use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::aov::{AovInputs, AovKind};
use crate::area;
use crate::bound_flight::{BoundFlight, FilmMotion};
use crate::commands::render::filming::fly_film;
use crate::commands::render::flags::WORKERS_PER_ENCODER;
use crate::commands::render::request::{FrameRequest, bind, render_options};
use crate::commands::render::settings::settings;
use crate::exit::{self, Outcome, STDOUT};
use crate::farm::work::ChunkWork;
use crate::finish::{self, Finishing};
use crate::interrupt::Interrupt;
use crate::memory::{self, Late};
use crate::output::{Files, Origin, Stdout, Stream, WRITER, unfinished};
use crate::product::Product;
use crate::progress::Reporter;
use crate::running_sun;
use crate::scene::Playing;
use crate::sequence::{Fineness, Sequence, Shot};
use crate::titling::{self, FilmTitles};
use crate::traffic::Traffic;
use crate::trust::{self, DamagedPage};
use hedgehop::earth::Curvature;
use hedgehop::encode::atomic::write_with;
use hedgehop::encode::video::encode_video;
use hedgehop::encode::{FramePattern, Target};
use hedgehop::flight::FrameRate;
use hedgehop::frame::map_offset;
use hedgehop::memory::{PageFile, Paging, ResidentPages};
use hedgehop::progress::Observer;
use hedgehop::render::{NumberedCamera, RenderOptions, Renderer};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{Header, PageSource};
use hedgehop::{Error, Result, Size};

/// Result of a flight.
#[derive(Debug)]
pub struct Done {
    /// Files of the frames asked for, rising; the one file of a stream or of a film alone.
    pub files: Vec<PathBuf>,
    /// Size of each frame.
    size: Size,
    /// Cost of paging.
    pub paging: Paging,
    /// Pages that coarser levels stood in for.
    damaged: Vec<DamagedPage>,
    /// Fineness of the ground that was seen.
    fineness: Fineness,
    /// Whether the database stores all pages of all levels.
    is_whole: bool,
    /// Number of frames rendered.
    rendered: usize,
    /// Number of frames that were there already.
    kept: usize,
    /// Time from the first frame to the last, seconds.
    seconds: f64,
}

/// Runs the command.
pub fn run(args: &RenderArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    args.instructions.check()?;
    let file = args.cache.open_trusting(&args.area, args.trust.trust());
    let file = file.inspect_err(|error| args.work.give_up(error))?;
    let done = fly(args, file, &reporter)?;
    if args.stats {
        reporter.note(&memory::sentence(&done.paging));
    }
    trust::sentence(&args.area, &done.damaged).iter().for_each(|sentence| reporter.note(sentence));
    let elsewhere = notes::elsewhere(done.is_whole, !done.damaged.is_empty());
    if let Some(note) = notes::coarser(&done.fineness, args.late, elsewhere) {
        reporter.note(&note);
    }
    if args.output.as_ref().is_some_and(FramePattern::is_standard_output) {
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
    let Some(work) = args.work.begin(args.instructions, reporter)? else {
        return fly_frames(args, file, None, reporter);
    };
    let done = fly_frames(args, file, Some(&work), reporter);
    let told = work.end(done.as_ref().err());
    // What ended the flight explains more than what then happened to the record of it.
    let done = done?;
    told.map(|()| done)
}

/// Renders the frames that `args` asks for, or those of a chunk.
fn fly_frames(
    args: &RenderArgs,
    file: PageFile,
    work: Option<&ChunkWork>,
    reporter: &Reporter,
) -> Result<Done> {
    let request = FrameRequest::read(args, reporter)?;
    let FrameRequest { finish, titling, setup, product, .. } = &request;
    let farm = Farm::new(args.workers.count())?;
    let encoders = farm.workers().div_ceil(WORKERS_PER_ENCODER);
    let in_flight = farm.in_flight(args.overlap.in_flight);
    let shares = args.memory.shares(request.frames(args.aov.pixel_bytes(), in_flight, encoders))?;

    let pages = ResidentPages::new(file, shares.map(|shares| shares.pages));
    let source = &pages;
    let flight = match args.late {
        Late::Wait => bind(args, &request, work, source, reporter)?,
        // Ground under the path is not to be in memory because the path is known.
        Late::Coarser => bind(args, &request, work, source.file(), reporter)?,
    };
    let BoundFlight { motion, playing, cameras, .. } = &flight;
    request.film.iter().try_for_each(|film| film.check_length(cameras.len() as u64))?;

    let options = render_options(args, request.scene.as_ref(), source.header(), motion, reporter)?;
    let mut renderer = Renderer::new(source, &options).with_isa(args.instructions.isa());
    if let Some(shares) = shares {
        renderer = renderer.with_memory(shares.derived as usize);
    }

    notes::left_to_reference(&renderer, &options, cameras, finish.antialias, reporter)?;
    // Heights of a path above ground were read before.
    let before = source.paging();
    args.memory.preload(source, shares, reporter)?;

    // Pages that are loaded before take no frame's time.
    let begun = Instant::now();
    let aov_inputs = aov_inputs(args, &request, source.header(), &flight, options.curvature);
    if *product == Product::Frame && (finish.is_developed() || !titling.is_empty()) {
        reporter.note(notes::left_out(args.target()));
    }

    let finishing = Finishing {
        finish: *finish,
        motion,
        setup,
        titles: titles(args, &request, motion, source, reporter)?,
    };
    let is_finished = finish.is_developed() || finish.gathers() || finishing.titles.is_some();

    let sequence = Sequence {
        pages: source,
        renderer: &renderer,
        product: *product,
        farm: &farm,
        in_flight,
        encoders,
        live: (args.late == Late::Coarser).then_some(args.fps),
        stats: args.stats,
        playing: playing.as_ref(),
        aov_inputs: &aov_inputs,
        motion,
        finishing: is_finished.then_some(&finishing),
    };

    let Delivered { files, rendered, fineness } =
        deliver(args, &request, &options, &sequence, work, cameras, reporter)?;
    if let Some(map) = &args.traffic {
        Traffic { header: source.header(), cameras, first_use: &source.first_use() }.write(map)?;
    }
    if let (Some(film), Some(_)) = (&request.film, &args.output) {
        encode_video(files.iter().cloned(), film, reporter)?;
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
        damaged: DamagedPage::of(source.file()),
        kept: cameras.len() - rendered,
        seconds: begun.elapsed().as_secs_f64(),
    })
}

/// Returns what frames need for the further channels that were asked for.
fn aov_inputs(
    args: &RenderArgs,
    request: &FrameRequest,
    header: &Header,
    flight: &BoundFlight,
    curvature: Curvature,
) -> AovInputs {
    let partners = args.aov.has(AovKind::Motion).then(|| flight.partners(&request.setup));
    let wants_matte = args.aov.has(AovKind::Cryptomatte);
    let names = wants_matte.then(|| flight.playing.as_ref().map(Playing::names).unwrap_or_default());
    AovInputs {
        names,
        partners,
        position_offset: args.aov.has(AovKind::Position).then(|| map_offset(&header.grid)),
        antialias: request.finish.antialias,
        material: args.aov.has(AovKind::Material),
        curvature,
    }
}

/// Returns the titles of pictures, if they have some; frames of light have none.
fn titles<'f>(
    args: &RenderArgs,
    request: &FrameRequest,
    motion: &'f FilmMotion,
    source: &ResidentPages,
    reporter: &Reporter,
) -> Result<Option<FilmTitles<'f>>> {
    let FrameRequest { titling, setup, product, .. } = request;
    if titling.is_empty() || *product == Product::Frame {
        return Ok(None);
    }
    // Ground under the path is not to be in memory because a map shows it.
    let ground: &dyn PageSource = match args.late {
        Late::Wait => source,
        Late::Coarser => source.file(),
    };
    FilmTitles::new(titling, motion, args.flight.world, setup.size, ground, reporter).map(Some)
}

/// Frames that were rendered and written.
struct Delivered {
    /// Files of the frames asked for, rising; the one file of a stream or of a film alone.
    files: Vec<PathBuf>,
    /// Number of frames rendered.
    rendered: usize,
    /// Fineness of the ground that was seen.
    fineness: Fineness,
}

/// Renders the frames of `cameras` into files, a stream, or a film alone.
fn deliver(
    args: &RenderArgs,
    request: &FrameRequest,
    options: &RenderOptions,
    sequence: &Sequence<'_>,
    work: Option<&ChunkWork>,
    cameras: &[NumberedCamera],
    reporter: &Reporter,
) -> Result<Delivered> {
    let FrameRequest { scene, finish, titling, setup, product, film } = request;
    let scene = scene.as_ref();
    let output = match (&args.output, film) {
        (Some(output), _) => output,
        (None, Some(film)) => {
            let (rendered, fineness) = fly_film(film, setup.size, sequence, cameras, reporter)?;
            return Ok(Delivered { files: vec![film.out.clone()], rendered, fineness });
        }
        (None, None) => return Err(Error::Configuration("give -o for frames, or --video for a film".into())),
    };

    if output.target() == Target::Y4m {
        let files = vec![output.path(1)];
        conflicts::check_frames(args, scene, &files)?;
        let stream = Sequence { encoders: 1, ..*sequence };
        let (rendered, fineness) = fly_stream(output, args.fps, setup.size, &stream, cameras, reporter)?;
        return Ok(Delivered { files, rendered, fineness });
    }

    if let Some(note) = args.poses.note(options.curvature) {
        reporter.note(&note);
    }
    let header = sequence.pages.header();
    let mut settings = settings(args, scene, setup, options);
    if let Some(sky) = sequence.motion.sky {
        running_sun::record(&sky, &mut settings)?;
    }
    args.aov.record(args.flight.path.as_deref(), map_offset(&header.grid), &mut settings);
    finish::record(finish, *product == Product::Frame, &mut settings);
    if *product == Product::Picture {
        titling::record(titling, &mut settings);
    }
    let origin = Origin {
        area: &args.area,
        header,
        path: args.flight.path.as_deref(),
        is_sequence: args.flight.is_sequence(),
        poses: args.poses.record(&header.grid),
        timeline: sequence.motion.timeline,
        settings,
    };

    let labels = args.labels.labelling(WRITER, &header.metadata, sequence.playing)?;
    let files = Files::new(origin, output, labels)?;
    let paths: Vec<_> = cameras.iter().map(|frame| files.path(frame.number)).collect();
    conflicts::check_frames(args, scene, &paths)?;
    if let Some(work) = work {
        // Pages that are checked by one reader are not checked anew by it.
        let anew = args.cache.open(&args.area)?;
        work.check(&files.manifest()?, files.folder(), sequence.renderer, cameras, &anew, reporter)?;
    }
    // That frames are not the job's explains more than what they would replace.
    let is_listed = replacing::check(args, &files, cameras, reporter)?;
    files.write_palette()?;
    let (rendered, fineness) = match work {
        Some(work) => fly_chunk(sequence, &files, work, cameras, reporter)?,
        None => fly_files(args, sequence, &files, is_listed, cameras, reporter)?,
    };
    Ok(Delivered { files: paths, rendered, fineness })
}

/// Renders frames into files, and lists them unless `is_listed` is false. Returns how many were rendered, and how finely.
fn fly_files(
    args: &RenderArgs,
    sequence: &Sequence<'_>,
    files: &Files<'_>,
    is_listed: bool,
    cameras: &[NumberedCamera],
    reporter: &Reporter,
) -> Result<(usize, Fineness)> {
    let is_kept =
        |frame: &NumberedCamera| args.skip_existing && files.is_whole(frame.number, &frame.camera, reporter);
    let (mut whole, wanted): (Vec<_>, Vec<_>) = cameras.iter().cloned().partition(is_kept);
    let flown = sequence.fly(&wanted, &|shot| files.write(shot, sequence.farm), reporter);
    whole.extend(wanted.into_iter().filter(|frame| flown.finished.contains(&frame.number)));
    whole.sort_unstable_by_key(|frame| frame.number);
    let damaged = DamagedPage::of(sequence.pages.file());
    let listed = if is_listed { files.list(&whole, &flown, &damaged) } else { Ok(()) };
    // What ended the flight explains more than what then happened to the list.
    let summed = flown.summed();
    flown.end?;
    listed?;
    Ok(summed)
}

/// Renders the frames of a chunk that are not finished yet, and records each. Returns how many were rendered, and how finely.
fn fly_chunk(
    sequence: &Sequence<'_>,
    files: &Files<'_>,
    work: &ChunkWork,
    cameras: &[NumberedCamera],
    reporter: &Reporter,
) -> Result<(usize, Fineness)> {
    let is_wanted = |frame: &&NumberedCamera| !work.is_finished(frame.number, &files.path(frame.number));
    let mut wanted: Vec<_> = cameras.iter().filter(is_wanted).cloned().collect();
    let write = |shot: &Shot| {
        files.write(shot, sequence.farm)?;
        let place = wanted.binary_search_by_key(&shot.delivery.number, |frame| frame.number);
        place.map_or(Ok(()), |place| work.record(files.record(&wanted[place])?, &shot.delivery))
    };

    let flown = sequence.fly(&wanted, &write, reporter);
    let summed = flown.summed();
    wanted.retain(|frame| flown.finished.binary_search(&frame.number).is_ok());
    let told = files.records(&wanted, &flown).and_then(|records| work.complete(records));
    flown.end?;
    told.map(|()| summed)
}

/// Renders frames into one stream. Returns how many were rendered, and how finely.
fn fly_stream(
    output: &FramePattern,
    fps: FrameRate,
    size: Size,
    sequence: &Sequence<'_>,
    cameras: &[NumberedCamera],
    reporter: &Reporter,
) -> Result<(usize, Fineness)> {
    if output.is_standard_output() {
        let stream = Stream::new(Stdout, Path::new(STDOUT), size, fps)?;
        let flown = sequence.fly(cameras, &|shot| stream.write(shot), reporter);
        let summed = flown.summed();
        return flown.end.map(|()| summed);
    }

    let file = output.path(1);
    let mut outcome = Ok((0, Fineness::default()));
    let written = write_with(&file, |target| {
        outcome = Stream::new(target, &file, size, fps).and_then(|stream| {
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
