//! Contents of a scene file.

use std::path::PathBuf;

use glam::DVec2;
use serde::Deserialize;

use crate::flight::{Shot, Track};
use crate::objects::Form;
use crate::scene::joint::Joint;
use crate::scene::{Finish, Light, Plume, Titling, Trail};
use crate::sunlight::{FilmSun, Night, Sky};
use crate::weather::Weather;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// Light of a night sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NightSky {
    /// Illuminance of level ground by moon, and by the lamps of the land about, lx, 0…1000.
    pub lux: f64,
    /// Whether stars are seen.
    pub stars: bool,
}

impl Default for NightSky {
    /// Stars, and as much moonlight as [`Night`] has.
    fn default() -> Self {
        Self { lux: Night::default().lux, stars: true }
    }
}

/// Contents of a scene file.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// The file; empty: none.
    pub path: PathBuf,
    /// Hexadecimal BLAKE3 of the file and of all files that it names.
    pub digest: String,
    /// Position of the sun, if it is given: from 90 degrees below the horizon to 90 above it.
    pub sun: Option<FilmSun>,
    /// Whether ground lies in the shadow of ground, if it says so.
    pub shadows: Option<bool>,
    /// Light besides the sun's.
    pub night: NightSky,
    /// Lines of the file that say when the sun stands, and that ground lies in shadow.
    pub lines: SunLines,
    /// Meteorological visibility at the lowest ground, metres, > 0, if it is given.
    pub visibility: Option<f64>,
    /// Weather, but for the visibility of haze.
    pub weather: Weather,
    /// Steps from light to a picture.
    pub finish: Finish,
    /// Text and figures over pictures.
    pub titling: Titling,
    /// Objects, by name.
    pub objects: Vec<Object>,
    /// Lights, in the order of the file.
    pub lights: Vec<Light>,
    /// Plumes, in the order of the file.
    pub plumes: Vec<Plume>,
    /// Shots of a film along the flight, in their order.
    pub cameras: Vec<Shot>,
    /// Trails, in the order of the file.
    pub trails: Vec<Trail>,
}

/// Lines of a scene file, from 1 on, for what is wrong with a sun over some database; `None`: it says nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SunLines {
    /// Line of `time`.
    pub time: Option<usize>,
    /// Line of `shadows`.
    pub shadows: Option<usize>,
}

/// Behaviour of an object before its track begins and after it has ended.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Beyond {
    /// Stands at the track's first and last fix.
    #[default]
    Hold,
    /// Is not there.
    Hide,
    /// Goes straight on as fast as it does there, and turned as it is there (IEEE 1278.1, dead reckoning model 2). With heights above ground it keeps to
    /// the ground for ten minutes at most, and goes on level where that ends.
    DeadReckoning,
}

/// Something that stands somewhere, or moves.
#[derive(Debug, Clone)]
pub struct Object {
    /// No two of a scene have the same.
    pub name: String,
    /// Line of the scene file, from 1 on.
    pub line: usize,
    /// Appearance from all sides.
    pub form: Form,
    /// Files that its models, and its parts' models and angles were read from.
    pub files: Vec<PathBuf>,
    /// Parts of its models that are not shown, as clauses.
    pub notes: Vec<String>,
    /// Linear Rec. 709 reflectance, 0…1; of a model that of what has no colour of its own.
    pub albedo: [f32; 3],
    /// Rank among bodies at the same range, −1000…1000.
    pub priority: i32,
    /// Track of the object; one fix if it stands.
    pub track: Track,
    /// End of a line, if its place and not its length is given.
    pub to: Option<Track>,
    /// Seconds after the flight's first fix at which the track's first fix is.
    pub start: f64,
    /// Behaviour beyond its track.
    pub beyond: Beyond,
    /// Whether it banks in turns where its track says nothing of roll.
    pub banks: bool,
    /// Whether it leans as the ground below it does.
    pub leans: bool,
    /// Whether cameras aboard what flies see it.
    pub from_aboard: bool,
    /// Moving parts; each after what it goes with.
    pub parts: Vec<Part>,
}

/// Between an object's name and its part's, where both are named.
pub(super) const BETWEEN: char = '/';

/// Something that goes with an object, and moves on it.
#[derive(Debug, Clone)]
pub struct Part {
    /// No two of an object have the same.
    pub name: String,
    /// Line of the scene file, from 1 on.
    pub line: usize,
    /// Appearance from all sides, about its pivot.
    pub form: Form,
    /// Linear Rec. 709 reflectance, 0…1; of a model that of what has no colour of its own.
    pub albedo: [f32; 3],
    /// Rank among bodies at the same range, −1000…1000.
    pub priority: i32,
    /// Number of the object's part that it goes with, less than its own; `None`: the object itself.
    pub parent: Option<usize>,
    /// Turns a minute about its axis, clockwise as seen from its tip.
    pub turn_rpm: f64,
    /// The table that says how it is turned.
    pub table: Option<PathBuf>,
    pub(super) joint: Joint,
}

impl Scene {
    /// Names of all bodies, by their ids: those of objects, and then `object/part` of their parts.
    pub fn names(&self) -> impl Iterator<Item = String> {
        let parts = self.objects.iter().flat_map(|object| {
            object.parts.iter().map(move |part| format!("{}{}{}", object.name, BETWEEN, part.name))
        });
        self.objects.iter().map(|object| object.name.clone()).chain(parts)
    }

    /// Builds the error of something in a line of the file; 0: in none.
    pub(super) fn wrong(&self, line: usize, what: &str) -> Error {
        match line {
            0 => Error::Configuration(what.to_owned()),
            line => Error::invalid(&self.path, format!("line {line}: {what}")),
        }
    }

    /// Finds where sun and stars of the scene stand over a place of `crs` (its metres or degrees), if it says so and they stand still.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the line: what [`SunSetting::over`](crate::sunlight::SunSetting::over) says of its time.
    pub fn sky_over(&self, crs: &Crs, place: DVec2) -> Result<Option<Sky>> {
        match self.sun {
            Some(FilmSun::Still(sun)) => sun.over(crs, place).map(Some).map_err(|error| self.of_sun(error)),
            Some(FilmSun::Track | FilmSun::From(_)) | None => Ok(None),
        }
    }

    /// Adds the line of the sun's time to what is wrong with it.
    pub fn of_sun(&self, error: Error) -> Error {
        match (error, self.lines.time) {
            (Error::Configuration(what), Some(line)) => {
                Error::invalid(&self.path, format!("line {line}: {what}"))
            }
            (other, _) => other,
        }
    }
}
