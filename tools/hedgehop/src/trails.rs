//! Flags of trails: the own way, and other recorded flights.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};

use crate::playback;
use crate::view::FlightArgs;
use hedgehop::colour::{linear_from_srgb8, srgb8_from_hex};
use hedgehop::flight::{Track, read_track};
use hedgehop::objects::Form;
use hedgehop::progress::Observer;
use hedgehop::scene::{Beyond, Object, Scene, Trail, TrailColour, TrailQuantity, TrailSource};
use hedgehop::{Error, Result};

/// Colours of other flights, sRGB: those of Okabe and Ito (2008), which all eyes tell apart.
const COLOURS: [[u8; 3]; 6] =
    [[86, 180, 233], [240, 228, 66], [0, 158, 115], [204, 121, 167], [213, 94, 0], [0, 114, 178]];

/// Width of the ball that stands for another flight: metres, and pixels at least.
const METRES: f64 = 2.0;
const PIXELS: f64 = 9.0;

/// Seconds of a day.
const DAY: f64 = 86_400.0;

/// Flags of trails and other flights.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Look")]
pub struct TrailArgs {
    /// Draw the way that was flown so far, in the colours of altitude, speed or climb, or in one, #ff8c00; it lies behind the eye unless
    /// the view looks back at it
    #[arg(long, value_name = "BY", value_parser = colour)]
    pub trail: Option<TrailColour>,

    /// Length of trails, back from where the flight is: 90s, 2m30s [default: since the first fix]
    #[arg(long, value_name = "TIME", value_parser = tail, allow_hyphen_values = true)]
    pub tail: Option<f64>,

    /// Another recorded flight, which is shown as a ball with a trail, by the times of day in both files, else from the first fix on; may be repeated
    #[arg(long = "other", value_name = "FILE")]
    pub others: Vec<PathBuf>,
}

/// `altitude`, `speed`, `climb`, or `#rrggbb`.
fn colour(text: &str) -> std::result::Result<TrailColour, String> {
    let by = |quantity| Ok(TrailColour::By(quantity, None));
    match text {
        "altitude" => by(TrailQuantity::Altitude),
        "speed" => by(TrailQuantity::Speed),
        "climb" => by(TrailQuantity::Climb),
        _ => srgb8_from_hex(text)
            .map(plain)
            .ok_or_else(|| "want altitude, speed, climb, or a colour, such as #ff8c00".to_owned()),
    }
}

/// A length of time above 0, seconds.
fn tail(text: &str) -> std::result::Result<f64, String> {
    playback::duration(text)
        .map_err(|_| "want how far back trails reach, above 0, such as 90s or 2m30s".to_owned())
}

fn plain(codes: [u8; 3]) -> TrailColour {
    TrailColour::Plain(linear_from_srgb8(codes).into())
}

impl TrailArgs {
    /// Adds what the flags ask for to a scene, which is made if there is none.
    ///
    /// # Errors
    /// A track that cannot be read or has a single fix; a length of trails that there are none of.
    pub fn add_to(
        &self,
        scene: Option<Scene>,
        flight: &FlightArgs,
        observer: &dyn Observer,
    ) -> Result<Option<Scene>> {
        if self.trail.is_none() && self.others.is_empty() {
            return match self.tail {
                Some(_) => Err(Error::Configuration(
                    "--tail says how long trails are; give --trail or --other, or tail_s in the scene".into(),
                )),
                None => Ok(scene),
            };
        }

        if flight.path.is_none() {
            return Err(Error::Configuration(
                "--trail and --other show flights over time; give --path FILE, not a single --eye".into(),
            ));
        }
        let own = flight.track()?;
        let mut scene = scene.unwrap_or_default();
        let mut hasher = blake3::Hasher::new();
        hasher.update(scene.digest.as_bytes());

        for (index, path) in self.others.iter().enumerate() {
            let track = read_track(path, &flight.tracks.of_others(flight.alt_mode.map(Into::into)))?;
            if track.fixes.len() < 2 {
                return Err(Error::invalid(path, "has a single fix, which is no flight (--other)"));
            }
            let bytes = fs::read(path).map_err(|source| Error::io(path, "read", source))?;
            hasher.update(&(bytes.len() as u64).to_le_bytes()).update(&bytes);

            let start = start(&own, &track, path, observer);
            let codes = COLOURS[index % COLOURS.len()];
            let object = other(free_name(&scene, path), track, start, codes);
            scene.trails.push(self.trail(TrailSource::Object(object.name.clone()), plain(codes)));
            scene.objects.push(object);
        }

        if let Some(colour) = self.trail {
            if own.fixes.len() < 2 {
                return Err(Error::invalid(&own.path, "has a single fix, and leaves no trail (--trail)"));
            }
            // What there is to say of the path is said of the flight.
            let track = Track { notes: Vec::new(), ..own };
            let source = TrailSource::Track { track, start: 0.0, options: flight.binding() };
            scene.trails.push(self.trail(source, colour));
        }

        scene.digest = hasher.finalize().to_hex().to_string();
        Ok(Some(scene))
    }

    /// A trail of something.
    fn trail(&self, source: TrailSource, colour: TrailColour) -> Trail {
        let name = match &source {
            TrailSource::Object(name) => name.clone(),
            TrailSource::Track { track, .. } => track.path.display().to_string(),
        };
        Trail {
            name,
            line: 0,
            source,
            colour,
            width: Trail::WIDTH,
            outline: Trail::OUTLINE,
            tail: self.tail,
            is_whole: false,
        }
    }

    /// Records what decides pictures, besides the files.
    pub fn record(&self, settings: &mut Value) {
        let said = match self.trail {
            None => None,
            Some(TrailColour::By(quantity, _)) => Some(json!(format!("{quantity:?}").to_lowercase())),
            Some(TrailColour::Plain(colour)) => Some(json!(colour.to_array())),
        };
        if let Some(said) = said {
            settings["trail"] = said;
        }
        if let Some(tail) = self.tail {
            settings["tail_s"] = json!(tail);
        }
        if !self.others.is_empty() {
            settings["others"] = json!(self.others.len());
        }
    }
}

/// Time at which another flight begins, seconds after the first fix of the own: by the clocks of both, on the nearest day.
fn start(own: &Track, other: &Track, path: &Path, observer: &dyn Observer) -> f64 {
    let (Some(first), Some(second)) = (own.clock, other.clock) else {
        let silent = if own.clock.is_none() { own } else { other };
        observer.note(&format!(
            "{} begins with the flight, since {} tells no time of day",
            path.display(),
            silent.path.display()
        ));
        return 0.0;
    };
    let apart = second.time_of_day - first.time_of_day;
    let apart = apart - DAY * (apart / DAY).round();
    let way = if apart < 0.0 { "before" } else { "after" };
    observer.note(&format!(
        "{} begins {:.0} s {way} the flight, by the times of day in both files; dates are not compared",
        path.display(),
        apart.abs()
    ));
    apart
}

/// A name after a file, which nothing in the scene has.
pub fn free_name(scene: &Scene, path: &Path) -> String {
    let stem =
        path.file_stem().map_or_else(|| "other".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let stem: String = stem.chars().filter(|char| !char.is_control()).take(100).collect();
    let numbered = (2..).map(|number| format!("{stem} {number}"));
    let is_free = |name: &String| scene.names().all(|known| known != *name);
    std::iter::once(stem.clone()).chain(numbered).find(is_free).unwrap_or_default()
}

/// The ball of another flight.
fn other(name: String, track: Track, start: f64, codes: [u8; 3]) -> Object {
    Object {
        name,
        line: 0,
        form: Form::Point { width: METRES, pixels: PIXELS },
        files: Vec::new(),
        notes: Vec::new(),
        albedo: linear_from_srgb8(codes),
        priority: 0,
        track,
        to: None,
        start,
        beyond: Beyond::Hold,
        banks: false,
        leans: false,
        from_aboard: true,
        parts: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use hedgehop::flight::TrackClock;

    use super::*;

    #[test]
    fn flights_of_one_day_are_shown_at_the_same_time() {
        struct Notes(std::sync::Mutex<Vec<String>>);
        impl Observer for Notes {
            fn note(&self, what: &str) {
                self.0.lock().unwrap().push(what.to_owned());
            }
        }

        let track = |name: &str, time_of_day: Option<f64>| Track {
            path: name.into(),
            format: "IGC",
            fixes: Vec::new(),
            clock: time_of_day.map(|time_of_day| TrackClock { time_of_day, midnight: None }),
            notes: Vec::new(),
            cameras: Vec::new(),
        };
        let cases = [
            (Some(36_000.0), Some(36_090.0), 90.0, "b begins 90 s after"),
            (Some(100.0), Some(86_300.0), -200.0, "b begins 200 s before"),
            (Some(86_000.0), Some(10.0), 410.0, "after"),
            (None, Some(10.0), 0.0, "since a tells no time"),
            (Some(10.0), None, 0.0, "since b tells no time"),
        ];
        for (own, other, expected, said) in cases {
            let notes = Notes(Vec::new().into());
            let found = start(&track("a", own), &track("b", other), Path::new("b"), &notes);
            let noted = notes.0.into_inner().unwrap().join("");
            assert!(found == expected && noted.contains(said), "{found} s: {noted}");
        }
    }

    #[test]
    fn trails_are_coloured_by_a_quantity_or_as_a_whole() {
        assert_eq!(colour("climb"), Ok(TrailColour::By(TrailQuantity::Climb, None)));
        assert_eq!(colour("#ff0000"), Ok(TrailColour::Plain(glam::Vec3::X)));
        for wrong in ["", "height", "#ff00", "#+f0000", "ff0000", "#é0000"] {
            assert!(colour(wrong).is_err(), "{wrong}");
        }
    }
}
