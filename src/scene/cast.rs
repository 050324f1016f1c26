//! A scene over a database.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};

use super::form::LARGEST;
use super::joint::Axes;
use super::light::LampCast;
use super::onward::{Onward, Reach};
use super::plume::PlumeCast;
use super::slope::Slope;
use super::trail_cast::{FlownWay, TrailCast};
use super::{Beyond, Object, OwnFlight, Part, Scene};
use crate::flight::{AltitudeMode, Fix, Subject, Track, Trajectory};
use crate::objects::{Body, Form, PointLight, Ribbon};
use crate::space::{Attitude, Pose};
use crate::weather::Puff;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// Metres that a track is raised by before it is worth a word.
const NOTED: f64 = 0.1;

/// Time over which the velocity at an end of a track is measured, seconds.
const STEP: f64 = 0.1;

/// Objects of a scene in a database's reference system: where each is at any time.
#[derive(Debug, Clone)]
pub struct Cast {
    /// Actors by name.
    actors: Vec<Actor>,
    /// Names of all bodies, by their ids.
    names: Vec<String>,
    /// The actors of those that are parts: the ids of these follow on those of actors.
    owners: Vec<usize>,
    lamps: LampCast,
    plumes: PlumeCast,
    trails: TrailCast,
}

#[derive(Debug, Clone)]
struct Actor {
    form: Form,
    albedo: Vec3,
    priority: i32,
    trajectory: Trajectory,
    /// The other end of a line, metres in the world.
    to: Option<DVec3>,
    start: f64,
    beyond: Beyond,
    /// Whether cameras aboard what flies see it.
    from_aboard: bool,
    /// The ground below, if it leans as that does.
    slope: Option<Slope>,
    /// Course before its track and behind it, if it keeps to the ground there.
    onward: Option<[Onward; 2]>,
    parts: Vec<Part>,
    /// Id of the first part's body.
    first: usize,
}

impl Scene {
    /// Binds the scene to a database's CRS; `ground` gives the surface height (metres) below a position of that CRS, `None` outside the area
    /// or where there is no surface.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the line and name of an object or a light: what [`Trajectory::bind`] says of its track; a lamp without ground below it, a light of an object
    /// that is none.
    pub fn bind(&self, crs: &Crs, ground: &dyn Fn(DVec2) -> Option<f64>) -> Result<Cast> {
        self.bind_with_flight(crs, ground, None)
    }

    /// Binds the scene as [`Self::bind`] does; an object that is the body of a flight is where the flight is.
    ///
    /// # Errors
    /// [`Error::Invalid`] as of [`Self::bind`].
    #[doc(hidden)]
    pub fn bind_with_flight(
        &self,
        crs: &Crs,
        ground: &dyn Fn(DVec2) -> Option<f64>,
        flight: Option<&OwnFlight>,
    ) -> Result<Cast> {
        let going_on = self.objects.iter().filter(|object| keeps_to_ground(object));
        let reach = going_on.fold(Reach::default(), |reach, object| reach.with(object.leans));
        let mut first = self.objects.len();

        let actors = self.objects.iter().map(|object| {
            let options = OwnFlight::options_of(flight, object);
            let of_object = |error: Error| {
                let what = match error {
                    // What would help a path helps no object that stands.
                    Error::Invalid { what, .. } if object.track.fixes.len() == 1 => {
                        let what = what.split(';').next().unwrap_or_default();
                        format!("{what}; move it, give degrees as at_lonlat, or altitude = \"msl\"")
                    }
                    other => other.to_string(),
                };
                self.wrong(object.line, &format!("object `{}`: {what}", object.name))
            };

            let bind = |track: &Track| Trajectory::bind(track, crs, ground, &options).map_err(of_object);
            let trajectory = bind(&object.track)?;
            let to = object.to.as_ref().map(bind).transpose()?.map(|end| end.pose_at(0.0).eye);
            let length = to.map_or(1.0, |to| (to - trajectory.pose_at(0.0).eye).length());
            if length == 0.0 || length > LARGEST {
                let what = format!("a line must be more than 0 m and at most 100 km long, not {length} m");
                return Err(of_object(Error::Configuration(what)));
            }

            first += object.parts.len();
            let lean = || Slope::bind(&object.track, &trajectory, object.form.corners(), ground);
            let actor = Actor {
                slope: object.leans.then(lean),
                parts: object.parts.clone(),
                first: first - object.parts.len(),
                form: object.form.clone(),
                albedo: Vec3::from_array(object.albedo),
                priority: object.priority,
                trajectory,
                to,
                start: object.start,
                beyond: object.beyond,
                from_aboard: object.from_aboard,
                onward: None,
            };

            let goes_on = keeps_to_ground(object) && actor.trajectory.duration() > 0.0;
            let onward = goes_on.then(|| actor.onward(reach, ground));
            Ok(Actor { onward, ..actor })
        });

        let actors: Vec<Actor> = actors.collect::<Result<_>>()?;
        let names: Vec<String> = self.names().collect();
        let numbers: HashMap<&str, usize> = names.iter().map(String::as_str).zip(0..).collect();
        let actor = |name: &str| numbers.get(name).copied();
        let lamps = LampCast::bind(&self.path, &self.lights, crs, ground, actor)?;
        let wrong = |line: usize, what: &str| self.wrong(line, what);
        let plumes = PlumeCast::bind(&self.plumes, crs, ground, wrong, actor)?;
        let way = |name: &str| actors.get(*numbers.get(name)?).map(Actor::way);
        let trails = TrailCast::bind(&self.trails, crs, ground, wrong, way)?;
        let owners = actors.iter().enumerate();
        let owners =
            owners.flat_map(|(actor, Actor { parts, .. })| parts.iter().map(move |_| actor)).collect();

        Ok(Cast { actors, names, owners, lamps, plumes, trails })
    }
}

/// Whether an object goes on over the ground where its track ends.
fn keeps_to_ground(object: &Object) -> bool {
    let is_above = |fix: &Fix| fix.altitude.mode == AltitudeMode::Agl;
    object.beyond == Beyond::DeadReckoning && (object.leans || object.track.fixes.iter().all(is_above))
}

/// Bodies, lights and plumes at some moment.
#[derive(Debug, Clone, Default)]
pub struct Scenery {
    /// All objects, and then their parts.
    pub bodies: Vec<Body>,
    /// Number of the bodies, at the end, that are parts, which may turn fast.
    pub parts: usize,
    /// The lamps that shine.
    pub lights: Vec<PointLight>,
    /// Smoke and dust.
    pub puffs: Vec<Puff>,
    /// Trails as far as they are seen.
    pub trails: Vec<Ribbon>,
}

impl Actor {
    /// Returns the pose so many seconds after the flight's first fix; `None`: it is not there.
    fn pose_at(&self, seconds: f64) -> Option<Pose> {
        let seconds = seconds - self.start;
        let duration = self.trajectory.duration();
        let end = seconds.clamp(0.0, duration);
        let mut pose = self.on_track(end);
        match self.beyond {
            Beyond::Hide if seconds != end => return None,
            Beyond::DeadReckoning if seconds != end && duration > 0.0 => match &self.onward {
                Some([before, _]) if seconds < end => return Some(before.pose_at(end - seconds)),
                Some([_, after]) => return Some(after.pose_at(seconds - end)),
                None => pose.eye += self.velocity(end) * (seconds - end),
            },
            Beyond::Hold | Beyond::Hide | Beyond::DeadReckoning => {}
        }
        Some(pose)
    }

    /// Returns the velocity at an end of its track, metres a second.
    fn velocity(&self, end: f64) -> DVec3 {
        let step = STEP.min(self.trajectory.duration());
        let before = (end - step).max(0.0);
        (self.on_track(before + step).eye - self.on_track(before).eye) / step
    }

    /// Finds its course before its track and behind it, keeping to the ground.
    fn onward(&self, reach: Reach, ground: &dyn Fn(DVec2) -> Option<f64>) -> [Onward; 2] {
        [(0.0, -1.0), (self.trajectory.duration(), 1.0)].map(|(end, way)| {
            let velocity = way * self.velocity(end).truncate();
            let slope = self.slope.as_ref().map(|slope| (slope, slope.above(end)));
            Onward::bind(self.on_track(end), velocity, slope, reach, ground)
        })
    }

    /// Returns the pose that many seconds after its track has begun.
    fn on_track(&self, seconds: f64) -> Pose {
        let pose = self.trajectory.pose_at(seconds);
        self.slope.as_ref().map_or(pose, |slope| slope.stand(pose, seconds))
    }

    /// Returns the way along its track.
    fn way(&self) -> FlownWay<'_> {
        let place: Box<dyn Fn(f64) -> DVec3> = match &self.slope {
            Some(_) => Box::new(|seconds| self.on_track(seconds).eye),
            None => Box::new(|seconds| self.trajectory.position_at(seconds)),
        };
        FlownWay { trajectory: &self.trajectory, place, start: self.start }
    }

    /// Builds its body, which has that id and is at `pose`.
    fn body(&self, id: u32, pose: Pose) -> Body {
        let (mut form, mut attitude) = (self.form.clone(), pose.attitude);
        if let (Some(to), Form::Line { length, .. }) = (self.to, &mut form) {
            let offset = to - pose.eye;
            *length = offset.length();
            let pitch = offset.z.atan2(offset.truncate().length()).to_degrees();
            attitude = Attitude { yaw: offset.x.atan2(offset.y).to_degrees(), pitch, roll: 0.0 };
        }
        Body { id, form, position: pose.eye, attitude, albedo: self.albedo, priority: self.priority }
    }

    /// Returns the axes of its parts while it is at `pose`, so many seconds after the flight's first fix.
    fn parts_at(&self, pose: Pose, seconds: f64) -> Vec<Axes> {
        let own = Axes { origin: pose.eye, turn: pose.attitude.world_from_body() };
        let mut all: Vec<Axes> = Vec::with_capacity(self.parts.len());
        for part in &self.parts {
            let below = part.parent.map_or(own, |parent| all[parent]);
            all.push(below.with(&part.joint.at(seconds)));
        }
        all
    }
}

/// An object of a scene, or a part of one, as what a camera looks at: while it is hidden, at the nearest end of its track.
#[derive(Debug, Clone)]
pub struct CastSubject {
    cast: Arc<Cast>,
    id: usize,
}

impl CastSubject {
    /// Finds it by name; `None`: there is none of that name.
    pub fn new(cast: &Arc<Cast>, name: &str) -> Option<Self> {
        let id = cast.names.iter().position(|other| other == name)?;
        Some(Self { cast: cast.clone(), id })
    }
}

impl Subject for CastSubject {
    fn place_at(&self, seconds: f64) -> DVec3 {
        let owner = match self.id.checked_sub(self.cast.actors.len()) {
            Some(part) => self.cast.owners[part],
            None => self.id,
        };
        let actor = &self.cast.actors[owner];
        let hidden = || actor.start + (seconds - actor.start).clamp(0.0, actor.trajectory.duration());
        let pose = self.cast.pose_at(self.id, seconds).or_else(|| self.cast.pose_at(self.id, hidden()));
        pose.unwrap_or_else(|| actor.on_track(0.0)).eye
    }
}

impl Cast {
    /// Names of all bodies, by their ids 0, 1, …: those of the objects, and then those of their parts, `object/part`.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    /// Objects whose tracks were raised to keep their height above hills between fixes, and by how much at most, metres: such as stand on the ground keep to that.
    pub fn raised(&self) -> impl Iterator<Item = (&str, f64)> {
        let over = self.names.iter().zip(&self.actors).filter(|(_, actor)| actor.slope.is_none());
        over.map(|(name, actor)| (name.as_str(), actor.trajectory.raised()))
            .filter(|(_, metres)| *metres > NOTED)
    }

    /// Names of the objects that bodies are or are parts of, by the ids of these.
    pub fn owners(&self) -> impl Iterator<Item = &str> {
        (0..self.actors.len()).chain(self.owners.iter().copied()).map(|actor| self.names[actor].as_str())
    }

    /// All bodies that are there so many seconds after the flight's first fix: objects, and then parts.
    pub fn bodies_at(&self, seconds: f64) -> Vec<Body> {
        self.bodies_and_parts(seconds, |_| true).0
    }

    /// Returns [`Self::bodies_at`] of actors that are seen, and how many of them are parts.
    fn bodies_and_parts(&self, seconds: f64, is_seen: impl Fn(&Actor) -> bool) -> (Vec<Body>, usize) {
        let (mut bodies, mut parts) = (Vec::with_capacity(self.names.len()), Vec::new());
        for (id, actor) in (0..).zip(&self.actors).filter(|(_, actor)| is_seen(actor)) {
            let Some(pose) = actor.pose_at(seconds) else { continue };
            bodies.push(actor.body(id, pose));
            let placed = actor.parts.iter().zip(actor.parts_at(pose, seconds));
            parts.extend((actor.first as u32..).zip(placed).map(|(id, (part, axes))| Body {
                id,
                form: part.form.clone(),
                position: axes.origin,
                attitude: Attitude::of_body(axes.turn),
                albedo: Vec3::from_array(part.albedo),
                priority: part.priority,
            }));
        }
        let count = parts.len();
        bodies.extend(parts);
        (bodies, count)
    }

    /// Returns the pose of the body of that id, so many seconds after the flight's first fix; `None`: it is not there.
    fn pose_at(&self, id: usize, seconds: f64) -> Option<Pose> {
        let Some(part) = id.checked_sub(self.actors.len()) else { return self.actors[id].pose_at(seconds) };
        let actor = &self.actors[self.owners[part]];
        let pose = actor.pose_at(seconds)?;
        let Axes { origin, turn } = actor.parts_at(pose, seconds)[id - actor.first];
        Some(Pose { eye: origin, attitude: Attitude::of_body(turn), ..pose })
    }

    /// All of them, so many seconds after the flight's first fix.
    pub fn at(&self, seconds: f64) -> Scenery {
        self.scenery(seconds, |_| true)
    }

    /// Returns all that a camera aboard what flies sees, so many seconds after the flight's first fix.
    pub fn from_aboard(&self, seconds: f64) -> Scenery {
        self.scenery(seconds, |actor| actor.from_aboard)
    }

    fn scenery(&self, seconds: f64, is_seen: impl Fn(&Actor) -> bool) -> Scenery {
        let (bodies, parts) = self.bodies_and_parts(seconds, is_seen);
        let (lights, puffs) = (self.lights_at(seconds), self.puffs_at(seconds));
        Scenery { bodies, parts, lights, puffs, trails: self.trails.at(seconds) }
    }

    /// All puffs of smoke and dust, so many seconds after the flight's first fix.
    pub fn puffs_at(&self, seconds: f64) -> Vec<Puff> {
        self.plumes.at(seconds, |body, seconds| self.pose_at(body, seconds))
    }

    /// All lamps that shine, so many seconds after the flight's first fix.
    pub fn lights_at(&self, seconds: f64) -> Vec<PointLight> {
        self.lamps.at(seconds, |body| self.pose_at(body, seconds))
    }
}
