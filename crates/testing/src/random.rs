//! Numbers that look random, the same everywhere.

/// Steele, Lea and Flood's SplitMix (2014).
pub struct Random(pub u64);

impl Random {
    /// Draws a number from 0 to 1.
    pub fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ bits >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        (bits ^ bits >> 31) as f64 / u64::MAX as f64
    }

    /// Draws a number between two others, all alike.
    pub fn between(&mut self, [low, high]: [f64; 2]) -> f64 {
        low + (high - low) * self.share()
    }
}
