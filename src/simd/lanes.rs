//! Operations on sixteen lanes.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

/// Lanes of every type here.
pub const LANES: usize = 16;

/// Sixteen f32 in memory, in one cache line: lanes that straddle two take twice as long.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct Sixteen(pub [f32; LANES]);

impl Default for Sixteen {
    #[inline(always)]
    fn default() -> Self {
        Self([0.0; LANES])
    }
}

/// Work that is written for any instruction set.
pub trait Kernel {
    /// Type of the result.
    type Output;
    /// Does it. Implementations are `#[inline(always)]`, or the set's instructions are not used.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// An instruction set: makes lanes, and reads memory into them.
pub trait Simd: Copy {
    /// Sixteen f32.
    type F: Floats<I = Self::I, M = Self::M>;
    /// Sixteen i32.
    type I: Ints<F = Self::F, M = Self::M>;
    /// Sixteen yes or no.
    type M: Mask;

    /// Runs a kernel as a function of its own that is compiled for the set.
    ///
    /// Whatever is large and needed in several places goes through here, and whatever is rare: inlined, each place has a copy
    /// that takes seconds to compile; as an ordinary function it lacks the set's instructions, and every operator is a call.
    fn call<K: Kernel>(self, kernel: K) -> K::Output;

    /// All lanes the same.
    fn splat(self, value: f32) -> Self::F;
    /// All lanes the same.
    fn splat_int(self, value: i32) -> Self::I;
    /// Loads floats from memory, lane 0 first.
    fn load(self, values: &[f32; LANES]) -> Self::F;
    /// Loads integers from memory, lane 0 first.
    fn load_ints(self, values: &[i32; LANES]) -> Self::I;
    /// Loads 16-bit integers from memory, lane 0 first.
    fn load_shorts(self, values: &[u16; LANES]) -> Self::I;
    /// Three bytes a lane from memory, lane 0 first; the first is the lowest, and the highest byte is 0.
    fn load_triples(self, values: &[u8; 3 * LANES]) -> Self::I;
    /// Five bytes a lane from memory, lane 0 first: four of them, the first is the lowest, and the last one alone.
    fn load_fives(self, values: &[u8; 5 * LANES]) -> [Self::I; 2];
    /// Bit n of `bits` is lane n.
    fn mask(self, bits: u16) -> Self::M;
    /// `table[index]` of each lane; an index outside is taken to the last.
    fn gather(self, table: &[f32], index: Self::I) -> Self::F;
    /// `table[index]` of each lane; an index outside is taken to the last.
    fn gather_words(self, table: &[u32], index: Self::I) -> Self::I;
    /// `table[index] | table[index + 1] << 16` of each lane, an index outside is taken to the last
    /// pair. `table` has two elements at least.
    fn gather_pairs(self, table: &[u16], index: Self::I) -> Self::I;
    /// `near[index] | near[index + 1] << 16` of each lane, whose `index` is 0…30.
    fn permute_pairs(self, near: &[u16; 2 * LANES], index: Self::I) -> Self::I;
    /// `(table[index], table[index + 1])` of each lane, an index outside is taken to the last pair.
    /// `table` has two elements at least.
    fn gather_word_pairs(self, table: &[u32], index: Self::I) -> (Self::I, Self::I);
    /// Has the processor fetch `table[index]` while it does other work; an index outside is no harm.
    fn prefetch<T>(self, table: &[T], index: usize);
    /// The low three bytes of each lane to memory, lane 0 first, lowest byte first.
    fn store_triples(self, values: Self::I, target: &mut [u8; 3 * LANES]);
    /// Lanes `index` (0…30) and `index + 1` of the 32 lanes of `low` and `high`.
    fn permute_neighbours(self, low: Self::F, high: Self::F, index: Self::I) -> [Self::F; 2];
}

/// Sixteen f32.
pub trait Floats:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Integers of the same set.
    type I;
    /// Masks of the same set.
    type M;

    /// `self · factor + summand`, rounded once or twice.
    fn mul_add(self, factor: Self, summand: Self) -> Self;
    /// `summand − self · factor`, rounded once or twice.
    fn neg_mul_add(self, factor: Self, summand: Self) -> Self;
    /// The smaller one; `other` where either is no number.
    fn min(self, other: Self) -> Self;
    /// The larger one; `other` where either is no number.
    fn max(self, other: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Without sign.
    fn abs(self) -> Self;
    /// 1/self within 4·10⁻⁷ of it; of no particular value for 0.
    fn recip(self) -> Self;
    /// 1/√self within 4·10⁻⁷ of it, for self > 0.
    fn rsqrt(self) -> Self;
    /// √self within 10⁻⁴ of it, for self > 0.
    fn sqrt_rough(self) -> Self;
    /// Down to the integer below, for values from 0 to 4,000,000 and whole ones from −4,000,000; others have no particular value.
    fn to_int(self) -> Self::I;
    /// Down to the integer below.
    fn floor(self) -> Self;
    /// self < other
    fn lt(self, other: Self) -> Self::M;
    /// self ≤ other
    fn le(self, other: Self) -> Self::M;
    /// `self` where the mask is set, else `other`.
    fn select(self, mask: Self::M, other: Self) -> Self;
    /// Least lane.
    fn least(self) -> f32;
    /// Greatest lane.
    fn greatest(self) -> f32;
    /// The bits.
    fn to_bits(self) -> Self::I;
    /// Stores to memory, lane 0 first.
    fn store(self, target: &mut [f32; LANES]);
    /// Lanes of the mask to memory; the others stay.
    fn store_masked(self, mask: Self::M, target: &mut [f32; LANES]);
}

/// Sixteen i32.
pub trait Ints:
    Copy + Add<Output = Self> + Sub<Output = Self> + BitAnd<Output = Self> + BitOr<Output = Self>
{
    /// Floats of the same set.
    type F;
    /// Masks of the same set.
    type M;

    /// Nearest f32.
    fn to_float(self) -> Self::F;
    /// The bits as floats.
    fn as_floats(self) -> Self::F;
    /// Logical shift right.
    fn shr<const N: u32>(self) -> Self;
    /// Shift right that keeps the sign.
    fn sar<const N: u32>(self) -> Self;
    /// Shift left.
    fn shl<const N: u32>(self) -> Self;
    /// Low 32 bits of the product.
    fn mul(self, other: Self) -> Self;
    /// Sum of the products of both signed halves, −32,768 to 32,767.
    fn dot_halves(self, other: Self) -> Self;
    /// The smaller one.
    fn min(self, other: Self) -> Self;
    /// The larger one.
    fn max(self, other: Self) -> Self;
    /// self = other
    fn eq(self, other: Self) -> Self::M;
    /// self > other
    fn gt(self, other: Self) -> Self::M;
    /// `self` where the mask is set, else `other`.
    fn select(self, mask: Self::M, other: Self) -> Self;
    /// Least lane among those of the mask; i32::MAX if there is none.
    fn least(self, mask: Self::M) -> i32;
    /// Stores to memory, lane 0 first.
    fn store(self, target: &mut [i32; LANES]);
    /// Stores lanes of 0 to 65,535 to memory, lane 0 first.
    fn store_shorts(self, target: &mut [u16; LANES]);
}

/// Sixteen yes or no.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Any lane set?
    fn any(self) -> bool;
    /// All lanes set?
    fn all(self) -> bool;
    /// Bit n is lane n.
    fn bits(self) -> u16;
}
