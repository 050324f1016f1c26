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

/// Steps of the table that a search for a byte starts from.
const GUESSES: usize = 4096;

/// Byte of the lower end of each of equal intervals of linear light.
static GUESS: LazyLock<[u8; GUESSES]> = LazyLock::new(|| {
    std::array::from_fn(|index| {
        let low = index as f32 / GUESSES as f32;
        STEPS.partition_point(|step| *step <= low) as u8
    })
});

/// Nearest sRGB byte of a linear value; values outside 0…1 are clamped, NaN is 0.
pub(super) fn encode(linear: f32) -> u8 {
    let clamped = linear.clamp(0.0, 1.0);
    let guess = usize::from(GUESS[((clamped * GUESSES as f32) as usize).min(GUESSES - 1)]);
    // Intervals are narrow: few steps lie within one.
    let above = STEPS[guess..].iter().take_while(|step| **step <= clamped).count();
    (guess + above) as u8
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
    fn every_value_meets_the_nearest_byte() {
        for index in 0..=100_000 {
            let linear = index as f32 / 100_000.0;
            assert_eq!(
                usize::from(encode(linear)),
                STEPS.partition_point(|step| *step <= linear),
                "{linear}"
            );
        }
    }

    #[test]
    fn the_mean_of_black_and_white_is_188() {
        assert_eq!(encode(0.5), 188);
    }
}
