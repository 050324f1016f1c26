//! Sun that runs with a flight: what flags and the scene ask for, over a database.

use std::path::Path;

use serde_json::{Value, json};

use crate::area;
use hedgehop::flight::{TrackClock, Trajectory};
use hedgehop::scene::Scene;
use hedgehop::sunlight::{FilmSun, RunningSky};
use hedgehop::voxel::Header;
use hedgehop::{Error, Result};

/// Request for a sun that runs with the flight.
#[derive(Debug, Clone, Copy)]
pub struct RunningSun<'s> {
    /// Time of the first fix, seconds since 1970-01-01T00:00:00Z; `None`: by the clock of the path file.
    start: Option<f64>,
    /// Scene that asks for it; `None`: a flag does.
    scene: Option<&'s Scene>,
}

impl<'s> RunningSun<'s> {
    /// The sun that a flag or, if it is given, a scene asks for; `None`: that one stands still.
    pub fn new(sun: FilmSun, scene: Option<&'s Scene>) -> Option<Self> {
        match sun {
            FilmSun::Still(_) => None,
            FilmSun::Track | FilmSun::From(_) => Some(Self { start: sun.start(), scene }),
        }
    }

    /// Puts it over a database, along a flight whose path is in a file; `None`: an eye that stands still.
    ///
    /// # Errors
    /// A flight without date and time, where they are asked for; an area that is not placed on Earth; a year that has no sun.
    pub fn over(&self, header: &Header, flown: &Trajectory, path: Option<&Path>) -> Result<RunningSky> {
        let sky = || {
            let start = match self.start {
                Some(start) => start,
                None => self.clock(flown, path)?,
            };
            let sky = RunningSky::new(area::observatory(header)?, start);
            // Between them the years are sound, too.
            sky.at(0.0).and(sky.at(flown.duration())).map(|_| sky)
        };
        sky().map_err(|error| match self.scene {
            Some(scene) => scene.of_sun(error),
            None => error,
        })
    }

    /// Returns the time of the first fix by the file's clock, seconds since 1970-01-01T00:00:00Z.
    fn clock(&self, flown: &Trajectory, path: Option<&Path>) -> Result<f64> {
        let clock = flown.clock();
        if let Some(seconds) = clock.and_then(|clock| clock.unix_seconds()) {
            return Ok(seconds);
        }

        let [asked, remedy] = match self.scene {
            Some(_) => ["time = \"track\"", "the time of the first fix as time, and runs = true"],
            None => ["--sun track", "--sun TIME with --sun-runs, TIME being that of the first fix"],
        };
        let silent = match (path, clock) {
            (None, _) => "--eye and --views tell no time".to_owned(),
            (Some(path), None) => format!("{} tells no time", path.display()),
            (Some(path), Some(TrackClock { .. })) => {
                format!("{} tells the time of day, but not the date (HFDTE)", path.display())
            }
        };
        Err(Error::Configuration(format!("{asked}: {silent}; give {remedy}")))
    }
}

/// Records what decides pictures: the time of the flight's first fix, in place of one sun.
pub fn record(sky: &RunningSky, settings: &mut Value) -> Result<()> {
    if let Some(settings) = settings.as_object_mut() {
        settings.remove("sun_azimuth_elevation_deg");
    }
    settings["sun_runs_from"] = json!(sky.start()?);
    Ok(())
}
