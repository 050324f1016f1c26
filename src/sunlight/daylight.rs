//! How bright ground is under sun and sky.

use glam::Vec3;

use super::Sun;
use crate::simd::{Floats, Simd};

/// Share of the light on level ground that comes from the sky by day, at least.
const SKY_SHARE: f32 = 0.35;

/// Light of the sky on level ground as a share of the sun's on a surface that faces it (a clear sky; Honsberg and Bowden, *Photovoltaics*, "Air mass"): with a low
/// sun nearly all light on the ground is the sky's.
const SKY_PER_SUN: f32 = 0.1;

/// Sine of the sun's elevation below which the light on a wall no longer grows against that on level ground: half a degree, the sun's own
/// width.
const LOWEST: f32 = 0.0087;

/// Light of a sun and a uniform sky, 1 on level ground that sees all of both, whatever the sun's elevation: photographs already hold the light of their
/// hour. Of a sun below the horizon all light is the sky's; [`Brightness`](super::Brightness) tells how much that is.
#[derive(Debug, Clone, Copy)]
pub struct Daylight {
    /// Direction to the sun; its third component is no less than [`LOWEST`].
    to_sun: Vec3,
    /// Share of the light on level ground that comes from the sky.
    sky: f32,
}

impl Daylight {
    /// That of a day on which the sun stands there.
    pub fn new(sun: Sun) -> Self {
        let to_sun = sun.direction();
        let sine = to_sun.z.max(0.0);
        let sky = (SKY_PER_SUN / (SKY_PER_SUN + sine)).max(SKY_SHARE);
        Self { to_sun: to_sun.with_z(to_sun.z.max(LOWEST)), sky }
    }

    /// How much sun there is on the ground against a high one's, 0…1: less from some ten degrees of elevation down, none on the horizon.
    pub fn strength(&self) -> f32 {
        (1.0 - self.sky) / (1.0 - SKY_SHARE)
    }

    /// Light on a surface of unit `normal` that sees a share `sun` (0…1) of the sun's disc: Lambert's law for the sun, and the sky, of which
    /// a slope sees less (half of it on a wall).
    #[inline]
    pub fn on(&self, normal: Vec3, sun: f32) -> f32 {
        let direct = normal.dot(self.to_sun).max(0.0) / self.to_sun.z;
        let sky = 0.5 + 0.5 * normal.z;
        self.sky * sky + (1.0 - self.sky) * direct * sun
    }

    /// The same for sixteen surfaces that rise eastward and northward by so much per unit.
    #[inline(always)]
    pub fn on_slopes<V: Simd>(&self, simd: V, [eastward, northward]: [V::F; 2], sun: V::F) -> V::F {
        let one = simd.splat(1.0);
        let upward = one / (eastward * eastward + northward * northward + one).sqrt();
        let [east, north] = [self.to_sun.x, self.to_sun.y].map(|share| simd.splat(share / self.to_sun.z));
        // Of the normal's upward part, like all that is multiplied by it.
        let direct = (one - eastward * east - northward * north).max(simd.splat(0.0));
        let sky = simd.splat(0.5 * self.sky);
        sky + upward * (sky + direct * simd.splat(1.0 - self.sky) * sun)
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
        for elevation in [11.0, 40.0, 90.0] {
            assert_eq!(shadowed(elevation), SKY_SHARE);
            assert_eq!(daylight(elevation).strength(), 1.0);
        }
        assert!((shadowed(5.0) - 0.534).abs() < 0.001, "{}", shadowed(5.0));
        // Nothing jumps, on level ground or on a wall that faces the sun, which has nine times the light of level ground until the disc sets.
        let wall = Sun { azimuth: 120.0, elevation: 0.0 }.direction();
        for step in 0_u8..130 {
            let [own, next] = [0.1, 0.0].map(|more| daylight(11.5 - 0.1 * f64::from(step) + more));
            for (normal, most) in [(Vec3::Z, 1.0e-6), (wall, 2.0)] {
                let [own, next] = [own, next].map(|daylight| daylight.on(normal, 1.0));
                assert!((own - next).abs() < most, "{step}: {own} {next}");
            }
            assert!((own.on(Vec3::Z, 0.0) - next.on(Vec3::Z, 0.0)).abs() < 0.02);
        }
        assert_eq!(daylight(-0.1).strength(), 0.0);
    }
}
