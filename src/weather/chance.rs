//! Numbers that look random, each a function of another.

/// Difference from one seed to the next.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// A number of 0 ≤ … < 1 for each of many, without pattern.
pub fn unit(number: u64) -> f64 {
    mixed(number.wrapping_add(1).wrapping_mul(STEP))
}

fn mixed(seed: u64) -> f64 {
    let mixed = (seed ^ (seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Numbers without pattern (Steele, Lea and Flood 2014, *Fast splittable pseudorandom number generators*: SplitMix64).
pub(crate) struct Random(pub u64);

impl Random {
    /// 0 ≤ a number < 1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(STEP);
        mixed(self.0)
    }
}
