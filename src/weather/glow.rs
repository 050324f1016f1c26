//! Light that haze sends from about the sun.
//!
//! Droplets and dust scatter mostly forward: towards the sun air is brighter, and as warm as sunlight is after its way through
//! the air. How much of the colour of haze gives way to that of sunlight follows the phase function of Henyey and Greenstein
//! (1941, *Astrophysical Journal* 93, 70–83), which is 0 here where it is least, opposite the sun: haze there keeps its own
//! colour. A mixture of two colours, of which none is brighter than display white, is never brighter either.

use glam::Vec3;

use crate::sunlight::{Sun, seen_through};

/// Mean cosine of the angle by which light is scattered: between that of haze (0.7) and of what has been scattered several times.
const ASYMMETRY: f32 = 0.6;

/// 1 + g² and 2g of the phase function's (1 + g² − 2g·cos)^(−3/2).
pub(crate) const PHASE: [f32; 2] = [1.0 + ASYMMETRY * ASYMMETRY, 2.0 * ASYMMETRY];

/// The sun's elevation at which twilight ends, degrees.
const DARK: f64 = -18.0;

/// Glow of the air about the sun.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Glow {
    /// Unit vector to the sun.
    pub to_sun: Vec3,
    /// Linear Rec. 709 colour of sunlight that has come through the air; its largest part is 1.
    pub colour: Vec3,
    /// Share of it in the direction of the sun, 0…1, per unit of [`lobe`].
    pub strength: f32,
    /// The phase function opposite the sun.
    pub least: f32,
}

impl Glow {
    /// A glow of 0…1 around `sun`; none for 0.
    pub fn new(glow: f64, sun: Sun) -> Option<Self> {
        let (least, most) = (lobe(-1.0), lobe(1.0));
        // After sunset it goes with twilight.
        let glow = glow * (1.0 - sun.elevation / DARK).clamp(0.0, 1.0);
        (glow > 0.0).then(|| Self {
            to_sun: sun.direction(),
            colour: sunlight(sun),
            strength: glow as f32 / (most - least),
            least,
        })
    }

    /// Share of the colour of air seen in unit `direction` that gives way to that of sunlight, 0…1.
    pub fn share(&self, direction: Vec3) -> f32 {
        self.strength * (lobe(direction.dot(self.to_sun)) - self.least)
    }
}

/// Linear Rec. 709 colour of sunlight that has come through the air, of which the largest part is 1: white from the zenith.
pub fn sunlight(sun: Sun) -> Vec3 {
    seen_through(sun.air_mass() - 1.0)
}

/// The phase function, but for a factor.
fn lobe(cosine: f32) -> f32 {
    let base = PHASE[0] - PHASE[1] * cosine;
    1.0 / (base * base.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn air_opposite_the_sun_keeps_its_colour_and_towards_it_has_the_suns() {
        let sun = Sun { azimuth: 70.0, elevation: 8.0 };
        let glow = Glow::new(1.0, sun).unwrap();
        assert!(glow.share(-sun.direction()).abs() < 1e-6);
        assert!((glow.share(sun.direction()) - 1.0).abs() < 1e-5);
        assert_eq!(Glow::new(0.0, sun), None);
    }

    #[test]
    fn over_all_directions_little_is_added() {
        let glow = Glow::new(1.0, Sun { azimuth: 0.0, elevation: 45.0 }).unwrap();
        // Equal steps of cosine are equal parts of the sphere.
        let steps = 10_000;
        let mean = (0..steps)
            .map(|step| 2.0 * (step as f32 + 0.5) / steps as f32 - 1.0)
            .map(|cosine| glow.strength * (lobe(cosine) - glow.least))
            .sum::<f32>()
            / steps as f32;
        // The mean of Henyey and Greenstein's function is 1.
        let scale = (1.0 - ASYMMETRY * ASYMMETRY) * (lobe(1.0) - lobe(-1.0));
        let expected = (1.0 - (1.0 - ASYMMETRY * ASYMMETRY) * lobe(-1.0)) / scale;
        assert!((mean / expected - 1.0).abs() < 1e-3, "{mean} {expected}");
        assert!(mean < 0.1, "{mean}");
    }

    #[test]
    fn a_low_sun_is_red_and_a_high_one_white() {
        let low = sunlight(Sun { azimuth: 0.0, elevation: 3.0 });
        assert!(low.x == 1.0 && low.y < 0.8 && low.z < 0.4, "{low}");
        assert!((sunlight(Sun { azimuth: 0.0, elevation: 90.0 }) - Vec3::ONE).length() < 1e-3);
    }
}
