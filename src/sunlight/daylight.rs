//! Light of sun and sky on the ground.

use glam::Vec3;

use super::sun::seen_through;
use super::{Sun, illuminance};
use crate::simd::{Each, Floats, Simd};
use hedgehop_base::colour::LUMINANCE;

/// Share of the light on level ground that comes from the sky by day, at least.
const SKY_SHARE: f64 = 0.35;

/// Illuminance of a surface that faces the sun outside of the air, lx (Illuminating Engineering Society, *Lighting Handbook*), and what an air mass of 1
/// lets through of it; of others that to the power of mass^[`THINNING`] (Meinel and Meinel 1976, *Applied Solar Energy*, ch. 2).
const OUTSIDE: f64 = 133_100.0;
const CLEAR: f64 = 0.7;
const THINNING: f64 = 0.678;

/// Sine of the sun's elevation below which its disc sets: half a degree, its own width.
const SETTING: f64 = 0.0087;

/// Air mass from which sunlight reddens, as photographs show it: that of a sun 20° high. Where it is higher, they take its colour for white.
const WHITE: f64 = 3.0;

/// Light that the ground sends up, as a share of what falls on it: reflectance of meadows and rock.
const GROUND: f32 = 0.2;

/// Light of a sun and a uniform sky, of luminance 1 on level ground that sees all of both, whatever the sun's elevation: photographs already hold the light of their
/// hour. A low sun is red, and most light is the sky's; of a sun below the horizon all is. [`Brightness`](super::Brightness) tells how much that is.
#[derive(Debug, Clone, Copy)]
pub struct Daylight {
    /// Unit vector to the sun.
    to_sun: Vec3,
    /// Light of the sun on a surface that faces it, linear Rec. 709.
    beam: Vec3,
    /// Share of the light on level ground that comes from the sky.
    sky: f32,
}

impl Daylight {
    /// Computes the light of a day on which the sun stands there.
    pub fn new(sun: Sun) -> Self {
        let sine = sun.elevation.to_radians().sin().max(0.0);
        let mass = sun.air_mass();
        let direct = OUTSIDE * CLEAR.powf(mass.powf(THINNING)) / illuminance(sun.elevation);
        let direct = direct.min((1.0 - SKY_SHARE) / sine.max(f64::MIN_POSITIVE)) * (sine / SETTING).min(1.0);
        let sky = (1.0 - direct * sine) as f32;
        let colour = seen_through(mass - WHITE);
        Self { to_sun: sun.direction(), beam: colour * (direct as f32 / colour.dot(LUMINANCE)), sky }
    }

    /// Returns how much sun there is on the ground against a high one's, 0…1: less from some ten degrees of elevation down, none on the horizon.
    pub fn strength(&self) -> f32 {
        (1.0 - self.sky) / (1.0 - SKY_SHARE as f32)
    }

    /// Light on a surface of unit `normal` that sees a share `sun` (0…1) of the sun's disc: Lambert's law for the sun, and the sky, of which
    /// a slope sees less (half of it on a wall).
    #[inline]
    pub fn on(&self, normal: Vec3, sun: f32) -> Vec3 {
        let direct = normal.dot(self.to_sun).max(0.0);
        Vec3::splat(self.sky * (0.5 + 0.5 * normal.z)) + self.beam * (direct * sun)
    }

    /// The same on a body, which level ground below lights, too: what looks down is not black.
    #[inline]
    pub fn on_body(&self, normal: Vec3, sun: f32) -> Vec3 {
        self.on(normal, sun) + Vec3::splat(GROUND * (0.5 - 0.5 * normal.z))
    }

    /// Light on sixteen surfaces that rise eastward and northward by so much per unit: what falls on all colours alike, and what is multiplied by [`Self::beam`].
    #[inline(always)]
    pub fn on_slopes<V: Simd>(&self, simd: V, [eastward, northward]: [V::F; 2], sun: V::F) -> [V::F; 2] {
        let one = simd.splat(1.0);
        let upward = one / (eastward * eastward + northward * northward + one).sqrt();
        let [east, north, up] = self.to_sun.to_array().each(|part| simd.splat(part));
        // Of the normal's upward part, like all that is multiplied by it.
        let direct = (up - eastward * east - northward * north).max(simd.splat(0.0));
        let sky = simd.splat(0.5 * self.sky);
        [sky + upward * sky, upward * direct * sun]
    }

    /// Light of the sun on a surface that faces it, linear Rec. 709.
    pub fn beam(&self) -> Vec3 {
        self.beam
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn daylight(elevation: f64) -> Daylight {
        Daylight::new(Sun { azimuth: 120.0, elevation })
    }

    #[test]
    fn light_is_that_of_the_sky_as_the_sun_goes_down() {
        let shadowed = |elevation| daylight(elevation).on(Vec3::Z, 0.0);
        for elevation in [10.0, 11.0, 40.0, 90.0] {
            assert!((shadowed(elevation) - 0.35).abs().max_element() < 1.0e-6);
            assert!((daylight(elevation).strength() - 1.0).abs() < 1.0e-6);
        }
        // By hand: of 4,538 lx the sun gives 2,048 lx 5° above the horizon, and of 1,578 lx 184 lx at 1.5°.
        for (elevation, sky) in [(5.0, 0.549), (1.5, 0.883)] {
            let found = shadowed(elevation);
            assert!((found - sky).abs().max_element() < 0.005, "{elevation}: {found}");
        }
        assert_eq!(daylight(-0.1).strength(), 0.0);
        assert_eq!(daylight(-0.1).beam(), Vec3::ZERO);
    }

    #[test]
    fn nothing_jumps_as_the_sun_sets() {
        // On level ground or on a wall that faces the sun, which has five times the light of level ground at most.
        let wall = Sun { azimuth: 120.0, elevation: 0.0 }.direction();
        let mut brightest = 0.0_f32;
        for step in 0_u8..130 {
            let [own, next] = [0.1, 0.0].map(|more| daylight(11.5 - 0.1 * f64::from(step) + more));
            let luminance = |daylight: &Daylight, normal| daylight.on(normal, 1.0).dot(LUMINANCE);
            for (normal, most) in [(Vec3::Z, 1.0e-5), (wall, 0.8)] {
                let [own, next] = [&own, &next].map(|daylight| luminance(daylight, normal));
                assert!((own - next).abs() < most, "{step}: {own} {next}");
                brightest = brightest.max(next);
            }
            assert!((own.on(Vec3::Z, 0.0) - next.on(Vec3::Z, 0.0)).abs().max_element() < 0.02);
        }
        assert!((5.0..6.0).contains(&brightest), "{brightest}");
    }

    #[test]
    fn a_low_sun_is_warm_and_a_high_one_leaves_photographs_as_they_are() {
        for elevation in [20.0, 40.0, 90.0] {
            assert!((daylight(elevation).on(Vec3::Z, 1.0) - 1.0).abs().max_element() < 0.005);
        }
        let low = daylight(3.0).on(Vec3::Z, 1.0);
        assert!(low.x > 1.1 && low.z < 0.85 && (low.dot(LUMINANCE) - 1.0).abs() < 1.0e-5, "{low}");
    }

    #[test]
    fn what_looks_down_has_light_from_the_ground() {
        let light = |normal| daylight(40.0).on_body(normal, 0.0);
        assert_eq!((light(Vec3::NEG_Z), light(Vec3::Z)), (Vec3::splat(0.2), daylight(40.0).on(Vec3::Z, 0.0)));
    }
}
