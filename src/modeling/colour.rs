//! sRGB bytes to linear light and back (IEC 61966-2-1). Colours are averaged in linear light only: the
//! mean of a black and a white pixel is 188, not 128.

use std::sync::LazyLock;

/// Linear light of each sRGB byte, 0…1.
pub(super) static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear(byte as f64) as f32));

/// Linear light half-way (as encoded) between each byte and the next.
static STEPS: LazyLock<[f32; 255]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear(byte as f64 + 0.5) as f32));

/// Linear light of an encoded value, 0…255.
fn linear(value: f64) -> f64 {
    let encoded = value / 255.0;
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Nearest sRGB byte of a linear value; values outside 0…1 are clamped.
pub(super) fn encode(linear: f32) -> u8 {
    STEPS.partition_point(|step| *step <= linear) as u8
}

/// Linear light of an sRGB colour.
pub(super) fn decode(colour: [u8; 3]) -> [f32; 3] {
    colour.map(|byte| LINEAR[usize::from(byte)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_survive_the_round_trip() {
        for byte in 0..=255 {
            assert_eq!(encode(LINEAR[usize::from(byte)]), byte);
        }
        assert_eq!((encode(-1.0), encode(2.0), encode(f32::NAN)), (0, 255, 0));
    }

    #[test]
    fn the_mean_of_black_and_white_is_188() {
        assert_eq!(encode(0.5), 188);
    }
}
