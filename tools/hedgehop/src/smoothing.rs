//! Flags of how smooth a flight is.

use clap::Args;
use serde_json::{Value, json};

use hedgehop::flight::Smoothing;

/// Flags of the smoothness of a path's positions.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct SmoothingArgs {
    /// Take out of the path's positions what swings faster than this; 0 leaves them as they are [default: the noise of recordings]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_hyphen_values = true, conflicts_with_all = ["eye", "views"])]
    pub smooth: Option<f64>,
}

impl SmoothingArgs {
    /// Returns what the flags ask for.
    pub fn smoothing(&self) -> Smoothing {
        self.smooth.map_or(Smoothing::Noise, Smoothing::Period)
    }

    /// Records what decides the positions; the default is not mentioned.
    pub fn record(&self, settings: &mut Value) {
        if let Some(seconds) = self.smooth {
            settings["smooth_s"] = json!(seconds);
        }
    }
}

/// `3`, `3s`, `0`.
fn seconds(text: &str) -> Result<f64, String> {
    let number = text.strip_suffix('s').unwrap_or(text).parse();
    number
        .ok()
        .filter(|seconds: &f64| *seconds >= 0.0 && seconds.is_finite())
        .ok_or_else(|| "want seconds, such as 3, or 0 to leave the path as it is".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn periods_are_seconds() {
        assert_eq!((seconds("3"), seconds("2.5s"), seconds("0")), (Ok(3.0), Ok(2.5), Ok(0.0)));
        for wrong in ["", "-1", "nan", "inf", "s", "3m"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }
}
