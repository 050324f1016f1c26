//! Frames as flags and the scene ask for them, bound to a database.

use super::conflicts;
use super::flags::RenderArgs;
use super::notes;
use crate::aov::AovKind;
use crate::bound_flight::{BoundFlight, FilmMotion, FilmRequest};
use crate::farm::work::ChunkWork;
use crate::finish;
use crate::memory::Frames;
use crate::own_body;
use crate::product::Product;
use crate::progress::Reporter;
use crate::scene;
use crate::screen::Setup;
use hedgehop::Result;
use hedgehop::encode::video::VideoSettings;
use hedgehop::encode::{FrameSet, Target};
use hedgehop::progress::Observer;
use hedgehop::render::RenderOptions;
use hedgehop::scene::{Finish, Scene, Titling};
use hedgehop::voxel::{Header, PageSource};

/// Frames as flags and the scene ask for them.
pub struct FrameRequest {
    /// Scene, if there is one.
    pub scene: Option<Scene>,
    /// Steps from light to a picture.
    pub finish: Finish,
    /// Text and figures over the picture.
    pub titling: Titling,
    /// Screen of the frames.
    pub setup: Setup,
    /// Product of each frame.
    pub product: Product,
    /// Film to be made, if one is.
    pub film: Option<VideoSettings>,
}

impl FrameRequest {
    /// Reads the scene and refuses flags that do not go together.
    pub fn read(args: &RenderArgs, reporter: &Reporter) -> Result<Self> {
        let scene = args.trails.add_to(args.scene.read(reporter)?, &args.flight, reporter)?;
        let finish = args.finish.finish(scene.as_ref())?;
        let titling = args.titling.titling(scene.as_ref())?;
        let setup = args.film.sized(&args.flight.screen)?.setup()?.behind_lens(finish.distortion)?;
        let scene = if setup.is_map() { scene } else { own_body::add_to(scene, &args.flight, reporter)? };
        conflicts::check_combination(args, scene.as_ref(), &setup)?;
        conflicts::check_views(args, &finish, &titling)?;
        conflicts::check_labels(args, &finish)?;
        args.aov.check(args.target(), &setup)?;
        let product = match args.target() {
            Some(Target::Exr | Target::Npy) => Product::Frame,
            Some(Target::Png) if args.labels.labels.is_some() => Product::Frame,
            Some(Target::Png | Target::Y4m) | None => Product::Picture,
        };

        // Workers of a farm leave the film to the end of the job.
        let film = if args.work.is_worker() { None } else { args.film.settings(args.fps)? };
        film.iter().try_for_each(|film| conflicts::check_film(args, scene.as_ref(), film))?;
        Ok(Self { scene, finish, titling, setup, product, film })
    }

    /// Returns what the flight's frames take of the memory.
    pub fn frames(&self, aov_bytes: u64, in_flight: usize, encoders: usize) -> Frames {
        let is_gathered =
            self.finish.gathers() || self.finish.is_developed() && self.product == Product::Picture;
        Frames {
            size: self.setup.size,
            product: self.product,
            gathered: if is_gathered { self.finish.antialias } else { 0 },
            has_objects: scene::has_objects(self.scene.as_ref()),
            aov_bytes,
            in_flight,
            encoders,
        }
    }
}

/// Binds path, cameras and scene to the database, whose ground is read from `ground`.
pub fn bind(
    args: &RenderArgs,
    request: &FrameRequest,
    work: Option<&ChunkWork>,
    ground: &dyn PageSource,
    reporter: &Reporter,
) -> Result<BoundFlight> {
    let FrameRequest { scene, finish, setup, .. } = request;
    let scene = scene.as_ref();
    let chosen = work.map(|work| &work.frames).or(args.frames.as_ref());
    let choose = |count| {
        work.map_or(Ok(()), |work| work.check_length(count))?;
        Ok(chosen.cloned().unwrap_or_else(|| FrameSet::all(count)))
    };
    let sun = args.look.running_sun(scene)?;
    let film = FilmRequest { file: &args.area, source: ground, setup, fps: args.fps, scene, sun };
    let bound = BoundFlight::bind(&args.flight, &film, choose, reporter)?;
    finish::check_lens(&bound.cameras, finish)?;
    if let Some(note) = scene.filter(|_| setup.is_map()).and_then(scene::left_out_of_map) {
        reporter.note(&note);
    }

    Ok(bound)
}

/// Returns the options of the engine, and notes shadows of another sun in the database's colours.
pub fn render_options(
    args: &RenderArgs,
    scene: Option<&Scene>,
    header: &Header,
    motion: &FilmMotion,
    reporter: &Reporter,
) -> Result<RenderOptions> {
    let look = RenderOptions {
        engine: args.instructions.engine(),
        matte: args.aov.has(AovKind::Cryptomatte),
        tells_synthesis: args.aov.has(AovKind::Synthesis),
        ..args.look.options(scene, header)?
    };
    let options = args.flight.world.apply(header, look);
    let still = motion.sky.is_none().then_some(options.sun);
    if let Some(note) = notes::other_sun(&args.area, header, still) {
        reporter.note(&note);
    }
    Ok(options)
}
