//! Numbers that look random, each a function of another.

/// Difference from one seed to the next.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// A number of 0 ≤ … < 1 for each of many, without pattern.
pub fn unit(number: u64) -> f64 {
    mixed(number.wrapping_add(1).wrapping_mul(STEP))
}

fn mixed(seed: u64) -> f64 {
    (mix(seed) >> 11) as f64 / (1_u64 << 53) as f64
}

fn mix(seed: u64) -> u64 {
    let mixed = (seed ^ (seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

/// Numbers without pattern (Steele, Lea and Flood 2014, *Fast splittable pseudorandom number generators*: SplitMix64).
#[derive(Debug, Clone)]
pub struct Random(pub u64);

impl Random {
    /// Returns one of many sequences of a seed.
    pub fn stream(seed: u64, number: u64) -> Self {
        let seed = mix(seed.wrapping_add(STEP));
        Self(mix(seed.wrapping_add(number.wrapping_add(1).wrapping_mul(STEP))))
    }

    /// 0 ≤ a number < 1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(STEP);
        mixed(self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_paper_and_stay() {
        // The first number of SplitMix64 with the seed 0.
        assert_eq!(mix(STEP), 0xe220_a839_7b1d_cdaf);
        assert_eq!(Random(0).unit(), (0xe220_a839_7b1d_cdaf_u64 >> 11) as f64 / 9_007_199_254_740_992.0);
        assert_eq!(unit(0), Random(0).unit());
    }

    #[test]
    fn streams_differ_by_seed_and_number() {
        let first = |seed, number| Random::stream(seed, number).unit();
        let mut seen: Vec<u64> =
            (0..100).flat_map(|seed| (0..100).map(move |number| first(seed, number).to_bits())).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 10_000);
    }
}
