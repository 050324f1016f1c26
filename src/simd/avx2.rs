//! AVX2: two registers of eight lanes, masks as lanes of all bits or none.

#![expect(unsafe_code, reason = "vector instructions; see the contract at `Avx2`")]

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

use super::{Floats, Ints, Kernel, LANES, Mask, Simd};

/// Proof that this processor has AVX2 and FMA.
///
/// Contract: made only by [`Avx2::detect`]; [`F`], [`I`] and [`M`] are made only from it or from each
/// other. So whoever holds any of them runs on a processor that has their instructions.
#[derive(Debug, Clone, Copy)]
pub struct Avx2(());

/// Sixteen f32.
#[derive(Clone, Copy)]
pub struct F(__m256, __m256);
/// Sixteen i32.
#[derive(Clone, Copy)]
pub struct I(__m256i, __m256i);
/// Sixteen lanes of all bits or none.
#[derive(Clone, Copy)]
pub struct M(__m256, __m256);

impl Avx2 {
    pub fn detect() -> Option<Self> {
        let has = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2");
        has.then_some(Self(()))
    }
}

/// An intrinsic on lanes.
macro_rules! lanes {
    ($e:expr) => {
        // SAFETY: lanes exist only where their instructions do, see `Avx2`.
        unsafe { $e }
    };
}

/// The same intrinsic for both halves.
macro_rules! halves {
    ($type:ident, $f:expr, $a:expr) => {{
        let a = $a;
        lanes!($type($f(a.0), $f(a.1)))
    }};
    ($type:ident, $f:expr, $a:expr, $b:expr) => {{
        let (a, b) = ($a, $b);
        lanes!($type($f(a.0, b.0), $f(a.1, b.1)))
    }};
    ($type:ident, $f:expr, $a:expr, $b:expr, $c:expr) => {{
        let (a, b, c) = ($a, $b, $c);
        lanes!($type($f(a.0, b.0, c.0), $f(a.1, b.1, c.1)))
    }};
}

macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                halves!($type, $intrinsic, self, other)
            }
        }
    };
}
operator!(F, Add, add, _mm256_add_ps);
operator!(F, Sub, sub, _mm256_sub_ps);
operator!(F, Mul, mul, _mm256_mul_ps);
operator!(F, Div, div, _mm256_div_ps);
operator!(I, Add, add, _mm256_add_epi32);
operator!(I, Sub, sub, _mm256_sub_epi32);
operator!(I, BitAnd, bitand, _mm256_and_si256);
operator!(I, BitOr, bitor, _mm256_or_si256);
operator!(M, BitAnd, bitand, _mm256_and_ps);
operator!(M, BitOr, bitor, _mm256_or_ps);

impl Not for M {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        let ones = lanes!(_mm256_castsi256_ps(_mm256_set1_epi32(-1)));
        halves!(M, _mm256_xor_ps, self, M(ones, ones))
    }
}

#[inline(always)]
fn constant(value: f32) -> F {
    let half = lanes!(_mm256_set1_ps(value));
    F(half, half)
}

/// Indices at which `width` elements of a table of `length` begin.
#[inline(always)]
fn clamped(index: I, length: usize, width: usize) -> I {
    assert!(length >= width);
    let last = lanes!(_mm256_set1_epi32((length - width).min(i32::MAX as usize / 8) as i32));
    halves!(I, _mm256_min_epu32, index, I(last, last))
}

/// Eight pairs of words: the first ones, and the second ones. A function and not a closure: those are not compiled for
/// the set.
///
/// # Safety
/// The processor has AVX2, and the indices and their successors are within the table.
#[inline(always)]
unsafe fn pairs_of_eight(from: *const i64, index: __m256i) -> (__m256i, __m256i) {
    // SAFETY: the caller's.
    unsafe {
        let low = _mm256_i32gather_epi64::<4>(from, _mm256_castsi256_si128(index));
        let high = _mm256_i32gather_epi64::<4>(from, _mm256_extracti128_si256::<1>(index));
        let (low, high) = (_mm256_castsi256_ps(low), _mm256_castsi256_ps(high));
        let first = _mm256_castps_si256(_mm256_shuffle_ps::<0b10_00_10_00>(low, high));
        let second = _mm256_castps_si256(_mm256_shuffle_ps::<0b11_01_11_01>(low, high));
        (_mm256_permute4x64_epi64::<0b11_01_10_00>(first), _mm256_permute4x64_epi64::<0b11_01_10_00>(second))
    }
}

/// Eight lanes of three bytes each.
///
/// # Safety
/// The processor has AVX2, and 24 bytes are there.
#[inline(always)]
unsafe fn eight_triples(from: *const u8) -> __m256i {
    // SAFETY: the caller's; sixteen bytes from 0 and from 8 on are read.
    unsafe {
        let halves = _mm256_loadu2_m128i(from.add(8).cast(), from.cast());
        let order = _mm256_setr_epi8(
            0, 1, 2, -1, 3, 4, 5, -1, 6, 7, 8, -1, 9, 10, 11, -1, // four from byte 0 on
            4, 5, 6, -1, 7, 8, 9, -1, 10, 11, 12, -1, 13, 14, 15, -1, // four from byte 12 on
        );
        _mm256_shuffle_epi8(halves, order)
    }
}

/// Eight lanes of five bytes each: four of them, and the fifth.
///
/// # Safety
/// The processor has AVX2, and 40 bytes are there.
#[inline(always)]
unsafe fn eight_fives(from: *const u8) -> (__m256i, __m256i) {
    // SAFETY: the caller's; sixteen bytes from 0, 4, 20 and 24 on are read.
    unsafe {
        let first = _mm256_loadu2_m128i(from.add(20).cast(), from.cast());
        let last = _mm256_loadu2_m128i(from.add(24).cast(), from.add(4).cast());
        let three = _mm_setr_epi8(0, 1, 2, 3, 5, 6, 7, 8, 10, 11, 12, 13, -1, -1, -1, -1);
        let fourth = _mm_setr_epi8(-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, 11, 12, 13, 14);
        let fifth = _mm_setr_epi8(0, -1, -1, -1, 5, -1, -1, -1, 10, -1, -1, -1, 15, -1, -1, -1);
        let four = _mm256_or_si256(
            _mm256_shuffle_epi8(first, _mm256_broadcastsi128_si256(three)),
            _mm256_shuffle_epi8(last, _mm256_broadcastsi128_si256(fourth)),
        );
        (four, _mm256_shuffle_epi8(last, _mm256_broadcastsi128_si256(fifth)))
    }
}

/// One lane of sixteen, by halves.
macro_rules! fold {
    ($lanes:expr, $eight:ident, $four:ident) => {
        lanes!({
            let eight = $eight($lanes.0, $lanes.1);
            let four = $four(_mm256_castps256_ps128(eight), _mm256_extractf128_ps::<1>(eight));
            let two = $four(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32($four(two, _mm_movehdup_ps(two)))
        })
    };
}

/// Eight of the 32 lanes of `low` and `high`.
#[inline(always)]
fn permute_half(low: F, high: F, index: __m256i) -> __m256 {
    lanes!({
        let eight = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(index));
        let sixteen = _mm256_castsi256_ps(_mm256_slli_epi32::<27>(index));
        let a = _mm256_permutevar8x32_ps(low.0, index);
        let b = _mm256_permutevar8x32_ps(low.1, index);
        let c = _mm256_permutevar8x32_ps(high.0, index);
        let d = _mm256_permutevar8x32_ps(high.1, index);
        _mm256_blendv_ps(_mm256_blendv_ps(a, b, eight), _mm256_blendv_ps(c, d, eight), sixteen)
    })
}

impl Simd for Avx2 {
    type F = F;
    type I = I;
    type M = M;

    #[inline]
    fn call<K: Kernel>(self, kernel: K) -> K::Output {
        #[target_feature(enable = "avx2,fma,bmi1,bmi2")]
        fn inner<K: Kernel>(token: Avx2, kernel: K) -> K::Output {
            kernel.run(token)
        }
        // SAFETY: the token proves the features.
        unsafe { inner(self, kernel) }
    }
    #[inline(always)]
    fn splat(self, value: f32) -> F {
        constant(value)
    }
    #[inline(always)]
    fn splat_int(self, value: i32) -> I {
        let half = lanes!(_mm256_set1_epi32(value));
        I(half, half)
    }
    #[inline(always)]
    fn load(self, values: &[f32; LANES]) -> F {
        let from = values.as_ptr();
        lanes!(F(_mm256_loadu_ps(from), _mm256_loadu_ps(from.add(8))))
    }
    #[inline(always)]
    fn load_ints(self, values: &[i32; LANES]) -> I {
        let from = values.as_ptr();
        lanes!(I(_mm256_loadu_si256(from.cast()), _mm256_loadu_si256(from.add(8).cast())))
    }
    #[inline(always)]
    fn load_shorts(self, values: &[u16; LANES]) -> I {
        let from = values.as_ptr().cast::<__m128i>();
        lanes!(I(
            _mm256_cvtepu16_epi32(_mm_loadu_si128(from)),
            _mm256_cvtepu16_epi32(_mm_loadu_si128(from.add(1)))
        ))
    }
    #[inline(always)]
    fn load_triples(self, values: &[u8; 3 * LANES]) -> I {
        // SAFETY: bytes 0 to 24 and 24 to 48 are read, which is what there is.
        unsafe { I(eight_triples(values.as_ptr()), eight_triples(values.as_ptr().add(24))) }
    }
    #[inline(always)]
    fn load_fives(self, values: &[u8; 5 * LANES]) -> [I; 2] {
        // SAFETY: bytes 0 to 40 and 40 to 80 are read, which is what there is.
        let [low, high] = unsafe { [eight_fives(values.as_ptr()), eight_fives(values.as_ptr().add(40))] };
        [I(low.0, high.0), I(low.1, high.1)]
    }
    #[inline(always)]
    fn mask(self, bits: u16) -> M {
        lanes!({
            let bits = _mm256_set1_epi32(i32::from(bits));
            let low = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let high = _mm256_slli_epi32::<8>(low);
            M(
                _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(bits, low), low)),
                _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(bits, high), high)),
            )
        })
    }
    #[inline(always)]
    fn gather(self, table: &[f32], index: I) -> F {
        let index = clamped(index, table.len(), 1);
        let from = table.as_ptr();
        // SAFETY: the indices are within the table.
        unsafe { F(_mm256_i32gather_ps::<4>(from, index.0), _mm256_i32gather_ps::<4>(from, index.1)) }
    }
    #[inline(always)]
    fn gather_words(self, table: &[u32], index: I) -> I {
        let index = clamped(index, table.len(), 1);
        let from = table.as_ptr().cast();
        // SAFETY: the indices are within the table.
        unsafe { I(_mm256_i32gather_epi32::<4>(from, index.0), _mm256_i32gather_epi32::<4>(from, index.1)) }
    }
    #[inline(always)]
    fn gather_pairs(self, table: &[u16], index: I) -> I {
        let index = clamped(index, table.len(), 2);
        let from = table.as_ptr().cast();
        // SAFETY: the indices and their successors are within the table.
        unsafe { I(_mm256_i32gather_epi32::<2>(from, index.0), _mm256_i32gather_epi32::<2>(from, index.1)) }
    }
    #[inline(always)]
    fn permute_pairs(self, near: &[u16; 2 * LANES], index: I) -> I {
        self.gather_pairs(near, index)
    }
    #[inline(always)]
    fn gather_word_pairs(self, table: &[u32], index: I) -> (I, I) {
        let index = clamped(index, table.len(), 2);
        let from: *const i64 = table.as_ptr().cast();
        // SAFETY: the indices and their successors are within the table.
        let ((a, b), (c, d)) = unsafe { (pairs_of_eight(from, index.0), pairs_of_eight(from, index.1)) };
        (I(a, c), I(b, d))
    }
    #[inline(always)]
    fn prefetch<T>(self, table: &[T], index: usize) {
        // SAFETY: a hint, which never faults, whatever the address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(table.as_ptr().wrapping_add(index).cast()) };
    }
    #[inline(always)]
    fn store_triples(self, values: I, target: &mut [u8; 3 * LANES]) {
        // SAFETY: six lanes of four bytes are written per half, which is what the target has.
        unsafe {
            let triples = _mm_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1);
            let order = _mm256_setr_epi32(0, 1, 2, 4, 5, 6, 3, 7);
            let six = _mm256_setr_epi32(-1, -1, -1, -1, -1, -1, 0, 0);
            for (half, &part) in [values.0, values.1].iter().enumerate() {
                let quarters = _mm256_shuffle_epi8(part, _mm256_broadcastsi128_si256(triples));
                let together = _mm256_permutevar8x32_epi32(quarters, order);
                _mm256_maskstore_epi32(target.as_mut_ptr().add(24 * half).cast(), six, together);
            }
        }
    }
    #[inline(always)]
    fn permute_neighbours(self, low: F, high: F, index: I) -> [F; 2] {
        let next = index + self.splat_int(1);
        [
            F(permute_half(low, high, index.0), permute_half(low, high, index.1)),
            F(permute_half(low, high, next.0), permute_half(low, high, next.1)),
        ]
    }
}

impl Floats for F {
    type I = I;
    type M = M;

    #[inline(always)]
    fn mul_add(self, factor: Self, summand: Self) -> Self {
        halves!(F, _mm256_fmadd_ps, self, factor, summand)
    }
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, summand: Self) -> Self {
        halves!(F, _mm256_fnmadd_ps, self, factor, summand)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        halves!(F, _mm256_min_ps, self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        halves!(F, _mm256_max_ps, self, other)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        halves!(F, _mm256_sqrt_ps, self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        halves!(F, _mm256_andnot_ps, constant(-0.0), self)
    }
    #[inline(always)]
    fn recip(self) -> Self {
        // One Newton step from 12 bits.
        let guess = halves!(F, _mm256_rcp_ps, self);
        guess * self.neg_mul_add(guess, constant(2.0))
    }
    #[inline(always)]
    fn rsqrt(self) -> Self {
        let guess = halves!(F, _mm256_rsqrt_ps, self);
        guess * (self * constant(0.5) * guess).neg_mul_add(guess, constant(1.5))
    }
    #[inline(always)]
    fn sqrt_rough(self) -> Self {
        // Twelve bits are too few.
        self * self.rsqrt()
    }
    #[inline(always)]
    fn to_int(self) -> I {
        halves!(I, _mm256_cvttps_epi32, self)
    }
    #[inline(always)]
    fn floor(self) -> Self {
        halves!(F, _mm256_floor_ps, self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M {
        halves!(M, _mm256_cmp_ps::<_CMP_LT_OQ>, self, other)
    }
    #[inline(always)]
    fn le(self, other: Self) -> M {
        halves!(M, _mm256_cmp_ps::<_CMP_LE_OQ>, self, other)
    }
    #[inline(always)]
    fn select(self, mask: M, other: Self) -> Self {
        halves!(F, _mm256_blendv_ps, other, self, mask)
    }
    #[inline(always)]
    fn least(self) -> f32 {
        fold!(self, _mm256_min_ps, _mm_min_ps)
    }
    #[inline(always)]
    fn greatest(self) -> f32 {
        fold!(self, _mm256_max_ps, _mm_max_ps)
    }
    #[inline(always)]
    fn to_bits(self) -> I {
        halves!(I, _mm256_castps_si256, self)
    }
    #[inline(always)]
    fn store(self, target: &mut [f32; LANES]) {
        let to = target.as_mut_ptr();
        lanes!({
            _mm256_storeu_ps(to, self.0);
            _mm256_storeu_ps(to.add(8), self.1);
        });
    }
    #[inline(always)]
    fn store_masked(self, mask: M, target: &mut [f32; LANES]) {
        let to = target.as_mut_ptr();
        lanes!({
            _mm256_maskstore_ps(to, _mm256_castps_si256(mask.0), self.0);
            _mm256_maskstore_ps(to.add(8), _mm256_castps_si256(mask.1), self.1);
        });
    }
}

impl Ints for I {
    type F = F;
    type M = M;

    #[inline(always)]
    fn to_float(self) -> F {
        halves!(F, _mm256_cvtepi32_ps, self)
    }
    #[inline(always)]
    fn as_floats(self) -> F {
        halves!(F, _mm256_castsi256_ps, self)
    }
    #[inline(always)]
    fn shr<const N: u32>(self) -> Self {
        let count = lanes!(_mm_cvtsi32_si128(N as i32));
        lanes!(I(_mm256_srl_epi32(self.0, count), _mm256_srl_epi32(self.1, count)))
    }
    #[inline(always)]
    fn sar<const N: u32>(self) -> Self {
        let count = lanes!(_mm_cvtsi32_si128(N as i32));
        lanes!(I(_mm256_sra_epi32(self.0, count), _mm256_sra_epi32(self.1, count)))
    }
    #[inline(always)]
    fn shl<const N: u32>(self) -> Self {
        let count = lanes!(_mm_cvtsi32_si128(N as i32));
        lanes!(I(_mm256_sll_epi32(self.0, count), _mm256_sll_epi32(self.1, count)))
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        halves!(I, _mm256_mullo_epi32, self, other)
    }
    #[inline(always)]
    fn dot_halves(self, other: Self) -> Self {
        halves!(I, _mm256_madd_epi16, self, other)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        halves!(I, _mm256_min_epi32, self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        halves!(I, _mm256_max_epi32, self, other)
    }
    #[inline(always)]
    fn eq(self, other: Self) -> M {
        let equal = halves!(I, _mm256_cmpeq_epi32, self, other).as_floats();
        M(equal.0, equal.1)
    }
    #[inline(always)]
    fn gt(self, other: Self) -> M {
        let greater = halves!(I, _mm256_cmpgt_epi32, self, other).as_floats();
        M(greater.0, greater.1)
    }
    #[inline(always)]
    fn select(self, mask: M, other: Self) -> Self {
        self.as_floats().select(mask, other.as_floats()).to_bits()
    }
    #[inline(always)]
    fn least(self, mask: M) -> i32 {
        let none = lanes!(_mm256_set1_epi32(i32::MAX));
        let lanes = self.select(mask, I(none, none));
        lanes!({
            let eight = _mm256_min_epi32(lanes.0, lanes.1);
            let four = _mm_min_epi32(_mm256_castsi256_si128(eight), _mm256_extracti128_si256::<1>(eight));
            let two = _mm_min_epi32(four, _mm_shuffle_epi32::<0b01_00_11_10>(four));
            _mm_cvtsi128_si32(_mm_min_epi32(two, _mm_shuffle_epi32::<0b10_11_00_01>(two)))
        })
    }
    #[inline(always)]
    fn store(self, target: &mut [i32; LANES]) {
        let to = target.as_mut_ptr();
        lanes!({
            _mm256_storeu_si256(to.cast(), self.0);
            _mm256_storeu_si256(to.add(8).cast(), self.1);
        });
    }
    #[inline(always)]
    fn store_shorts(self, target: &mut [u16; LANES]) {
        // Quarters of both halves take turns.
        lanes!({
            let packed = _mm256_permute4x64_epi64::<0b11_01_10_00>(_mm256_packus_epi32(self.0, self.1));
            _mm256_storeu_si256(target.as_mut_ptr().cast(), packed);
        });
    }
}

impl Mask for M {
    #[inline(always)]
    fn any(self) -> bool {
        lanes!(_mm256_movemask_ps(_mm256_or_ps(self.0, self.1))) != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        lanes!(_mm256_movemask_ps(_mm256_and_ps(self.0, self.1))) == 0xff
    }
    #[inline(always)]
    fn bits(self) -> u16 {
        lanes!(_mm256_movemask_ps(self.0) | _mm256_movemask_ps(self.1) << 8) as u16
    }
}
