//! 8-bit sRGB to linear light and back, exactly rounded.
//!
//! Colours are averaged, filtered and shaded in linear light only: the mean of a black and a white
//! pixel is 188, not 128. Decoding is a table of 256 entries.
//!
//! Encoding, IEC 61966-2-1:1999, 5.2: `v = 12.92 x` up to `x = 0.0031308`, else
//! `v = 1.055 x^(1/2.4) − 0.055`; the code is `⌊255 v + ½⌋`. A `powf` per sample is slow, and differs
//! between machines in its last bit.
//! Since the code never falls as x rises, it is the number of thresholds at or below x, where the k-th
//! threshold is the least f32 whose code is k. So:
//!
//! ```text
//! for each k in 1 … 255:  threshold[k] = least f32 ≥ inverse((k − ½) / 255)        (in f64, once)
//! for each bucket of 2⁻⁷ of an octave:  (code at its start, the one threshold inside it or +∞)
//! code(x) = start of the bucket of x + (x ≥ its threshold)
//! ```
//!
//! A bucket is found by the upper 16 bits of x. It holds at most one threshold, because thresholds are
//! at least 0.9 % apart where they are densest. A test compares all 109 million f32 between the first
//! bucket and 1 with the thresholds, and another shows that no threshold comes so near to the middle
//! between two f32 that the last bits of a machine's `powf` could matter.

use std::sync::LazyLock;

use glam::Vec3;

/// Luminance of each channel of linear Rec. 709 (ITU-R BT.709, 3.2).
pub const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Linear light of each sRGB code, 0 … 1.
static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| linear_from_encoded(code as f64 / 255.0) as f32));

/// Buckets per octave, a power of two: the upper mantissa bits that take part in the index.
const INDEX_SHIFT: u32 = 16;
/// 2⁻¹³: everything below has code 0 (its largest is 0.4).
const LEAST: f32 = 1.0 / 8192.0;
const FIRST_BUCKET: u32 = LEAST.to_bits() >> INDEX_SHIFT;
const BUCKETS: usize = ((1.0_f32.to_bits() >> INDEX_SHIFT) - FIRST_BUCKET) as usize;

#[derive(Clone, Copy)]
struct Bucket {
    threshold: f32,
    code: u8,
}

static TABLE: LazyLock<[Bucket; BUCKETS]> = LazyLock::new(|| {
    let thresholds = thresholds();
    std::array::from_fn(|index| {
        let start = f32::from_bits((FIRST_BUCKET + index as u32) << INDEX_SHIFT);
        let below = thresholds.partition_point(|&threshold| threshold <= start);
        Bucket { threshold: thresholds.get(below).copied().unwrap_or(f32::INFINITY), code: below as u8 }
    })
});

/// Reads an sRGB colour, `#rrggbb`; `None`: it is no such text.
pub fn srgb8_from_hex(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii())?;
    let [_, red, green, blue] =
        u32::from_str_radix(digits, 16).ok().filter(|_| !digits.starts_with('+'))?.to_be_bytes();
    Some([red, green, blue])
}

/// Entry k − 1 is the least f32 whose code is k.
fn thresholds() -> [f32; 255] {
    std::array::from_fn(|index| {
        let exact = linear_from_encoded((index as f64 + 0.5) / 255.0);
        let nearest = exact as f32;
        if f64::from(nearest) < exact { nearest.next_up() } else { nearest }
    })
}

/// Inverse of the sRGB curve: linear light, 0 … 1, of an encoded value, 0 … 1.
pub fn linear_from_encoded(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Linear light, 0 … 1, of an 8-bit sRGB colour.
pub fn linear_from_srgb8(colour: [u8; 3]) -> [f32; 3] {
    colour.map(|code| LINEAR[usize::from(code)])
}

/// Linear light, 0 … 1, of each 8-bit sRGB code.
pub fn linear_of_codes() -> &'static [f32; 256] {
    &LINEAR
}

/// The 8-bit sRGB code of linear light, where 1 is display white. Values beyond 0 … 1 are clipped, NaN is 0.
pub fn srgb8_from_linear(linear: f32) -> u8 {
    encode(&TABLE, linear)
}

/// [`srgb8_from_linear`] of red, green and blue.
pub fn srgb8_from_light([red, green, blue]: [f32; 3]) -> [u8; 3] {
    let table = &*TABLE;
    [encode(table, red), encode(table, green), encode(table, blue)]
}

#[inline]
fn encode(table: &[Bucket; BUCKETS], linear: f32) -> u8 {
    if linear >= 1.0 {
        return 255;
    }
    if linear >= LEAST {
        let bucket = table[((linear.to_bits() >> INDEX_SHIFT) - FIRST_BUCKET) as usize];
        return bucket.code + u8::from(linear >= bucket.threshold);
    }
    0
}

/// Codes `r g b r g b …` of pixels in linear light.
pub fn srgb8_picture(pixels: &[[f32; 3]]) -> Vec<u8> {
    let table = &*TABLE;
    pixels.iter().flatten().map(|&linear| encode(table, linear)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition, in double precision.
    fn reference(linear: f64) -> u8 {
        let encoded =
            if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
        (255.0 * encoded + 0.5).floor() as u8
    }

    #[test]
    fn thresholds_are_where_the_definition_changes() {
        for (index, threshold) in thresholds().into_iter().enumerate() {
            let code = index as u8 + 1;
            assert_eq!(reference(f64::from(threshold)), code, "at {threshold}");
            assert_eq!(reference(f64::from(threshold.next_down())), code - 1, "below {threshold}");
        }
    }

    /// The rounding of a threshold to f32 is decided by far more than the error of any `powf`.
    #[test]
    fn thresholds_do_not_depend_on_the_machine() {
        for index in 0..255 {
            let exact = linear_from_encoded((f64::from(index) + 0.5) / 255.0);
            let nearest = exact as f32;
            let spacing = f64::from(nearest.next_up()) - f64::from(nearest);
            let position = (exact - f64::from(nearest)) / spacing;
            // Two ulp of f64 are 2⁻²⁸ of the spacing of f32; 0 and ±½ are where the choice would flip.
            assert!(position.abs() > 1e-6 && position.abs() < 0.5 - 1e-6, "{index}: {position}");
        }
    }

    #[test]
    fn every_f32_has_the_code_of_its_thresholds() {
        let thresholds = thresholds();
        let mut code = 0;
        for bits in LEAST.to_bits()..1.0_f32.to_bits() {
            let linear = f32::from_bits(bits);
            while thresholds.get(code).is_some_and(|&threshold| threshold <= linear) {
                code += 1;
            }
            assert_eq!(usize::from(srgb8_from_linear(linear)), code, "{linear}");
        }
        assert_eq!(code, 255);
        assert_eq!(reference(f64::from(LEAST.next_down())), 0);
    }

    #[test]
    fn codes_survive_the_round_trip() {
        for code in 0..=255 {
            assert_eq!(linear_from_srgb8([code; 3]).map(srgb8_from_linear), [code; 3]);
        }
    }

    #[test]
    fn values_that_no_light_has() {
        for (linear, code) in [
            (f32::NAN, 0),
            (-f32::NAN, 0),
            (f32::NEG_INFINITY, 0),
            (-1.0, 0),
            (-0.0, 0),
            (f32::MIN_POSITIVE, 0),
            (1.0, 255),
            (7.0, 255),
            (f32::INFINITY, 255),
        ] {
            assert_eq!(srgb8_from_linear(linear), code, "{linear}");
        }
        assert_eq!(srgb8_picture(&[[0.0, 0.5, 1.0]]), [0, 188, 255]);
    }
}
