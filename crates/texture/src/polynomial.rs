//! Polynomials over the field of two elements, a bit for each power of x.
//!
//! Arithmetic modulo a polynomial p of degree m:
//!
//! ```text
//! a·b:  for each bit of b, lowest first: add a to the sum where the bit is set, a = a·x, less p if a reaches degree m
//! x^n:  square and multiply, at most 2·m products
//! p is primitive  ⇔  x^(2^m − 1) = 1 and, for each prime factor q of 2^m − 1, x^((2^m − 1)/q) ≠ 1
//! ```

/// Polynomial modulo which others are taken, of degree 1 to 32.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Modulus {
    bits: u64,
    degree: u32,
}

impl Modulus {
    /// Takes the polynomial of these bits; `None` if its degree is not 1 to 32.
    pub fn new(bits: u64) -> Option<Self> {
        let degree = bits.checked_ilog2()?;
        (1..=32).contains(&degree).then_some(Self { bits, degree })
    }

    /// Polynomial of degree 8 with these coefficients below x⁸.
    pub const fn of_degree_8(lower: u8) -> Self {
        Self { bits: 0x100 | lower as u64, degree: 8 }
    }

    /// Greatest power of x.
    pub fn degree(self) -> u32 {
        self.degree
    }

    /// Coefficients below the greatest power.
    pub fn lower(self) -> u64 {
        self.bits ^ (1 << self.degree)
    }

    /// Number of polynomials other than zero, which is the period of x if this one is primitive.
    pub fn period(self) -> u64 {
        (1 << self.degree) - 1
    }

    /// Product of a polynomial of lower degree with x.
    pub fn times_x(self, factor: u64) -> u64 {
        let shifted = factor << 1;
        if shifted >> self.degree == 0 { shifted } else { shifted ^ self.bits }
    }

    /// Returns xⁿ.
    pub fn power_of_x(self, n: u64) -> u64 {
        let mut power = self.times_x(1);
        let mut product = 1;
        let mut left = n;
        while left > 0 {
            if left & 1 == 1 {
                product = self.product(product, power);
            }
            power = self.product(power, power);
            left >>= 1;
        }
        product
    }

    /// Whether powers of x are all polynomials but zero.
    pub fn is_primitive(self) -> bool {
        let period = self.period();
        self.power_of_x(period) == 1
            && prime_factors(period).into_iter().all(|prime| self.power_of_x(period / prime) != 1)
    }

    fn product(self, a: u64, b: u64) -> u64 {
        let (mut shifted, mut sum) = (a, 0);
        let mut left = b;
        while left > 0 {
            if left & 1 == 1 {
                sum ^= shifted;
            }
            shifted = self.times_x(shifted);
            left >>= 1;
        }
        sum
    }
}

/// All primitive polynomials of a degree of 1 to 32, ascending, a bit for each power of x; none of other
/// degrees.
pub fn primitive_polynomials(degree: u32) -> impl Iterator<Item = u64> {
    let lowest = if (1..=32).contains(&degree) { 1_u64 << degree } else { 0 };
    (lowest..2 * lowest).filter(|&bits| Modulus::new(bits).is_some_and(Modulus::is_primitive))
}

fn prime_factors(number: u64) -> Vec<u64> {
    let mut factors = Vec::new();
    let mut left = number;
    let mut divisor = 2;
    while divisor * divisor <= left {
        if left.is_multiple_of(divisor) {
            factors.push(divisor);
            while left.is_multiple_of(divisor) {
                left /= divisor;
            }
        }
        divisor += 1;
    }
    if left > 1 {
        factors.push(left);
    }
    factors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn primitive_polynomials_of_degree_8_are_sixteen() {
        let listed = [
            0x11D, 0x12B, 0x12D, 0x14D, 0x15F, 0x163, 0x165, 0x169, 0x171, 0x187, 0x18D, 0x1A9, 0x1C3, 0x1CF,
            0x1E7, 0x1F5,
        ];
        assert!(primitive_polynomials(8).eq(listed));

        // A polynomial and the same read backwards make one sequence in both directions: eight remain.
        let backwards = |bits: u64| bits.reverse_bits() >> (63 - 8);
        let mut pairs: Vec<u64> = listed.iter().map(|&bits| bits.min(backwards(bits))).collect();
        pairs.sort_unstable();
        pairs.dedup();
        assert_eq!(pairs.len(), 8);
    }

    #[test]
    fn primitive_polynomials_are_as_many_as_euler_says() {
        // φ(2^m − 1)/m of each degree m.
        for (degree, count) in [(1, 1), (2, 1), (3, 2), (4, 2), (9, 48), (10, 60), (11, 176), (12, 144)] {
            assert_eq!(primitive_polynomials(degree).count(), count, "degree {degree}");
        }
        assert_eq!(primitive_polynomials(0).count() + primitive_polynomials(33).count(), 0);
    }

    #[test]
    fn powers_are_repeated_products() {
        let modulus = Modulus::new(0x1100B).unwrap();
        let mut power = 1;
        for n in 0..2000 {
            assert_eq!(modulus.power_of_x(n), power, "n = {n}");
            power = modulus.times_x(power);
        }
    }
}
