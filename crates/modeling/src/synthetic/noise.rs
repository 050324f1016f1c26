//! Seeded noise: a function of the place and of a seed alone, made of integers, sums, products and quotients, so that every machine has the same.
//!
//! ```text
//! gradient(place) = gradients of the four lattice points around, each times the way to it, faded into each other
//! wave k          = gradient(place turned k times by an angle of tangent 3/4, shifted, in units of wavelength k)
//! ```
//! Gradient noise after Perlin, "An image synthesizer" (1985), with the fade of "Improving noise" (2002); the numbers of lattice points are mixed
//! as in SplitMix64 (Steele, Lea and Flood, 2014). Because each wave's lattice is turned and shifted, no direction of a grid shows in their sum.

use glam::DVec2;

/// Standard deviation of [`gradient`].
const DEVIATION: f64 = 0.176_13;

/// Well-mixed bits of a lattice point.
pub(super) fn hash(x: i64, y: i64, seed: u64) -> u64 {
    let mut z = (x as u64)
        .wrapping_mul(0x9E37_79B9_7F4A_7C15)
        .wrapping_add((y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F))
        .wrapping_add(seed.wrapping_mul(0x1656_67B1_9E37_79F9));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// Uniform in 0 ≤ share < 1.
pub(super) fn share(x: i64, y: i64, seed: u64) -> f64 {
    (hash(x, y, seed) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Gradient noise over a lattice of unit cells, −1…1, mean 0.
pub(crate) fn gradient(at: DVec2, seed: u64) -> f64 {
    let floor = at.floor();
    let (x, y) = (floor.x as i64, floor.y as i64);
    let t = at - floor;
    let corner = |i: i64, j: i64| {
        let bits = hash(x.wrapping_add(i), y.wrapping_add(j), seed);
        let part = |bits: u64| f64::from(bits as u16) / 32_768.0 - 1.0;
        part(bits) * (t.x - i as f64) + part(bits >> 16) * (t.y - j as f64)
    };
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (u, v) = (fade(t.x), fade(t.y));
    let mix = |a: f64, b: f64, share: f64| a + (b - a) * share;
    mix(mix(corner(0, 0), corner(1, 0), u), mix(corner(0, 1), corner(1, 1), u), v)
}

/// Waves of ever shorter length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Waves {
    pub seed: u64,
    /// Length of the first, in units of the place; each further one is half as long.
    pub longest: f64,
    /// Height of each as a share of that before it, 0…1.
    pub gain: f64,
}

impl Waves {
    /// Counts those that are no shorter than `shortest`.
    pub fn count(&self, shortest: f64) -> u32 {
        let lengths = std::iter::successors(Some(self.longest), |length| Some(0.5 * length));
        lengths.take(64).take_while(|length| *length >= shortest).count() as u32
    }

    /// Sum of the first `count`, each after `shape` of its value (standard deviation 1), the first with the weight 1.
    pub fn sum(&self, at: DVec2, count: u32, shape: impl Fn(f64) -> f64) -> f64 {
        const TURN: DVec2 = DVec2::new(0.8, 0.6);
        let (mut sum, mut weight, mut length) = (0.0, 1.0, self.longest);
        let mut place = at;
        for wave in 0..i64::from(count) {
            let shift = DVec2::new(share(wave, 0, self.seed), share(wave, 1, self.seed));
            let seed = hash(wave, 2, self.seed);
            sum += weight * shape(gradient(place / length + shift, seed) / DEVIATION);
            (weight, length) = (weight * self.gain, 0.5 * length);
            place = DVec2::new(TURN.x * place.x - TURN.y * place.y, TURN.y * place.x + TURN.x * place.y);
        }
        sum
    }
}

/// Way of one metre towards an azimuth in degrees, clockwise from grid north: series whose last term is below the rounding of what they add up to.
pub(super) fn turned(azimuth_deg: f64) -> DVec2 {
    let quarter = (azimuth_deg / 90.0).round();
    let angle = (azimuth_deg - 90.0 * quarter) * (std::f64::consts::PI / 180.0);
    let square = angle * angle;
    // Horner, from the highest term inward: 1 − x²/(n(n+1)) · …
    let series = |last: i32| {
        let terms = (0..9).map(|term| f64::from(last - 2 * term));
        terms.fold(1.0, |sum, n| 1.0 - square / (n * (n - 1.0)) * sum)
    };
    let (sine, cosine) = (angle * series(19), series(18));
    match quarter.rem_euclid(4.0) as i32 {
        0 => DVec2::new(sine, cosine),
        1 => DVec2::new(cosine, -sine),
        2 => DVec2::new(-sine, -cosine),
        _ => DVec2::new(-cosine, sine),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_mean_0_and_its_deviation_and_keeps_to_its_bounds() {
        let values = (0..250_000).map(|step| {
            gradient(DVec2::new(f64::from(step % 500) * 0.377, f64::from(step / 500) * 0.613), 9)
        });
        let values: Vec<f64> = values.collect();
        let mean = values.iter().sum::<f64>() / 250_000.0;
        let deviation = (values.iter().map(|value| value * value).sum::<f64>() / 250_000.0).sqrt();
        assert!(mean.abs() < 0.005 && (deviation / DEVIATION - 1.0).abs() < 0.02, "{mean} {deviation}");
        assert!(values.iter().all(|value| value.abs() <= 1.0));
    }

    #[test]
    fn noise_is_the_same_everywhere_and_for_ever() {
        // What other machines and later versions must give, too.
        assert_eq!(hash(-3, 5, 7), 6_327_483_995_954_054_376);
        assert_eq!(gradient(DVec2::new(-1234.375, 987.8125), 42).to_bits(), 4_599_636_028_867_947_420);
    }

    #[test]
    fn turns_are_sines_and_cosines() {
        for azimuth in -900..900 {
            let azimuth = f64::from(azimuth) * 0.77;
            let (sine, cosine) = azimuth.to_radians().sin_cos();
            assert!((turned(azimuth) - DVec2::new(sine, cosine)).length() < 1e-14, "{azimuth}");
        }
        assert_eq!(turned(90.0), DVec2::X);
        assert_eq!(turned(-180.0), -DVec2::Y);
    }

    #[test]
    fn waves_end_at_the_shortest() {
        let waves = Waves { seed: 1, longest: 64.0, gain: 0.5 };
        assert_eq!((waves.count(64.0), waves.count(65.0), waves.count(2.0)), (1, 0, 6));
        assert_eq!(waves.sum(DVec2::new(3.0, 4.0), 0, |value| value), 0.0);
    }
}
