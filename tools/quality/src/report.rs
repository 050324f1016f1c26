//! Report of the program: tables on standard output, everything measured as JSON.

use std::path::Path;

use serde::Serialize;

use hedgehop::encode::atomic::write_bytes;
use hedgehop::space::Pose;
use hedgehop::{Error, Result};

/// A line of the answer.
pub fn line(text: &str) {
    #[expect(clippy::print_stdout, reason = "a program's answer")]
    {
        println!("{text}");
    }
}

/// Writes `measured`, if a file is wanted.
pub fn json(path: Option<&Path>, measured: &impl Serialize) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let text = serde_json::to_string_pretty(measured)
        .map_err(|source| Error::invalid(path, format!("the figures make no JSON: {source}")))?;
    write_bytes(path, text.as_bytes())
}

/// A pose in reports.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct PoseRecord {
    /// Metres.
    pub eye_m: [f64; 3],
    /// Degrees.
    pub yaw_pitch_roll_deg: [f64; 3],
    /// Degrees.
    pub hfov_deg: f64,
}

impl From<Pose> for PoseRecord {
    fn from(pose: Pose) -> Self {
        let attitude = pose.attitude;
        Self {
            eye_m: pose.eye.to_array(),
            yaw_pitch_roll_deg: [attitude.yaw, attitude.pitch, attitude.roll],
            hfov_deg: pose.hfov,
        }
    }
}
