//! Conversion of light to codes, by table.
//!
//! A power for each sample would take longer than to render it. The curve is smooth, so that lines between values at 128 places of each octave are within
//! 0.003 of a code of it.

use crate::scene::Tone;

/// Buckets of an octave: the upper bits of the mantissa that take part in the index.
const SHIFT: u32 = 16;

/// 2⁻²⁰, below which light is taken to be in proportion, and 2⁶, from which on it is white.
const LEAST: f32 = 1.0 / 1_048_576.0;
const MOST: f32 = 64.0;
const FIRST: u32 = LEAST.to_bits() >> SHIFT;

/// Codes of white.
const WHITE: f64 = 255.0;

/// A curve from light, ≥ 0, to 0…255.
#[derive(Debug)]
pub struct Curve {
    /// Value at the start of each bucket, and how much more it is at the end.
    buckets: Vec<[f32; 2]>,
}

impl Curve {
    /// The tone's curve, and then the encoding's: a power, or that of sRGB.
    pub fn new(tone: Tone, gamma: Option<f64>) -> Self {
        let at = |bits: u32| WHITE * encoded(toned(f64::from(f32::from_bits(bits << SHIFT)), tone), gamma);
        let last = MOST.to_bits() >> SHIFT;
        let buckets = (FIRST..last).map(|bits| [at(bits) as f32, (at(bits + 1) - at(bits)) as f32]);
        Self { buckets: buckets.collect() }
    }

    /// The code of light, cut off after `threshold`, 0…1, is added. What is no number is black.
    pub fn code(&self, light: f32, threshold: f32) -> u8 {
        // Conversions to integers keep within their range.
        (self.value(light) + threshold) as u8
    }

    fn value(&self, light: f32) -> f32 {
        if light >= MOST {
            return WHITE as f32;
        }
        if light >= LEAST {
            let bits = light.to_bits();
            let share = (bits & ((1 << SHIFT) - 1)) as f32 / (1 << SHIFT) as f32;
            let [start, rise] = self.buckets[((bits >> SHIFT) - FIRST) as usize];
            return rise * share + start;
        }
        self.buckets[0][0] * (light.max(0.0) / LEAST)
    }
}

/// Applies a tone's curve to light ≥ 0, giving 0…1.
fn toned(light: f64, tone: Tone) -> f64 {
    let toned = match tone {
        Tone::None => light,
        Tone::Filmic => light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14),
    };
    toned.clamp(0.0, 1.0)
}

/// Light of 0…1 as it is encoded, 0…1.
fn encoded(light: f64, gamma: Option<f64>) -> f64 {
    match gamma {
        Some(gamma) => light.powf(1.0 / gamma),
        None if light <= 0.003_130_8 => 12.92 * light,
        None => 1.055 * light.powf(1.0 / 2.4) - 0.055,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_those_of_the_closed_forms() {
        for (tone, gamma) in
            [(Tone::None, None), (Tone::None, Some(2.2)), (Tone::Filmic, None), (Tone::Filmic, Some(1.0))]
        {
            let curve = Curve::new(tone, gamma);
            for step in 0..6000 {
                let light = 1.0e-5_f64 * 1.002_f64.powi(step);
                let x = f64::from(light as f32);
                let rolled = match tone {
                    Tone::None => x,
                    Tone::Filmic => (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14),
                };
                let rolled = rolled.min(1.0);

                let code = match gamma {
                    Some(gamma) => 255.0 * rolled.powf(1.0 / gamma),
                    None => {
                        255.0 * (1.055 * rolled.powf(1.0 / 2.4) - 0.055).max(12.92 * rolled.min(0.003_130_8))
                    }
                };
                let found = f64::from(curve.value(light as f32));
                assert!((found - code).abs() < 5e-3, "{tone:?} {gamma:?} {light}: {found} {code}");
            }
        }

        // White paper, middle grey, and a highlight of sixteen times white.
        let filmic = Curve::new(Tone::Filmic, None);
        assert_eq!([0.18, 1.0, 16.0].map(|light| filmic.code(light, 0.5)), [141, 232, 255]);
    }

    #[test]
    fn without_a_tone_codes_are_those_of_the_fast_path() {
        let curve = Curve::new(Tone::None, None);
        for step in 0..100_000 {
            let light = step as f32 * 1.0e-5;
            let (own, exact) = (curve.code(light, 0.5), hedgehop_base::colour::srgb8_from_linear(light));
            let is_near = (curve.value(light).fract() - 0.5).abs() < 5e-3;
            assert!(own == exact || is_near, "{light}: {own} {exact}");
        }
    }

    #[test]
    fn values_that_no_light_has() {
        let curve = Curve::new(Tone::Filmic, Some(2.2));
        for (light, code) in
            [(f32::NAN, 0), (-1.0, 0), (f32::NEG_INFINITY, 0), (f32::INFINITY, 255), (1.0e30, 255)]
        {
            assert_eq!(curve.code(light, 0.5), code, "{light}");
        }
    }
}
