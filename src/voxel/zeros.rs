//! Zeros that stand for planes of pages without a surface.

use super::{APRON, PAGE_SIDE, RELIEF_APRON, Relief};

/// Bytes of the largest plane that such a page has: its slopes.
const LARGEST: usize = samples(RELIEF_APRON) * size_of::<Relief>();
const _: () = assert!(LARGEST >= samples(APRON) * size_of::<[u8; 3]>());

const fn samples(apron: u32) -> usize {
    let side = (PAGE_SIDE + 2 * apron) as usize;
    side * side
}

/// Zeros, as aligned as planes are in memory.
#[repr(C, align(64))]
struct Zeros([u8; LARGEST]);

static ZEROS: Zeros = Zeros([0; LARGEST]);

/// A plane of a page without any surface, of so many bytes.
pub(super) fn plane(bytes: usize) -> &'static [u8] {
    &ZEROS.0[..bytes]
}
