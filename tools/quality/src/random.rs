//! Seeded numbers: the same poses, pixels and sub-pixel positions in every run.
//!
//! SplitMix64 (Steele, Lea and Flood, OOPSLA 2014), as a sequence and as a hash of its index.

/// A sequence of numbers that its seed decides.
#[derive(Debug, Clone)]
pub struct Random {
    state: u64,
}

impl Random {
    /// The sequence of `seed`.
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// Uniform in 0…1, 1 excluded.
    pub fn unit(&mut self) -> f64 {
        self.state = self.state.wrapping_add(GOLDEN);
        unit_of(mix(self.state))
    }

    /// Uniform in `low`…`high`.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in the logarithm, `low`…`high`, both > 0.
    pub fn log_within(&mut self, low: f64, high: f64) -> f64 {
        self.within(low.ln(), high.ln()).exp()
    }
}

/// 2⁶⁴ divided by the golden ratio.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Two uniform numbers in 0…1 for element `index` of a set.
pub fn pair_of(index: u64) -> [f64; 2] {
    let first = mix(index.wrapping_mul(GOLDEN).wrapping_add(GOLDEN));
    [unit_of(first), unit_of(mix(first.wrapping_add(GOLDEN)))]
}

fn mix(mut bits: u64) -> u64 {
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

fn unit_of(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// A hash of `hash` and one more value.
pub fn fold(hash: u64, value: u64) -> u64 {
    mix(hash.wrapping_mul(GOLDEN) ^ value.wrapping_add(GOLDEN))
}
