//! Lanes as arrays: what every target has, and the twin that the others are tested against.
//!
//! Functions of several instructions an element stay out of line: kernels take longer to compile with them, and are no faster
//! for it.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

use super::{Floats, Ints, Kernel, LANES, Mask, Simd};

/// Any processor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Portable;

/// Sixteen f32.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub struct F([f32; LANES]);

/// Sixteen i32.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub struct I([i32; LANES]);

/// All bits of a lane, or none.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub struct M([u32; LANES]);

/// Array of what an expression is for each lane, written out. As a loop every operator would be inlined as one, and
/// compilers take minutes over kernels of some thousand loops.
macro_rules! lanes {
    (|$lane:ident| $value:expr) => {
        lanes!(@ $lane $value; 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15)
    };
    (@ $lane:ident $value:expr; $($number:literal)*) => {
        [$({
            let $lane: usize = $number;
            $value
        }),*]
    };
}

/// Array of what an expression is for each element of an array.
macro_rules! each {
    ($of:expr, |$a:ident| $value:expr) => {{
        let all = $of;
        lanes!(|lane| {
            let $a = all[lane];
            $value
        })
    }};
}

/// Array of what an expression is for each pair of elements of two arrays.
macro_rules! both {
    ($of:expr, $and:expr, |$a:ident, $b:ident| $value:expr) => {{
        let (all, others) = ($of, $and);
        lanes!(|lane| {
            let ($a, $b) = (all[lane], others[lane]);
            $value
        })
    }};
}

/// One of sixteen lanes, by halves.
macro_rules! halve {
    ($of:expr, |$a:ident, $b:ident| $value:expr) => {{
        let mut all = $of;
        halve!(@ all $a $b $value; 0 8, 1 9, 2 10, 3 11, 4 12, 5 13, 6 14, 7 15, 0 4, 1 5, 2 6, 3 7, 0 2, 1 3, 0 1);
        all[0]
    }};
    (@ $all:ident $a:ident $b:ident $value:expr; $($low:literal $high:literal),*) => {
        $(
            let ($a, $b) = ($all[$low], $all[$high]);
            $all[$low] = $value;
        )*
    };
}

/// Summand that brings the whole part of a number into the lowest bits, if it is less than [`LARGEST`]. Rust's own
/// conversion saturates, for which the oldest x86 needs several instructions an element.
const WHOLE: f32 = 1.5 * 8_388_608.0;
const LARGEST: f32 = 4_194_304.0;

#[inline(always)]
fn yes(condition: bool) -> u32 {
    0_u32.wrapping_sub(u32::from(condition))
}

macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, |$a:ident, $b:ident| $body:expr) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(both!(self.0, other.0, |$a, $b| $body))
            }
        }
    };
}
operator!(F, Add, add, |a, b| a + b);
operator!(F, Sub, sub, |a, b| a - b);
operator!(F, Mul, mul, |a, b| a * b);
operator!(F, Div, div, |a, b| a / b);
operator!(I, Add, add, |a, b| a.wrapping_add(b));
operator!(I, Sub, sub, |a, b| a.wrapping_sub(b));
operator!(I, BitAnd, bitand, |a, b| a & b);
operator!(I, BitOr, bitor, |a, b| a | b);
operator!(M, BitAnd, bitand, |a, b| a & b);
operator!(M, BitOr, bitor, |a, b| a | b);

impl Not for M {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(each!(self.0, |a| !a))
    }
}

impl Simd for Portable {
    type F = F;
    type I = I;
    type M = M;

    #[inline(never)]
    fn call<K: Kernel>(self, kernel: K) -> K::Output {
        kernel.run(self)
    }
    #[inline(always)]
    fn splat(self, value: f32) -> F {
        F([value; LANES])
    }
    #[inline(always)]
    fn splat_int(self, value: i32) -> I {
        I([value; LANES])
    }
    #[inline(always)]
    fn load(self, values: &[f32; LANES]) -> F {
        F(*values)
    }
    #[inline(always)]
    fn load_ints(self, values: &[i32; LANES]) -> I {
        I(*values)
    }
    #[inline(never)]
    fn load_shorts(self, values: &[u16; LANES]) -> I {
        I(each!(*values, |a| i32::from(a)))
    }
    #[inline(never)]
    fn load_triples(self, values: &[u8; 3 * LANES]) -> I {
        I(lanes!(|lane| {
            let at = 3 * lane;
            i32::from_le_bytes([values[at], values[at + 1], values[at + 2], 0])
        }))
    }
    #[inline(never)]
    fn load_fives(self, values: &[u8; 5 * LANES]) -> [I; 2] {
        let four = lanes!(|lane| {
            let at = 5 * lane;
            i32::from_le_bytes([values[at], values[at + 1], values[at + 2], values[at + 3]])
        });
        [I(four), I(lanes!(|lane| i32::from(values[5 * lane + 4])))]
    }
    #[inline(never)]
    fn mask(self, bits: u16) -> M {
        M(lanes!(|lane| yes(bits >> lane & 1 != 0)))
    }
    #[inline(never)]
    fn gather(self, table: &[f32], index: I) -> F {
        let last = table.len() - 1;
        F(each!(index.0, |index| table[(index as u32 as usize).min(last)]))
    }
    #[inline(never)]
    fn gather_words(self, table: &[u32], index: I) -> I {
        let last = table.len() - 1;
        I(each!(index.0, |index| table[(index as u32 as usize).min(last)] as i32))
    }
    #[inline(never)]
    fn gather_pairs(self, table: &[u16], index: I) -> I {
        let last = table.len() - 2;
        I(each!(index.0, |index| {
            let index = (index as u32 as usize).min(last);
            (u32::from(table[index]) | u32::from(table[index + 1]) << 16) as i32
        }))
    }
    #[inline(never)]
    fn permute_pairs(self, near: &[u16; 2 * LANES], index: I) -> I {
        I(each!(index.0, |index| {
            let (low, high) = (near[index as usize % (2 * LANES)], near[(index + 1) as usize % (2 * LANES)]);
            i32::from(low) | i32::from(high) << 16
        }))
    }
    #[inline(never)]
    fn gather_word_pairs(self, table: &[u32], index: I) -> (I, I) {
        let last = table.len() - 2;
        let first: [usize; LANES] = each!(index.0, |index| (index as u32 as usize).min(last));
        (I(each!(first, |index| table[index] as i32)), I(each!(first, |index| table[index + 1] as i32)))
    }
    #[inline(always)]
    fn prefetch<T>(self, _: &[T], _: usize) {}
    #[inline(never)]
    fn store_triples(self, values: I, target: &mut [u8; 3 * LANES]) {
        // Four lanes make three words.
        for (target, lanes) in target.as_chunks_mut::<12>().0.iter_mut().zip(values.0.as_chunks::<4>().0) {
            let [a, b, c, d] = lanes.map(|lane| lane as u32 & 0xff_ffff);
            let words = [a | b << 24, b >> 8 | c << 16, c >> 16 | d << 8];
            for (target, word) in target.as_chunks_mut::<4>().0.iter_mut().zip(words) {
                *target = word.to_le_bytes();
            }
        }
    }
    #[inline(never)]
    fn permute_neighbours(self, low: F, high: F, index: I) -> [F; 2] {
        let mut all = [0.0; 2 * LANES];
        all[..LANES].copy_from_slice(&low.0);
        all[LANES..].copy_from_slice(&high.0);
        [
            F(each!(index.0, |index| all[index as usize % (2 * LANES)])),
            F(each!(index.0, |index| all[(index + 1) as usize % (2 * LANES)])),
        ]
    }
}

impl Floats for F {
    type I = I;
    type M = M;

    #[inline(always)]
    fn mul_add(self, factor: Self, summand: Self) -> Self {
        self * factor + summand
    }
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, summand: Self) -> Self {
        summand - self * factor
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(both!(self.0, other.0, |a, b| if a < b { a } else { b }))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(both!(self.0, other.0, |a, b| if a > b { a } else { b }))
    }
    #[inline(never)]
    fn sqrt(self) -> Self {
        Self(each!(self.0, |a| a.sqrt()))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(each!(self.0, |a| a.abs()))
    }
    #[inline(never)]
    fn recip(self) -> Self {
        Self(each!(self.0, |a| 1.0 / a))
    }
    #[inline(never)]
    fn rsqrt(self) -> Self {
        Self(each!(self.0, |a| 1.0 / a.sqrt()))
    }
    #[inline(always)]
    fn sqrt_rough(self) -> Self {
        self.sqrt()
    }
    #[inline(never)]
    fn to_int(self) -> I {
        I(each!(self.0, |a| {
            let nearest = a + WHOLE;
            nearest.to_bits().wrapping_sub(WHOLE.to_bits()) as i32 - i32::from(nearest - WHOLE > a)
        }))
    }
    #[inline(never)]
    fn floor(self) -> Self {
        Self(each!(self.0, |a| {
            let nearest = (a + WHOLE) - WHOLE;
            let below = nearest - if nearest > a { 1.0 } else { 0.0 };
            if a.abs() < LARGEST { below } else { a }
        }))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M {
        M(both!(self.0, other.0, |a, b| yes(a < b)))
    }
    #[inline(always)]
    fn le(self, other: Self) -> M {
        M(both!(self.0, other.0, |a, b| yes(a <= b)))
    }
    #[inline(always)]
    fn select(self, mask: M, other: Self) -> Self {
        self.to_bits().select(mask, other.to_bits()).as_floats()
    }
    #[inline(never)]
    fn least(self) -> f32 {
        halve!(self.0, |a, b| if a < b { a } else { b })
    }
    #[inline(never)]
    fn greatest(self) -> f32 {
        halve!(self.0, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn to_bits(self) -> I {
        I(each!(self.0, |a| a.to_bits() as i32))
    }
    #[inline(always)]
    fn store(self, target: &mut [f32; LANES]) {
        *target = self.0;
    }
    #[inline(always)]
    fn store_masked(self, mask: M, target: &mut [f32; LANES]) {
        *target = self.select(mask, Self(*target)).0;
    }
}

impl Ints for I {
    type F = F;
    type M = M;

    #[inline(always)]
    fn to_float(self) -> F {
        F(each!(self.0, |a| a as f32))
    }
    #[inline(always)]
    fn as_floats(self) -> F {
        F(each!(self.0, |a| f32::from_bits(a as u32)))
    }
    #[inline(always)]
    fn shr<const N: u32>(self) -> Self {
        Self(each!(self.0, |a| (a as u32 >> N) as i32))
    }
    #[inline(always)]
    fn sar<const N: u32>(self) -> Self {
        Self(each!(self.0, |a| a >> N))
    }
    #[inline(always)]
    fn shl<const N: u32>(self) -> Self {
        Self(each!(self.0, |a| a << N))
    }
    #[inline(never)]
    fn mul(self, other: Self) -> Self {
        Self(both!(self.0, other.0, |a, b| a.wrapping_mul(b)))
    }
    #[inline(never)]
    fn dot_halves(self, other: Self) -> Self {
        let halves = |word: i32| [word as i16, (word >> 16) as i16].map(i32::from);
        let dot = |[a, b]: [i32; 2], [c, d]: [i32; 2]| a.wrapping_mul(c).wrapping_add(b.wrapping_mul(d));
        Self(both!(self.0, other.0, |a, b| dot(halves(a), halves(b))))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(both!(self.0, other.0, |a, b| if a < b { a } else { b }))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(both!(self.0, other.0, |a, b| if a > b { a } else { b }))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> M {
        M(both!(self.0, other.0, |a, b| yes(a == b)))
    }
    #[inline(always)]
    fn gt(self, other: Self) -> M {
        M(both!(self.0, other.0, |a, b| yes(a > b)))
    }
    #[inline(always)]
    fn select(self, mask: M, other: Self) -> Self {
        let chosen = both!(self.0, mask.0, |a, mask| a & mask as i32);
        let others = both!(other.0, mask.0, |a, mask| a & !mask as i32);
        Self(both!(chosen, others, |a, b| a | b))
    }
    #[inline(never)]
    fn least(self, mask: M) -> i32 {
        halve!(self.select(mask, Self([i32::MAX; LANES])).0, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn store(self, target: &mut [i32; LANES]) {
        *target = self.0;
    }
    #[inline(always)]
    fn store_shorts(self, target: &mut [u16; LANES]) {
        *target = each!(self.0, |a| a as u16);
    }
}

impl Mask for M {
    #[inline(always)]
    fn any(self) -> bool {
        halve!(self.0, |a, b| a | b) != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        halve!(self.0, |a, b| a & b) == u32::MAX
    }
    #[inline(never)]
    fn bits(self) -> u16 {
        let bits: [u32; LANES] = lanes!(|lane| (self.0[lane] & 1) << lane);
        halve!(bits, |a, b| a | b) as u16
    }
}
