//! How bright ground is under sun and sky.

use glam::Vec3;

use super::Sun;
use crate::simd::{Floats, Simd};

/// Share of the light on level ground that comes from the sky by day.
const SKY_SHARE: f32 = 0.35;

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
        Self { to_sun: to_sun.with_z(to_sun.z.max(LOWEST)), sky: if sun.is_up() { SKY_SHARE } else { 1.0 } }
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
