//! Sixteen lanes in lockstep: one generic kernel, several instruction sets, chosen at run time.
//!
//! A [`Kernel`] is a value with one generic method over [`Simd`]. [`Isa::run`] calls it through a function
//! that is compiled for the instruction set, into which everything is inlined: a kernel is written once
//! and reads as the algorithm.
//!
//! * [`Portable`]: arrays of 16, which compilers vectorise for whatever the target offers (SSE2).
//! * `Avx2`: two registers of eight.
//! * `Avx512`: one register, comparisons into mask registers.
//! * `Neon`: four registers of four.
//!
//! Values of a set's lane types exist only where the set was detected, because only the set's token makes
//! them: that is what makes their operators safe.
//!
//! Gathers never wait for a mask: one that is gated by the last comparison is several times slower than
//! one of all lanes whose result is masked. Their indices are clamped into the slice instead.

mod each;
mod lanes;
#[doc(hidden)]
pub mod math;
mod portable;
mod turn;

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "aarch64")]
mod neon;
#[cfg(test)]
mod tests;

pub(crate) use each::Each;
#[doc(hidden)]
pub use lanes::{Floats, Ints, Kernel, LANES, Mask, Simd, Sixteen};
#[doc(hidden)]
pub use portable::Portable;
#[doc(hidden)]
pub use turn::turned;

use std::str::FromStr;

/// An instruction set that this machine has.
#[derive(Debug, Clone, Copy)]
pub struct Isa(Set);

#[derive(Debug, Clone, Copy)]
enum Set {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(avx512::Avx512),
    #[cfg(target_arch = "aarch64")]
    Neon(neon::Neon),
}

impl Isa {
    /// Any processor's.
    pub const PORTABLE: Self = Self(Set::Portable);

    /// Lists the sets that this machine has, the fastest first.
    pub fn available() -> Vec<Self> {
        let mut sets = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            sets.extend(avx512::Avx512::detect().map(|token| Self(Set::Avx512(token))));
            sets.extend(avx2::Avx2::detect().map(|token| Self(Set::Avx2(token))));
        }
        #[cfg(target_arch = "aarch64")]
        sets.extend(neon::Neon::detect().map(|token| Self(Set::Neon(token))));
        sets.push(Self::PORTABLE);
        sets
    }

    /// The fastest that this machine has.
    pub fn best() -> Self {
        static BEST: std::sync::LazyLock<Isa> = std::sync::LazyLock::new(|| Isa::available()[0]);
        *BEST
    }

    /// Name as users write it: `avx512`, `avx2`, `neon` or `portable`.
    pub fn name(self) -> &'static str {
        match self.0 {
            Set::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            Set::Avx512(_) => "avx512",
            #[cfg(target_arch = "aarch64")]
            Set::Neon(_) => "neon",
        }
    }

    /// Runs a kernel with this set.
    #[inline]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Set::Portable => Portable.call(kernel),
            #[cfg(target_arch = "x86_64")]
            Set::Avx2(token) => token.call(kernel),
            #[cfg(target_arch = "x86_64")]
            Set::Avx512(token) => token.call(kernel),
            #[cfg(target_arch = "aarch64")]
            Set::Neon(token) => token.call(kernel),
        }
    }
}

impl PartialEq for Isa {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Default for Isa {
    fn default() -> Self {
        Self::best()
    }
}

impl std::fmt::Display for Isa {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Isa {
    type Err = String;

    /// Parses a [name](Self::name), if this machine has the set.
    fn from_str(name: &str) -> Result<Self, String> {
        let available = Self::available();
        available.iter().copied().find(|isa| isa.name() == name).ok_or_else(|| {
            let names: Vec<_> = available.iter().map(|isa| isa.name()).collect();
            format!("this machine has no instruction set {name:?}; it has {}", names.join(", "))
        })
    }
}
