//! Bands of sensors: one pattern, at a gain and an offset for each.
//!
//! ```text
//! tone in a band = offset + gain·(tone of the code − middle)         a gain below zero: what is bright becomes dark
//! ```
//!
//! The study of cyclic codes (AFHRL on ACTES) asks for texture as infrared and low-light sensors show it; the
//! law is ours.

use serde::{Deserialize, Serialize};

/// Band that a sensor sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorBand {
    /// Visible light.
    Visual,
    /// Visible and near infrared light, amplified.
    LowLight,
    /// Heat.
    Infrared,
}

/// Gain and offset of a pattern in a band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BandTone {
    /// Mean, greys of 256.
    pub offset: f64,
    /// Change for each tone of the pattern.
    pub gain: f64,
}

/// A pattern in all bands.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BandTones {
    /// Tone in visible light.
    pub visual: BandTone,
    /// Tone in amplified light.
    pub low_light: BandTone,
    /// Tone in heat.
    pub infrared: BandTone,
}

impl SensorBand {
    /// All bands.
    pub const ALL: [Self; 3] = [Self::Visual, Self::LowLight, Self::Infrared];
}

impl BandTone {
    /// Grey of a tone, so far from the middle of the pattern.
    pub fn grey(self, from_middle: f64) -> f64 {
        self.offset + self.gain * from_middle
    }
}

impl BandTones {
    /// Gain and offset in a band.
    pub fn of(&self, band: SensorBand) -> BandTone {
        match band {
            SensorBand::Visual => self.visual,
            SensorBand::LowLight => self.low_light,
            SensorBand::Infrared => self.infrared,
        }
    }
}
