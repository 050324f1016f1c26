//! Settings of a run, in the study's four groups.
//!
//! Source: study of cyclic codes for surface texture (AFHRL on ACTES), inputs; names and units are ours.

use hedgehop_base::error::{Error, Result};
use serde::{Deserialize, Serialize};

use crate::table_text;

/// Name in errors.
const WHAT: &str = "settings of a run";

/// Everything that a run depends on.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Sky, ground and texture.
    pub database: DatabaseSettings,
    /// Size and angle of the screen.
    pub display: DisplaySettings,
    /// Frames, arithmetic and reports.
    pub simulator: SimulatorSettings,
    /// Place, velocity and attitude.
    pub aircraft: AircraftSettings,
}

/// Sky, ground and terrain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DatabaseSettings {
    /// Primitive polynomial of degree 8, a bit for each power.
    pub polynomial: u64,
    /// Tone of the sky, 0 to 255.
    pub sky: u8,
    /// Tone of flat ground, 0 to 255.
    pub ground: u8,
    /// Shades of the texture, a power of two.
    pub shades: u32,
    /// Shade in their middle.
    pub centre: u8,
    /// Terrain from and to, along x, feet.
    pub terrain_x_ft: [f64; 2],
    /// Terrain from and to, along y, feet.
    pub terrain_y_ft: [f64; 2],
    /// Side of a cell, feet.
    pub cell_ft: f64,
    /// Lines of a subterrain.
    pub subterrain_lines: u32,
    /// Place along the code where the first subterrain begins.
    pub subterrain_start: i64,
    /// Places along the code from the start of a subterrain to that of the next.
    pub subterrain_slip: i64,
    /// Tone of a runway, 0 to 255; none shows none.
    pub runway: Option<u8>,
}

/// Screen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DisplaySettings {
    /// Pixels of a line.
    pub pixels: u32,
    /// Lines.
    pub lines: u32,
    /// Angle that a line fills, degrees.
    pub fov_deg: f64,
}

/// Frames, arithmetic and reports.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SimulatorSettings {
    /// Time from a frame to the next, seconds.
    pub step_s: f64,
    /// Length of the flight, seconds.
    pub flight_s: f64,
    /// Parts of a cell that arithmetic tells apart, as a power of two.
    pub subdivision: u32,
    /// Whether edges are smoothed.
    pub smooth_edges: bool,
    /// Whether cells blend where they are larger than pixels.
    pub smooth_nearby: bool,
    /// Frames from one that is told of in the report to the next.
    pub report_every: u32,
}

/// Flight.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AircraftSettings {
    /// Place of the first frame: x, y and height, feet.
    pub place_ft: [f64; 3],
    /// Velocity along x, y and up, feet a second.
    pub velocity_ft_s: [f64; 3],
    /// Heading, degrees.
    pub heading_deg: f64,
    /// Pitch, degrees.
    pub pitch_deg: f64,
    /// Roll, degrees.
    pub roll_deg: f64,
}

impl Settings {
    /// Reads settings from TOML; what is missing has its usual value.
    ///
    /// # Errors
    ///
    /// The text is no TOML, or a key is unknown or of another kind.
    pub fn from_text(text: &str) -> Result<Self> {
        table_text::from_text(text, WHAT)
    }

    /// Writes settings as TOML, from which they come back as they are.
    ///
    /// # Errors
    ///
    /// Never, as settings hold what tables can.
    pub fn to_text(&self) -> Result<String> {
        table_text::to_text(self)
    }

    /// Settings with some values changed, as by who sits before the screen: `aircraft.roll_deg = 30`.
    ///
    /// # Errors
    ///
    /// As of [`Self::from_text`].
    pub fn changed(&self, change: &str) -> Result<Self> {
        table_text::changed(self, change, WHAT)
    }

    /// Frames of the flight, at least one.
    ///
    /// # Errors
    ///
    /// Times are not above zero, or there are more than a million.
    pub fn frames(&self) -> Result<u32> {
        let SimulatorSettings { step_s, flight_s, .. } = self.simulator;
        let frames = (flight_s / step_s).round();
        if step_s > 0.0 && (1.0..=1e6).contains(&frames) {
            return Ok(frames as u32);
        }
        Err(Error::Configuration(format!(
            "a flight of {flight_s} s in steps of {step_s} s has no frames; want simulator.step_s above 0, and \
             simulator.flight_s from one step to a million"
        )))
    }
}

impl Default for DatabaseSettings {
    /// Terrain of the study: a mile and a half in cells of 6 feet.
    fn default() -> Self {
        Self {
            polynomial: 0x12B,
            sky: 220,
            ground: 90,
            shades: 32,
            centre: 128,
            terrain_x_ft: [0.0, 9114.0],
            terrain_y_ft: [-3000.0, 3000.0],
            cell_ft: 6.0,
            subterrain_lines: 5,
            subterrain_start: 1,
            subterrain_slip: 10,
            runway: None,
        }
    }
}

impl Default for DisplaySettings {
    fn default() -> Self {
        Self { pixels: 640, lines: 480, fov_deg: 20.0 }
    }
}

impl Default for SimulatorSettings {
    /// Six seconds at 30 frames a second.
    fn default() -> Self {
        Self {
            step_s: 1.0 / 30.0,
            flight_s: 6.0,
            subdivision: 12,
            smooth_edges: true,
            smooth_nearby: false,
            report_every: 30,
        }
    }
}

impl Default for AircraftSettings {
    /// 200 knots toward the terrain.
    fn default() -> Self {
        Self {
            place_ft: [-3000.0, 0.0, 1000.0],
            velocity_ft_s: [337.6, 0.0, 0.0],
            heading_deg: 0.0,
            pitch_deg: -8.0,
            roll_deg: 0.0,
        }
    }
}
