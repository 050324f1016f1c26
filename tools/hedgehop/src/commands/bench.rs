//! `hedgehop bench`: how fast this machine renders a path, for several numbers of workers.
//!
//! ```text
//! warm up: every frame once (pages into memory); remember the hash of each
//! for each worker count: every frame, untimed; compare hashes
//! repeat R times: for each worker count: every frame, timed and traced
//! report medians over the repeats; replay the tasks of one worker for other numbers of them
//! ```
//! Worker counts are interleaved, so that a machine that slows down slows all of them. Frames overlap
//! as they do in `render`, so nothing but rendering may happen in a timed pass.

mod crew;
mod flags;
mod frames;
mod ranges;

pub use flags::BenchArgs;

use crate::commands::bench::flags::DEFAULT_FRAMES;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::args::{self, check_no_input};
use crate::bound_flight::{BoundFlight, FilmRequest};
use crate::exit::{self, Failure, Outcome};
use crate::figures::{BenchReport, Figures};
use crate::interrupt::Interrupt;
use crate::memory::{self, Frames, Shares};
use crate::output::WRITER;
use crate::plot;
use crate::product::Product;
use crate::progress::Reporter;
use crate::scene::{self, Playing};
use crate::speedup::{MeasuredSpeed, Prediction};
use crate::trust::{self, DamagedPage};
use crew::{Crew, Pass, crews, last_passes};
use frames::Timed;
use hedgehop::encode::atomic::{check_writable, write_bytes};
use hedgehop::encode::{FrameInfo, FrameSet, encode_picture};
use hedgehop::frame::Picture;
use hedgehop::memory::ResidentPages;
use hedgehop::progress::Observer;
use hedgehop::render::{Engine, FlightPlan, NumberedCamera, RenderOptions, Renderer, StageTimes};
use hedgehop::scene::{Scene, Scenery};
use hedgehop::space::Camera;
use hedgehop::subimage::{Batch, DEFAULT_IN_FLIGHT, Farm, FrameWork, Trace};
use hedgehop::voxel::PageSource;
use hedgehop::{Error, Result, Size};

/// Flight to be rendered, and how.
struct Job<'a> {
    pages: &'a ResidentPages,
    renderer: Renderer<'a>,
    cameras: &'a [NumberedCamera],
    playing: Option<&'a Playing>,
    reporter: &'a Reporter,
}

/// Runs the command.
pub fn run(args: &BenchArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    args.instructions.check()?;
    let scene = args.scene.read(&reporter)?;
    let files = std::iter::once(&*args.area).chain(args.flight.path.as_deref());
    let inputs: Vec<&Path> = files.chain(scene::inputs(scene.as_ref())).collect();
    let mut outputs: Vec<&PathBuf> = Vec::new();

    for (flag, file) in [("--svg", &args.svg), ("--json", &args.json), ("--trace", &args.trace)] {
        for file in file.iter().filter(|file| *file != Path::new("-")) {
            check_no_input(flag, file, &inputs)?;
            check_writable(file)?;
            if let Some(other) = outputs.iter().find(|other| *other == &file) {
                return Err(Error::Configuration(format!(
                    "{} is to be written twice; give --svg, --json and --trace a file each",
                    other.display()
                ))
                .into());
            }
            outputs.push(file);
        }
    }

    let file = args.cache.open_trusting(&args.area, args.trust.trust())?;
    let choose = |count| args.frames.clone().map_or_else(|| FrameSet::parse(&spread(count)), Ok);
    let setup = args.flight.screen.setup()?;
    let most = *args.workers.iter().max().unwrap_or(&args::available_cores());
    let in_flight = Farm::new(most)?.in_flight(args.overlap.in_flight);
    let has_objects = scene::has_objects(scene.as_ref());

    let frames = Frames {
        size: setup.size,
        product: Product::Picture,
        gathered: 0,
        has_objects,
        aov_bytes: 0,
        in_flight,
        encoders: 0,
    };

    let shares = args.memory.shares(frames)?;
    let source = ResidentPages::new(file, shares.map(|shares| shares.pages));
    let request = FilmRequest {
        file: &args.area,
        source: &source,
        setup: &setup,
        fps: args.fps,
        scene: scene.as_ref(),
        sun: args.look.running_sun(scene.as_ref())?,
    };
    let flight = BoundFlight::bind(&args.flight, &request, choose, &reporter)?;
    args.memory.preload(&source, shares, &reporter)?;
    let report = measure(args, scene.as_ref(), &source, shares, setup.size, &flight, &reporter)?;
    trust::sentence(&args.area, &DamagedPage::of(source.file()))
        .iter()
        .for_each(|sentence| reporter.note(sentence));

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

fn measure(
    args: &BenchArgs,
    scene: Option<&Scene>,
    source: &ResidentPages,
    shares: Option<Shares>,
    size: Size,
    flight: &BoundFlight,
    reporter: &Reporter,
) -> Result<BenchReport> {
    let BoundFlight { playing, cameras, .. } = flight;
    let mut crews = crews(args)?;
    let (most, cores) =
        (crews.iter().map(|crew| crew.farm.workers()).max().unwrap_or(1), args::available_cores());
    if most > cores {
        reporter.note(&format!(
            "{most} workers share {cores} core{}: figures of more workers than cores say nothing about a machine that has these, nor about the prediction",
            if cores == 1 { "" } else { "s" }
        ));
    }

    let look = args.look.options(scene, source.header())?;
    let look = RenderOptions { engine: args.instructions.engine(), ..look };
    let options = args.flight.world.apply(source.header(), look);
    let mut renderer = Renderer::new(source, &options).with_isa(args.instructions.isa());
    if let Some(shares) = shares {
        renderer = renderer.with_memory(shares.derived as usize);
    }

    let job = Job { pages: source, renderer, cameras, playing: playing.as_ref(), reporter };
    let passes = 1 + crews.len() as u64 * (1 + u64::from(args.repeats));
    reporter.begin("bench", passes * cameras.len() as u64, "frames");
    let (identical_frames, encode_ms) = job.compare(&crews, args.dump_ranges.as_deref())?;

    for _ in 0..args.repeats {
        for crew in &mut crews {
            crew.passes.push(job.time(crew)?);
        }
    }

    reporter.end();
    if let Some(file) = &args.trace {
        write_bytes(file, format!("{}\n", last_passes(&crews)).as_bytes())?;
    }

    let pixels = f64::from(size.width) * f64::from(size.height);
    let all: Vec<Figures> =
        crews.iter().map(|crew| figures(crew, encode_ms, cameras.len() as f64, pixels)).collect();
    let one = crews[0].passes.iter().map(|pass| FrameWork::from_trace(&pass.trace));
    let measured: Vec<_> = all
        .iter()
        .map(|figures| MeasuredSpeed { workers: figures.workers, frames_per_s: figures.frames_per_s })
        .collect();
    let in_flight = args.overlap.in_flight.unwrap_or(DEFAULT_IN_FLIGHT);
    let prediction = Prediction::new(&FrameWork::least(one), in_flight, &measured, args::available_cores());
    let listed = all.into_iter().zip(&crews).filter(|(_, crew)| crew.is_listed);
    let mut results: Vec<Figures> = listed.map(|(figures, _)| figures).collect();
    set_efficiency(&mut results);

    Ok(BenchReport {
        hedgehop: env!("CARGO_PKG_VERSION"),
        cores: args::available_cores(),
        engine: args.instructions.engine,
        simd: (options.engine == Engine::Planes).then(|| args.instructions.isa().name()),
        frames_by_reference: job.frames_by(Engine::Reference)?,
        area: args.area.display().to_string(),
        content_hash: source.header().content_hash.to_string(),
        size: [size.width, size.height],
        frames: cameras.iter().map(|frame| frame.number).collect(),
        repeats: args.repeats,
        identical_frames,
        results,
        prediction,
    })
}

impl Job<'_> {
    /// Returns the scenery in a frame.
    fn scenery(&self, number: u64) -> Scenery {
        self.playing.as_ref().map(|playing| playing.scenery(number)).unwrap_or_default()
    }

    /// The renderer of a frame.
    fn at(&self, frame: &NumberedCamera) -> Renderer<'_> {
        let seconds = self.playing.as_ref().map_or(0.0, |playing| playing.seconds(frame.number));
        self.renderer.under(frame.sky).at(seconds)
    }

    /// Counts the frames that `engine` renders.
    fn frames_by(&self, engine: Engine) -> Result<usize> {
        let by = |frame: &NumberedCamera| self.renderer.engine_for(&frame.camera);
        self.cameras.iter().map(by).try_fold(0, |count, by| Ok(count + usize::from(by? == engine)))
    }

    /// Renders every frame and shows it to `look` in order.
    fn fly(
        &self,
        farm: &Farm,
        in_flight: usize,
        mut look: impl FnMut(u64, Timed) -> Result<()>,
    ) -> Result<()> {
        let frames: Vec<_> =
            (0..).zip(self.cameras).map(|(frame, seen)| (seen.number, (frame, &seen.camera))).collect();
        let batch = Batch { frames: &frames, in_flight, observer: self.reporter };
        let plan = FlightPlan::new(&self.renderer, farm, self.cameras).of_pictures();

        let flown = self.pages.ahead_of(frames.len() as u32, &plan, |flight| {
            let mut delivered = 0;
            let render = |farm: &Farm, &(frame, camera): &(u32, &Camera)| {
                flight.begin(frame);
                let seen = &self.cameras[frame as usize];
                let (scenery, renderer) = (self.scenery(seen.number), self.at(seen));
                Timed::render(|| renderer.picture_with(camera, &scenery, farm))
            };

            farm.fly(&batch, render, |number, timed| {
                self.reporter.advance(1);
                flight.deliver(delivered);
                delivered += 1;
                look(number, timed)
            })
        });

        flown.flatten().map_err(|error| match error {
            Error::Interrupted(_) => Error::Interrupted("nothing was measured".into()),
            other => other,
        })
    }

    /// Whether all numbers of workers make the same frames, and how long one takes to encode, milliseconds.
    /// The first frames' ranges go into `dump_ranges`.
    fn compare(&self, crews: &[Crew], dump_ranges: Option<&Path>) -> Result<(bool, f64)> {
        let Some(most) = crews.last() else { return Ok((true, 0.0)) };
        let mut encoding = Duration::ZERO;
        let mut reference = Vec::with_capacity(self.cameras.len());

        // One frame after the other, so that rendering does not slow the encoder.
        let mut cameras = self.cameras.iter();
        self.fly(&most.farm, 1, |number, Timed { picture, .. }| {
            let Some(seen) = cameras.next() else { return Ok(()) };
            encoding += encode(&picture, &seen.camera, number)?;
            reference.push(blake3::hash(&picture.rgb));
            match dump_ranges {
                Some(folder) => ranges::dump(
                    folder,
                    number,
                    &self.at(seen).frame_with(&seen.camera, &self.scenery(number), &most.farm)?.frame,
                ),
                None => Ok(()),
            }
        })?;

        let mut is_identical = true;
        for crew in crews {
            let mut expected = reference.iter();
            self.fly(&crew.farm, crew.in_flight, |_, Timed { picture, .. }| {
                is_identical &= expected.next() == Some(&blake3::hash(&picture.rgb));
                Ok(())
            })?;
        }

        Ok((is_identical, encoding.as_secs_f64() * 1000.0 / self.cameras.len() as f64))
    }

    fn time(&self, crew: &Crew) -> Result<Pass> {
        let trace = Arc::new(Trace::new(crew.farm.workers()));
        let mut stages = StageTimes::default();
        let mut frames = Vec::new();
        let paging = self.pages.paging();
        let begun = Instant::now();
        self.fly(&crew.farm.with_trace(&trace), crew.in_flight, |number, timed| {
            stages.march += timed.stages.march;
            stages.shade += timed.stages.shade;
            stages.image += timed.stages.image;
            if crew.in_flight == 1 {
                frames.push(timed.times(number));
            }
            self.renderer.recycle(timed.picture);
            Ok(())
        })?;
        let (wall, paging) = (begun.elapsed(), self.pages.paging().since(&paging));
        Ok(Pass { wall, stages, frames, trace, paging })
    }
}

/// Time to make a PNG in memory.
fn encode(picture: &Picture, camera: &Camera, number: u64) -> Result<Duration> {
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
    let bytes = encode_picture(Path::new("bench.png"), picture, camera, &info)?;
    let elapsed = begun.elapsed();
    std::hint::black_box(bytes);
    Ok(elapsed)
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

fn figures(crew: &Crew, encode_ms: f64, frames: f64, pixels: f64) -> Figures {
    let passes = &crew.passes;
    let seconds = median(passes.iter().map(|pass| pass.wall.as_secs_f64()));
    let per_frame = |time: fn(&Pass) -> Duration| {
        median(passes.iter().map(|pass| time(pass).as_secs_f64())) * 1000.0 / frames
    };
    let frames_per_s = frames / seconds;

    Figures {
        workers: crew.farm.workers(),
        in_flight: crew.in_flight,
        frames_per_s,
        mpixel_per_s: frames_per_s * pixels / 1e6,
        efficiency: 1.0,
        march_ms: per_frame(|pass| pass.stages.march),
        shade_ms: per_frame(|pass| pass.stages.shade),
        image_ms: per_frame(|pass| pass.stages.image),
        encode_ms,
        paging: passes.last().map(|pass| pass.paging).unwrap_or_default(),
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

fn table(report: &BenchReport) -> String {
    let [width, height] = report.size;
    let mut text = format!(
        "{}: {} frames of {width}x{height}, median of {}, {} cores, {}\n\n\
         workers  frames/s  Mpixel/s  efficiency  march ms  shade ms  image ms  encode ms\n",
        report.area,
        report.frames.len(),
        report.repeats,
        report.cores,
        report.marcher()
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
        "\nefficiency: speed per worker against {base}; march and shade: time per frame, summed over workers; image:\n\
         haze and sky (wall time) of the reference, taking planes to the screen and 8 bits (summed) of planes; encode:\n\
         PNG to memory on one thread, not part of frames/s\n"
    );
    for f in &report.results {
        text += &format!("\n{} workers, last pass: {}\n", f.workers, memory::sentence(&f.paging));
    }

    text += &report.prediction.table();
    text += if report.identical_frames {
        "\nall numbers of workers gave identical frames\n"
    } else {
        "\nFRAMES DIFFER between numbers of workers\n"
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
