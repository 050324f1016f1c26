//! From a level to the next coarser one.

use super::PageBuffer;

/// Placeholder signature; see the module's owner.
pub fn coarsen(_finer: &PageBuffer) {}
