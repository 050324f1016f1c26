//! Work that is written for any instruction set.

use super::lanes::Simd;

/// Work that is written for any instruction set.
pub trait Kernel {
    /// Type of the result.
    type Output;
    /// Does it. Implementations are `#[inline(always)]`, or the set's instructions are not used.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}
