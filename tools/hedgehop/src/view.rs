//! Flags of the flight and its look: the path or the single eye, bound to a database.

use std::cell::RefCell;
use std::path::PathBuf;

use clap::ValueEnum;
use glam::DVec2;

use crate::args::{self, AltitudeMode};
use crate::camera::{CameraArgs, single_fix};
use crate::playback::PlaybackArgs;
use crate::running_sun::RunningSun;
use crate::screen::{ScreenArgs, Setup};
use crate::smoothing::SmoothingArgs;
use crate::tracks::TrackArgs;
use crate::views::ViewArgs;
use crate::world::WorldArgs;
use crate::{area, reference};
use hedgehop::flight::{Altitude, BindOptions, Horizontal, Track, Trajectory, Views, read_track};
use hedgehop::geo::Crs;
use hedgehop::progress::Observer;
use hedgehop::raymarch::SPAN_PIXELS;
use hedgehop::render::RenderOptions;
use hedgehop::scene::{OwnFlight, Scene};
use hedgehop::sunlight::{FilmSun, Night, Sun, SunSetting};
use hedgehop::voxel::{Header, PageSource};
use hedgehop::{Error, Result};

/// Flags of the flight: the path of the eye.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Flight")]
#[command(group(clap::ArgGroup::new("view").required(true).args(["path", "eye", "views"])))]
pub struct FlightArgs {
    /// Flight path: CSV, JSBSim CSV, KML gx:Track, GPX or IGC
    #[arg(long, value_name = "FILE")]
    pub path: Option<PathBuf>,

    /// A single eye instead of a path: metres in the database's reference system
    #[arg(long, value_name = "X,Y,Z", value_parser = args::position, allow_hyphen_values = true)]
    pub eye: Option<[f64; 3]>,

    /// --eye is longitude and latitude in degrees (WGS 84) and altitude in metres
    #[arg(long, requires = "eye")]
    pub eye_lonlat: bool,

    /// Attitude of --eye, degrees: yaw clockwise from true north, pitch up, roll right wing down [default: 0,0,0]
    #[arg(long, value_name = "YAW,PITCH,ROLL", value_parser = args::attitude, requires = "eye", allow_hyphen_values = true)]
    pub ypr: Option<[f64; 3]>,

    /// Surface that altitudes are measured from where the path file does not say, and for --eye [default: msl]
    #[arg(long, value_enum, value_name = "MODE")]
    pub alt_mode: Option<AltitudeMode>,

    /// Fly without bank where the attitude is derived from the track
    #[arg(long, conflicts_with_all = ["eye", "views"])]
    pub level: bool,

    /// Least height above ground, metres; lower parts of the path are raised [default: as the path says]
    #[arg(long, value_name = "METRES", value_parser = args::not_negative, allow_negative_numbers = true)]
    pub clearance: Option<f64>,

    /// Go on where the eye lies below the ground, where there is one dark colour to see
    #[arg(long)]
    pub allow_below_ground: bool,

    #[command(flatten)]
    pub tracks: TrackArgs,

    #[command(flatten)]
    pub camera: CameraArgs,

    #[command(flatten)]
    pub smoothing: SmoothingArgs,

    #[command(flatten)]
    pub playback: PlaybackArgs,

    #[command(flatten)]
    pub screen: ScreenArgs,

    #[command(flatten)]
    pub views: ViewArgs,

    #[command(flatten)]
    pub world: WorldArgs,
}

/// Flags of the ground's surface and its light: sun, shadows, haze, detail.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Look")]
pub struct LookArgs {
    /// smooth: interpolated between posts; blocks: the voxels themselves
    #[arg(long, value_enum, default_value = "smooth")]
    pub surface: Surface,

    /// Meteorological visibility at the lowest ground, metres
    #[arg(long, value_name = "METRES", value_parser = args::positive, allow_negative_numbers = true, help = visibility_help())]
    pub visibility: Option<f64>,

    /// Sun's azimuth clockwise from north and elevation above the horizon, degrees, or the time: 2026-06-21T09:30Z; track: it
    /// runs with the flight, by the path file's clock [default: 135,40]
    #[arg(long, value_name = "AZ,EL|TIME|track", value_parser = args::film_sun, allow_hyphen_values = true)]
    pub sun: Option<FilmSun>,

    /// The sun runs with the flight; TIME of --sun is that of the path's first fix
    #[arg(long, requires = "sun")]
    pub sun_runs: bool,

    /// Whether ground lies in the shadow of ground [default: off]
    #[arg(long, value_enum)]
    pub shadows: Option<Switch>,

    /// Fineness at which far and steep ground is looked at, 0.1 to 16: 2 is sharper and slower, 0.5 softer and faster
    #[arg(long, value_name = "FACTOR", value_parser = args::detail, allow_negative_numbers = true, default_value = "1")]
    pub detail: f64,

    /// Detail below the finest voxel, made up as rough as the imagery is there: on, off, or a factor on its strength, up to 2
    #[arg(long, value_name = "on|off|FACTOR", value_parser = args::detail_synthesis, default_value = "on")]
    pub detail_synthesis: f64,

    /// Pixels that a voxel fills at least where houses and trees keep shapes and walls, from 0.25 on: with 2.5 they melt far off, in half to two thirds of the time
    #[arg(long, value_name = "PIXELS", value_parser = args::far_spans, allow_negative_numbers = true, default_value_t = SPAN_PIXELS)]
    pub far_spans: f64,
}

/// Help of `--visibility`: its default is the library's, which a scene goes before.
fn visibility_help() -> String {
    let default = RenderOptions::default().visibility;
    format!("Meteorological visibility at the lowest ground, metres [default: {default}]")
}

/// Something that may be had or not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    /// Switched on
    On,
    /// Switched off
    Off,
}

/// Surfaces as users name them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Surface {
    /// Interpolated between posts
    Smooth,
    /// Voxels as blocks
    Blocks,
}

impl Default for LookArgs {
    fn default() -> Self {
        Self {
            surface: Surface::Smooth,
            visibility: None,
            sun: None,
            sun_runs: false,
            shadows: None,
            detail: 1.0,
            detail_synthesis: 1.0,
            far_spans: SPAN_PIXELS,
        }
    }
}

impl LookArgs {
    /// Returns the sun that the flags ask for.
    fn flagged_sun(&self) -> Result<Option<FilmSun>> {
        match self.sun {
            Some(FilmSun::Still(SunSetting::Time(time))) if self.sun_runs => Ok(Some(FilmSun::From(time))),
            Some(_) if self.sun_runs => Err(Error::Configuration(
                "--sun-runs needs a TIME as --sun; --sun track runs without it, and angles tell no time"
                    .into(),
            )),
            sun => Ok(sun),
        }
    }

    /// Returns the sun that runs with the flight, if one does; what a scene says holds where no flag does.
    pub fn running_sun<'s>(&self, scene: Option<&'s Scene>) -> Result<Option<RunningSun<'s>>> {
        Ok(match (self.flagged_sun()?, scene) {
            (Some(sun), _) => RunningSun::new(sun, None),
            (None, Some(scene)) => scene.sun.and_then(|sun| RunningSun::new(sun, Some(scene))),
            (None, None) => None,
        })
    }

    /// The library's options for a database; what a scene says holds where no flag does. A sun that runs is none of them.
    pub fn options(&self, scene: Option<&Scene>, header: &Header) -> Result<RenderOptions> {
        let mut options = RenderOptions {
            surface: match self.surface {
                Surface::Smooth => hedgehop::raymarch::Surface::Smooth,
                Surface::Blocks => hedgehop::raymarch::Surface::Blocks,
            },
            detail: self.detail,
            detail_synthesis: self.detail_synthesis,
            far_spans: self.far_spans,
            ..RenderOptions::default()
        };

        if let Some(visibility) = self.visibility.or(scene.and_then(|scene| scene.visibility)) {
            options.visibility = visibility;
        }
        let sky = match (self.flagged_sun()?, scene) {
            (Some(FilmSun::Still(sun)), _) => Some(area::sky(sun, header)?),
            (Some(FilmSun::Track | FilmSun::From(_)), _) | (None, None) => None,
            (None, Some(scene)) => area::sky_of(scene, header)?,
        };
        let sun = sky.map(|sky| sky.sun);
        let baked = header.metadata.baked_sun.map(|[azimuth, elevation]| Sun { azimuth, elevation });
        options.sun = sun.or(baked).unwrap_or(options.sun);
        let shadows = self.shadows.map(|switch| switch == Switch::On);
        options.shadows = shadows.or(scene.and_then(|scene| scene.shadows)).unwrap_or(options.shadows);

        if let (Some(baked), true) = (baked, options.shadows) {
            let what = format!(
                "the database's colours hold the shadows of a sun {:.1}° from grid north and {:.1}° high already",
                baked.azimuth, baked.elevation
            );
            let line = scene.and_then(|scene| Some((&scene.path, scene.lines.shadows?)));

            return Err(match line.filter(|_| self.shadows.is_none()) {
                Some((path, line)) => Error::invalid(
                    path,
                    format!(
                        "line {line}: shadows = true, and {what}; leave it out, give --shadows off, or render the database that it was baked from"
                    ),
                ),
                None => Error::Configuration(format!(
                    "{what}; render it without --shadows on, or the database that it was baked from"
                )),
            });
        }

        let night = scene.map(|scene| scene.night).unwrap_or_default();
        let firmament = sky.map(|sky| sky.firmament).unwrap_or_default();
        options.night = Night { lux: night.lux, stars: night.stars.then_some(firmament) };
        options.weather = scene.map(|scene| scene.weather).unwrap_or_default();

        Ok(options)
    }
}

impl FlightArgs {
    /// Whether frames are several, which numbers tell apart: of a path or a set of views.
    pub fn is_sequence(&self) -> bool {
        self.path.is_some() || self.views.views.is_some()
    }

    /// Returns the views that flags ask for instead of a flight, if they do.
    ///
    /// # Errors
    /// Flags that do not go together, or with a map.
    pub fn views(&self, header: &Header, setup: &Setup) -> Result<Option<Views>> {
        let Some(kind) = self.views.views else { return self.views.check_unused().map(|()| None) };
        self.tracks.check(false, "--path")?;
        if setup.is_map() && (self.views.have_directions() || self.camera.is_given()) {
            return Err(Error::Configuration(
                "a map is seen from above; leave out --pitches, --headings and --look-at, or take another screen".into(),
            ));
        }
        let target = self.camera.place(self.alt_mode.map(Into::into))?;
        self.views.views(kind, &header.grid, target, setup.hfov).map(Some)
    }

    /// Binds the path, or the single eye, to a database.
    pub fn bind(
        &self,
        source: &dyn PageSource,
        setup: &Setup,
        observer: &dyn Observer,
    ) -> Result<Trajectory> {
        let track = self.track()?;
        if !setup.takes_hfov_from_path() && track.fixes.iter().any(|fix| fix.hfov.is_some()) {
            observer.note("the path's fields of view are for planar screens; this one has its own");
        }
        let options = BindOptions { hfov: setup.hfov, ..self.binding() };
        let trajectory =
            over_ground(source, self.world, |crs, ground| Trajectory::bind(&track, crs, ground, &options))?;
        track.notes.iter().chain(trajectory.notes()).for_each(|note| observer.note(note));
        Ok(trajectory)
    }

    /// Returns the options by which a path is bound, but for the field of view.
    pub fn binding(&self) -> BindOptions {
        BindOptions {
            level: self.level,
            clearance: self.clearance,
            smoothing: self.smoothing.smoothing(),
            ..BindOptions::default()
        }
    }

    /// Returns the flight that a scene may hold the body of; `None`: there is a single eye, or views.
    pub fn own_flight(&self) -> Option<OwnFlight> {
        OwnFlight::new(self.path.as_deref()?, self.binding())
    }

    /// Reads the path, or the single eye.
    pub fn track(&self) -> Result<Track> {
        self.tracks.check(self.path.is_some(), "--path")?;
        match (&self.path, self.eye) {
            (Some(path), _) => read_track(path, &self.tracks.options(self.alt_mode.map(Into::into))),
            (None, Some(eye)) => Ok(self.single_fix(eye)),
            (None, None) => Err(Error::Configuration("give --path FILE or --eye X,Y,Z".into())),
        }
    }

    /// The eye as a track of one fix, so that both ways share altitude modes, clearance and north.
    fn single_fix(&self, [x, y, z]: [f64; 3]) -> Track {
        let horizontal = if self.eye_lonlat { Horizontal::LonLat(x, y) } else { Horizontal::Xy(x, y) };
        let mode = self.alt_mode.unwrap_or(AltitudeMode::Msl).into();
        single_fix("--eye", horizontal, Altitude { metres: z, mode }, self.ypr.unwrap_or_default())
    }
}

/// Binds something to a database's reference system and its surface, which answers questions about the ground.
pub fn over_ground<T>(
    source: &dyn PageSource,
    world: WorldArgs,
    bind: impl FnOnce(&Crs, &dyn Fn(DVec2) -> Option<f64>) -> Result<T>,
) -> Result<T> {
    let damaged = RefCell::new(None);
    let ground = |position: DVec2| {
        world.ground(source, position).unwrap_or_else(|error| {
            damaged.borrow_mut().get_or_insert(error);
            None
        })
    };
    let bound = bind(&reference::crs(source.header())?, &ground);
    match damaged.into_inner() {
        // A page that cannot be read explains whatever the binding said about missing ground.
        Some(error) => Err(error),
        None => bound,
    }
}
