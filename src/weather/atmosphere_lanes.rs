//! Haze, fog and sky in sixteen lanes at once: the twin of [`Atmosphere`]'s closed forms, which are of one ray.

use crate::pixels::UNITS;
use crate::raymarch::scan::PlaneGroup;
use crate::simd::math::exp_neg;
use crate::simd::{Floats, Simd, Sixteen};
use crate::weather::Atmosphere;
use crate::weather::atmosphere::{HAZE_COLOUR, HORIZON, SCALE_HEIGHT, SKY_DEPTH, SKY_ONSET, ZENITH};
use crate::weather::fog::{FogLayer, GAUSS, SMALL_FOG_RISE};
use crate::weather::glow::{Glow, PHASE};

/// Terms of the polynomial for haze, and rises in scale heights up to which it serves: exact to 10⁻⁴ over three of them.
const TERMS: usize = 6;
const WIDEST: f64 = 3.0;

/// Rise, scale heights, below which the mean extinction of haze is nearly linear.
const SMALL_HAZE_RISE: f32 = 0.02;

/// [`Atmosphere`] as one eye sees it, for sixteen lanes at once.
#[derive(Debug, Clone, Copy)]
pub struct AtmosphereLanes {
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
    /// Fog and glow; `None`: neither, as in most air.
    fog_and_glow: Option<FogAndGlow>,
}

/// Fog and glow of the air, of which one may be missing.
#[derive(Debug, Clone, Copy)]
struct FogAndGlow {
    /// Glow about the sun.
    glow: Option<Glow>,
    /// Cosine of each lane's azimuth from that of the sun, times that of the sun's elevation.
    sunward: Sixteen,
    /// Fog below a height.
    fog: Option<EyeFog>,
}

/// Fog about an eye.
#[derive(Debug, Clone, Copy)]
struct EyeFog {
    layer: FogLayer,
    /// Depth of the eye below all that is clear, metres, and the fog above it, metres of full density.
    below: f32,
    column: f32,
    /// But for its glow.
    colour: [f32; 3],
}

/// Heights of one eye between which its veil changes so fast that light from one to the other is not linear: those of fog's upper edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteepHeights {
    /// The lowest and the highest, metres above the eye.
    pub bounds: [f32; 2],
    /// Longest step of height over which light still is linear, metres.
    pub step: f32,
}

/// Depth below the top of fog, in depths of its upper edge, from which on nothing is seen of what is farther down.
const EDGE_DEPTH: f32 = 2.0;

/// Longest step of height within it over which light is linear, in depths of the upper edge.
const EDGE_STEP: f32 = 0.125;

/// Least |sine| of an elevation by which is divided.
const LEAST_SINE: f32 = 1.0e-6;

impl AtmosphereLanes {
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

        let fog = atmosphere.fog().map(|layer| EyeFog {
            layer: *layer,
            below: layer.below(eye),
            column: layer.column(layer.below(eye)),
            colour: atmosphere.fog_colour(layer, eye).to_array(),
        });
        let glow = atmosphere.glow().copied();
        let has_either = fog.is_some() || glow.is_some();
        let fog_and_glow = has_either.then_some(FogAndGlow { glow, sunward: Sixteen::default(), fog });

        Self { excess, start, extinction, density, series, middle: middle as f32, fog_and_glow }
    }

    /// Whether there is fog or glow: kernels have a loop of their own for them, so that air with nothing but haze stays as fast as it is.
    pub fn has_fog_or_glow(&self) -> bool {
        self.fog_and_glow.is_some()
    }

    /// Returns the heights at which the veil is not linear; `None`: it is at all of them.
    pub fn steep_heights(&self) -> Option<SteepHeights> {
        let fog = self.fog_and_glow?.fog?;
        let soft = fog.layer.soft;
        Some(SteepHeights { bounds: [fog.below - EDGE_DEPTH * soft, fog.below], step: EDGE_STEP * soft })
    }

    /// Turns to where a group of planes looks, which only a glow needs to know.
    pub fn face(&mut self, group: &PlaneGroup) {
        if let Some(FogAndGlow { glow: Some(glow), sunward, .. }) = &mut self.fog_and_glow {
            let sun = [glow.to_sun.x, glow.to_sun.y];
            for (lane, sunward) in sunward.0.iter_mut().enumerate() {
                let minor = group.minor[lane];
                let ahead = group.forward as f32;
                let along = ahead * sun[group.major] + minor * sun[1 - group.major];
                *sunward = along / minor.hypot(ahead);
            }
        }
    }

    /// Turns each lane to a direction of which the parts eastward and northward are given, and need not be of unit length.
    #[inline(always)]
    pub fn turn<V: Simd>(&mut self, simd: V, [east, north]: [V::F; 2]) {
        if let Some(FogAndGlow { glow: Some(glow), sunward, .. }) = &mut self.fog_and_glow {
            let least = simd.splat(1.0e-12);
            let along = east * simd.splat(glow.to_sun.x) + north * simd.splat(glow.to_sun.y);
            (along * (east * east + north * north + least).rsqrt()).store(&mut sunward.0);
        }
    }

    /// Share of light that haze lets through from `range` metres away and `rise` metres above the eye.
    #[inline(always)]
    fn through<V: Simd>(&self, simd: V, range: V::F, rise: V::F) -> V::F {
        exp_neg(simd, self.depth(simd, range, rise))
    }

    /// Optical depth of haze, ≥ 0.
    #[inline(always)]
    fn depth<V: Simd>(&self, simd: V, range: V::F, rise: V::F) -> V::F {
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
            let is_small = rise.abs().lt(simd.splat(SMALL_HAZE_RISE));
            let first = rise.neg_mul_add(simd.splat(0.5), simd.splat(1.0)) * density;
            first.select(is_small, (density - end) * rise.recip()) * simd.splat(self.extinction)
        };
        range * mean
    }

    /// Radiance that reaches the eye from ground of `radiance`, in [`UNITS`], `range` metres away and `rise` metres above the
    /// eye along the ray.
    #[inline(always)]
    pub fn haze<V: Simd, const FOG_OR_GLOW: bool>(
        &self,
        simd: V,
        radiance: [V::F; 3],
        range: V::F,
        rise: V::F,
    ) -> [V::F; 3] {
        if FOG_OR_GLOW && let Some(fog_and_glow) = &self.fog_and_glow {
            let mut light = radiance;
            for (channel, light) in light.iter_mut().enumerate() {
                *light = *light * simd.splat(UNITS[channel]);
            }
            return self.over_with(simd, fog_and_glow, light, range, rise);
        }
        let through = self.through(simd, range, rise);
        let mut seen = radiance;
        for (channel, seen) in seen.iter_mut().enumerate() {
            let haze = HAZE_COLOUR.to_array()[channel];
            let more = seen.mul_add(simd.splat(UNITS[channel]), simd.splat(-haze));
            *seen = more.mul_add(through, simd.splat(haze));
        }
        seen
    }

    /// Share that ground has in light that is `seen` of it through the air, 0…1: of green, which is near the mean of all.
    #[inline(always)]
    pub fn ground_share<V: Simd, const FOG_OR_GLOW: bool>(
        &self,
        simd: V,
        seen: [V::F; 3],
        range: V::F,
        rise: V::F,
    ) -> V::F {
        const GREEN: usize = 1;
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let air = if FOG_OR_GLOW {
            self.haze::<V, true>(simd, [zero; 3], range, rise)[GREEN]
        } else {
            (one - self.through(simd, range, rise)) * simd.splat(HAZE_COLOUR.y)
        };
        let light = seen[GREEN].max(simd.splat(f32::MIN_POSITIVE));
        (one - air * light.recip()).max(zero).min(one)
    }

    /// The sky's radiance in a direction of which `up` is the sine of the elevation.
    #[inline(always)]
    pub fn sky<V: Simd, const FOG_OR_GLOW: bool>(&self, simd: V, up: V::F) -> [V::F; 3] {
        let toward = up;
        let up = up.max(simd.splat(LEAST_SINE));
        let blue = up * up * simd.splat(SKY_DEPTH) * (up + simd.splat(SKY_ONSET)).recip();
        let mut clear = simd.splat(1.0) - exp_neg(simd, blue);
        if self.excess > 0.0 {
            clear = clear * exp_neg(simd, simd.splat(self.excess) * up.recip());
        }
        if FOG_OR_GLOW && let Some(fog_and_glow) = &self.fog_and_glow {
            return self.sky_with(simd, fog_and_glow, clear, toward);
        }
        let mut seen = [clear; 3];
        for (channel, seen) in seen.iter_mut().enumerate() {
            let (horizon, zenith) = (HORIZON.to_array()[channel], ZENITH.to_array()[channel]);
            *seen = clear.mul_add(simd.splat(zenith - horizon), simd.splat(horizon));
        }
        seen
    }
}

impl AtmosphereLanes {
    /// Radiance that reaches the eye from what sends `light`, linear Rec. 709, `range` metres away and `rise` metres above the eye.
    #[inline(always)]
    pub fn over<V: Simd>(&self, simd: V, light: [V::F; 3], range: V::F, rise: V::F) -> [V::F; 3] {
        if let Some(fog_and_glow) = &self.fog_and_glow {
            return self.over_with(simd, fog_and_glow, light, range, rise);
        }
        let mut haze = light;
        splat_all(simd, &mut haze, HAZE_COLOUR.to_array());
        mixed::<V>(haze, light, self.through(simd, range, rise))
    }

    /// [`Self::over`] with fog and glow.
    #[inline(always)]
    fn over_with<V: Simd>(
        &self,
        simd: V,
        fog_and_glow: &FogAndGlow,
        light: [V::F; 3],
        range: V::F,
        rise: V::F,
    ) -> [V::F; 3] {
        let (zero, up) = (simd.splat(0.0), rise * range.recip());
        let glow = fog_and_glow.share(simd, up);
        let haze = fog_and_glow.lit(simd, HAZE_COLOUR.to_array(), glow);
        let Some(fog) = &fog_and_glow.fog else {
            return mixed::<V>(haze, light, self.through(simd, range, rise));
        };

        let colour = fog_and_glow.lit(simd, fog.colour, glow);
        let veil = exp_neg(simd, fog.depth(simd, range, rise).max(zero));
        if fog.below >= 0.0 {
            let behind = mixed::<V>(haze, light, self.through(simd, range, rise));
            return mixed::<V>(colour, behind, veil);
        }

        let whole = self.depth(simd, range, rise);
        // Clear air ends where a ray that sinks enters the fog.
        let sinks = up.lt(simd.splat(-LEAST_SINE));
        let reach = simd.splat(fog.below) * up.min(simd.splat(-LEAST_SINE)).recip();
        let clear = reach.min(range).select(sinks, range);
        let before = self.depth(simd, clear, clear * up).min(whole);
        let behind = mixed::<V>(haze, light, exp_neg(simd, whole - before));

        mixed::<V>(haze, mixed::<V>(colour, behind, veil), exp_neg(simd, before))
    }

    /// [`Self::sky`] with fog and glow; `clear` is the share of the zenith's blue.
    #[inline(always)]
    fn sky_with<V: Simd>(&self, simd: V, fog_and_glow: &FogAndGlow, clear: V::F, up: V::F) -> [V::F; 3] {
        let glow = fog_and_glow.share(simd, up);
        let horizon = fog_and_glow.lit(simd, HORIZON.to_array(), glow);
        let mut zenith = horizon;
        splat_all(simd, &mut zenith, ZENITH.to_array());
        let sky = mixed::<V>(horizon, zenith, clear);
        let Some(fog) = &fog_and_glow.fog else { return sky };
        let (zero, least) = (simd.splat(0.0), simd.splat(LEAST_SINE));
        let colour = fog_and_glow.lit(simd, fog.colour, glow);
        let rises = zero.lt(up);
        if fog.below >= 0.0 {
            let depth = simd.splat(fog.layer.extinction * fog.column) * up.max(least).recip();
            return mixed::<V>(colour, sky, exp_neg(simd, depth).select(rises, zero));
        }

        let before = simd.splat(fog.below) * up.min(zero - least).recip();
        let through = self.through(simd, before, simd.splat(fog.below));
        let mut floor = mixed::<V>(horizon, colour, through);
        for (channel, floor) in floor.iter_mut().enumerate() {
            *floor = floor.select(up.lt(zero), sky[channel]);
        }

        floor
    }
}

impl FogAndGlow {
    /// Share of sunlight in what glows, for elevations of which `up` is the sine.
    #[inline(always)]
    fn share<V: Simd>(&self, simd: V, up: V::F) -> Option<(V::F, [f32; 3])> {
        let glow = self.glow.as_ref()?;
        let along = up.neg_mul_add(up, simd.splat(1.0)).max(simd.splat(1.0e-9)).sqrt_rough();
        let cosine = (up * simd.splat(glow.to_sun.z)) + along * simd.load(&self.sunward.0);
        let root = cosine.neg_mul_add(simd.splat(PHASE[1]), simd.splat(PHASE[0])).rsqrt();
        let strength = simd.splat(glow.strength);
        let share = (root * root * root - simd.splat(glow.least)) * strength;
        Some((share.max(simd.splat(0.0)).min(simd.splat(1.0)), glow.colour.to_array()))
    }

    /// A colour with so much glow.
    #[inline(always)]
    fn lit<V: Simd>(&self, simd: V, colour: [f32; 3], glow: Option<(V::F, [f32; 3])>) -> [V::F; 3] {
        let mut lit = [simd.splat(0.0); 3];
        splat_all(simd, &mut lit, colour);
        if let Some((share, sun)) = glow {
            let mut toward = lit;
            splat_all(simd, &mut toward, sun);
            lit = mixed::<V>(lit, toward, share);
        }
        lit
    }
}

impl EyeFog {
    /// Optical depth of the fog, see [`FogLayer::depth`].
    #[inline(always)]
    fn depth<V: Simd>(&self, simd: V, range: V::F, rise: V::F) -> V::F {
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let (soft, per_soft) = (simd.splat(self.layer.soft), simd.splat(1.0 / self.layer.soft));
        let below = simd.splat(self.below);
        let end = below - rise;
        let share = (end * per_soft).max(zero).min(one);
        let column = (soft * share * share * share)
            .mul_add(share.neg_mul_add(simd.splat(0.5), one), (end - soft).max(zero));
        let is_small = rise.abs().lt(simd.splat(SMALL_FOG_RISE) * soft);
        let mut density = zero;
        for share in GAUSS {
            let place = (rise.neg_mul_add(simd.splat(share), below) * per_soft).max(zero).min(one);
            density = (place * place).mul_add(simd.splat(1.5) - place, density);
        }
        let rising = one.select(is_small, rise);
        let mean = density.select(is_small, (simd.splat(self.column) - column) * rising.recip());
        range * simd.splat(self.layer.extinction) * mean
    }
}

/// Mixes two lights, by the share of the latter.
#[inline(always)]
fn mixed<V: Simd>(from: [V::F; 3], to: [V::F; 3], share: V::F) -> [V::F; 3] {
    let mut mixed = from;
    for (channel, mixed) in mixed.iter_mut().enumerate() {
        *mixed = (to[channel] - *mixed).mul_add(share, *mixed);
    }
    mixed
}

/// The same colour in all lanes.
#[inline(always)]
fn splat_all<V: Simd>(simd: V, light: &mut [V::F; 3], colour: [f32; 3]) {
    for (channel, light) in light.iter_mut().enumerate() {
        *light = simd.splat(colour[channel]);
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
