//! NEON: four registers of four lanes, masks as lanes of all bits or none.

#![expect(unsafe_code, reason = "vector instructions; see the contract at `Neon`")]

use std::arch::aarch64::*;
use std::arch::{asm, is_aarch64_feature_detected};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

use super::{Each, Floats, Ints, Kernel, LANES, Mask, Simd};

/// Proof that this processor has NEON.
///
/// Contract: made only by [`Neon::detect`]; [`F`], [`I`], `U` and [`M`] are made only from it or from each
/// other. So whoever holds any of them runs on a processor that has their instructions.
#[derive(Debug, Clone, Copy)]
pub struct Neon(());

/// Sixteen f32.
#[derive(Clone, Copy)]
pub struct F(float32x4_t, float32x4_t, float32x4_t, float32x4_t);
/// Sixteen i32.
#[derive(Clone, Copy)]
pub struct I(int32x4_t, int32x4_t, int32x4_t, int32x4_t);
/// Sixteen u32, for instructions that differ by the sign.
#[derive(Clone, Copy)]
struct U(uint32x4_t, uint32x4_t, uint32x4_t, uint32x4_t);
/// Sixteen lanes of all bits or none.
#[derive(Clone, Copy)]
pub struct M(uint32x4_t, uint32x4_t, uint32x4_t, uint32x4_t);

impl Neon {
    pub fn detect() -> Option<Self> {
        is_aarch64_feature_detected!("neon").then_some(Self(()))
    }
}

/// An intrinsic on lanes.
macro_rules! lanes {
    ($e:expr) => {
        // SAFETY: lanes exist only where their instructions do, see `Neon`.
        unsafe { $e }
    };
}

/// The same intrinsic for all quarters, or a function with what it takes before them.
macro_rules! quarters {
    ($type:ident, $f:ident[$($before:expr),+], $a:expr) => {{
        let a = $a;
        lanes!($type($f($($before),+, a.0), $f($($before),+, a.1), $f($($before),+, a.2), $f($($before),+, a.3)))
    }};
    ($type:ident, $f:expr, $a:expr) => {{
        let a = $a;
        lanes!($type($f(a.0), $f(a.1), $f(a.2), $f(a.3)))
    }};
    ($type:ident, $f:expr, $a:expr, $b:expr) => {{
        let (a, b) = ($a, $b);
        lanes!($type($f(a.0, b.0), $f(a.1, b.1), $f(a.2, b.2), $f(a.3, b.3)))
    }};
    ($type:ident, $f:expr, $a:expr, $b:expr, $c:expr) => {{
        let (a, b, c) = ($a, $b, $c);
        lanes!($type($f(a.0, b.0, c.0), $f(a.1, b.1, c.1), $f(a.2, b.2, c.2), $f(a.3, b.3, c.3)))
    }};
}

/// One register for all quarters.
macro_rules! same {
    ($type:ident, $e:expr) => {{
        let quarter = lanes!($e);
        $type(quarter, quarter, quarter, quarter)
    }};
}

/// The quarters in memory, lane 0 first.
macro_rules! loaded {
    ($type:ident, $load:ident, $from:expr) => {{
        let from = $from.as_ptr();
        lanes!($type($load(from), $load(from.add(4)), $load(from.add(8)), $load(from.add(12))))
    }};
}

/// The quarters to memory, lane 0 first.
macro_rules! stored {
    ($store:ident, $lanes:expr, $target:expr) => {{
        let (lanes, to) = ($lanes, $target.as_mut_ptr());
        lanes!({
            $store(to, lanes.0);
            $store(to.add(4), lanes.1);
            $store(to.add(8), lanes.2);
            $store(to.add(12), lanes.3);
        });
    }};
}

macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                quarters!($type, $intrinsic, self, other)
            }
        }
    };
}
operator!(F, Add, add, vaddq_f32);
operator!(F, Sub, sub, vsubq_f32);
operator!(F, Mul, mul, vmulq_f32);
operator!(F, Div, div, vdivq_f32);
operator!(I, Add, add, vaddq_s32);
operator!(I, Sub, sub, vsubq_s32);
operator!(I, BitAnd, bitand, vandq_s32);
operator!(I, BitOr, bitor, vorrq_s32);
operator!(M, BitAnd, bitand, vandq_u32);
operator!(M, BitOr, bitor, vorrq_u32);

impl Not for M {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        quarters!(M, vmvnq_u32, self)
    }
}

impl F {
    /// 1/√self to 16 bits.
    #[inline(always)]
    fn rsqrt_rough(self) -> Self {
        // A Newton step from 8 bits; the instruction for it is (3 − self · guess²)/2.
        let guess = quarters!(F, vrsqrteq_f32, self);
        guess * quarters!(F, vrsqrtsq_f32, self * guess, guess)
    }
}

impl I {
    /// The same bits.
    #[inline(always)]
    fn unsigned(self) -> U {
        quarters!(U, vreinterpretq_u32_s32, self)
    }
}

impl U {
    /// The same bits.
    #[inline(always)]
    fn signed(self) -> I {
        quarters!(I, vreinterpretq_s32_u32, self)
    }
}

/// The bit of each lane in [`Mask::bits`].
#[inline(always)]
fn bit_of_each() -> U {
    static BITS: [u32; LANES] =
        [1, 2, 4, 8, 0x10, 0x20, 0x40, 0x80, 0x100, 0x200, 0x400, 0x800, 0x1000, 0x2000, 0x4000, 0x8000];
    loaded!(U, vld1q_u32, BITS)
}

/// Indices at which `width` elements of a table of `length` begin.
#[inline(always)]
fn clamped(index: I, length: usize, width: usize) -> U {
    assert!(length >= width);
    let last = (length - width).min(u32::MAX as usize) as u32;
    quarters!(U, vminq_u32, index.unsigned(), same!(U, vdupq_n_u32(last)))
}

/// Reads values at four elements of a table.
///
/// # Safety
/// The processor has NEON, and a `T` is there from each of the elements on.
#[inline(always)]
unsafe fn four_of<E, T: Copy>(from: *const E, index: uint32x4_t) -> [T; 4] {
    // SAFETY: the caller's.
    unsafe {
        [
            from.add(vgetq_lane_u32::<0>(index) as usize).cast::<T>().read_unaligned(),
            from.add(vgetq_lane_u32::<1>(index) as usize).cast::<T>().read_unaligned(),
            from.add(vgetq_lane_u32::<2>(index) as usize).cast::<T>().read_unaligned(),
            from.add(vgetq_lane_u32::<3>(index) as usize).cast::<T>().read_unaligned(),
        ]
    }
}

/// Four words of a table.
///
/// # Safety
/// The processor has NEON, and four bytes are there from each of the elements on.
#[inline(always)]
unsafe fn four_words<E>(from: *const E, index: uint32x4_t) -> int32x4_t {
    // SAFETY: the caller's.
    unsafe { vld1q_s32(four_of(from, index).as_ptr()) }
}

/// Four pairs of words: the first ones, and the second ones.
///
/// # Safety
/// The processor has NEON, and the indices and their successors are within the table.
#[inline(always)]
unsafe fn four_pairs(from: *const u32, index: uint32x4_t) -> (int32x4_t, int32x4_t) {
    // SAFETY: the caller's.
    unsafe {
        let pairs: [i64; 4] = four_of(from, index);
        let low = vreinterpretq_s32_s64(vld1q_s64(pairs.as_ptr()));
        let high = vreinterpretq_s32_s64(vld1q_s64(pairs.as_ptr().add(2)));
        (vuzp1q_s32(low, high), vuzp2q_s32(low, high))
    }
}

/// Bytes of sixteen in another order; 0 for places beyond.
///
/// # Safety
/// The processor has NEON, and sixteen bytes are there.
#[inline(always)]
unsafe fn ordered(from: *const u8, order: uint8x16_t) -> int32x4_t {
    // SAFETY: the caller's.
    unsafe { vreinterpretq_s32_u8(vqtbl1q_u8(vld1q_u8(from), order)) }
}

/// Four lanes of five bytes each: four of them, and the fifth.
///
/// # Safety
/// The processor has NEON, and twenty bytes are there.
#[inline(always)]
unsafe fn four_fives(from: *const u8) -> (int32x4_t, int32x4_t) {
    const FOUR: [u8; 16] = [0, 1, 2, 3, 5, 6, 7, 8, 10, 11, 12, 13, 15, 28, 29, 30];
    const FIFTH: [u8; 16] = [4, 99, 99, 99, 9, 99, 99, 99, 14, 99, 99, 99, 31, 99, 99, 99];
    // SAFETY: the caller's; sixteen bytes from 0 and from 4 on are read. Byte 16 is the second ones' place 12.
    unsafe {
        let bytes = uint8x16x2_t(vld1q_u8(from), vld1q_u8(from.add(4)));
        let four = vqtbl2q_u8(bytes, vld1q_u8(FOUR.as_ptr()));
        let fifth = vqtbl2q_u8(bytes, vld1q_u8(FIFTH.as_ptr()));
        (vreinterpretq_s32_u8(four), vreinterpretq_s32_u8(fifth))
    }
}

/// The smaller ones; the second where either is no number.
///
/// # Safety
/// The processor has NEON.
#[inline(always)]
unsafe fn smaller(a: float32x4_t, b: float32x4_t) -> float32x4_t {
    // The instruction for it takes what is no number from either side, and heeds the signs of zeros.
    // SAFETY: the caller's.
    unsafe { vbslq_f32(vcltq_f32(a, b), a, b) }
}

/// The larger ones; the second where either is no number.
///
/// # Safety
/// The processor has NEON.
#[inline(always)]
unsafe fn larger(a: float32x4_t, b: float32x4_t) -> float32x4_t {
    // SAFETY: the caller's.
    unsafe { vbslq_f32(vcgtq_f32(a, b), a, b) }
}

/// One lane of sixteen, by halves.
macro_rules! fold {
    ($lanes:expr, $four:ident) => {
        lanes!({
            let four = $four($four($lanes.0, $lanes.2), $four($lanes.1, $lanes.3));
            let two = $four(four, vextq_f32::<2>(four, four));
            vgetq_lane_f32::<0>($four(two, vextq_f32::<1>(two, two)))
        })
    };
}

/// Four pairs of words of 16 bits of a table of 32.
///
/// # Safety
/// The processor has NEON.
#[inline(always)]
unsafe fn near_pairs(near: uint8x16x4_t, index: int32x4_t) -> int32x4_t {
    // SAFETY: the caller's.
    unsafe {
        let places = vmlaq_n_s32(vdupq_n_s32(0x0302_0100), index, 0x0202_0202);
        vreinterpretq_s32_u8(vqtbl4q_u8(near, vreinterpretq_u8_s32(places)))
    }
}

/// Bytes of lanes as a table.
#[inline(always)]
fn bytes_of(lanes: F) -> uint8x16x4_t {
    quarters!(uint8x16x4_t, vreinterpretq_u8_f32, lanes)
}

/// Four of the 32 lanes of `low` and `high`.
///
/// # Safety
/// The processor has NEON.
#[inline(always)]
unsafe fn permute_quarter(low: F, high: F, index: int32x4_t) -> float32x4_t {
    // SAFETY: the caller's.
    unsafe {
        let places = vreinterpretq_u8_s32(vmlaq_n_s32(vdupq_n_s32(0x0302_0100), index, 0x0404_0404));
        // Places beyond a table leave what was there.
        let beyond = veorq_u8(places, vdupq_n_u8(64));
        let found = vqtbl4q_u8(bytes_of(low), places);
        vreinterpretq_f32_u8(vqtbx4q_u8(found, bytes_of(high), beyond))
    }
}

impl Simd for Neon {
    type F = F;
    type I = I;
    type M = M;

    #[inline]
    fn call<K: Kernel>(self, kernel: K) -> K::Output {
        // Callers have NEON too: without this they inline it.
        #[inline(never)]
        #[target_feature(enable = "neon")]
        fn inner<K: Kernel>(token: Neon, kernel: K) -> K::Output {
            kernel.run(token)
        }
        // SAFETY: the token proves the feature.
        unsafe { inner(self, kernel) }
    }
    #[inline(always)]
    fn splat(self, value: f32) -> F {
        same!(F, vdupq_n_f32(value))
    }
    #[inline(always)]
    fn splat_int(self, value: i32) -> I {
        same!(I, vdupq_n_s32(value))
    }
    #[inline(always)]
    fn load(self, values: &[f32; LANES]) -> F {
        loaded!(F, vld1q_f32, values)
    }
    #[inline(always)]
    fn load_ints(self, values: &[i32; LANES]) -> I {
        loaded!(I, vld1q_s32, values)
    }
    #[inline(always)]
    fn load_shorts(self, values: &[u16; LANES]) -> I {
        let from = values.as_ptr();
        lanes!({
            let (low, high) = (vld1q_u16(from), vld1q_u16(from.add(8)));
            let (first, third) = (vmovl_u16(vget_low_u16(low)), vmovl_u16(vget_low_u16(high)));
            U(first, vmovl_high_u16(low), third, vmovl_high_u16(high))
        })
        .signed()
    }
    #[inline(always)]
    fn load_triples(self, values: &[u8; 3 * LANES]) -> I {
        const ORDER: [u8; 16] = [0, 1, 2, 99, 3, 4, 5, 99, 6, 7, 8, 99, 9, 10, 11, 99];
        let from = values.as_ptr();
        // SAFETY: sixteen bytes from 0, 12, 24 and 32 on are read; the last twelve are in the last sixteen's places 4 to 16.
        unsafe {
            let order = vld1q_u8(ORDER.as_ptr());
            let last = vaddq_u8(order, vdupq_n_u8(4));
            I(
                ordered(from, order),
                ordered(from.add(12), order),
                ordered(from.add(24), order),
                ordered(from.add(32), last),
            )
        }
    }
    #[inline(always)]
    fn load_fives(self, values: &[u8; 5 * LANES]) -> [I; 2] {
        let from = values.as_ptr();
        // SAFETY: twenty bytes from 0, 20, 40 and 60 on are read, which is what there is.
        let [a, b, c, d] = unsafe {
            [four_fives(from), four_fives(from.add(20)), four_fives(from.add(40)), four_fives(from.add(60))]
        };
        [I(a.0, b.0, c.0, d.0), I(a.1, b.1, c.1, d.1)]
    }
    #[inline(always)]
    fn mask(self, bits: u16) -> M {
        quarters!(M, vtstq_u32, same!(U, vdupq_n_u32(u32::from(bits))), bit_of_each())
    }
    #[inline(always)]
    fn gather(self, table: &[f32], index: I) -> F {
        let index = clamped(index, table.len(), 1);
        // SAFETY: the indices are within the table.
        quarters!(I, four_words[table.as_ptr()], index).as_floats()
    }
    #[inline(always)]
    fn gather_words(self, table: &[u32], index: I) -> I {
        let index = clamped(index, table.len(), 1);
        // SAFETY: the indices are within the table.
        quarters!(I, four_words[table.as_ptr()], index)
    }
    #[inline(always)]
    fn gather_pairs(self, table: &[u16], index: I) -> I {
        let index = clamped(index, table.len(), 2);
        // SAFETY: the indices and their successors are within the table.
        quarters!(I, four_words[table.as_ptr()], index)
    }
    #[inline(always)]
    fn permute_pairs(self, near: &[u16; 2 * LANES], index: I) -> I {
        // SAFETY: 64 bytes are there.
        let near = unsafe { vld1q_u8_x4(near.as_ptr().cast()) };
        quarters!(I, near_pairs[near], index)
    }
    #[inline(always)]
    fn gather_word_pairs(self, table: &[u32], index: I) -> (I, I) {
        let index = clamped(index, table.len(), 2);
        let from = table.as_ptr();
        // SAFETY: the indices and their successors are within the table.
        let [a, b, c, d] = unsafe {
            [
                four_pairs(from, index.0),
                four_pairs(from, index.1),
                four_pairs(from, index.2),
                four_pairs(from, index.3),
            ]
        };
        (I(a.0, b.0, c.0, d.0), I(a.1, b.1, c.1, d.1))
    }
    #[inline(always)]
    fn prefetch<T>(self, table: &[T], index: usize) {
        let address = table.as_ptr().wrapping_add(index).addr();
        // SAFETY: a hint, which never faults, whatever the address.
        unsafe { asm!("prfm pldl1keep, [{}]", in(reg) address, options(nomem, nostack, preserves_flags)) };
    }
    #[inline(always)]
    fn store_triples(self, values: I, target: &mut [u8; 3 * LANES]) {
        // Bytes of two quarters: the twelve of one and four more, eight of either, four and the twelve.
        const FIRST: [u8; 16] = [0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 16, 17, 18, 20];
        const SECOND: [u8; 16] = [5, 6, 8, 9, 10, 12, 13, 14, 16, 17, 18, 20, 21, 22, 24, 25];
        const THIRD: [u8; 16] = [10, 12, 13, 14, 16, 17, 18, 20, 21, 22, 24, 25, 26, 28, 29, 30];
        let to = target.as_mut_ptr();
        // SAFETY: sixteen bytes from 0, 16 and 32 on are written, which is what the target has.
        unsafe {
            let [a, b, c, d] = [values.0, values.1, values.2, values.3].each(|x| vreinterpretq_u8_s32(x));
            vst1q_u8(to, vqtbl2q_u8(uint8x16x2_t(a, b), vld1q_u8(FIRST.as_ptr())));
            vst1q_u8(to.add(16), vqtbl2q_u8(uint8x16x2_t(b, c), vld1q_u8(SECOND.as_ptr())));
            vst1q_u8(to.add(32), vqtbl2q_u8(uint8x16x2_t(c, d), vld1q_u8(THIRD.as_ptr())));
        }
    }
    #[inline(always)]
    fn permute_neighbours(self, low: F, high: F, index: I) -> [F; 2] {
        let next = index + self.splat_int(1);
        [index, next].each(|index| quarters!(F, permute_quarter[low, high], index))
    }
}

impl Floats for F {
    type I = I;
    type M = M;

    #[inline(always)]
    fn mul_add(self, factor: Self, summand: Self) -> Self {
        quarters!(F, vfmaq_f32, summand, self, factor)
    }
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, summand: Self) -> Self {
        quarters!(F, vfmsq_f32, summand, self, factor)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        quarters!(F, smaller, self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        quarters!(F, larger, self, other)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        quarters!(F, vsqrtq_f32, self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        quarters!(F, vabsq_f32, self)
    }
    #[inline(always)]
    fn recip(self) -> Self {
        // Two Newton steps from 8 bits; the instruction for them is 2 − self · guess.
        let guess = quarters!(F, vrecpeq_f32, self);
        let guess = guess * quarters!(F, vrecpsq_f32, self, guess);
        guess * quarters!(F, vrecpsq_f32, self, guess)
    }
    #[inline(always)]
    fn rsqrt(self) -> Self {
        let guess = self.rsqrt_rough();
        guess * quarters!(F, vrsqrtsq_f32, self * guess, guess)
    }
    #[inline(always)]
    fn sqrt_rough(self) -> Self {
        self * self.rsqrt_rough()
    }
    #[inline(always)]
    fn to_int(self) -> I {
        quarters!(I, vcvtmq_s32_f32, self)
    }
    #[inline(always)]
    fn floor(self) -> Self {
        quarters!(F, vrndmq_f32, self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M {
        quarters!(M, vcltq_f32, self, other)
    }
    #[inline(always)]
    fn le(self, other: Self) -> M {
        quarters!(M, vcleq_f32, self, other)
    }
    #[inline(always)]
    fn select(self, mask: M, other: Self) -> Self {
        quarters!(F, vbslq_f32, mask, self, other)
    }
    #[inline(always)]
    fn least(self) -> f32 {
        fold!(self, smaller)
    }
    #[inline(always)]
    fn greatest(self) -> f32 {
        fold!(self, larger)
    }
    #[inline(always)]
    fn to_bits(self) -> I {
        quarters!(I, vreinterpretq_s32_f32, self)
    }
    #[inline(always)]
    fn store(self, target: &mut [f32; LANES]) {
        stored!(vst1q_f32, self, target);
    }
    #[inline(always)]
    fn store_masked(self, mask: M, target: &mut [f32; LANES]) {
        let others = loaded!(F, vld1q_f32, target);
        self.select(mask, others).store(target);
    }
}

impl Ints for I {
    type F = F;
    type M = M;

    #[inline(always)]
    fn to_float(self) -> F {
        quarters!(F, vcvtq_f32_s32, self)
    }
    #[inline(always)]
    fn as_floats(self) -> F {
        quarters!(F, vreinterpretq_f32_s32, self)
    }
    #[inline(always)]
    fn shr<const N: u32>(self) -> Self {
        // Left by less than nothing is right.
        quarters!(U, vshlq_u32, self.unsigned(), same!(I, vdupq_n_s32(-(N as i32)))).signed()
    }
    #[inline(always)]
    fn sar<const N: u32>(self) -> Self {
        quarters!(I, vshlq_s32, self, same!(I, vdupq_n_s32(-(N as i32))))
    }
    #[inline(always)]
    fn shl<const N: u32>(self) -> Self {
        quarters!(I, vshlq_s32, self, same!(I, vdupq_n_s32(N as i32)))
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        quarters!(I, vmulq_s32, self, other)
    }
    #[inline(always)]
    fn dot_halves(self, other: Self) -> Self {
        let low = |words: Self| words.shl::<16>().sar::<16>();
        low(self).mul(low(other)) + self.sar::<16>().mul(other.sar::<16>())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        quarters!(I, vminq_s32, self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        quarters!(I, vmaxq_s32, self, other)
    }
    #[inline(always)]
    fn eq(self, other: Self) -> M {
        quarters!(M, vceqq_s32, self, other)
    }
    #[inline(always)]
    fn gt(self, other: Self) -> M {
        quarters!(M, vcgtq_s32, self, other)
    }
    #[inline(always)]
    fn select(self, mask: M, other: Self) -> Self {
        quarters!(I, vbslq_s32, mask, self, other)
    }
    #[inline(always)]
    fn least(self, mask: M) -> i32 {
        let lanes = self.select(mask, same!(I, vdupq_n_s32(i32::MAX)));
        lanes!(vminvq_s32(vminq_s32(vminq_s32(lanes.0, lanes.1), vminq_s32(lanes.2, lanes.3))))
    }
    #[inline(always)]
    fn store(self, target: &mut [i32; LANES]) {
        stored!(vst1q_s32, self, target);
    }
    #[inline(always)]
    fn store_shorts(self, target: &mut [u16; LANES]) {
        let to = target.as_mut_ptr();
        let I(a, b, c, d) = self;
        lanes!({
            vst1q_u16(to, vreinterpretq_u16_s16(vcombine_s16(vmovn_s32(a), vmovn_s32(b))));
            vst1q_u16(to.add(8), vreinterpretq_u16_s16(vcombine_s16(vmovn_s32(c), vmovn_s32(d))));
        });
    }
}

impl Mask for M {
    #[inline(always)]
    fn any(self) -> bool {
        lanes!(vmaxvq_u32(vorrq_u32(vorrq_u32(self.0, self.1), vorrq_u32(self.2, self.3)))) != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        lanes!(vminvq_u32(vandq_u32(vandq_u32(self.0, self.1), vandq_u32(self.2, self.3)))) != 0
    }
    #[inline(always)]
    fn bits(self) -> u16 {
        let bits = quarters!(U, vandq_u32, self, bit_of_each());
        lanes!(vaddvq_u32(vorrq_u32(vorrq_u32(bits.0, bits.1), vorrq_u32(bits.2, bits.3)))) as u16
    }
}
