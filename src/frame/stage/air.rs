//! Haze and sky of sixteen pixels: the twin of [`Atmosphere`]'s closed forms.

use super::super::Atmosphere;
use super::super::atmosphere::{HORIZON, SCALE_HEIGHT, SKY_DEPTH, SKY_ONSET, ZENITH};
use crate::sensor::radiance::UNITS;
use crate::simd::math::exp_neg;
use crate::simd::{Floats, Simd};

/// Terms of the polynomial for haze, and rises in scale heights up to which it serves: exact to 10⁻⁴ over three of them.
const TERMS: usize = 6;
const WIDEST: f64 = 3.0;

/// Rise, scale heights, below which the mean is nearly linear.
const LEVEL: f32 = 0.02;

/// The air around an eye.
#[derive(Debug, Clone, Copy)]
pub struct Air {
    /// Haze beyond a clear day's, above the eye, times scale height: its optical depth to the zenith.
    excess: f32,
    /// Height of the eye above the haze's base, scale heights; haze is as thick as there below it.
    start: f32,
    /// Extinction where haze is thickest, 1/metres, and the share of it at the eye.
    extinction: f32,
    density: f32,
    /// Polynomial of mean extinction on the way up or down to what is to be seen, 1/metres, from the highest power of
    /// the rise down, which counts from `middle` in scale heights; `None`: rises are too different for one.
    series: Option<[f32; TERMS]>,
    middle: f32,
}

impl Air {
    /// Seen from height `eye` ground that is not higher than `ceiling`, metres above the datum.
    pub fn new(atmosphere: &Atmosphere, eye: f64, ceiling: f64) -> Self {
        let start = atmosphere.scale_heights(eye);
        let density = (-start).exp();
        let extinction = atmosphere.extinction();
        let low = -f64::from(start);
        let width = (ceiling - eye).max(1.0) / f64::from(SCALE_HEIGHT) - low;
        let middle = low + 0.5 * width;
        let mean = |rise: f64| if rise.abs() < 1.0e-6 { 1.0 } else { -(-rise).exp_m1() / rise };
        let at_eye = f64::from(extinction * density);
        let series = (width <= WIDEST)
            .then(|| polynomial(middle, 0.5 * width, mean).map(|term| (term * at_eye) as f32));
        let excess = atmosphere.excess() * SCALE_HEIGHT * density;
        Self { excess, start, extinction, density, series, middle: middle as f32 }
    }

    /// Share of light that haze lets through from `range` metres away and `rise` metres above the eye.
    #[inline(always)]
    fn through<V: Simd>(&self, simd: V, range: V::F, rise: V::F) -> V::F {
        let rise = (rise * simd.splat(1.0 / SCALE_HEIGHT)).max(simd.splat(-self.start));
        let mean = if let Some(series) = &self.series {
            let rise = rise - simd.splat(self.middle);
            let mut mean = simd.splat(series[0]);
            for term in &series[1..] {
                mean = mean.mul_add(rise, simd.splat(*term));
            }
            mean
        } else {
            // (e^−start − e^−(start + rise)) / rise, which loses its digits for small rises: for them the first two terms.
            let density = simd.splat(self.density);
            let end = exp_neg(simd, rise + simd.splat(self.start));
            let level = rise.abs().lt(simd.splat(LEVEL));
            let first = rise.neg_mul_add(simd.splat(0.5), simd.splat(1.0)) * density;
            first.select(level, (density - end) * rise.recip()) * simd.splat(self.extinction)
        };
        exp_neg(simd, range * mean)
    }

    /// Radiance that reaches the eye from ground of `radiance`, in [`UNITS`], `range` metres away and `rise` metres above the
    /// eye along the ray.
    #[inline(always)]
    pub fn haze<V: Simd>(&self, simd: V, radiance: [V::F; 3], range: V::F, rise: V::F) -> [V::F; 3] {
        let through = self.through(simd, range, rise);
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

/// Polynomial through `value` at Chebyshev's points of `middle − half` to `middle + half`, of what lies beyond `middle`, from
/// the highest power down.
fn polynomial(middle: f64, half: f64, value: impl Fn(f64) -> f64) -> [f64; TERMS] {
    let points: [f64; TERMS] = std::array::from_fn(|point| {
        half * ((point as f64 + 0.5) / TERMS as f64 * std::f64::consts::PI).cos()
    });
    // Newton's divided differences, then his products multiplied out.
    let mut differences = points.map(|point| value(middle + point));
    for order in 1..TERMS {
        for point in (order..TERMS).rev() {
            differences[point] =
                (differences[point] - differences[point - 1]) / (points[point] - points[point - order]);
        }
    }
    let mut terms = [0.0; TERMS];
    for (difference, point) in differences.into_iter().zip(points).rev() {
        let before = terms;
        for power in 0..TERMS {
            let lower = before.get(power + 1).copied().unwrap_or(difference);
            terms[power] = lower - before[power] * point;
        }
    }
    terms
}
