//! Haze and sky of sixteen pixels: the twin of [`Atmosphere`]'s closed forms.

use super::super::Atmosphere;
use super::super::atmosphere::{HORIZON, SCALE_HEIGHT, SKY_DEPTH, SKY_ONSET, ZENITH};
use crate::sensor::radiance::UNITS;
use crate::simd::math::exp_neg;
use crate::simd::{Floats, Mask, Simd};

/// Rise in scale heights below which the terms of [`MEAN_DENSITY`] are exact to 10⁻⁵: nearly always.
const SMALL_RISE: f32 = 1.0;

/// (1 − e^−x)/x by Taylor, from the highest power down.
const MEAN_DENSITY: [f32; 8] =
    [-1.0 / 40320.0, 1.0 / 5040.0, -1.0 / 720.0, 1.0 / 120.0, -1.0 / 24.0, 1.0 / 6.0, -0.5, 1.0];

/// The air around an eye.
#[derive(Debug, Clone, Copy)]
pub struct Air {
    extinction: f32,
    /// Haze beyond a clear day's, above the eye, times scale height: its optical depth to the zenith.
    excess: f32,
    /// Height of the eye above the haze's base, scale heights, and the density of haze there.
    start: f32,
    density: f32,
}

impl Air {
    /// Seen from height `eye`, metres above the datum.
    pub fn new(atmosphere: &Atmosphere, eye: f64) -> Self {
        let start = atmosphere.scale_heights(eye);
        let density = (-start).exp();
        let excess = atmosphere.excess() * SCALE_HEIGHT * density;
        Self { extinction: atmosphere.extinction(), excess, start, density }
    }

    /// Share of light that haze lets through from `range` metres, where `up` is the sine of the elevation.
    #[inline(always)]
    fn through<V: Simd>(&self, simd: V, range: V::F, up: V::F) -> V::F {
        // The ray's rise in scale heights; haze is as thick as at its base below that.
        let rise = (up * range * simd.splat(1.0 / SCALE_HEIGHT)).max(simd.splat(-self.start));
        // Mean density: (e^−start − e^−(start + rise)) / rise; the quotient loses its digits where terms do.
        let mut mean = simd.splat(MEAN_DENSITY[0]);
        for coefficient in &MEAN_DENSITY[1..] {
            mean = mean.mul_add(rise, simd.splat(*coefficient));
        }
        mean = mean * simd.splat(self.density);
        let small = rise.abs().lt(simd.splat(SMALL_RISE));
        if !small.all() {
            let end = exp_neg(simd, rise + simd.splat(self.start));
            mean = mean.select(small, (simd.splat(self.density) - end) * rise.recip());
        }
        exp_neg(simd, simd.splat(self.extinction) * range * mean)
    }

    /// Radiance that reaches the eye from ground of `radiance`, in [`UNITS`].
    #[inline(always)]
    pub fn haze<V: Simd>(&self, simd: V, radiance: [V::F; 3], range: V::F, up: V::F) -> [V::F; 3] {
        let through = self.through(simd, range, up);
        let mut seen = radiance;
        for ((seen, horizon), unit) in seen.iter_mut().zip(HORIZON.to_array()).zip(UNITS) {
            let more = seen.mul_add(simd.splat(unit), simd.splat(-horizon));
            *seen = more.mul_add(through, simd.splat(horizon));
        }
        seen
    }

    /// The sky's radiance in a direction of which `up` is the sine of the elevation.
    #[inline(always)]
    pub fn sky<V: Simd>(&self, simd: V, up: V::F) -> [V::F; 3] {
        let up = up.max(simd.splat(1.0e-6));
        let blue = up * up * simd.splat(SKY_DEPTH) * (up + simd.splat(SKY_ONSET)).recip();
        let mut clear = simd.splat(1.0) - exp_neg(simd, blue);
        if self.excess > 0.0 {
            clear = clear * exp_neg(simd, simd.splat(self.excess) * up.recip());
        }
        let mut seen = [clear; 3];
        for (seen, (horizon, zenith)) in
            seen.iter_mut().zip(HORIZON.to_array().into_iter().zip(ZENITH.to_array()))
        {
            *seen = clear.mul_add(simd.splat(zenith - horizon), simd.splat(horizon));
        }
        seen
    }
}
