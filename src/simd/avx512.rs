//! AVX-512: one register of sixteen lanes, masks in registers of their own.

#![expect(unsafe_code, reason = "vector instructions; see the contract at `Avx512`")]

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

use super::{Floats, Ints, Kernel, LANES, Mask, Simd};

/// Proof that this processor has AVX-512 F, BW, DQ and VL, as all since 2017 do that are made for it.
///
/// Contract: made only by [`Avx512::detect`]; [`F`], [`I`] and [`M`] are made only from it or from each
/// other. So whoever holds any of them runs on a processor that has their instructions.
#[derive(Debug, Clone, Copy)]
pub struct Avx512(());

/// Sixteen f32.
#[derive(Clone, Copy)]
pub struct F(__m512);
/// Sixteen i32.
#[derive(Clone, Copy)]
pub struct I(__m512i);
/// Sixteen bits.
#[derive(Clone, Copy)]
pub struct M(__mmask16);

/// Builds with assertions, which are for tests, leave these kernels out where the machine that compiles them could not run
/// them (`build.rs`).
const IS_COMPILED: bool = cfg!(any(not(debug_assertions), host_has_avx512));

impl Avx512 {
    pub fn detect() -> Option<Self> {
        let has = IS_COMPILED
            && is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2");
        has.then_some(Self(()))
    }
}

/// An intrinsic on lanes.
macro_rules! lanes {
    ($e:expr) => {
        // SAFETY: lanes exist only where their instructions do, see `Avx512`.
        unsafe { $e }
    };
}

macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(lanes!($intrinsic(self.0, other.0)))
            }
        }
    };
}
operator!(F, Add, add, _mm512_add_ps);
operator!(F, Sub, sub, _mm512_sub_ps);
operator!(F, Mul, mul, _mm512_mul_ps);
operator!(F, Div, div, _mm512_div_ps);
operator!(I, Add, add, _mm512_add_epi32);
operator!(I, Sub, sub, _mm512_sub_epi32);
operator!(I, BitAnd, bitand, _mm512_and_si512);
operator!(I, BitOr, bitor, _mm512_or_si512);

impl BitAnd for M {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}
impl BitOr for M {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}
impl Not for M {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

/// Indices at which `width` elements of a table of `length` begin.
#[inline(always)]
fn clamped(index: I, length: usize, width: usize) -> __m512i {
    assert!(length >= width);
    let last = (length - width).min(i32::MAX as usize / 8) as i32;
    lanes!(_mm512_min_epu32(index.0, _mm512_set1_epi32(last)))
}

impl Simd for Avx512 {
    type F = F;
    type I = I;
    type M = M;

    #[inline]
    fn call<K: Kernel>(self, kernel: K) -> K::Output {
        #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2")]
        fn inner<K: Kernel>(token: Avx512, kernel: K) -> K::Output {
            kernel.run(token)
        }
        if !IS_COMPILED {
            unreachable!("no token was made");
        }
        // SAFETY: the token proves the features.
        unsafe { inner(self, kernel) }
    }
    #[inline(always)]
    fn splat(self, value: f32) -> F {
        F(lanes!(_mm512_set1_ps(value)))
    }
    #[inline(always)]
    fn splat_int(self, value: i32) -> I {
        I(lanes!(_mm512_set1_epi32(value)))
    }
    #[inline(always)]
    fn load(self, values: &[f32; LANES]) -> F {
        F(lanes!(_mm512_loadu_ps(values.as_ptr())))
    }
    #[inline(always)]
    fn load_ints(self, values: &[i32; LANES]) -> I {
        I(lanes!(_mm512_loadu_si512(values.as_ptr().cast())))
    }
    #[inline(always)]
    fn load_shorts(self, values: &[u16; LANES]) -> I {
        I(lanes!(_mm512_cvtepu16_epi32(_mm256_loadu_si256(values.as_ptr().cast()))))
    }
    #[inline(always)]
    fn load_triples(self, values: &[u8; 3 * LANES]) -> I {
        // The words in which four lanes begin to each quarter, then their bytes.
        // SAFETY: twelve words are read, which is what there is.
        unsafe {
            let words = _mm512_maskz_loadu_epi32(0x0fff, values.as_ptr().cast());
            let order = _mm512_setr_epi32(0, 1, 2, 2, 3, 4, 5, 5, 6, 7, 8, 8, 9, 10, 11, 11);
            let quarters = _mm512_permutexvar_epi32(order, words);
            let triples = _mm_setr_epi8(0, 1, 2, -1, 3, 4, 5, -1, 6, 7, 8, -1, 9, 10, 11, -1);
            I(_mm512_shuffle_epi8(quarters, _mm512_broadcast_i32x4(triples)))
        }
    }
    #[inline(always)]
    fn load_fives(self, values: &[u8; 5 * LANES]) -> [I; 2] {
        // Four lanes have five words: the first four to a quarter each, and the last four.
        // SAFETY: twenty words are read, which is what there is.
        unsafe {
            let low = _mm512_loadu_si512(values.as_ptr().cast());
            let high = _mm512_castsi128_si512(_mm_loadu_si128(values.as_ptr().add(64).cast()));
            let order = _mm512_setr_epi32(0, 1, 2, 3, 5, 6, 7, 8, 10, 11, 12, 13, 15, 16, 17, 18);
            let first = _mm512_permutex2var_epi32(low, order, high);
            let order = _mm512_add_epi32(order, _mm512_set1_epi32(1));
            let last = _mm512_permutex2var_epi32(low, order, high);

            // Bytes of `last` are four further on than those of `first`.
            let three = _mm_setr_epi8(0, 1, 2, 3, 5, 6, 7, 8, 10, 11, 12, 13, -1, -1, -1, -1);
            let fourth = _mm_setr_epi8(-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, 11, 12, 13, 14);
            let four = _mm512_or_si512(
                _mm512_shuffle_epi8(first, _mm512_broadcast_i32x4(three)),
                _mm512_shuffle_epi8(last, _mm512_broadcast_i32x4(fourth)),
            );
            let fifth = _mm_setr_epi8(0, -1, -1, -1, 5, -1, -1, -1, 10, -1, -1, -1, 15, -1, -1, -1);

            [I(four), I(_mm512_shuffle_epi8(last, _mm512_broadcast_i32x4(fifth)))]
        }
    }
    #[inline(always)]
    fn mask(self, bits: u16) -> M {
        M(bits)
    }
    #[inline(always)]
    fn gather(self, table: &[f32], index: I) -> F {
        let index = clamped(index, table.len(), 1);
        // SAFETY: the indices are within the table.
        F(unsafe { _mm512_i32gather_ps::<4>(index, table.as_ptr()) })
    }
    #[inline(always)]
    fn gather_words(self, table: &[u32], index: I) -> I {
        let index = clamped(index, table.len(), 1);
        // SAFETY: the indices are within the table.
        I(unsafe { _mm512_i32gather_epi32::<4>(index, table.as_ptr().cast()) })
    }
    #[inline(always)]
    fn gather_pairs(self, table: &[u16], index: I) -> I {
        let index = clamped(index, table.len(), 2);
        // SAFETY: the indices and their successors are within the table.
        I(unsafe { _mm512_i32gather_epi32::<2>(index, table.as_ptr().cast()) })
    }
    #[inline(always)]
    fn permute_pairs(self, near: &[u16; 2 * LANES], index: I) -> I {
        // SAFETY: 32 words are there.
        let near = unsafe { _mm512_loadu_si512(near.as_ptr().cast()) };
        let index = index | (index + self.splat_int(1)).shl::<16>();
        I(lanes!(_mm512_permutexvar_epi16(index.0, near)))
    }
    #[inline(always)]
    fn gather_word_pairs(self, table: &[u32], index: I) -> (I, I) {
        let index = clamped(index, table.len(), 2);
        let from = table.as_ptr().cast();
        // Half as many loads as two gathers of words.
        // SAFETY: the indices and their successors are within the table.
        unsafe {
            let low = _mm512_i32gather_epi64::<4>(_mm512_castsi512_si256(index), from);
            let high = _mm512_i32gather_epi64::<4>(_mm512_extracti64x4_epi64::<1>(index), from);
            let even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
            let odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
            (I(_mm512_permutex2var_epi32(low, even, high)), I(_mm512_permutex2var_epi32(low, odd, high)))
        }
    }
    #[inline(always)]
    fn prefetch<T>(self, table: &[T], index: usize) {
        // SAFETY: a hint, which never faults, whatever the address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(table.as_ptr().wrapping_add(index).cast()) };
    }
    #[inline(always)]
    fn store_triples(self, values: I, target: &mut [u8; 3 * LANES]) {
        // Twelve bytes in each quarter, then the quarters together.
        // SAFETY: twelve lanes of four bytes are written, which is what the target has.
        unsafe {
            let triples = _mm_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1);
            let quarters = _mm512_shuffle_epi8(values.0, _mm512_broadcast_i32x4(triples));
            let order = _mm512_setr_epi32(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 3, 7, 11, 15);
            let together = _mm512_permutexvar_epi32(order, quarters);
            _mm512_mask_storeu_epi32(target.as_mut_ptr().cast(), 0x0fff, together);
        }
    }
    #[inline(always)]
    fn permute_neighbours(self, low: F, high: F, index: I) -> [F; 2] {
        let next = index + self.splat_int(1);
        lanes!([
            F(_mm512_permutex2var_ps(low.0, index.0, high.0)),
            F(_mm512_permutex2var_ps(low.0, next.0, high.0))
        ])
    }
}

impl Floats for F {
    type I = I;
    type M = M;

    #[inline(always)]
    fn mul_add(self, factor: Self, summand: Self) -> Self {
        Self(lanes!(_mm512_fmadd_ps(self.0, factor.0, summand.0)))
    }
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, summand: Self) -> Self {
        Self(lanes!(_mm512_fnmadd_ps(self.0, factor.0, summand.0)))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(lanes!(_mm512_min_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(lanes!(_mm512_max_ps(self.0, other.0)))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(lanes!(_mm512_sqrt_ps(self.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(lanes!(_mm512_abs_ps(self.0)))
    }
    #[inline(always)]
    fn recip(self) -> Self {
        // One Newton step from 14 bits.
        let guess = Self(lanes!(_mm512_rcp14_ps(self.0)));
        let two = Self(lanes!(_mm512_set1_ps(2.0)));
        guess * self.neg_mul_add(guess, two)
    }
    #[inline(always)]
    fn rsqrt(self) -> Self {
        let guess = Self(lanes!(_mm512_rsqrt14_ps(self.0)));
        let (half, more) = lanes!((Self(_mm512_set1_ps(0.5)), Self(_mm512_set1_ps(1.5))));
        guess * (self * half * guess).neg_mul_add(guess, more)
    }
    #[inline(always)]
    fn sqrt_rough(self) -> Self {
        self * Self(lanes!(_mm512_rsqrt14_ps(self.0)))
    }
    #[inline(always)]
    fn to_int(self) -> I {
        I(lanes!(_mm512_cvttps_epi32(self.0)))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Self(lanes!(_mm512_roundscale_ps::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0)))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M {
        M(lanes!(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn le(self, other: Self) -> M {
        M(lanes!(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn select(self, mask: M, other: Self) -> Self {
        Self(lanes!(_mm512_mask_blend_ps(mask.0, other.0, self.0)))
    }
    #[inline(always)]
    fn least(self) -> f32 {
        lanes!(_mm512_reduce_min_ps(self.0))
    }
    #[inline(always)]
    fn greatest(self) -> f32 {
        lanes!(_mm512_reduce_max_ps(self.0))
    }
    #[inline(always)]
    fn to_bits(self) -> I {
        I(lanes!(_mm512_castps_si512(self.0)))
    }
    #[inline(always)]
    fn store(self, target: &mut [f32; LANES]) {
        lanes!(_mm512_storeu_ps(target.as_mut_ptr(), self.0));
    }
    #[inline(always)]
    fn store_masked(self, mask: M, target: &mut [f32; LANES]) {
        lanes!(_mm512_mask_storeu_ps(target.as_mut_ptr(), mask.0, self.0));
    }
}

impl Ints for I {
    type F = F;
    type M = M;

    #[inline(always)]
    fn to_float(self) -> F {
        F(lanes!(_mm512_cvtepi32_ps(self.0)))
    }
    #[inline(always)]
    fn as_floats(self) -> F {
        F(lanes!(_mm512_castsi512_ps(self.0)))
    }
    #[inline(always)]
    fn shr<const N: u32>(self) -> Self {
        Self(lanes!(_mm512_srli_epi32::<N>(self.0)))
    }
    #[inline(always)]
    fn sar<const N: u32>(self) -> Self {
        Self(lanes!(_mm512_srai_epi32::<N>(self.0)))
    }
    #[inline(always)]
    fn shl<const N: u32>(self) -> Self {
        Self(lanes!(_mm512_slli_epi32::<N>(self.0)))
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(lanes!(_mm512_mullo_epi32(self.0, other.0)))
    }
    #[inline(always)]
    fn dot_halves(self, other: Self) -> Self {
        Self(lanes!(_mm512_madd_epi16(self.0, other.0)))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(lanes!(_mm512_min_epi32(self.0, other.0)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(lanes!(_mm512_max_epi32(self.0, other.0)))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> M {
        M(lanes!(_mm512_cmpeq_epi32_mask(self.0, other.0)))
    }
    #[inline(always)]
    fn gt(self, other: Self) -> M {
        M(lanes!(_mm512_cmpgt_epi32_mask(self.0, other.0)))
    }
    #[inline(always)]
    fn select(self, mask: M, other: Self) -> Self {
        Self(lanes!(_mm512_mask_blend_epi32(mask.0, other.0, self.0)))
    }
    #[inline(always)]
    fn least(self, mask: M) -> i32 {
        lanes!(_mm512_mask_reduce_min_epi32(mask.0, self.0))
    }
    #[inline(always)]
    fn store(self, target: &mut [i32; LANES]) {
        lanes!(_mm512_storeu_si512(target.as_mut_ptr().cast(), self.0));
    }
    #[inline(always)]
    fn store_shorts(self, target: &mut [u16; LANES]) {
        lanes!(_mm256_storeu_si256(target.as_mut_ptr().cast(), _mm512_cvtepi32_epi16(self.0)));
    }
}

impl Mask for M {
    #[inline(always)]
    fn any(self) -> bool {
        self.0 != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0 == u16::MAX
    }
    #[inline(always)]
    fn bits(self) -> u16 {
        self.0
    }
}
