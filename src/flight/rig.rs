//! Camera rigs: the eye of a film over a flight, shot by shot.
//!
//! ```text
//! flight ──mount──▶ path of the eye (eye_path.rs, or keys) ──▶ lifted over what stands there ──aim──▶ pose_at(seconds)
//! ```

use std::sync::Arc;

use super::aim::{Aim, FixedPlace, MovingPlace, PlaceAhead, Subject, towards};
use super::eye_path::{Steadied, Stretch};
use super::ground;
use super::shot::{Ease, Keys, Look, Mount, Shot, Zoom};
use super::site::{CLEARANCE, FilmSite, bound_place, place};
use super::spline::Spline;
use super::timeline::Timeline;
use super::trajectory::{BindOptions, Trajectory};
use super::views::{MomentPose, ViewPoses, Views};
use crate::space::Pose;
use hedgehop_base::error::{Error, Result};

/// Seconds of flight in a second of the film from which on turns are too quick to be followed.
const QUICK: f64 = 4.0;

/// Camera of a film: the pose of the eye at any time of a flight.
#[derive(Debug, Clone)]
pub struct Rig {
    flight: Arc<Trajectory>,
    /// Shots by their beginnings; at least one.
    shots: Vec<BoundShot>,
    notes: Vec<String>,
}

/// A shot over a database.
#[derive(Debug, Clone)]
struct BoundShot {
    stretch: Stretch,
    eye: EyePath,
    aim: Aim,
    zoom: Option<Zoom>,
}

/// Path of an eye.
#[derive(Debug, Clone)]
enum EyePath {
    /// The flight's own.
    Flight,
    /// The flight's own, with a level nose along a way that changes over time, metres.
    Steady(Spline),
    /// One that follows it, with a level nose along a way; times as the flight's.
    Following { path: Spline, way: Spline },
    /// One of its own.
    Keyed(Box<KeyedPath>),
    /// A single place.
    Still(Pose),
}

/// Path of an eye by its keys.
#[derive(Debug, Clone)]
struct KeyedPath {
    path: Trajectory,
    /// Moment of the first key, seconds after the flight's first fix, and times of all after it.
    start: f64,
    keys: Vec<f64>,
    ease: Ease,
}

impl Rig {
    /// Puts shots, by their beginnings, over a flight; before the first one the eye is aboard and looks along the nose.
    ///
    /// # Errors
    /// [`Error::Configuration`] for a place that the reference system does not have, or an object that the scene does not have.
    pub fn bind(
        flight: Arc<Trajectory>,
        timeline: &Timeline,
        shots: &[Shot],
        site: &FilmSite<'_>,
    ) -> Result<Self> {
        let duration = flight.duration();
        let (shots, late) = shots.split_at(shots.partition_point(|shot| shot.from <= duration));
        let notes = late.iter().map(|shot| {
            format!("The camera from {} s on sees nothing: the flight ends at {duration:.1} s.", shot.from)
        });
        let mut rig = Self { flight, shots: Vec::with_capacity(shots.len() + 1), notes: notes.collect() };

        // Until the first shot begins, the eye is aboard.
        let aboard = shots.first().is_none_or(|first| first.from > 0.0).then(Shot::default);
        let shots: Vec<&Shot> = aboard.iter().chain(shots).collect();
        let ends = shots[1..].iter().map(|shot| shot.from).chain([duration]);
        for (shot, end) in shots.iter().zip(ends) {
            let bound = rig.bound(shot, Stretch { begin: shot.from, end, pace: timeline.speed() }, site)?;
            rig.shots.push(bound);
        }

        Ok(rig)
    }

    /// Puts views over a database, each a shot of its own; those of other numbers than `numbers`, which rise, are not known.
    ///
    /// # Errors
    /// [`Error::Configuration`] for a view or a target that has no ground below it.
    pub fn of_views(
        views: &Views,
        numbers: impl Iterator<Item = u64>,
        timeline: &Timeline,
        site: &FilmSite<'_>,
    ) -> Result<Self> {
        let ViewPoses { poses, raised } = views.poses(numbers, timeline, site)?;
        let first = poses.first().ok_or_else(|| Error::Configuration("no view is asked for".into()))?;
        let flight = Arc::new(Trajectory::still(first.pose));
        let shot = |view: &MomentPose| BoundShot {
            stretch: Stretch { begin: view.seconds, end: view.seconds, pace: timeline.speed() },
            eye: EyePath::Still(view.pose),
            aim: Aim::Nose,
            zoom: None,
        };
        let notes = if raised > 0.0 { vec![raised_note(raised)] } else { Vec::new() };
        Ok(Self { flight, shots: poses.iter().map(shot).collect(), notes })
    }

    /// Returns what flies; of views, which have no flight, one that stays at the first of them.
    pub fn flight(&self) -> &Arc<Trajectory> {
        &self.flight
    }

    /// Pose of the eye at `seconds` after the flight's first fix, clamped to the flight.
    pub fn pose_at(&self, seconds: f64) -> Pose {
        self.shot_at(seconds).pose_at(&self.flight, seconds)
    }

    /// Pose of the eye at `seconds`, by the camera that sees the moment `frame`: a shutter does not see across a cut.
    pub fn pose_in_frame(&self, frame: f64, seconds: f64) -> Pose {
        self.shot_at(frame).pose_at(&self.flight, seconds)
    }

    /// Whether one camera sees both moments.
    pub fn is_one_shot(&self, one: f64, other: f64) -> bool {
        self.number_at(one) == self.number_at(other)
    }

    /// Whether the moment is seen from aboard what flies.
    pub fn is_aboard_at(&self, seconds: f64) -> bool {
        matches!(self.shot_at(seconds).eye, EyePath::Flight | EyePath::Steady(_))
    }

    /// Lists what was done for the user, as sentences.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    fn shot_at(&self, seconds: f64) -> &BoundShot {
        &self.shots[self.number_at(seconds)]
    }

    fn number_at(&self, seconds: f64) -> usize {
        self.shots.partition_point(|shot| shot.stretch.begin <= seconds).saturating_sub(1)
    }

    fn bound(&mut self, shot: &Shot, stretch: Stretch, site: &FilmSite<'_>) -> Result<BoundShot> {
        let heading = self.flight.pose_at(stretch.begin).attitude.yaw;
        let looked =
            shot.look.as_ref().map(|look| self.aim(look, shot.from, stretch.pace, site)).transpose()?;
        let zoom = shot.zoom;

        let steadied = || Steadied::of(&self.flight, stretch);
        let (followed, way) = match &shot.mount {
            Mount::Aboard => {
                let (eye, aim) = self.aboard(looked, heading, stretch);
                return Ok(BoundShot { stretch, eye, aim, zoom });
            }
            Mount::Keys(keys) => {
                let keyed = KeyedPath::bind(keys, site, &mut self.notes)?;
                let eye = EyePath::Keyed(Box::new(keyed));
                return Ok(BoundShot { stretch, eye, aim: looked.unwrap_or(Aim::Nose), zoom });
            }
            Mount::Chase(chase) => {
                let followed = steadied();
                let way = followed.chased(*chase, heading, stretch.pace);
                (followed, way)
            }
            Mount::Orbit(orbit) => {
                let followed = steadied();
                let centre = match &looked {
                    Some(Aim::At(subject)) => Some(subject.as_ref()),
                    Some(Aim::Ahead(place)) => Some(place as &dyn Subject),
                    _ => None,
                };
                let way = followed.orbited(*orbit, centre, heading, stretch.pace);
                (followed, way)
            }
        };

        let times = || followed.times.clone();
        let path = clear(Spline::through(times(), way.eyes), stretch, site, &mut self.notes);
        let ways = way.ways.iter().map(|way| way.extend(0.0)).collect();
        let eye = EyePath::Following { path, way: Spline::through(times(), ways) };
        let flight = || Aim::At(Arc::new(Spline::through(times(), way.middles)));
        Ok(BoundShot { stretch, eye, aim: looked.unwrap_or_else(flight), zoom })
    }

    /// Returns eye and aim aboard: a film that is quick shows where the flight goes, or will be going, and not how it turns.
    fn aboard(&self, looked: Option<Aim>, heading: f64, stretch: Stretch) -> (EyePath, Aim) {
        let aim = looked.unwrap_or(Aim::Nose);
        let lead = match &aim {
            Aim::Lowered => Some(0.0),
            Aim::Pitch(_) | Aim::Down => self.flight.lacks_pitch().then_some(0.0),
            Aim::Ahead(place) => Some(place.lead),
            Aim::Nose | Aim::At(_) => None,
        };
        let Some(lead) = lead.filter(|_| stretch.pace >= QUICK) else { return (EyePath::Flight, aim) };

        let followed = Steadied::of(&self.flight, stretch);
        let ways = followed.ways_ahead(lead, heading, stretch.pace);
        let ways = ways.into_iter().map(|way| way.extend(0.0)).collect();
        let aim = if matches!(aim, Aim::Ahead(_)) { Aim::Lowered } else { aim };
        (EyePath::Steady(Spline::through(followed.times, ways)), aim)
    }

    fn aim(&self, look: &Look, from: f64, pace: f64, site: &FilmSite<'_>) -> Result<Aim> {
        Ok(match look {
            Look::Nose => Aim::Nose,
            Look::Lowered => Aim::Lowered,
            Look::Pitch(pitch) => Aim::Pitch(*pitch),
            Look::Down => Aim::Down,
            Look::Ahead(lead) => Aim::Ahead(PlaceAhead { flight: self.flight.clone(), lead: lead * pace }),
            Look::Place(track) => Aim::At(Arc::new(FixedPlace(place(track, site)?))),
            Look::Moving(track) => {
                let path = bound_place(track, site, &BindOptions::default())?;
                Aim::At(Arc::new(MovingPlace { path, from }))
            }
            Look::Object(name) => Aim::At((site.object)(name).ok_or_else(|| {
                Error::Configuration(format!("the scene has no object `{name}` to look at"))
            })?),
        })
    }
}

impl BoundShot {
    fn pose_at(&self, flight: &Trajectory, seconds: f64) -> Pose {
        let aboard = flight.pose_at(seconds);
        let seconds = if seconds.is_nan() { 0.0 } else { seconds.clamp(0.0, flight.duration()) };
        let Pose { eye, attitude: nose, hfov } = match &self.eye {
            EyePath::Flight => aboard,
            EyePath::Steady(way) => {
                Pose { attitude: towards(way.position(seconds), aboard.attitude.yaw), ..aboard }
            }
            EyePath::Following { path, way } => {
                let attitude = towards(way.position(seconds), aboard.attitude.yaw);
                Pose { eye: path.position(seconds), attitude, ..aboard }
            }
            EyePath::Keyed(keyed) => keyed.pose_at(seconds),
            EyePath::Still(pose) => *pose,
        };

        let Stretch { begin, end, .. } = self.stretch;
        let share = || if end > begin { (seconds - begin) / (end - begin) } else { 0.0 };
        Pose {
            eye,
            attitude: self.aim.attitude(eye, seconds, nose),
            hfov: self.zoom.map_or(hfov, |zoom| zoom.at(share())),
        }
    }
}

impl KeyedPath {
    /// Puts keys over the database.
    fn bind(keys: &Keys, site: &FilmSite<'_>, notes: &mut Vec<String>) -> Result<Self> {
        let options = BindOptions { clearance: site.clearance.or(Some(CLEARANCE)), ..BindOptions::default() };
        let path = bound_place(&keys.track, site, &options)?;
        if path.raised() > 0.0 {
            notes.push(raised_note(path.raised()));
        }
        let times = keys.track.fixes.iter().map(|fix| fix.time).collect();
        Ok(Self { path, start: keys.start, keys: times, ease: keys.ease })
    }

    fn pose_at(&self, seconds: f64) -> Pose {
        let seconds = seconds - self.start;
        let after = self.keys.partition_point(|key| *key <= seconds);
        let (Some(before), Some(next)) = (after.checked_sub(1), self.keys.get(after)) else {
            return self.path.pose_at(seconds);
        };

        let begin = self.keys[before];
        let share = (seconds - begin) / (next - begin);
        self.path.pose_at(begin + (next - begin) * self.ease.at(share))
    }
}

fn raised_note(metres: f64) -> String {
    format!("The camera was raised over the ground by up to {metres:.1} m.")
}

/// Lifts a path over the ground and what stands there.
fn clear(path: Spline, stretch: Stretch, site: &FilmSite<'_>, notes: &mut Vec<String>) -> Spline {
    let least = vec![Some(site.clearance.unwrap_or(CLEARANCE)); path.times().len()];
    let Some(lifted) = ground::lift(&path, &least, stretch.pace, site.ground) else { return path };
    notes.push(raised_note(lifted.most));
    lifted.spline
}

#[cfg(test)]
mod tests;
