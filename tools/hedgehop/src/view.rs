//! Cameras from flags: the path or the single eye, bound to a database, and how its pictures look.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use glam::DVec2;

use crate::aim::AimArgs;
use crate::args::{self, AltitudeMode};
use crate::partner::Partner;
use crate::playback::PlaybackArgs;
use crate::screen::{ScreenArgs, Setup};
use crate::tracks::TrackArgs;
use crate::world::WorldArgs;
use crate::{area, reference, sharpness};
use hedgehop::encode::FrameSet;
use hedgehop::flight::{
    Altitude, BindOptions, Fix, FrameRate, Horizontal, Timeline, Track, Trajectory, read_track,
};
use hedgehop::geo::Crs;
use hedgehop::progress::{Observer, Silent};
use hedgehop::render::{NumberedCamera, RenderOptions};
use hedgehop::scene::Scene;
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::sunlight::{Night, Sun, SunSetting};
use hedgehop::voxel::{Header, PageSource};
use hedgehop::{Error, Result};
use hedgehop_query::Ground;

/// Far more frames than anybody renders at once, and few enough to list: days of flight.
const MOST_FRAMES: usize = 10_000_000;

/// Metres by which an eye on the ground may lie below it.
const ROUNDING: f64 = 1.0e-3;

/// Pose of the eye in a frame.
#[derive(Debug, Clone, Copy)]
pub struct NumberedPose {
    /// Number of the frame, 1…
    pub number: u64,
    /// Pose of the eye.
    pub pose: Pose,
}

/// A path bound to a database, and its frames.
#[derive(Debug)]
pub struct BoundFlight {
    /// Path of the eye over time.
    pub trajectory: Trajectory,
    /// Moments of the frames.
    pub timeline: Timeline,
    /// Numbers and cameras of the frames that were chosen, rising.
    pub cameras: Vec<NumberedCamera>,
}

/// Flags of the flight: the path of the eye.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Flight")]
#[command(group(clap::ArgGroup::new("view").required(true).args(["path", "eye"])))]
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
    #[arg(long, conflicts_with = "eye")]
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
    pub aim: AimArgs,

    #[command(flatten)]
    pub playback: PlaybackArgs,

    #[command(flatten)]
    pub screen: ScreenArgs,

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

    /// Sun's azimuth clockwise from north and elevation above the horizon, degrees, or the time: 2026-06-21T09:30Z [default: 135,40]
    #[arg(long, value_name = "AZ,EL|TIME", value_parser = args::sun, allow_hyphen_values = true)]
    pub sun: Option<SunSetting>,

    /// Whether ground lies in the shadow of ground [default: off]
    #[arg(long, value_enum)]
    pub shadows: Option<Switch>,

    /// Fineness at which far and steep ground is looked at, 0.1 to 16: 2 is sharper and slower, 0.5 softer and faster
    #[arg(long, value_name = "FACTOR", value_parser = args::detail, allow_negative_numbers = true, default_value = "1")]
    pub detail: f64,
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

impl LookArgs {
    /// The library's options for a database; what a scene says holds where no flag does.
    pub fn options(&self, scene: Option<&Scene>, header: &Header) -> Result<RenderOptions> {
        let mut options = RenderOptions {
            surface: match self.surface {
                Surface::Smooth => hedgehop::raymarch::Surface::Smooth,
                Surface::Blocks => hedgehop::raymarch::Surface::Blocks,
            },
            detail: self.detail,
            ..RenderOptions::default()
        };

        if let Some(visibility) = self.visibility.or(scene.and_then(|scene| scene.visibility)) {
            options.visibility = visibility;
        }
        let sky = match (self.sun, scene) {
            (Some(sun), _) => Some(area::sky(sun, header)?),
            (None, Some(scene)) => area::sky_of(scene, header)?,
            (None, None) => None,
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
        let options = BindOptions {
            level: self.level,
            hfov: setup.hfov,
            clearance: self.clearance,
            aim: self.aim.aim(),
        };
        let trajectory =
            over_ground(source, self.world, |crs, ground| Trajectory::bind(&track, crs, ground, &options))?;
        track.notes.iter().chain(trajectory.notes()).for_each(|note| observer.note(note));
        Ok(trajectory)
    }

    /// Poses of a map: straight down from above all ground, grid north up, unless --ypr says otherwise.
    fn look_down(&self, highest: f64, poses: &mut [NumberedPose], observer: &dyn Observer) {
        if self.ypr.is_some() {
            return;
        }
        let above = highest.ceil() + 1.0;
        if poses.iter().any(|numbered| numbered.pose.eye.z < above) {
            observer.note(&format!("the map is seen from {above} m, above all ground"));
        }
        for NumberedPose { pose, .. } in poses {
            pose.attitude = Attitude { yaw: 0.0, pitch: -90.0, roll: 0.0 };
            pose.eye.z = pose.eye.z.max(above);
        }
    }

    /// Binds the path, and finds the cameras of the frames that `choose` takes out of the flight's count, after checks that
    /// somebody will see something.
    pub fn flight(
        &self,
        file: &Path,
        source: &dyn PageSource,
        setup: &Setup,
        fps: FrameRate,
        choose: impl FnOnce(u64) -> Result<FrameSet>,
        observer: &dyn Observer,
    ) -> Result<BoundFlight> {
        let trajectory = self.bind(source, setup, observer)?;
        let timeline = Timeline::new(fps, trajectory.span(), &self.playback.playback())?;
        let count = timeline.frame_count();
        let frames = choose(count)?;
        frames.check_within(count)?;
        let mut poses: Vec<_> = frames
            .iter()
            .take(MOST_FRAMES)
            .map(|number| NumberedPose { number, pose: trajectory.pose_at(timeline.seconds_at(number)) })
            .collect();
        if poses.len() == MOST_FRAMES {
            return Err(Error::Configuration(format!(
                "the path lasts {:.0} s, which is too many frames at once; choose some with --frames, show it faster with --speed or --duration, or check the unit of its times",
                trajectory.duration()
            )));
        }

        if !self.world.tile_world {
            check_inside(file, source, &poses)?;
        }
        if setup.is_map() {
            self.look_down(source.header().height_range.high, &mut poses, observer);
        }

        self.world.note_seam(source.header(), observer);
        check_above_ground(self, source, timeline, &poses, observer)?;
        if !setup.is_map() {
            let cameras: Vec<Camera> = sharpness::some(poses.iter().map(|numbered| numbered.pose))
                .map(|pose| setup.camera(pose))
                .collect();
            let ground = |place: DVec2| self.world.ground(source, place);
            sharpness::warning(source.header(), &cameras, ground)?
                .iter()
                .for_each(|note| observer.note(note));
        }

        let camera_of = |NumberedPose { number, pose }| NumberedCamera { number, camera: setup.camera(pose) };
        let cameras = poses.into_iter().map(camera_of).collect();
        Ok(BoundFlight { trajectory, timeline, cameras })
    }

    /// The frame next to each of `numbers`, which tells its motion: the one behind it, or before the last; of a single one itself a moment later.
    pub fn partners(
        &self,
        source: &dyn PageSource,
        setup: &Setup,
        fps: FrameRate,
        numbers: impl Iterator<Item = u64>,
    ) -> Result<BTreeMap<u64, Partner>> {
        // What there is to say was said when the frames were chosen.
        let trajectory = self.bind(source, setup, &Silent)?;
        let timeline = Timeline::new(fps, trajectory.span(), &self.playback.playback())?;
        let count = timeline.frame_count();
        let beside = |number: u64| if number < count || number == 1 { number + 1 } else { number - 1 };
        let numbers: Vec<u64> = numbers.collect();
        let pose =
            |number: u64| NumberedPose { number, pose: trajectory.pose_at(timeline.seconds_at(number)) };
        let mut poses: Vec<_> = numbers.iter().map(|number| pose(beside(*number))).collect();
        if setup.is_map() {
            self.look_down(source.header().height_range.high, &mut poses, &Silent);
        }
        let partner = |NumberedPose { number, pose }| Partner { number, camera: setup.camera(pose) };
        Ok(numbers.into_iter().zip(poses.into_iter().map(partner)).collect())
    }

    fn track(&self) -> Result<Track> {
        self.tracks.check(self.path.is_some(), "--path")?;
        match (&self.path, self.eye) {
            (Some(path), _) => read_track(path, &self.tracks.options(self.alt_mode.map(Into::into))),
            (None, Some(eye)) => Ok(self.single_fix(eye)),
            (None, None) => Err(Error::Configuration("give --path FILE or --eye X,Y,Z".into())),
        }
    }

    /// The eye as a track of one fix, so that both ways share altitude modes, clearance and north.
    fn single_fix(&self, [x, y, z]: [f64; 3]) -> Track {
        let [yaw, pitch, roll] = self.ypr.unwrap_or_default();
        let horizontal = if self.eye_lonlat { Horizontal::LonLat(x, y) } else { Horizontal::Xy(x, y) };
        let mode = self.alt_mode.unwrap_or(AltitudeMode::Msl).into();
        let fix = Fix {
            time: 0.0,
            horizontal,
            altitude: Altitude { metres: z, mode },
            yaw: Some(yaw),
            pitch: Some(pitch),
            roll: Some(roll),
            hfov: None,
        };
        Track {
            path: "--eye".into(),
            format: "single eye",
            fixes: vec![fix],
            time_of_day: None,
            notes: Vec::new(),
        }
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

fn check_inside(file: &Path, source: &dyn PageSource, poses: &[NumberedPose]) -> Result<()> {
    let header = source.header();
    let inside = |pose: &Pose| header.grid.contains(pose.eye.truncate());
    let Some(NumberedPose { number, pose }) = poses.iter().find(|outside| !inside(&outside.pose)) else {
        return Ok(());
    };
    let within: Vec<u64> =
        poses.iter().filter(|within| inside(&within.pose)).map(|within| within.number).collect();
    let degrees =
        !reference::crs(header)?.is_local() && pose.eye.x.abs() <= 180.0 && pose.eye.y.abs() <= 90.0;

    let remedy = if within.is_empty() && degrees {
        "degrees need --eye-lonlat, or columns lon_deg and lat_deg".to_owned()
    } else if within.is_empty() {
        "check the reference system and the order of the axes".to_owned()
    } else {
        format!("--frames {} are inside", ranges(&within))
    };

    Err(Error::Configuration(format!(
        "the camera of frame {number} at x {:.1}, y {:.1} is outside {}, which covers {}; {remedy}",
        pose.eye.x,
        pose.eye.y,
        file.display(),
        area::extents(header)?
    )))
}

/// Refuses eyes below the ground, which see nothing but one dark colour.
fn check_above_ground(
    flight: &FlightArgs,
    source: &dyn PageSource,
    timeline: Timeline,
    poses: &[NumberedPose],
    observer: &dyn Observer,
) -> Result<()> {
    let depth = |pose: &Pose| -> Result<Option<f64>> {
        let place = pose.eye.truncate();
        let ground = flight.world.ground(source, place)?;
        let Some(ground) = ground.filter(|ground| ground - pose.eye.z > ROUNDING) else { return Ok(None) };
        // Below a bridge or a crown one is not underground.
        let bare = Ground::Bare.height_at(source, place)?;
        Ok(bare.is_none_or(|bare| bare - pose.eye.z > ROUNDING).then_some(ground - pose.eye.z))
    };

    let mut below: Vec<(u64, f64)> = Vec::new();
    for NumberedPose { number, pose } in poses {
        below.extend(depth(pose)?.map(|depth| (*number, depth)));
    }

    let Some(&(number, depth)) = below.first() else { return Ok(()) };

    let what = if flight.eye.is_some() {
        format!("--eye lies {depth:.1} m below the ground")
    } else {
        let deepest = below.iter().map(|(_, depth)| *depth).fold(0.0, f64::max);
        format!(
            "the eye of frame {number}, {:.2} s after the start, lies {depth:.1} m below the ground, {} of {} frames do, the deepest {deepest:.1} m",
            timeline.seconds_at(number),
            below.len(),
            poses.len()
        )
    };

    let remedy = "--clearance METRES raises it, --alt-mode says what altitudes are measured from";
    if flight.allow_below_ground {
        observer.note(&format!("{what}; {remedy}"));
        return Ok(());
    }

    Err(Error::Configuration(format!("{what}; {remedy}, and --allow-below-ground renders it as it is")))
}

/// Numbers in rising order as `--frames` takes them: `1-10,20`.
pub fn ranges(numbers: &[u64]) -> String {
    let mut runs: Vec<(u64, u64)> = Vec::new();
    for &number in numbers {
        match runs.last_mut() {
            Some((_, last)) if last.checked_add(1) == Some(number) => *last = number,
            _ => runs.push((number, number)),
        }
    }
    let texts: Vec<String> = runs
        .into_iter()
        .map(|(first, last)| if first == last { first.to_string() } else { format!("{first}-{last}") })
        .collect();
    texts.join(",")
}

#[cfg(test)]
mod tests {
    use super::ranges;

    #[test]
    fn numbers_fold_into_ranges() {
        assert_eq!(ranges(&[1, 2, 3, 7, 9, 10]), "1-3,7,9-10");
        assert_eq!(ranges(&[]), "");
        assert_eq!(ranges(&[u64::MAX]), u64::MAX.to_string());
    }
}
