//! Flags of the camera's aim along a flight.

use clap::Args;
use serde_json::{Value, json};

use hedgehop::flight::Aim;

/// Flags of the camera's aim.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct AimArgs {
    /// Pitch of the view, degrees, up positive, whatever the flight's: -10 keeps the ground in view
    #[arg(long, value_name = "DEGREES", value_parser = pitch, allow_hyphen_values = true, conflicts_with = "eye")]
    pub pitch: Option<f64>,

    /// Direction of the view: ahead, along the nose; down; or a time, 5s, at the place where the flight will be then [default: ahead]
    #[arg(long, value_name = "WHERE", value_parser = look, allow_hyphen_values = true, conflicts_with_all = ["eye", "pitch"])]
    pub look: Option<Aim>,
}

/// Longest time that a view is ahead of its flight, seconds.
const LONGEST: f64 = 3600.0;

impl AimArgs {
    /// Returns what the flags ask for.
    pub fn aim(&self) -> Aim {
        self.pitch.map(Aim::Pitch).or(self.look).unwrap_or_default()
    }

    /// Records what decides the view; the default is not mentioned.
    pub fn record(&self, settings: &mut Value) {
        match self.aim() {
            Aim::Nose => {}
            Aim::Pitch(degrees) => settings["pitch_deg"] = json!(degrees),
            Aim::Ahead(seconds) => settings["look_ahead_s"] = json!(seconds),
            Aim::Down => settings["look"] = json!("down"),
        }
    }
}

fn pitch(text: &str) -> Result<f64, String> {
    let pitch = text.parse().ok().filter(|pitch: &f64| pitch.abs() <= 90.0);
    pitch.ok_or_else(|| "want degrees from -90, straight down, to 90".to_owned())
}

/// `ahead`, `down`, `5s`, `5`.
fn look(text: &str) -> Result<Aim, String> {
    match text {
        "ahead" => Ok(Aim::Nose),
        "down" => Ok(Aim::Down),
        _ => text
            .strip_suffix('s')
            .unwrap_or(text)
            .parse()
            .ok()
            .filter(|seconds| *seconds > 0.0 && *seconds <= LONGEST)
            .map(Aim::Ahead)
            .ok_or_else(|| "want ahead, down, or how far ahead the view is, above 0, such as 5s".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_named_by_a_word_or_a_time() {
        assert_eq!(
            (look("down"), look("5s"), look("0.5")),
            (Ok(Aim::Down), Ok(Aim::Ahead(5.0)), Ok(Aim::Ahead(0.5)))
        );
        for wrong in ["", "up", "0", "-3", "nan", "inf", "9000s", "s"] {
            assert!(look(wrong).is_err(), "{wrong}");
        }
        assert!(pitch("-90").is_ok() && pitch("-91").is_err() && pitch("nan").is_err());
        let args = AimArgs { pitch: Some(-10.0), look: None };
        assert_eq!((args.aim(), AimArgs::default().aim()), (Aim::Pitch(-10.0), Aim::Nose));
    }
}
