//! A track bound to a database: a pose for any time.
//!
//! ```text
//! fixes ──▶ positions in the CRS, heights above the datum       (AGL: ground below; ellipsoid: − EGM96 undulation)
//!       ──▶ without noise, if a receiver recorded them          (smooth.rs, fit.rs)
//!       ──▶ spline                                              (spline.rs)
//!       ──▶ lifted over the ground, if asked                    (ground.rs)
//! attitude: slerp of what the file gives (angles.rs); the rest from the smoothed motion (motion.rs)
//! ```
//!
//! Which fixes are smoothed unasked: those in longitude and latitude, at most two seconds apart at the median, of a file that
//! does not give full attitude. Such a file comes from a receiver, whose noise would shake the picture; files with attitude
//! come from simulators and inertial systems, files in metres from programs, and theirs pass through every fix.

use glam::{DVec2, DVec3};

use super::angles::{Orientations, Samples};
use super::camera_shots::camera_shots;
use super::ground;
use super::motion::Motion;
use super::moving::moving;
use super::raw::{CLOCK, COORDINATE_LIMIT};
use super::shot::Shot;
use super::smooth::{Smoother, Smoothing};
use super::spline::Spline;
use super::timeline::{FlightSpan, frames_within};
use super::track::{AltitudeMode, Fix, Horizontal, Track, TrackClock};
use crate::space::{Attitude, Pose};
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::{Crs, GridNorth, Transform, egm96_undulation};

/// Options by which a track becomes a trajectory.
#[derive(Debug, Clone, Copy)]
pub struct BindOptions {
    /// Derived attitude is without bank.
    pub level: bool,
    /// Horizontal field of view where the track gives none, degrees, 0 < hfov < 180.
    pub hfov: f64,
    /// Least height above ground, metres; where the path is lower it is raised, between fixes too. `None`: as the file
    /// says.
    pub clearance: Option<f64>,
    /// Jitter that is taken out of the positions.
    pub smoothing: Smoothing,
}

impl Default for BindOptions {
    /// Takes all that the file says, with a field of view of 60° where it says none.
    fn default() -> Self {
        Self { level: false, hfov: 60.0, clearance: None, smoothing: Smoothing::Noise }
    }
}

/// A pose for any time between start and end.
#[derive(Debug, Clone)]
pub struct Trajectory {
    spline: Spline,
    attitude: AttitudeSource,
    hfov: Option<Samples>,
    default_hfov: f64,
    clock: Option<TrackClock>,
    notes: Vec<String>,
    raised: f64,
    lacks_pitch: bool,
    /// Departure and arrival, seconds after the first fix.
    moving: [f64; 2],
    shots: Vec<Shot>,
}

/// Source of a trajectory's attitude.
#[derive(Debug, Clone)]
enum AttitudeSource {
    /// All three angles are in the file.
    Given(Orientations),
    /// Some are; the rest follows from motion.
    Derived { motion: Motion, given: Given, level: bool },
}

/// Angles in the file, degrees; yaw from grid north.
#[derive(Debug, Clone)]
struct Given {
    yaw: Option<Samples>,
    pitch: Option<Samples>,
    roll: Option<Samples>,
}

impl Trajectory {
    /// Binds a track to a database's CRS; `ground` gives the surface height (metres) below a position of that CRS,
    /// `None` outside the area or where there is no surface.
    ///
    /// # Errors
    /// [`Error::Configuration`] if track and CRS do not fit (longitudes and a local database), or the path neither moves
    /// nor gives a yaw; [`Error::Invalid`] with time and position if a fix has no place in the CRS or no ground below it.
    pub fn bind(
        track: &Track,
        crs: &Crs,
        ground: &dyn Fn(DVec2) -> Option<f64>,
        options: &BindOptions,
    ) -> Result<Self> {
        check(track, options)?;
        let times: Vec<f64> = track.fixes.iter().map(|fix| fix.time).collect();
        let mut notes = Vec::new();
        let placement = FixPlacement::new(track, crs)?;
        let mut points = placement.horizontal()?;
        let given = placement.given_angles(&points, &mut notes)?;
        let full = given.yaw.is_some() && given.pitch.is_some() && given.roll.is_some();
        let is_recorded = !full && matches!(track.fixes[0].horizontal, Horizontal::LonLat(..));

        let mut smoother = Smoother::new(track, options.smoothing, is_recorded)?;
        smoother.smooth_positions(&mut points);
        placement.heights(&mut points, ground)?;
        smoother.smooth_heights(&mut points);
        notes.extend(smoother.notes());

        let mut spline = Spline::through(times.clone(), points);
        let mut raised = 0.0;
        if let Some(lifted) = ground::lift(&spline, &least_heights(track, options.clearance), 1.0, ground) {
            (spline, raised) = (lifted.spline, lifted.most);
            notes.push(format!("The path was raised over the ground by up to {:.1} m: it keeps its height above hills between fixes, too.", lifted.most));
        }

        let attitude = if let (Some(yaw), Some(pitch), Some(roll)) = (&given.yaw, &given.pitch, &given.roll) {
            let at = |time| Attitude { yaw: yaw.at(time), pitch: pitch.at(time), roll: roll.at(time) };
            AttitudeSource::Given(Orientations::new(&times, at))
        } else {
            let motion = Motion::along(&spline, &times, smoother.interval());
            if given.yaw.is_none() && !motion.moves && times.len() > 1 {
                return Err(Error::Configuration(format!(
                    "{}: the path never moves and gives no heading; add a yaw_deg column",
                    track.path.display()
                )));
            }

            if given.yaw.is_none() && !motion.moves {
                notes.push("The single fix gives no heading: the view is to the north.".into());
            }
            notes.extend(derived_note(&given, &motion, options.level));
            AttitudeSource::Derived { motion, given, level: options.level }
        };

        let hfov = Samples::new(track.fixes.iter().map(|fix| (fix.time, fix.hfov)));
        let (default_hfov, clock) = (options.hfov, track.clock);
        let lacks_pitch = is_recorded && track.fixes.iter().all(|fix| fix.pitch.is_none());
        Ok(Self {
            moving: moving(&spline),
            spline,
            attitude,
            hfov,
            default_hfov,
            clock,
            notes,
            raised,
            lacks_pitch,
            shots: camera_shots(track),
        })
    }

    /// A flight that stays at a pose.
    pub(super) fn still(pose: Pose) -> Self {
        let times = vec![0.0];
        Self {
            attitude: AttitudeSource::Given(Orientations::new(&times, |_| pose.attitude)),
            spline: Spline::through(times, vec![pose.eye]),
            hfov: None,
            default_hfov: pose.hfov,
            clock: None,
            notes: Vec::new(),
            raised: 0.0,
            lacks_pitch: false,
            moving: [0.0; 2],
            shots: Vec::new(),
        }
    }

    /// Returns how long the flight lasts, when it moves, and when it began.
    #[doc(hidden)]
    pub fn span(&self) -> FlightSpan {
        let time_of_day = self.clock.map(|clock| clock.time_of_day);
        let [departure, arrival] = self.moving;
        FlightSpan { duration: self.duration(), departure, arrival, time_of_day }
    }

    /// Returns the clock at the first fix, if the file tells the time.
    pub fn clock(&self) -> Option<TrackClock> {
        self.clock
    }

    /// Length, seconds.
    pub fn duration(&self) -> f64 {
        self.spline.duration()
    }

    /// Frames at `fps` > 0: numbers 1 … count; frame n is at (n − 1)/fps seconds. The last frame is not later than the
    /// last fix, up to the microsecond that clocks are good to. At least 1.
    pub fn frame_count(&self, fps: f64) -> u64 {
        frames_within(self.duration(), fps)
    }

    /// Pose at `seconds` after the start, clamped to the trajectory. Yaw is 0…360; orientation is continuous in time.
    pub fn pose_at(&self, seconds: f64) -> Pose {
        let seconds = if seconds.is_nan() { 0.0 } else { seconds.clamp(0.0, self.duration()) };
        Pose {
            eye: self.spline.position(seconds),
            attitude: self.nose_at(seconds),
            hfov: self.hfov.as_ref().map_or(self.default_hfov, |hfov| hfov.at(seconds)),
        }
    }

    /// Returns the place at `seconds` after the start, clamped to the trajectory: that of [`Self::pose_at`], sooner.
    pub fn position_at(&self, seconds: f64) -> DVec3 {
        self.spline.position(seconds)
    }

    /// Returns the velocity at a time, seconds, clamped to the flight; `None` of a single place.
    #[doc(hidden)]
    pub fn velocity_at(&self, seconds: f64) -> Option<DVec3> {
        (self.duration() > 0.0).then(|| self.spline.velocity(seconds.clamp(0.0, self.duration())))
    }

    /// Times of its fixes, and of places between them that keep it above the ground, seconds after the start, increasing.
    pub fn times(&self) -> &[f64] {
        self.spline.times()
    }

    /// Returns how far the path was raised over the ground at most, metres.
    pub fn raised(&self) -> f64 {
        self.raised
    }

    /// Returns the cameras that the path file asks for, by their beginnings.
    #[doc(hidden)]
    pub fn shots(&self) -> &[Shot] {
        &self.shots
    }

    /// Whether it is a receiver's recording of places, which tells no pitch: that of the motion is what the air does, too.
    #[doc(hidden)]
    pub fn lacks_pitch(&self) -> bool {
        self.lacks_pitch
    }

    /// Lists what was derived or assumed, as sentences.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Returns the place at any time, seconds: before the first fix and behind the last one it goes straight on.
    pub(super) fn place_at(&self, seconds: f64) -> DVec3 {
        let inside = seconds.clamp(0.0, self.duration());
        self.spline.position(inside) + (seconds - inside) * self.spline.velocity(inside)
    }

    fn nose_at(&self, seconds: f64) -> Attitude {
        match &self.attitude {
            AttitudeSource::Given(orientations) => orientations.at(seconds),
            AttitudeSource::Derived { motion, given, level } => {
                let derived = motion.at(&self.spline, seconds);
                let bank = if *level { 0.0 } else { derived.bank };
                let or =
                    |samples: &Option<Samples>, value: f64| samples.as_ref().map_or(value, |s| s.at(seconds));
                Attitude {
                    yaw: or(&given.yaw, derived.heading).rem_euclid(360.0),
                    pitch: or(&given.pitch, derived.pitch),
                    roll: or(&given.roll, bank),
                }
            }
        }
    }
}

/// Tracks may be made by programs: what `read_track` promises is checked here.
fn check(track: &Track, options: &BindOptions) -> Result<()> {
    let fail = |what: &str| Err(Error::invalid(&track.path, what));
    if !(options.hfov > 0.0 && options.hfov < 180.0) {
        return Err(Error::Configuration(format!(
            "--hfov {} is not between 0 and 180 degrees",
            options.hfov
        )));
    }
    if let Some(clearance) = options.clearance.filter(|clearance| !clearance.is_finite()) {
        return Err(Error::Configuration(format!("--clearance {clearance} is no height in metres")));
    }
    if track.fixes.is_empty() {
        return fail("the track has no fix");
    }

    let finite = |fix: &Fix| {
        let (x, y) = match fix.horizontal {
            Horizontal::LonLat(x, y) | Horizontal::Xy(x, y) => (x, y),
        };
        let angles = [fix.yaw, fix.pitch, fix.roll, fix.hfov];
        [x, y, fix.altitude.metres].iter().all(|value| value.abs() <= COORDINATE_LIMIT)
            && fix.time.is_finite()
            && angles.iter().flatten().all(|value| value.is_finite())
            && fix.hfov.is_none_or(|hfov| hfov > 0.0 && hfov < 180.0)
            && fix.accuracy.is_none_or(|accuracy| accuracy > 0.0 && accuracy.is_finite())
    };

    if !track.fixes.iter().all(finite) {
        return fail(
            "the track holds a number that is not finite or beyond 10⁹ m, a field of view outside 0…180 degrees, or an accuracy that is not above 0",
        );
    }
    if track.fixes[0].time != 0.0 || track.fixes.windows(2).any(|pair| pair[1].time - pair[0].time < CLOCK) {
        return fail("the times of the track do not start at 0 and increase by at least a microsecond");
    }

    Ok(())
}

/// Puts fixes into a database's system.
struct FixPlacement<'a> {
    track: &'a Track,
    crs: &'a Crs,
    /// Transformations from and to WGS 84; `None` in a local system.
    earth: Option<(Transform, Transform)>,
}

impl<'a> FixPlacement<'a> {
    fn new(track: &'a Track, crs: &'a Crs) -> Result<Self> {
        if crs.is_local() {
            if track.fixes.iter().any(|fix| matches!(fix.horizontal, Horizontal::LonLat(..))) {
                return Err(Error::Configuration(format!(
                    "{}: the path gives longitudes and latitudes, but the database has local metres without a place on \
                     Earth; give the path in x_m and y_m columns, or build the database with --crs",
                    track.path.display()
                )));
            }
            return Ok(Self { track, crs, earth: None });
        }
        let wgs84 = Crs::wgs84();
        let earth = (Transform::new(&wgs84, crs)?, Transform::new(crs, &wgs84)?);
        Ok(Self { track, crs, earth: Some(earth) })
    }

    /// Positions in the CRS, metres; z is 0.
    fn horizontal(&self) -> Result<Vec<DVec3>> {
        let place = |fix: &Fix| match (fix.horizontal, &self.earth) {
            (Horizontal::Xy(x, y), _) => Ok(DVec3::new(x, y, 0.0)),
            (Horizontal::LonLat(longitude, latitude), Some((from_wgs84, _))) => from_wgs84
                .apply(longitude, latitude)
                .filter(|(x, y)| x.is_finite() && y.is_finite())
                .map(|(x, y)| DVec3::new(x, y, 0.0))
                .ok_or_else(|| self.nowhere(fix)),
            (Horizontal::LonLat(..), None) => Err(self.nowhere(fix)),
        };
        self.track.fixes.iter().map(place).collect()
    }

    fn nowhere(&self, fix: &Fix) -> Error {
        let what =
            format!("{}: this position has no place in the database's system {}", at(fix), self.crs.name());
        Error::invalid(&self.track.path, what)
    }

    /// Fills in z, metres above the database's datum.
    fn heights(&self, points: &mut [DVec3], ground: &dyn Fn(DVec2) -> Option<f64>) -> Result<()> {
        for (fix, point) in self.track.fixes.iter().zip(points) {
            let metres = fix.altitude.metres;
            point.z = match fix.altitude.mode {
                AltitudeMode::Msl => metres,
                AltitudeMode::Agl => {
                    let surface = ground(point.truncate()).filter(|height| height.is_finite());
                    let surface = surface.ok_or_else(|| {
                        let what = format!(
                            "{}: there is no ground below this fix, so its height above ground means nothing; give \
                             altitudes above sea level (alt_msl_m), or cut the path to the database's area",
                            at(fix)
                        );
                        Error::invalid(&self.track.path, what)
                    })?;
                    surface + metres
                }
                AltitudeMode::Ellipsoid => metres - self.undulation(fix)?,
            };
        }

        Ok(())
    }

    fn undulation(&self, fix: &Fix) -> Result<f64> {
        match (fix.horizontal, &self.earth) {
            (Horizontal::LonLat(longitude, latitude), _) => Ok(egm96_undulation(longitude, latitude)),
            (Horizontal::Xy(x, y), Some((_, to_wgs84))) => {
                let (longitude, latitude) = to_wgs84.apply(x, y).ok_or_else(|| self.nowhere(fix))?;
                Ok(egm96_undulation(longitude, latitude))
            }
            (Horizontal::Xy(..), None) => Err(Error::Configuration(format!(
                "{}: altitudes above the ellipsoid need a place on Earth, but the database has local metres; give \
                 alt_msl_m or alt_agl_m",
                self.track.path.display()
            ))),
        }
    }

    /// Angles of the file. Yaw is turned from true to grid north.
    fn given_angles(&self, points: &[DVec3], notes: &mut Vec<String>) -> Result<Given> {
        let fixes = &self.track.fixes;
        let north = GridNorth::new(self.crs)?;
        let grid_yaw = |(fix, point): (&Fix, &DVec3)| {
            (fix.time, fix.yaw.map(|yaw| yaw + north.convergence(point.x, point.y)))
        };
        let given = Given {
            yaw: Samples::angles(fixes.iter().zip(points).map(grid_yaw)),
            pitch: Samples::new(fixes.iter().map(|fix| (fix.time, fix.pitch))),
            roll: Samples::angles(fixes.iter().map(|fix| (fix.time, fix.roll))),
        };
        for (name, samples) in [("yaw", &given.yaw), ("pitch", &given.pitch), ("roll", &given.roll)] {
            let missing = samples.as_ref().map_or(0, |samples| fixes.len() - samples.len());
            if missing > 0 {
                notes.push(format!("{missing} fixes without {name} take it from their neighbours."));
            }
        }
        Ok(given)
    }
}

fn at(fix: &Fix) -> String {
    match fix.horizontal {
        Horizontal::LonLat(longitude, latitude) => {
            format!("at {:.3} s, longitude {longitude}, latitude {latitude}", fix.time)
        }
        Horizontal::Xy(x, y) => format!("at {:.3} s, x {x}, y {y}", fix.time),
    }
}

/// Height above ground that each fix asks for.
fn least_heights(track: &Track, clearance: Option<f64>) -> Vec<Option<f64>> {
    let least = |fix: &Fix| {
        let own = (fix.altitude.mode == AltitudeMode::Agl).then_some(fix.altitude.metres);
        match (own, clearance) {
            (Some(own), Some(clearance)) => Some(own.max(clearance)),
            (own, clearance) => own.or(clearance),
        }
    };
    track.fixes.iter().map(least).collect()
}

fn derived_note(given: &Given, motion: &Motion, level: bool) -> Option<String> {
    let bank = if level { "bank (level)" } else { "bank" };
    let names = [("heading", &given.yaw), ("pitch", &given.pitch), (bank, &given.roll)];
    let derived: Vec<&str> =
        names.iter().filter(|(_, samples)| samples.is_none()).map(|(name, _)| *name).collect();
    (motion.moves && !derived.is_empty()).then(|| {
        format!("Derived from the motion, smoothed over {:.1} s: {}.", motion.sigma(), derived.join(", "))
    })
}

#[cfg(test)]
mod tests;
