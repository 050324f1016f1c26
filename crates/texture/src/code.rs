//! Cyclic codes: maximal-length sequences of linear feedback shift registers in Fibonacci form.
//!
//! ```text
//! step:    b = parity(state AND lower coefficients of p)
//!          state = (state >> 1) | b << (m − 1)              the lowest bit is the oldest
//! tone(n): the whole register after n steps from state 1, read as a number 1 … 2^m − 1
//! jump:    bit j of tone(n) = coefficient 0 of x^(n + j) mod p
//! ```
//!
//! The jump holds because the register's output obeys the recurrence of the powers of x modulo p, and both
//! begin with 1 and m − 1 zeros. Registers of Galois form have other tones, whose averages differ from
//! polynomial to polynomial.
//!
//! Source: study of cyclic codes for surface texture (AFHRL on ACTES), which steps or stores sequences; jumps
//! are ours.

use hedgehop_base::error::{Error, Result};

use crate::polynomial::Modulus;

/// Greatest degree whose sequence is kept as a table, 128 KiB at most.
const MAX_TABLE_DEGREE: u32 = 16;

/// Maximal-length sequence of register states, at any place along it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CyclicCode {
    modulus: Modulus,
    /// States in their order, of degrees up to 16; empty above.
    states: Vec<u16>,
}

impl CyclicCode {
    /// Polynomial x⁸ + x⁵ + x³ + x + 1, a bit for each power: the one of the study's tables.
    pub const DEFAULT_POLYNOMIAL: u64 = 0x12B;

    /// Takes a primitive polynomial of degree 8 to 32, a bit for each power of x (x⁸ + x⁵ + x³ + x + 1 is
    /// 0x12B).
    ///
    /// # Errors
    ///
    /// The polynomial is of another degree or not primitive.
    pub fn new(polynomial: u64) -> Result<Self> {
        let modulus = Modulus::new(polynomial).filter(|modulus| modulus.degree() >= 8).ok_or_else(|| {
            Error::Configuration(format!(
                "the polynomial {polynomial:#x} of a cyclic code is not of degree 8 to 32; want one such as 0x12b"
            ))
        })?;
        if !modulus.is_primitive() {
            return Err(Error::Configuration(format!(
                "the polynomial {polynomial:#x} of a cyclic code is not primitive, so that its sequence would be \
                 shorter than {}; want one such as 0x12b, 0x409, 0x1053 or 0x1100b",
                modulus.period()
            )));
        }
        Ok(Self::of(modulus))
    }

    /// The code of a polynomial of degree 8 that is known to be primitive, by its coefficients below x⁸.
    pub(crate) fn of_degree_8(lower: u8) -> Self {
        Self::of(Modulus::of_degree_8(lower))
    }

    fn of(modulus: Modulus) -> Self {
        let mut code = Self { modulus, states: Vec::new() };
        if modulus.degree() <= MAX_TABLE_DEGREE {
            let states = std::iter::successors(Some(1), |&state| Some(code.step(state)));
            code.states = states.take(modulus.period() as usize).map(|state| state as u16).collect();
        }
        code
    }

    /// Stages of the register.
    pub fn degree(&self) -> u32 {
        self.modulus.degree()
    }

    /// Steps after which the sequence repeats, 2^degree − 1: each tone from 1 to this comes once.
    pub fn period(&self) -> i64 {
        self.modulus.period() as i64
    }

    /// Tone after `n` steps, of 1 to the period; `n` below zero counts backwards.
    pub fn tone(&self, n: i64) -> u32 {
        let place = n.rem_euclid(self.period());
        match self.states.get(place as usize) {
            Some(&state) => u32::from(state),
            None => self.jump(n),
        }
    }

    /// Tone as [`Self::tone`], found without the table by a power of x.
    pub fn jump(&self, n: i64) -> u32 {
        let mut power = self.modulus.power_of_x(n.rem_euclid(self.period()) as u64);
        let mut tone = 0;
        for bit in 0..self.degree() {
            tone |= ((power & 1) as u32) << bit;
            power = self.modulus.times_x(power);
        }
        tone
    }

    /// State that follows one of the register.
    pub fn step(&self, state: u32) -> u32 {
        let fed_back = (u64::from(state) & self.modulus.lower()).count_ones() & 1;
        (state >> 1) | fed_back << (self.degree() - 1)
    }
}

impl Default for CyclicCode {
    /// The code of [`Self::DEFAULT_POLYNOMIAL`], which is primitive.
    fn default() -> Self {
        Self::of_degree_8(0x2b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polynomial::primitive_polynomials;
    use hedgehop_base::chance::Random;

    /// One primitive polynomial of each degree that is told of, and of a few more.
    const POLYNOMIALS: [u64; 8] =
        [0x12B, 0x409, 0x1053, 0x1100B, 0x10_0009, 0x100_0087, 0x8000_0009, 0x1_0040_0007];

    /// Any of all numbers.
    fn any(random: &mut Random) -> i64 {
        ((random.unit() - 0.5) * 1.8e19) as i64 ^ (random.unit() * 1e6) as i64
    }

    #[test]
    fn orders_are_whole_periods() {
        for polynomial in POLYNOMIALS {
            assert!(CyclicCode::new(polynomial).is_ok(), "{polynomial:#x}");
        }
        for (polynomial, period) in [(0x12B, 255), (0x1100B, 65535)] {
            let code = CyclicCode::new(polynomial).unwrap();
            let (mut state, mut steps) = (code.step(1), 1);
            while state != 1 {
                (state, steps) = (code.step(state), steps + 1);
            }
            assert_eq!((steps, code.period()), (period, period));
        }
        assert_eq!(CyclicCode::default(), CyclicCode::new(CyclicCode::DEFAULT_POLYNOMIAL).unwrap());
    }

    #[test]
    fn composites_and_strange_degrees_are_refused() {
        // The polynomials: even weight; irreducible, but of order 51 (the Rijndael field's); a square; no constant.
        for polynomial in [0x12A, 0x101, 0x11B, 0x155, 0x100] {
            let error = CyclicCode::new(polynomial).unwrap_err().to_string();
            assert!(error.contains("not primitive") && error.contains("0x12b"), "{error}");
        }
        for polynomial in [0, 1, 0x89, 0x3_0000_0000, u64::MAX] {
            let error = CyclicCode::new(polynomial).unwrap_err().to_string();
            assert!(error.contains("degree 8 to 32"), "{error}");
        }
    }

    #[test]
    fn jumps_equal_steps_of_all_polynomials() {
        for polynomial in primitive_polynomials(8) {
            let code = CyclicCode::new(polynomial).unwrap();
            let mut state = 1;
            for n in 0..600 {
                assert_eq!((code.jump(n), code.tone(n)), (state, state), "{polynomial:#x}, n = {n}");
                state = code.step(state);
            }
        }
    }

    #[test]
    fn jumps_equal_steps_at_a_million_places() {
        let mut random = Random(2);
        let codes: Vec<CyclicCode> =
            POLYNOMIALS[..4].iter().map(|&polynomial| CyclicCode::new(polynomial).unwrap()).collect();
        for _ in 0..250_000 {
            let n = any(&mut random);
            for code in &codes {
                assert_eq!(code.jump(n), code.tone(n), "n = {n}");
            }
        }
        for n in [i64::MIN, -255, -1, 0, 1, 1_000_000_007, 1 << 40, i64::MAX] {
            assert!(codes.iter().all(|code| code.jump(n) == code.tone(n)), "n = {n}");
        }
    }

    #[test]
    fn long_codes_step_from_wherever_they_jump_to() {
        let mut random = Random(5);
        for polynomial in &POLYNOMIALS[4..] {
            let code = CyclicCode::new(*polynomial).unwrap();
            assert_eq!(code.tone(0), 1);
            for _ in 0..300 {
                let n = any(&mut random) / 2;
                let state = code.tone(n);
                assert_eq!(code.tone(n + 1), code.step(state), "{polynomial:#x}, n = {n}");
                assert_eq!(code.tone(n + code.period()), state);
            }
            assert_eq!(code.step(code.tone(-1)), 1);
        }
    }

    #[test]
    fn tones_have_the_moments_of_the_study() {
        let tones: Vec<f64> = (0..255).map(|n| f64::from(CyclicCode::default().tone(n))).collect();
        let mean = tones.iter().sum::<f64>() / 255.0;
        let deviation = (tones.iter().map(|tone| (tone - mean).powi(2)).sum::<f64>() / 255.0).sqrt();
        assert_eq!(mean, 128.0);
        assert!((deviation - 73.6).abs() < 0.05, "{deviation}");

        // A state is mostly its predecessor, shifted.
        let correlation = |lag: usize| {
            let products = (0..255).map(|n| (tones[n] - mean) * (tones[(n + lag) % 255] - mean));
            products.sum::<f64>() / 255.0 / deviation.powi(2)
        };
        assert!((correlation(1) - 0.494).abs() < 0.001, "{}", correlation(1));
        assert!((correlation(4) - 0.051).abs() < 0.001, "{}", correlation(4));
    }
}
