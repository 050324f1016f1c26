//! Flags of a film's camera: where the eye is along a flight, and where it looks.

use std::path::Path;

use clap::Args;
use serde_json::{Value, json};

use crate::args;
use hedgehop::flight::{Altitude, AltitudeMode, Chase, Fix, Horizontal, Look, Mount, Orbit, Shot, Track};
use hedgehop::scene::Scene;
use hedgehop::{Error, Result};

/// Flags of the camera. Any of them goes before the cameras of the scene.
#[derive(Debug, Clone, Default, Args)]
pub struct CameraArgs {
    /// Pitch of the view, degrees, up positive, whatever the flight's: -10 keeps the ground in view
    #[arg(long, value_name = "DEGREES", value_parser = pitch, allow_hyphen_values = true, conflicts_with_all = ["eye", "views"])]
    pub pitch: Option<f64>,

    /// Direction of the view: ahead, along the nose; down; or a time of the film, 5s, at the place where the flight will be then, 9° below the horizon or lower
    /// [default: ahead, lowered likewise for recordings without a pitch]
    #[arg(long, value_name = "WHERE", value_parser = look, allow_hyphen_values = true, conflicts_with_all = ["eye", "views", "pitch"])]
    pub look: Option<LookWord>,

    /// Look at a place, metres in the database's reference system (without Z on the ground there), or at an object of the scene by its name
    #[arg(long, value_name = "X,Y[,Z]|NAME", value_parser = look_at, allow_hyphen_values = true, conflicts_with_all = ["eye", "pitch", "look"])]
    pub look_at: Option<LookedAt>,

    /// --look-at is longitude and latitude in degrees (WGS 84), and altitude in metres
    #[arg(long, requires = "look_at")]
    pub look_at_lonlat: bool,

    /// Fly behind, so many metres back, up and perhaps to the right, and look at what flies: 60,15
    #[arg(long, value_name = "BACK,UP[,SIDE]", value_parser = chase, allow_hyphen_values = true, conflicts_with_all = ["eye", "views"])]
    pub chase: Option<Chase>,

    /// Go around what flies, or what --look-at names: radius and height above it, metres, and seconds of the film a turn takes
    /// (60; negative: anticlockwise)
    #[arg(long, value_name = "RADIUS,UP[,SECONDS]", value_parser = orbit, allow_hyphen_values = true, conflicts_with_all = ["eye", "views", "chase"])]
    pub orbit: Option<Orbit>,
}

/// A direction, as --look names it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LookWord {
    /// Along the nose.
    Nose,
    /// Straight down.
    Down,
    /// At the place of the flight so many seconds of the film later.
    Ahead(f64),
}

/// Something that a camera looks at, as --look-at names it.
#[derive(Debug, Clone, PartialEq)]
pub enum LookedAt {
    /// A place, and its altitude unless that is the ground's.
    Place([f64; 2], Option<f64>),
    /// An object of the scene.
    Object(String),
}

/// Longest time that a view is ahead of its flight, seconds.
const LONGEST: f64 = 3600.0;

impl CameraArgs {
    /// Returns the shots of a film: one if flags say anything of it, or else those of the path file, or those of the scene. `mode` is the
    /// level that altitudes are measured from, if that is said.
    ///
    /// # Errors
    /// An object is named, and there is no scene with it.
    pub fn shots(
        &self,
        of_file: &[Shot],
        scene: Option<&Scene>,
        mode: Option<AltitudeMode>,
    ) -> Result<Vec<Shot>> {
        if !self.is_given() && !of_file.is_empty() {
            return Ok(of_file.to_vec());
        }
        if !self.is_given() {
            return Ok(scene.map(|scene| scene.cameras.clone()).unwrap_or_default());
        }

        let mount = match (self.chase, self.orbit) {
            (Some(chase), _) => Mount::Chase(chase),
            (None, Some(orbit)) => Mount::Orbit(orbit),
            (None, None) => Mount::Aboard,
        };
        let looked_at =
            self.look_at.as_ref().map(|looked_at| self.looked_at(looked_at, scene, mode)).transpose()?;
        let word = self.look.map(|word| match word {
            LookWord::Nose => Look::Nose,
            LookWord::Down => Look::Down,
            LookWord::Ahead(lead) => Look::Ahead(lead),
        });
        let look = looked_at.or(self.pitch.map(Look::Pitch)).or(word);
        Ok(vec![Shot { mount, look, ..Shot::default() }])
    }

    /// Records what decides the view; the default is not mentioned.
    pub fn record(&self, settings: &mut Value) {
        match self.look {
            None | Some(LookWord::Nose) => {}
            Some(LookWord::Ahead(seconds)) => settings["look_ahead_s"] = json!(seconds),
            Some(LookWord::Down) => settings["look"] = json!("down"),
        }
        if let Some(degrees) = self.pitch {
            settings["pitch_deg"] = json!(degrees);
        }
        match &self.look_at {
            Some(LookedAt::Place([x, y], z)) => {
                let key = if self.look_at_lonlat { "look_at_lonlat" } else { "look_at" };
                settings[key] = json!([x, y, z]);
            }
            Some(LookedAt::Object(name)) => settings["look_at_object"] = json!(name),
            None => {}
        }
        if let Some(Chase { back, up, side }) = self.chase {
            settings["chase_m"] = json!([back, up, side]);
        }
        if let Some(Orbit { radius, up, period }) = self.orbit {
            settings["orbit"] = json!({ "radius_m": radius, "up_m": up, "turn_s": period });
        }
    }

    /// Whether flags say anything of the camera.
    pub fn is_given(&self) -> bool {
        let looks = self.pitch.is_some() || self.look.is_some() || self.look_at.is_some();
        looks || self.chase.is_some() || self.orbit.is_some()
    }

    /// Returns the place that --look-at names, if it is given.
    ///
    /// # Errors
    /// An object is named.
    pub fn place(&self, mode: Option<AltitudeMode>) -> Result<Option<Track>> {
        match &self.look_at {
            None => Ok(None),
            Some(LookedAt::Place(place, z)) => Ok(Some(self.place_track(*place, *z, mode))),
            Some(LookedAt::Object(name)) => Err(Error::Configuration(format!(
                "--look-at {name}: --views looks at a place; give X,Y or X,Y,Z"
            ))),
        }
    }

    fn place_track(&self, [x, y]: [f64; 2], z: Option<f64>, mode: Option<AltitudeMode>) -> Track {
        let horizontal = if self.look_at_lonlat { Horizontal::LonLat(x, y) } else { Horizontal::Xy(x, y) };
        let altitude = match z {
            Some(metres) => Altitude { metres, mode: mode.unwrap_or(AltitudeMode::Msl) },
            None => Altitude { metres: 0.0, mode: AltitudeMode::Agl },
        };
        single_fix("--look-at", horizontal, altitude, [0.0; 3])
    }

    fn looked_at(
        &self,
        looked_at: &LookedAt,
        scene: Option<&Scene>,
        mode: Option<AltitudeMode>,
    ) -> Result<Look> {
        match looked_at {
            LookedAt::Place(place, z) => Ok(Look::Place(self.place_track(*place, *z, mode))),
            LookedAt::Object(_) if self.look_at_lonlat => Err(Error::Configuration(
                "--look-at-lonlat is about a place; --look-at names an object".into(),
            )),
            LookedAt::Object(name) => {
                let mut names = scene.iter().flat_map(|scene| scene.names());
                if names.any(|other| other == *name) {
                    return Ok(Look::Object(name.clone()));
                }
                let what = match scene {
                    None => {
                        "that is no place, and there is no --scene with an object of that name".to_owned()
                    }
                    Some(scene) if scene.path.as_os_str().is_empty() => "no flight has that name".to_owned(),
                    Some(scene) => format!("{} has no object of that name", scene.path.display()),
                };
                Err(Error::Configuration(format!("--look-at {name}: {what}; give X,Y,Z or an object's name")))
            }
        }
    }
}

/// A track of one fix that stands still; `path` names it in messages.
pub fn single_fix(
    path: impl AsRef<Path>,
    horizontal: Horizontal,
    altitude: Altitude,
    [yaw, pitch, roll]: [f64; 3],
) -> Track {
    let fix = Fix {
        time: 0.0,
        horizontal,
        altitude,
        accuracy: None,
        yaw: Some(yaw),
        pitch: Some(pitch),
        roll: Some(roll),
        hfov: None,
    };
    Track {
        path: path.as_ref().to_owned(),
        format: "single eye",
        fixes: vec![fix],
        clock: None,
        notes: Vec::new(),
        cameras: Vec::new(),
    }
}

fn pitch(text: &str) -> Result<f64, String> {
    let pitch = text.parse().ok().filter(|pitch: &f64| pitch.abs() <= 90.0);
    pitch.ok_or_else(|| "want degrees from -90, straight down, to 90".to_owned())
}

/// `ahead`, `down`, `5s`, `5`.
fn look(text: &str) -> Result<LookWord, String> {
    match text {
        "ahead" => Ok(LookWord::Nose),
        "down" => Ok(LookWord::Down),
        _ => text
            .strip_suffix('s')
            .unwrap_or(text)
            .parse()
            .ok()
            .filter(|seconds| *seconds > 0.0 && *seconds <= LONGEST)
            .map(LookWord::Ahead)
            .ok_or_else(|| "want ahead, down, or how far ahead the view is, above 0, such as 5s".to_owned()),
    }
}

/// Two or three numbers, or a name.
fn look_at(text: &str) -> Result<LookedAt, String> {
    match numbers(text).as_deref() {
        Some(place) if place.iter().any(|value| value.abs() > 1.0e9) => {
            Err("want a place at most 10⁹ metres from the origin".to_owned())
        }
        Some(&[x, y]) => Ok(LookedAt::Place([x, y], None)),
        Some(&[x, y, z]) => Ok(LookedAt::Place([x, y], Some(z))),
        None if !text.trim().is_empty() => Ok(LookedAt::Object(text.to_owned())),
        _ => Err("want a place, X,Y or X,Y,Z, or the name of an object of the scene".to_owned()),
    }
}

/// `60,15` or `60,15,-20`.
fn chase(text: &str) -> Result<Chase, String> {
    numbers(text).and_then(|offsets| Chase::of(&offsets)).ok_or_else(|| {
        "want metres behind, above and perhaps to the right of what flies, not all 0, such as 60,15"
            .to_owned()
    })
}

/// `300,100` or `300,100,90`.
fn orbit(text: &str) -> Result<Orbit, String> {
    let orbit = match numbers(text).as_deref() {
        Some(&[radius, up]) => Orbit::of([radius, up], None),
        Some(&[radius, up, period]) => Orbit::of([radius, up], Some(period)),
        _ => None,
    };
    orbit.ok_or_else(|| {
        "want a radius above 0 and a height, metres, and perhaps the seconds that a turn takes, 1 or more, such as 300,100,60"
            .to_owned()
    })
}

/// Numbers with commas between.
fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split(',').map(|part| args::number(part).ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_named_by_a_word_or_a_time() {
        assert_eq!(
            (look("down"), look("5s"), look("0.5")),
            (Ok(LookWord::Down), Ok(LookWord::Ahead(5.0)), Ok(LookWord::Ahead(0.5)))
        );
        for wrong in ["", "up", "0", "-3", "nan", "inf", "9000s", "s"] {
            assert!(look(wrong).is_err(), "{wrong}");
        }
        assert!(pitch("-90").is_ok() && pitch("-91").is_err() && pitch("nan").is_err());
    }

    #[test]
    fn places_and_objects_are_told_apart() {
        assert_eq!(look_at("1,-2"), Ok(LookedAt::Place([1.0, -2.0], None)));
        assert_eq!(look_at("1,2,3.5"), Ok(LookedAt::Place([1.0, 2.0], Some(3.5))));
        assert_eq!(look_at("truck/gun"), Ok(LookedAt::Object("truck/gun".into())));
        for wrong in ["", " ", "7", "1,2,3,4", "1e12,0"] {
            assert!(look_at(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn eyes_of_their_own_are_somewhere_else() {
        assert_eq!(chase("60,15"), Ok(Chase { back: 60.0, up: 15.0, side: 0.0 }));
        assert_eq!(chase("-60,15,3"), Ok(Chase { back: -60.0, up: 15.0, side: 3.0 }));
        assert_eq!(orbit("300,-10"), Ok(Orbit { radius: 300.0, up: -10.0, period: 60.0 }));
        assert_eq!(orbit("300,0,-5"), Ok(Orbit { radius: 300.0, up: 0.0, period: -5.0 }));
        for wrong in ["", "60", "0,0", "0,0,0", "60,15,1,1", "x,1", "1e9,1", "nan,1"] {
            assert!(chase(wrong).is_err(), "{wrong}");
        }
        for wrong in ["", "300", "0,10", "-5,10", "300,10,0", "300,10,0.5", "1,2,3,4"] {
            assert!(orbit(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn flags_make_one_shot() {
        let given = CameraArgs { pitch: Some(-10.0), ..CameraArgs::default() };
        let shots = given.shots(&[], None, None).unwrap();
        assert!(matches!(shots.as_slice(), [Shot { look: Some(Look::Pitch(-10.0)), .. }]));
        assert!(CameraArgs::default().shots(&[], None, None).unwrap().is_empty());
        let named = CameraArgs { look_at: Some(LookedAt::Object("glider".into())), ..CameraArgs::default() };
        assert!(named.shots(&[], None, None).unwrap_err().to_string().contains("no --scene"));
    }
}
