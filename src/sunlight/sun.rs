//! Position of the sun.

use glam::Vec3;

use super::Firmament;

/// Direction to the sun.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Clockwise from grid north, degrees.
    pub azimuth: f64,
    /// Above the horizon, degrees, -90…90; below 0 it is night.
    pub elevation: f64,
}

/// Optical depth of clear air to the zenith at 610, 550 and 465 nm (Rayleigh; Bucholtz 1995, *Applied Optics* 34, 2765–2773).
const RAYLEIGH: Vec3 = Vec3::new(0.064, 0.098, 0.194);

/// Air masses beyond which sunlight does not redden any more: haze itself hides a lower sun.
const MOST_AIR: f64 = 12.0;

/// Linear Rec. 709 colour of white light that has come through so many air masses, < 0 for none, of which the largest part is 1.
pub fn seen_through(masses: f64) -> Vec3 {
    let seen = (-RAYLEIGH * masses.clamp(0.0, MOST_AIR) as f32).exp();
    seen / seen.max_element()
}

impl Default for Sun {
    /// A mid-morning sun in the south-east.
    fn default() -> Self {
        Self { azimuth: 135.0, elevation: 40.0 }
    }
}

impl Sun {
    /// Whether it stands above the horizon.
    pub fn is_up(&self) -> bool {
        self.elevation > 0.0
    }

    /// Air that its light comes through, as a multiple of that above the place; on the horizon and below it 38 (Kasten and Young 1989, *Applied Optics* 28,
    /// 4735–4738).
    pub fn air_mass(&self) -> f64 {
        let degrees = self.elevation.clamp(0.0, 90.0);
        1.0 / (degrees.to_radians().sin() + 0.505_72 * (degrees + 6.079_95).powf(-1.6364))
    }

    /// Unit vector to the sun, world axes.
    pub fn direction(&self) -> Vec3 {
        let (sin_azimuth, cos_azimuth) = self.azimuth.to_radians().sin_cos();
        let (sin_elevation, cos_elevation) = self.elevation.to_radians().sin_cos();
        Vec3::new(
            (sin_azimuth * cos_elevation) as f32,
            (cos_azimuth * cos_elevation) as f32,
            sin_elevation as f32,
        )
    }
}

/// Sun, stars and lamps over a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sky {
    /// The sun.
    pub sun: Sun,
    /// The stars.
    pub firmament: Firmament,
}

/// Light besides that of the sun.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Night {
    /// Illuminance of level ground by moon, and by the lamps of the land about, lx, 0…1000.
    pub lux: f64,
    /// Stand of the stars; `None`: there are none.
    pub stars: Option<Firmament>,
}

impl Default for Night {
    /// Some moonlight, and no stars.
    fn default() -> Self {
        Self { lux: 0.1, stars: None }
    }
}

impl Night {
    /// Brightest that a night may be, lx: the end of a day.
    pub const BRIGHTEST: f64 = 1000.0;

    /// Whether its values lie within their ranges.
    pub fn is_sound(&self) -> bool {
        let of_stars = |stars: &Firmament| [stars.sidereal, stars.latitude, stars.convergence];
        (0.0..=Self::BRIGHTEST).contains(&self.lux)
            && self.stars.as_ref().is_none_or(|stars| of_stars(stars).into_iter().all(f64::is_finite))
    }
}
