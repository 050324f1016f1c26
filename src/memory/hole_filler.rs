//! Databases of which only some bytes are on this machine: the others are brought before they are read.
//!
//! ```text
//! mapped sparse file:  ██████░░░░░░██░░░░░░░░░░░░████   █ there   ░ a hole, which would read as zeros
//!                            ▲
//! a part is touched for the first time, or announced ──▶ the filler writes its bytes into the file ──▶ checksum
//! ```
//!
//! A part is read only after its checksum was taken or left out, and neither happens before the filler has said that all bytes of the part
//! are there. So no hole is ever taken for ground.

use std::ops::Range;

use hedgehop_base::error::Result;

/// Fills holes of a sparse file, whose length is that of the whole database, before its bytes are read. Ranges are bytes of the file.
pub trait HoleFiller: std::fmt::Debug + Send + Sync {
    /// Begins to fill, and does not wait.
    fn announce(&self, range: Range<u64>);

    /// Fills, and waits until all of it is there; false: it cannot be had, and [`Self::intact`] says why.
    fn fill(&self, range: Range<u64>) -> bool;

    /// Whether all of it is there.
    fn is_filled(&self, range: Range<u64>) -> bool;

    /// Fills once more what turned out to be wrong, and waits.
    fn refill(&self, range: Range<u64>) -> bool;

    /// Whether something could not be had so far. It stays so.
    fn has_failed(&self) -> bool;

    /// Whether all that was filled is of the one database that was opened.
    ///
    /// # Errors
    /// The database has changed, or something could not be had.
    fn intact(&self) -> Result<()>;
}
