//! Means of sRGB colours in linear light, in 16-bit integers: sums of them are exact, so that averages do
//! not depend on the order of summing.

use std::sync::LazyLock;

use hedgehop_base::colour::linear_from_encoded;

/// Linear light of each sRGB code, 0…65535.
static LINEAR: LazyLock<[u16; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| linear(code as f64).round() as u16));

/// The sRGB code for each linear light: that in whose interval, half a code to each side, it falls.
static CODES: LazyLock<Box<[u8]>> = LazyLock::new(|| {
    let limits: Vec<f64> = (0..255).map(|code| linear(f64::from(code) + 0.5)).collect();
    (0..=u16::MAX).map(|light| limits.partition_point(|&limit| limit <= f64::from(light)) as u8).collect()
});

/// Linear light, 0…65535, of an sRGB code, 0…255.
fn linear(code: f64) -> f64 {
    linear_from_encoded(code / 255.0) * f64::from(u16::MAX)
}

/// Takes means of sRGB colours in linear light.
#[derive(Clone, Copy)]
pub(super) struct Averager {
    linear: &'static [u16; 256],
    codes: &'static [u8],
}

impl Averager {
    pub fn new() -> Self {
        Self { linear: &LINEAR, codes: &CODES }
    }

    /// Adds a colour to sums of linear light.
    #[inline]
    pub fn add(&self, sums: &mut [u32; 3], colour: [u8; 3]) {
        for (sum, code) in sums.iter_mut().zip(colour) {
            *sum += u32::from(self.linear[usize::from(code)]);
        }
    }

    /// The colour whose linear light is `sums / count`, count ≥ 1.
    #[inline]
    pub fn mean(&self, sums: [u32; 3], count: u32) -> [u8; 3] {
        sums.map(|sum| self.codes[((sum + count / 2) / count) as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_of_one_colour_is_that_colour() {
        let averager = Averager::new();
        for code in 0..=255 {
            for count in 1..=16 {
                let mut sums = [0; 3];
                (0..count).for_each(|_| averager.add(&mut sums, [code, 255 - code, code]));
                assert_eq!(averager.mean(sums, count), [code, 255 - code, code]);
            }
        }
    }

    #[test]
    fn black_and_white_make_the_grey_of_half_the_light() {
        let averager = Averager::new();
        let mut sums = [0; 3];
        averager.add(&mut sums, [0; 3]);
        averager.add(&mut sums, [255; 3]);
        // 0.5 in linear light is 0.7354 when encoded.
        assert_eq!(averager.mean(sums, 2), [188; 3]);
    }
}
