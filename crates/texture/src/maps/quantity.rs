//! Quantities: linear functions over the ground, folded, cut and joined by the sixteen modes of a four-bit
//! face code.
//!
//! ```text
//! q   = a·x + b·y + c
//! q_a = ⌊q⌋ mod 1024                         sawtooth, the ten lowest bits
//! q_b = q_a up to 511, else 1023 − q_a       triangle, continuous
//! q_c = q_b > threshold                      stripes
//! ```
//!
//! Functions are of the ground, not of the screen: perspective is right by itself, and what is seen is the
//! same from any eye.
//!
//! Bunker and Ferris name the uses (logical combinations of two stripes, sums, three functions for three
//! primaries, bit fields that address a memory of colours, tables); which code selects which is ours.

use serde::{Deserialize, Serialize};

/// Linear function over the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearFunction {
    /// Change for each unit of x.
    pub x: f64,
    /// Change for each unit of y.
    pub y: f64,
    /// Value at 0, 0.
    pub offset: f64,
}

impl LinearFunction {
    /// Value at a place.
    pub fn at(self, x: f64, y: f64) -> f64 {
        self.x * x + self.y * y + self.offset
    }

    /// Ten lowest bits of the value at a place, q_a: 0 to 1023.
    pub fn sawtooth(self, x: f64, y: f64) -> u16 {
        sawtooth_of(self.at(x, y))
    }

    /// The sawtooth folded about 511, q_b: 0 to 511.
    pub fn triangle(self, x: f64, y: f64) -> u16 {
        folded(self.sawtooth(x, y))
    }
}

/// Use of quantities, by the four-bit code of a face or material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "u8", try_from = "u8")]
pub enum QuantityMode {
    /// 0: no texture, full tone.
    Inhibited,
    /// 1: sawtooth of the first function.
    Sawtooth,
    /// 2: triangle of the first.
    Triangle,
    /// 3: stripes of the first.
    Stripes,
    /// 4: sawtooth of the second.
    SecondSawtooth,
    /// 5: triangle of the second.
    SecondTriangle,
    /// 6: stripes of the second.
    SecondStripes,
    /// 7: where stripes of both meet: rectangles.
    StripesAnd,
    /// 8: where stripes of either are: a lattice.
    StripesOr,
    /// 9: where stripes of one alone are: checks.
    StripesXor,
    /// 10: mean of both triangles.
    TriangleSum,
    /// 11: sawtooth of the sum of both functions.
    SawtoothOfSum,
    /// 12: product of both triangles.
    TriangleProduct,
    /// 13: triangles of the three functions, each for a primary.
    Primaries,
    /// 14: two bits of each of the first two sawteeth address a memory of sixteen tones.
    Memory,
    /// 15: triangle of the first, through the memory as a table that is looked up.
    LookUp,
}

impl QuantityMode {
    /// All modes in the order of their codes.
    pub const ALL: [Self; 16] = [
        Self::Inhibited,
        Self::Sawtooth,
        Self::Triangle,
        Self::Stripes,
        Self::SecondSawtooth,
        Self::SecondTriangle,
        Self::SecondStripes,
        Self::StripesAnd,
        Self::StripesOr,
        Self::StripesXor,
        Self::TriangleSum,
        Self::SawtoothOfSum,
        Self::TriangleProduct,
        Self::Primaries,
        Self::Memory,
        Self::LookUp,
    ];

    /// The mode of a face code, whose four lowest bits count.
    pub fn of_code(code: u8) -> Self {
        Self::ALL[usize::from(code & 15)]
    }
}

impl From<QuantityMode> for u8 {
    fn from(mode: QuantityMode) -> Self {
        mode as Self
    }
}

impl TryFrom<u8> for QuantityMode {
    type Error = String;

    fn try_from(code: u8) -> Result<Self, String> {
        let mode = Self::ALL.get(usize::from(code)).copied();
        mode.ok_or_else(|| format!("a mode of quantities is 0 to 15, not {code}"))
    }
}

/// Quantities of a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuantityTexture {
    /// Functions over the ground; most modes use one or two.
    pub functions: [LinearFunction; 3],
    /// Triangle above which a stripe is, 0 to 511.
    pub threshold: u16,
    /// Tones of the memory of colours, 0 to 1.
    pub memory: [f64; 16],
}

impl QuantityTexture {
    /// Tones of the three primaries at a place, 0 to 1.
    pub fn tones(&self, mode: QuantityMode, x: f64, y: f64) -> [f64; 3] {
        let sawtooth = |number: usize| self.functions[number].sawtooth(x, y);
        let triangle = |number: usize| self.functions[number].triangle(x, y);
        let stripe = |number: usize| triangle(number) > self.threshold;
        let share = |value: u16, most: u16| f64::from(value) / f64::from(most);
        let lit = |is_lit: bool| f64::from(u8::from(is_lit));

        let tone = match mode {
            QuantityMode::Inhibited => 1.0,
            QuantityMode::Sawtooth => share(sawtooth(0), 1023),
            QuantityMode::Triangle => share(triangle(0), 511),
            QuantityMode::Stripes => lit(stripe(0)),
            QuantityMode::SecondSawtooth => share(sawtooth(1), 1023),
            QuantityMode::SecondTriangle => share(triangle(1), 511),
            QuantityMode::SecondStripes => lit(stripe(1)),
            QuantityMode::StripesAnd => lit(stripe(0) && stripe(1)),
            QuantityMode::StripesOr => lit(stripe(0) || stripe(1)),
            QuantityMode::StripesXor => lit(stripe(0) != stripe(1)),
            QuantityMode::TriangleSum => share(triangle(0) + triangle(1), 1022),
            QuantityMode::SawtoothOfSum => {
                let sum = self.functions[0].at(x, y) + self.functions[1].at(x, y);
                share(sawtooth_of(sum), 1023)
            }
            QuantityMode::TriangleProduct => share(triangle(0), 511) * share(triangle(1), 511),
            QuantityMode::Primaries => return [0, 1, 2].map(|number| share(triangle(number), 511)),
            QuantityMode::Memory => self.memory[usize::from((sawtooth(1) >> 8) << 2 | sawtooth(0) >> 8)],
            QuantityMode::LookUp => self.memory[usize::from(triangle(0) >> 5)],
        };
        [tone; 3]
    }
}

/// Ten lowest bits of a value's whole part, counted up from below zero, too.
fn sawtooth_of(value: f64) -> u16 {
    value.floor().rem_euclid(1024.0) as u16
}

/// Folds 0 … 1023 about 511.
fn folded(sawtooth: u16) -> u16 {
    sawtooth.min(1023 - sawtooth)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture() -> QuantityTexture {
        let function = |x, y, offset| LinearFunction { x, y, offset };
        QuantityTexture {
            functions: [function(10.0, 0.0, 0.0), function(2.0, 6.0, 100.0), function(-1.0, 1.0, 0.5)],
            threshold: 255,
            memory: std::array::from_fn(|number| number as f64 / 15.0),
        }
    }

    #[test]
    fn sawtooth_and_triangle_have_golden_values() {
        let function = LinearFunction { x: 1.0, y: 0.0, offset: 0.0 };
        for (x, sawtooth, triangle) in [
            (0.0, 0, 0),
            (511.9, 511, 511),
            (512.0, 512, 511),
            (1023.0, 1023, 0),
            (1024.0, 0, 0),
            (-1.0, 1023, 0),
            (-0.25, 1023, 0),
            (1e9 + 5.0, 517, 506),
        ] {
            assert_eq!(
                (function.sawtooth(x, 7.0), function.triangle(x, 7.0)),
                (sawtooth, triangle),
                "x = {x}"
            );
        }
        // The triangle is continuous: neighbours differ by 1 at most.
        assert!((0..3000).all(|x| {
            let [a, b] = [x, x + 1].map(|x| function.triangle(f64::from(x), 0.0));
            a.abs_diff(b) <= 1
        }));
    }

    #[test]
    fn sixteen_modes_have_golden_values() {
        // At 60, 40: q = 600, 460, −19.5; q_a = 600, 460, 1004; q_b = 423, 460, 19.
        // At 10, 50: q = 100, 420, 40.5; q_a = q_b = 100, 420, 40.
        let golden = [
            (0, 1.0, 1.0),
            (1, 600.0 / 1023.0, 100.0 / 1023.0),
            (2, 423.0 / 511.0, 100.0 / 511.0),
            (3, 1.0, 0.0),
            (4, 460.0 / 1023.0, 420.0 / 1023.0),
            (5, 460.0 / 511.0, 420.0 / 511.0),
            (6, 1.0, 1.0),
            (7, 1.0, 0.0),
            (8, 1.0, 1.0),
            (9, 0.0, 1.0),
            (10, 883.0 / 1022.0, 520.0 / 1022.0),
            (11, 36.0 / 1023.0, 520.0 / 1023.0),
            (12, 423.0 * 460.0 / (511.0 * 511.0), 100.0 * 420.0 / (511.0 * 511.0)),
            (13, 423.0 / 511.0, 100.0 / 511.0),
            (14, 6.0 / 15.0, 4.0 / 15.0),
            (15, 13.0 / 15.0, 3.0 / 15.0),
        ];
        let texture = texture();
        for (code, first, second) in golden {
            let mode = QuantityMode::of_code(code);
            for (place, expected) in [([60.0, 40.0], first), ([10.0, 50.0], second)] {
                let got = texture.tones(mode, place[0], place[1])[0];
                assert!((got - expected).abs() < 1e-12, "code {code} at {place:?}: {got}, not {expected}");
            }
        }
        assert_eq!(
            texture.tones(QuantityMode::Primaries, 60.0, 40.0).map(|tone| (tone * 511.0).round()),
            [423.0, 460.0, 19.0]
        );
        assert_eq!(QuantityMode::of_code(0xF9), QuantityMode::StripesXor);
    }

    #[test]
    fn modes_keep_to_their_range() {
        let texture = texture();
        for mode in QuantityMode::ALL {
            for place in 0..500 {
                let (x, y) = (f64::from(place) * 7.3 - 900.0, f64::from(place % 37) * -11.9);
                assert!(texture.tones(mode, x, y).iter().all(|tone| (0.0..=1.0).contains(tone)), "{mode:?}");
            }
        }
    }
}
