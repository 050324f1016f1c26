//! A flight bound to a database and a scene: the cameras of its frames, checked.
//!
//! ```text
//! path ──▶ trajectory ──▶ timeline ──▶ scene's objects ──▶ rig ──▶ cameras of the frames that were chosen
//! views, without a path ──▶ timeline ──▶ scene's objects ──▶ rig of those that were chosen ──▶ their cameras
//! ```

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::frame_ranges::ranges;
use crate::partner::Partner;
use crate::running_sun::RunningSun;
use crate::scene::Playing;
use crate::screen::{PLANAR_RANGE, Setup};
use crate::view::{FlightArgs, over_ground};
use crate::{area, reference, sharpness};
use hedgehop::encode::FrameSet;
use hedgehop::flight::{FilmSite, FrameRate, Look, Rig, Shot, Timeline, Trajectory, Views};
use hedgehop::progress::Observer;
use hedgehop::render::NumberedCamera;
use hedgehop::scene::Scene;
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::sunlight::{RunningSky, Sky};
use hedgehop::voxel::PageSource;
use hedgehop::{Error, Result};
use hedgehop_query::Ground;

/// Far more frames than anybody renders at once, and few enough to list: days of flight.
const MOST_FRAMES: usize = 10_000_000;

/// Metres by which an eye on the ground may lie below it.
const ROUNDING: f64 = 1.0e-3;

/// Pose of the eye in a frame.
#[derive(Debug, Clone, Copy)]
struct NumberedPose {
    /// Number of the frame, 1…
    number: u64,
    /// Pose of the eye.
    pose: Pose,
}

/// Place and screen of a film.
#[derive(Clone, Copy)]
pub struct FilmRequest<'a> {
    /// File of the database.
    pub file: &'a Path,
    /// The database.
    pub source: &'a dyn PageSource,
    /// Screen of the frames.
    pub setup: &'a Setup,
    /// Frames a second of the film.
    pub fps: FrameRate,
    /// Scene with objects and cameras, if there is one.
    pub scene: Option<&'a Scene>,
    /// Sun that runs with the flight, if one does.
    pub sun: Option<RunningSun<'a>>,
}

/// Motion of a film's eye, of what flies, and of the sun.
#[derive(Debug, Clone)]
pub struct FilmMotion {
    /// Path of what flies over time.
    pub flown: Arc<Trajectory>,
    /// Moments of the frames.
    pub timeline: Timeline,
    /// Camera over time.
    pub rig: Arc<Rig>,
    /// Sun and stars over time; `None`: they stand still.
    pub sky: Option<RunningSky>,
}

/// A path bound to a database and a scene, and its frames.
#[derive(Debug)]
pub struct BoundFlight {
    /// Motion of eye and flight.
    pub motion: FilmMotion,
    /// Objects of the scene, if there is one.
    pub playing: Option<Playing>,
    /// Numbers and cameras of the frames that were chosen, rising.
    pub cameras: Vec<NumberedCamera>,
    /// Height that a map is seen from, metres, if it is one.
    above: Option<f64>,
}

impl FilmMotion {
    /// Returns the pose of the eye in a frame.
    pub fn pose(&self, number: u64) -> Pose {
        self.rig.pose_at(self.timeline.seconds_at(number))
    }

    /// Returns sun and stars of a frame, if they run.
    fn sky(&self, number: u64) -> Result<Option<Sky>> {
        self.sky.map(|sky| sky.at(self.timeline.seconds_at(number))).transpose()
    }

    /// Returns the velocity of the eye, metres per second: between half a frame before and half a frame after; `None` of an eye that has
    /// no flight.
    pub fn eye_velocity(&self, number: u64) -> Option<DVec3> {
        let (seconds, half) = (self.timeline.seconds_at(number), 0.5 * self.timeline.interval());
        let [from, to] = [seconds - half, seconds + half].map(|time| time.clamp(0.0, self.flown.duration()));
        let place_at = |time: f64| self.rig.pose_in_frame(seconds, time).eye;
        (to > from).then(|| (place_at(to) - place_at(from)) / (to - from))
    }

    /// Returns the number of the frame next to another that tells its motion: the one behind it, or the one before it at the end of the
    /// film and before a cut; of a single one itself a moment later.
    fn beside(&self, number: u64) -> u64 {
        let is_one_shot = |other: u64| {
            self.rig.is_one_shot(self.timeline.seconds_at(number), self.timeline.seconds_at(other))
        };
        let is_last = number >= self.timeline.frame_count() || !is_one_shot(number + 1);
        if is_last && number > 1 && is_one_shot(number - 1) { number - 1 } else { number + 1 }
    }
}

/// Motion of a film, the objects in it, and its frames that were chosen.
struct Filmed {
    motion: FilmMotion,
    playing: Option<Playing>,
    frames: FrameSet,
}

impl Filmed {
    /// Binds a path, or a single eye.
    fn of_flight(
        flight: &FlightArgs,
        request: &FilmRequest<'_>,
        choose: impl FnOnce(u64) -> Result<FrameSet>,
        observer: &dyn Observer,
    ) -> Result<Self> {
        let flown = Arc::new(flight.bind(request.source, request.setup, observer)?);
        let timeline = Timeline::new(request.fps, flown.span(), &flight.playback.playback(&flown, observer))?;
        let playing = playing(flight, request, timeline, observer)?;
        let shots = shots(flight, request, &flown, observer)?;
        let shown = Shown { flown: &flown, timeline: &timeline, playing: playing.as_ref() };
        let rig = Arc::new(rig(flight, request, &shown, &shots)?);

        let playing = match flight.path {
            Some(_) => playing.map(|playing| playing.seen_by(&rig)),
            None => playing,
        };
        let sky = running_sky(flight, request, &flown)?;
        let frames = choose(timeline.frame_count())?;
        frames.check_within(timeline.frame_count())?;
        Ok(Self { motion: FilmMotion { flown, timeline, rig, sky }, playing, frames })
    }

    /// Binds the chosen ones of some views.
    fn of_views(
        flight: &FlightArgs,
        request: &FilmRequest<'_>,
        views: &Views,
        choose: impl FnOnce(u64) -> Result<FrameSet>,
        observer: &dyn Observer,
    ) -> Result<Self> {
        note_unused_cameras(request.scene, "--views", observer);
        let (timeline, count) = (Timeline::of_views(request.fps, views.count()), views.count());
        let frames = choose(count)?;
        if let Some(last) = frames.last().filter(|last| *last > count) {
            return Err(Error::Configuration(format!(
                "--frames asks for frame {last}, but --views has frames 1-{count}"
            )));
        }
        if frames.iter().take(MOST_FRAMES).count() == MOST_FRAMES {
            return Err(Error::Configuration(format!(
                "--views has {count} frames, which are too many at once; choose some with --frames"
            )));
        }

        let rig = over_ground(request.source, flight.world, |crs, ground| {
            let site = FilmSite { crs, ground, object: &|_| None, clearance: flight.clearance };
            Rig::of_views(views, frames.iter(), &timeline, &site)
        })?;
        let flown = rig.flight().clone();
        let sky = running_sky(flight, request, &flown)?;
        let motion = FilmMotion { flown, timeline, rig: Arc::new(rig), sky };
        Ok(Self { motion, playing: playing(flight, request, timeline, observer)?, frames })
    }
}

/// Puts a sun that runs over the database, if there is one.
fn running_sky(
    flight: &FlightArgs,
    request: &FilmRequest<'_>,
    flown: &Trajectory,
) -> Result<Option<RunningSky>> {
    let over = |sun: RunningSun<'_>| sun.over(request.source.header(), flown, flight.path.as_deref());
    request.sun.map(over).transpose()
}

/// Binds the objects of the scene, if there is one.
fn playing(
    flight: &FlightArgs,
    request: &FilmRequest<'_>,
    timeline: Timeline,
    observer: &dyn Observer,
) -> Result<Option<Playing>> {
    let bound = |scene| Playing::new(scene, request.source, flight, timeline, observer);
    request.scene.map(bound).transpose()
}

impl BoundFlight {
    /// Binds path, scene and cameras, and finds the cameras of the frames that `choose` takes out of the film's count, after checks
    /// that somebody will see something.
    ///
    /// # Errors
    /// A path or camera that does not fit the database, frames that are not there, an eye outside the area or below its ground.
    pub fn bind(
        flight: &FlightArgs,
        request: &FilmRequest<'_>,
        choose: impl FnOnce(u64) -> Result<FrameSet>,
        observer: &dyn Observer,
    ) -> Result<Self> {
        let FilmRequest { file, source, setup, .. } = *request;
        let Filmed { motion, playing, frames } = match flight.views(source.header(), setup)? {
            Some(views) => Filmed::of_views(flight, request, &views, choose, observer)?,
            None => Filmed::of_flight(flight, request, choose, observer)?,
        };
        motion.rig.notes().iter().for_each(|note| observer.note(note));

        let above = setup.is_map().then(|| source.header().height_range.high.ceil() + 1.0);
        let above = above.filter(|_| flight.ypr.is_none());

        let mut poses: Vec<_> = frames
            .iter()
            .take(MOST_FRAMES)
            .map(|number| NumberedPose { number, pose: motion.pose(number) })
            .collect();
        if poses.len() == MOST_FRAMES {
            return Err(Error::Configuration(format!(
                "the path lasts {:.0} s, which is too many frames at once; choose some with --frames, show it faster with --speed or --duration, or check the unit of its times",
                motion.flown.duration()
            )));
        }

        if setup.takes_hfov_from_path() {
            check_fields_of_view(&poses)?;
        }
        if !flight.world.tile_world {
            check_inside(flight, &motion, file, source, &poses)?;
        }
        if let Some(above) = above {
            if poses.iter().any(|numbered| numbered.pose.eye.z < above) {
                observer.note(&format!("the map is seen from {above} m, above all ground"));
            }
            poses.iter_mut().for_each(|numbered| look_down(above, &mut numbered.pose));
        }

        flight.world.note_seam(source.header(), observer);
        check_above_ground(flight, source, motion.timeline, &poses, observer)?;
        if !setup.is_map() {
            let cameras: Vec<Camera> = sharpness::some(poses.iter().map(|numbered| numbered.pose))
                .map(|pose| setup.camera(pose))
                .collect();
            let ground = |place: DVec2| flight.world.ground(source, place);
            sharpness::warning(source.header(), &cameras, ground)?
                .iter()
                .for_each(|note| observer.note(note));
        }

        let camera_of = |NumberedPose { number, pose }| {
            let sky = motion.sky(number)?;
            Ok(NumberedCamera { number, camera: setup.camera(pose), sky })
        };
        let cameras = poses.into_iter().map(camera_of).collect::<Result<_>>()?;
        Ok(Self { motion, playing, cameras, above })
    }

    /// Returns the frame next to each of the chosen ones, which tells its motion.
    pub fn partners(&self, setup: &Setup) -> BTreeMap<u64, Partner> {
        let partner = |frame: &NumberedCamera| {
            let number = self.motion.beside(frame.number);
            let seen = self.motion.timeline.seconds_at(frame.number);
            let mut pose = self.motion.rig.pose_in_frame(seen, self.motion.timeline.seconds_at(number));
            if let Some(above) = self.above {
                look_down(above, &mut pose);
            }
            (frame.number, Partner { number, camera: setup.camera(pose) })
        };
        self.cameras.iter().map(partner).collect()
    }
}

/// Refuses fields of view that no planar screen has, whether a path or a camera asks for them.
fn check_fields_of_view(poses: &[NumberedPose]) -> Result<()> {
    match poses.iter().find(|numbered| !PLANAR_RANGE.contains(&numbered.pose.hfov)) {
        Some(NumberedPose { number, pose }) => Err(Error::Configuration(format!(
            "frame {number} has a field of view of {}°; a planar screen sees {} to {}°: mend hfov_deg of the path, or take another --screen",
            pose.hfov,
            PLANAR_RANGE.start(),
            PLANAR_RANGE.end()
        ))),
        None => Ok(()),
    }
}

/// Returns the shots of the film, from flags or the scene.
fn shots(
    flight: &FlightArgs,
    request: &FilmRequest<'_>,
    flown: &Trajectory,
    observer: &dyn Observer,
) -> Result<Vec<Shot>> {
    let FilmRequest { setup, scene, .. } = *request;
    if setup.is_map() {
        if flight.camera.is_given() {
            return Err(Error::Configuration(
                "a map is seen from above what flies; leave out --pitch, --look, --look-at, --chase and --orbit, or take another screen".into(),
            ));
        }
        return Ok(Vec::new());
    }
    if flight.eye.is_some() {
        note_unused_cameras(scene, "--eye", observer);
        return Ok(Vec::new());
    }

    let mut shots = flight.camera.shots(flown.shots(), scene, flight.alt_mode.map(Into::into))?;
    let are_of_file = !flight.camera.is_given() && !flown.shots().is_empty();
    if are_of_file && scene.is_some_and(|scene| !scene.cameras.is_empty()) {
        observer.note("the cameras of the path file go before those of the scene");
    }
    if shots.is_empty() && flown.lacks_pitch() && setup.takes_hfov_from_path() {
        observer.note("the path tells no pitch: the view is held low enough to show the ground, and in films from 4x on level and steady; --look ahead follows nose and climb");
        shots.push(Shot { look: Some(Look::Lowered), ..Shot::default() });
    }
    if shots.iter().any(|shot| shot.zoom.is_some()) && !setup.takes_hfov_from_path() {
        observer.note("fields of view of the scene's cameras are for planar screens; this one has its own");
    }
    Ok(shots)
}

/// Says that a scene has cameras which a flag goes before.
fn note_unused_cameras(scene: Option<&Scene>, flag: &str, observer: &dyn Observer) {
    if scene.is_some_and(|scene| !scene.cameras.is_empty()) {
        observer.note(&format!("the scene's cameras are for a flight; {flag} has its own view"));
    }
}

/// Flight and objects that cameras show.
struct Shown<'a> {
    flown: &'a Arc<Trajectory>,
    timeline: &'a Timeline,
    playing: Option<&'a Playing>,
}

/// Puts the cameras over the database.
fn rig(flight: &FlightArgs, request: &FilmRequest<'_>, shown: &Shown<'_>, shots: &[Shot]) -> Result<Rig> {
    let object = |name: &str| shown.playing.and_then(|playing| playing.subject(name));
    over_ground(request.source, flight.world, |crs, ground| {
        let site = FilmSite { crs, ground, object: &object, clearance: flight.clearance };
        Rig::bind(shown.flown.clone(), shown.timeline, shots, &site)
    })
}

/// Pose of a map: straight down from above all ground, grid north up.
fn look_down(above: f64, pose: &mut Pose) {
    pose.attitude = Attitude { yaw: 0.0, pitch: -90.0, roll: 0.0 };
    pose.eye.z = pose.eye.z.max(above);
}

fn check_inside(
    flight: &FlightArgs,
    motion: &FilmMotion,
    file: &Path,
    source: &dyn PageSource,
    poses: &[NumberedPose],
) -> Result<()> {
    let header = source.header();
    let inside = |pose: &Pose| header.grid.contains(pose.eye.truncate());
    let Some(NumberedPose { number, pose }) = poses.iter().find(|outside| !inside(&outside.pose)) else {
        return Ok(());
    };
    let within: Vec<u64> =
        poses.iter().filter(|within| inside(&within.pose)).map(|within| within.number).collect();
    let degrees =
        !reference::crs(header)?.is_local() && pose.eye.x.abs() <= 180.0 && pose.eye.y.abs() <= 90.0;

    let flown = motion.flown.pose_at(motion.timeline.seconds_at(*number));
    let remedy = if flight.views.views.is_some() {
        "take a smaller --radius, or a place farther inside".to_owned()
    } else if inside(&flown) {
        let frames =
            if within.is_empty() { String::new() } else { format!(", or take --frames {}", ranges(&within)) };
        format!("bring the camera nearer to what flies{frames}")
    } else if within.is_empty() && degrees {
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
