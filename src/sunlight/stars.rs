//! The stars that eyes see, and how they stand over a place.

use std::sync::OnceLock;

use glam::{DVec3, Vec3};

use hedgehop_base::colour::LUMINANCE;

/// The bright stars of the Extended Hipparcos Compilation (Anderson and Francis 2012, *Astronomy Letters* 38, 331–346), see `data/README.md`.
const CATALOGUE: &str = include_str!("../../data/stars.csv");

/// Illuminance of a star of magnitude 0 above the air, lx (Allen 1973, *Astrophysical Quantities*, § 10).
const MAGNITUDE_0: f64 = 2.54e-6;

/// Magnitudes that a zenith's depth of clear air takes, and of how many such depths there are most, towards the horizon.
const PER_AIR_MASS: f64 = 0.2;
const MOST_AIR: f64 = 38.0;

/// Wavelengths of red, green and blue, micrometres, and the second radiation constant, micrometres · kelvin.
const WAVELENGTHS: [f64; 3] = [0.61, 0.55, 0.465];
const RADIATION: f64 = 14_387.8;

/// Stand of the sphere of the stars over a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Firmament {
    /// Hour angle of the equinox: right ascension of what culminates, degrees.
    pub sidereal: f64,
    /// Latitude of the place, degrees north.
    pub latitude: f64,
    /// Azimuth of true north from grid north, clockwise, degrees.
    pub convergence: f64,
}

impl Default for Firmament {
    /// A winter's evening in the middle north.
    fn default() -> Self {
        Self { sidereal: 80.0, latitude: 47.0, convergence: 0.0 }
    }
}

/// A star.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Star {
    /// Towards it: x to the equinox, z to the north pole of J2000; of unit length.
    pub direction: DVec3,
    /// Illuminance that it gives above the air, lx.
    pub lux: f64,
    /// Linear Rec. 709, of luminance 1.
    pub colour: Vec3,
}

/// All stars, the brightest first.
pub fn stars() -> &'static [Star] {
    static STARS: OnceLock<Vec<Star>> = OnceLock::new();
    STARS.get_or_init(|| CATALOGUE.lines().skip(1).filter_map(Star::read).collect())
}

impl Star {
    /// Reads right ascension and declination (degrees), visual magnitude and B − V.
    fn read(line: &str) -> Option<Self> {
        let mut numbers = line.split(',').map(|field| field.parse::<f64>().ok());
        let mut next = || numbers.next().flatten();
        let (right_ascension, declination, magnitude, colour) = (next()?, next()?, next()?, next()?);
        let (sin, cos) = declination.to_radians().sin_cos();
        let (east, equinox) = right_ascension.to_radians().sin_cos();
        Some(Self {
            direction: DVec3::new(cos * equinox, cos * east, sin),
            lux: MAGNITUDE_0 * 10.0_f64.powf(-0.4 * magnitude),
            colour: black_body(temperature(colour)),
        })
    }
}

impl Firmament {
    /// Unit vector to a direction of the catalogue, world axes (J2000: precession since is less than half a degree).
    pub fn world(&self, direction: DVec3) -> DVec3 {
        // Turned about the pole: x to the meridian below the equator's highest point, y eastward.
        let (sin, cos) = self.sidereal.to_radians().sin_cos();
        let south = direction.x * cos + direction.y * sin;
        let east = direction.y * cos - direction.x * sin;
        let (sin, cos) = self.latitude.to_radians().sin_cos();
        let (north, up) = (direction.z * cos - south * sin, direction.z * sin + south * cos);
        let (sin, cos) = self.convergence.to_radians().sin_cos();
        DVec3::new(east * cos + north * sin, north * cos - east * sin, up)
    }
}

/// Share of a star's light that comes through clear air at a sine of elevation.
pub fn starlight_through(up: f64) -> f64 {
    let masses = (1.0 / up.max(1.0 / MOST_AIR)).min(MOST_AIR);
    10.0_f64.powf(-0.4 * PER_AIR_MASS * masses)
}

/// Temperature of a star, kelvin (Ballesteros 2012, *Europhysics Letters* 97, 34008, eq. 14).
fn temperature(colour: f64) -> f64 {
    4600.0 * (1.0 / (0.92 * colour + 1.7) + 1.0 / (0.92 * colour + 0.62))
}

/// Colour of a black body, of luminance 1 (Planck's law at three wavelengths).
fn black_body(kelvin: f64) -> Vec3 {
    let radiance = WAVELENGTHS.map(|length| length.powi(-5) / ((RADIATION / (length * kelvin)).exp_m1()));
    // Sunlight is white.
    let white = WAVELENGTHS.map(|length| length.powi(-5) / ((RADIATION / (length * 5800.0)).exp_m1()));
    let colour = Vec3::from_array(std::array::from_fn(|channel| (radiance[channel] / white[channel]) as f32));
    colour / colour.dot(LUMINANCE)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use time::macros::datetime;

    use super::*;
    use crate::sunlight::SunSetting;
    use hedgehop_geo::Crs;

    #[test]
    fn the_catalogue_is_read_whole() {
        assert_eq!(stars().len(), CATALOGUE.lines().count() - 1);
        assert!(stars().len() > 2000);
        assert!(stars().iter().all(|star| (star.direction.length() - 1.0).abs() < 1e-9));
        // Sirius is 3.8 times as bright as a star of magnitude 0, and bluer than Betelgeuse.
        let sirius = &stars()[0];
        assert!((sirius.lux / MAGNITUDE_0 - 3.77).abs() < 0.02 && sirius.colour.z > sirius.colour.x);
        assert!(stars()[1..20].iter().any(|star| star.colour.x > 1.5 * star.colour.z));
    }

    #[test]
    fn stars_stand_where_almanacs_have_them() {
        // Meeus 1998, Astronomical Algorithms, example 12.a: mean sidereal time of Greenwich at 1987 April 10, 0h UT: 13h 10m 46.3668s.
        let setting = SunSetting::Time(datetime!(1987-04-10 00:00 UTC));
        let firmament = setting.over(&Crs::wgs84(), DVec2::new(0.0, 51.5)).unwrap().firmament;
        assert!((firmament.sidereal - 197.693_195).abs() < 1e-4, "{firmament:?}");
        // The pole is as high as the latitude, in the north; what has the sidereal time for right ascension stands in the south.
        let pole = firmament.world(DVec3::Z);
        assert!((pole.z - 51.5_f64.to_radians().sin()).abs() < 1e-12 && pole.y > 0.0 && pole.x.abs() < 1e-12);
        let (sin, cos) = firmament.sidereal.to_radians().sin_cos();
        let culminates = firmament.world(DVec3::new(cos, sin, 0.0));
        assert!(culminates.x.abs() < 1e-12 && culminates.y < 0.0);
        // Six hours earlier it rose in the east.
        let before = Firmament { sidereal: firmament.sidereal - 90.0, ..firmament };
        let rises = before.world(DVec3::new(cos, sin, 0.0));
        assert!((rises.x - 1.0).abs() < 1e-9 && rises.z.abs() < 1e-9, "{rises}");
    }

    #[test]
    fn the_sun_stands_among_the_stars_where_it_should() {
        // At the March equinox the sun is at right ascension 0, declination 0 (2026-03-20 14:46 UTC).
        let place = DVec2::new(10.0, 47.0);
        let setting = SunSetting::Time(datetime!(2026-03-20 14:46 UTC));
        let sky = setting.over(&Crs::wgs84(), place).unwrap();
        let equinox = sky.firmament.world(DVec3::X);
        // 26 years of precession, and refraction.
        assert!(sky.sun.direction().as_dvec3().angle_between(equinox).to_degrees() < 0.5);
    }
}
