//! A scene over a database.

use glam::{DVec2, DVec3, Vec3};

use super::light::LampCast;
use super::object::LARGEST;
use super::plume::PlumeCast;
use super::{Beyond, Scene};
use crate::error::{Error, Result};
use crate::flight::{BindOptions, Track, Trajectory};
use crate::geo::Crs;
use crate::objects::{Body, Form, PointLight, Puff};
use crate::space::{Attitude, Pose};

/// A field of view that nobody looks through, degrees.
const UNUSED_HFOV: f64 = 60.0;

/// Time over which the velocity at an end of a track is measured, seconds.
const STEP: f64 = 0.1;

/// Objects of a scene in a database's reference system: where each is at any time.
#[derive(Debug, Clone)]
pub struct Cast {
    /// By name.
    actors: Vec<Actor>,
    lamps: LampCast,
    plumes: PlumeCast,
}

#[derive(Debug, Clone)]
struct Actor {
    name: String,
    form: Form,
    albedo: Vec3,
    trajectory: Trajectory,
    /// The other end of a line, metres in the world.
    to: Option<DVec3>,
    start: f64,
    beyond: Beyond,
}

impl Scene {
    /// Binds the scene to a database's CRS; `ground` gives the surface height (metres) below a position of that CRS, `None` outside the area
    /// or where there is no surface.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the line and name of an object or a light: what [`Trajectory::bind`] says of its track; a lamp without ground below it, a light of an object
    /// that is none.
    pub fn bind(&self, crs: &Crs, ground: &dyn Fn(DVec2) -> Option<f64>) -> Result<Cast> {
        let actors = self.objects.iter().map(|object| {
            let options = BindOptions { level: !object.banks, hfov: UNUSED_HFOV, clearance: None };
            let of_object = |error: Error| {
                let what = match error {
                    Error::Invalid { what, .. } if object.track.fixes.len() == 1 => {
                        format!("{what}; of an object, altitude = \"msl\" in the scene")
                    }
                    other => other.to_string(),
                };
                Error::invalid(&self.path, format!("line {}: object `{}`: {what}", object.line, object.name))
            };
            let bind = |track: &Track| Trajectory::bind(track, crs, ground, &options).map_err(of_object);
            let trajectory = bind(&object.track)?;
            let to = object.to.as_ref().map(bind).transpose()?.map(|end| end.pose_at(0.0).eye);
            let length = to.map_or(1.0, |to| (to - trajectory.pose_at(0.0).eye).length());
            if length == 0.0 || length > LARGEST {
                let what = format!("a line must be more than 0 m and at most 100 km long, not {length} m");
                return Err(of_object(Error::Configuration(what)));
            }
            Ok(Actor {
                name: object.name.clone(),
                form: object.form.clone(),
                albedo: Vec3::from_array(object.albedo),
                trajectory,
                to,
                start: object.start,
                beyond: object.beyond,
            })
        });
        let actors: Vec<Actor> = actors.collect::<Result<_>>()?;
        let actor = |name: &str| actors.iter().position(|actor| actor.name == name);
        let lamps = LampCast::bind(&self.path, &self.lights, crs, ground, actor)?;
        let wrong = |line: usize, what: &str| Error::invalid(&self.path, format!("line {line}: {what}"));
        let plumes = PlumeCast::bind(&self.plumes, crs, ground, wrong, actor)?;
        Ok(Cast { actors, lamps, plumes })
    }
}

/// What is where at some moment.
#[derive(Debug, Clone, Default)]
pub struct Scenery {
    /// All objects.
    pub bodies: Vec<Body>,
    /// The lamps that shine.
    pub lights: Vec<PointLight>,
    /// Smoke and dust.
    pub puffs: Vec<Puff>,
}

impl Actor {
    /// Where it is, so many seconds after the flight's first fix; `None`: it is not there.
    fn pose_at(&self, seconds: f64) -> Option<Pose> {
        let seconds = seconds - self.start;
        let mut pose = self.trajectory.pose_at(seconds);
        let duration = self.trajectory.duration();
        let end = seconds.clamp(0.0, duration);
        match self.beyond {
            Beyond::Hide if seconds != end => return None,
            Beyond::DeadReckoning if duration > 0.0 => {
                let step = STEP.min(duration);
                let before = (end - step).max(0.0);
                let way = |seconds: f64| self.trajectory.pose_at(seconds).eye;
                pose.eye += (way(before + step) - way(before)) / step * (seconds - end);
            }
            Beyond::Hold | Beyond::Hide | Beyond::DeadReckoning => {}
        }
        Some(pose)
    }
}

impl Cast {
    /// Names of the objects, by the ids of their bodies: 0, 1, ….
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.actors.iter().map(|actor| actor.name.as_str())
    }

    /// All bodies that are there so many seconds after the flight's first fix.
    pub fn bodies_at(&self, seconds: f64) -> Vec<Body> {
        let body = |(id, actor): (u32, &Actor)| {
            let pose = actor.pose_at(seconds)?;
            let (mut form, mut attitude) = (actor.form.clone(), pose.attitude);
            if let (Some(to), Form::Line { length, .. }) = (actor.to, &mut form) {
                let offset = to - pose.eye;
                *length = offset.length();
                let pitch = offset.z.atan2(offset.truncate().length()).to_degrees();
                attitude = Attitude { yaw: offset.x.atan2(offset.y).to_degrees(), pitch, roll: 0.0 };
            }
            Some(Body { id, form, position: pose.eye, attitude, albedo: actor.albedo })
        };
        (0..).zip(&self.actors).filter_map(body).collect()
    }

    /// All of them, so many seconds after the flight's first fix.
    pub fn at(&self, seconds: f64) -> Scenery {
        Scenery {
            bodies: self.bodies_at(seconds),
            lights: self.lights_at(seconds),
            puffs: self.puffs_at(seconds),
        }
    }

    /// All puffs of smoke and dust, so many seconds after the flight's first fix.
    pub fn puffs_at(&self, seconds: f64) -> Vec<Puff> {
        self.plumes.at(seconds, |actor, seconds| self.actors[actor].pose_at(seconds))
    }

    /// All lamps that shine, so many seconds after the flight's first fix.
    pub fn lights_at(&self, seconds: f64) -> Vec<PointLight> {
        self.lamps.at(seconds, |actor| self.actors[actor].pose_at(seconds))
    }
}
