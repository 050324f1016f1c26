//! Sinusoid as a map: evaluated anew at each level, not averaged.
//!
//! ```text
//! tone(s, level) = contrast·sin(2π·s/wavelength + phase)      contrast: below
//! contrast of a level = the greater of sinc(π·zone width/wavelength), which a mean over a zone leaves,
//!                       and a quarter of the contrast of the level before
//! ```
//!
//! Means of pairs turn a sinusoid into steps and shift it; its own function at less contrast keeps its phase
//! at all levels.
//!
//! Source: Bunker and Ferris 1977 (AFHRL-TR-77-66), on tables of functions. The law of contrast is ours.

use std::f64::consts::{PI, TAU};

/// Share of a level's contrast that the next keeps at least.
const LEAST_KEPT: f64 = 0.25;

/// Sinusoid along an axis on the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sinusoid {
    /// Length of a wave, in the unit of the ground.
    pub wavelength: f64,
    /// Phase at place 0, radians.
    pub phase: f64,
    /// Width of zones at level 1, in the unit of the ground.
    pub zone_width: f64,
}

impl Sinusoid {
    /// Tone at a place along the axis, at a level from 1: −1 to 1 at most.
    pub fn tone(self, along: f64, level: u32) -> f64 {
        self.contrast(level) * (TAU * (along / self.wavelength).fract() + self.phase).sin()
    }

    /// Amplitude at a level from 1, which falls from level to level.
    pub fn contrast(self, level: u32) -> f64 {
        let left = |number: u32| {
            let angle = PI * self.zone_width * 2_f64.powi(number as i32 - 1) / self.wavelength;
            if angle < PI { angle.sin() / angle } else { 0.0 }
        };
        (1..=level.max(1)).fold(1.0, |before, number| left(number).max(LEAST_KEPT * before))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phase_is_kept_over_seven_levels() {
        let wave = Sinusoid { wavelength: 100.0, phase: 0.7, zone_width: 8.0 };
        let mut before = f64::INFINITY;
        for level in 1..=7 {
            // Against sine and cosine over whole waves.
            let (mut sine, mut cosine) = (0.0, 0.0);
            for sample in 0..1000 {
                let (along, angle) = (f64::from(sample) - 300.0, TAU * f64::from(sample) / 100.0);
                sine += wave.tone(along, level) * angle.sin() / 500.0;
                cosine += wave.tone(along, level) * angle.cos() / 500.0;
            }
            assert!((cosine.atan2(sine) - 0.7).abs() < 1e-9, "level {level}");
            let contrast = sine.hypot(cosine);
            assert!((contrast - wave.contrast(level)).abs() < 1e-9 && contrast < before && contrast > 0.0);
            before = contrast;
        }
    }

    #[test]
    fn fine_levels_are_means_over_zones() {
        let wave = Sinusoid { wavelength: 100.0, phase: 0.0, zone_width: 4.0 };
        let finer = Sinusoid { zone_width: 1e-6, ..wave };
        for (level, width) in [(1, 4.0), (2, 8.0), (3, 16.0)] {
            let samples = (0..1000)
                .map(|sample| finer.tone(17.0 + width * ((f64::from(sample) + 0.5) / 1000.0 - 0.5), 1));
            assert!((samples.sum::<f64>() / 1000.0 - wave.tone(17.0, level)).abs() < 1e-5);
        }
    }
}
