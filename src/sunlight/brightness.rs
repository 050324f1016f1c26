//! Brightness of a picture at an hour, and the luminance that its light stands for.
//!
//! By day level ground keeps the light of its photograph, whatever the sun's elevation: eyes and cameras adapt. Under a low sun they do
//! so in part only. A picture grows darker by a power of the illuminance, and at dusk bluer, as eyes see by night; and since it is known which illuminance
//! makes white of white ground, it is known how bright a lamp of so many candela is in it.

use glam::Vec3;

use super::Sun;

/// Cubic polynomials of the decimal logarithm of the sun's illuminance on level ground, lx, over elevation/90°, and the elevations (degrees) down to
/// which they hold (Janiczek and DeYoung 1987, *Computer Programs for Sun and Moon Illuminance*, US Naval Observatory Circular 171).
const ILLUMINANCE: [(f64, [f64; 4]); 6] = [
    (20.0, [3.74, 3.97, -4.07, 1.47]),
    (5.0, [3.05, 13.28, -45.98, 64.33]),
    (-0.8, [2.88, 22.26, -207.64, 1034.30]),
    (-5.0, [2.88, 21.81, -258.11, -858.36]),
    (-12.0, [2.70, 12.17, -431.69, -1899.83]),
    (-18.0, [13.84, 262.72, 1447.42, 2797.93]),
];

/// Elevation of the sun, degrees, from which pictures are as bright as by day.
const DAY: f64 = 10.0;

/// Part of a fall of illuminance that a picture shows, as the power to which it is taken: five magnitudes from day to moonlight
/// become one and a third. Chosen so that ground in moonlight is dark, and can be seen.
const SHOWN: f64 = 0.27;

/// Colour of white ground at night, linear Rec. 709 of luminance 1: rods see blue brighter than cones do.
const NIGHT: Vec3 = Vec3::new(0.74, 1.02, 1.57);

/// Elevation of the sun, degrees, at which cones have given way to rods.
const RODS: f64 = -12.0;

/// Brightness of a picture's light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Brightness {
    tint: Vec3,
    per_luminance: f32,
}

/// Illuminance of level ground by the sun and the sky it lights, lx, for a sun so many degrees above the horizon; by night what stars and airglow give.
pub fn illuminance(elevation: f64) -> f64 {
    let elevation = elevation.clamp(-18.0, 90.0);
    let holds = ILLUMINANCE.iter().find(|(lowest, _)| elevation >= *lowest);
    let (_, terms) = holds.unwrap_or(&ILLUMINANCE[ILLUMINANCE.len() - 1]);
    10.0_f64.powf(terms.iter().rev().fold(0.0, |sum, term| sum * (elevation / 90.0) + term))
}

impl Brightness {
    /// Computes brightness under `sun` where moon and lamps about give level ground `night` lx, ≥ 0.
    pub fn new(sun: Sun, night: f64) -> Self {
        let lux = illuminance(sun.elevation) + night;
        if sun.elevation >= DAY {
            return Self { tint: Vec3::ONE, per_luminance: (std::f64::consts::PI / lux) as f32 };
        }
        let shown = (lux / (illuminance(DAY) + night)).powf(SHOWN);
        let rods = (sun.elevation / RODS).clamp(0.0, 1.0) as f32;
        Self {
            tint: shown as f32 * Vec3::ONE.lerp(NIGHT, rods),
            per_luminance: (shown * std::f64::consts::PI / lux) as f32,
        }
    }

    /// Factor on all light that sun and sky give, by channel; 1 by day.
    pub fn tint(&self) -> Vec3 {
        self.tint
    }

    /// Whether it is 1.
    pub fn is_day(&self) -> bool {
        self.tint == Vec3::ONE
    }

    /// Linear light, 1 = display white, of a luminance of 1 cd/m².
    pub fn per_luminance(&self) -> f32 {
        self.per_luminance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop_base::colour::LUMINANCE;

    fn at(elevation: f64, night: f64) -> Brightness {
        Brightness::new(Sun { azimuth: 0.0, elevation }, night)
    }

    #[test]
    fn illuminance_is_that_of_tables_and_has_no_steps() {
        // Lux at sunset, at the ends of civil and nautical twilight, and of night (same source, table of typical values).
        for (elevation, lux) in
            [(90.0, 129_000.0), (0.0, 759.0), (-6.0, 3.4), (-12.0, 0.008), (-18.0, 0.00065)]
        {
            let found = illuminance(elevation);
            assert!((found / lux - 1.0).abs() < 0.05, "{elevation}: {found}");
        }
        for (lowest, _) in &ILLUMINANCE[..5] {
            let step = illuminance(lowest + 1.0e-6) / illuminance(lowest - 1.0e-6);
            assert!((step - 1.0).abs() < 0.03, "{lowest}: {step}");
        }
        assert!(illuminance(-60.0) == illuminance(-18.0));
    }

    #[test]
    fn pictures_darken_under_a_low_sun_and_ground_keeps_its_luminance() {
        assert!(at(10.0, 0.1).is_day() && at(60.0, 0.0).is_day() && !at(9.99, 0.1).is_day());
        let (sunset, by_day) = (at(0.0, 0.1).tint(), at(10.0, 0.1).tint());
        assert!((0.45..0.55).contains(&sunset.y) && sunset.x == sunset.z && by_day == Vec3::ONE, "{sunset}");
        let mut before = 1.0;
        for step in 1..400 {
            let elevation = 10.0 - 0.1 * f64::from(step);
            let now = at(elevation, 0.1);
            let green = now.tint().y;
            assert!(green <= before && green > 0.955 * before, "{elevation}: {green} after {before}");
            before = green;
            // White ground has the luminance E/π.
            let white =
                (illuminance(elevation) + 0.1) / std::f64::consts::PI * f64::from(now.per_luminance());
            let luminance = now.tint().dot(LUMINANCE);
            assert!((f64::from(luminance) / white - 1.0).abs() < 0.01, "{elevation}");
        }
        assert!((0.03..0.1).contains(&before), "{before}");
    }
}
