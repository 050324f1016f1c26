//! Where pages come from: a trait, the directory, and the twin that keeps a file's bytes in memory.

use super::{Header, PageId, PageView};
use crate::error::Result;

/// Gives out pages. The marchers are generic over it.
pub trait PageSource: Sync {
    /// What the database is.
    fn header(&self) -> &Header;

    /// The page, `None` where it is absent (stored at a coarser level only, or outside the area).
    /// A page whose checksum or shape is wrong is an error, every time it is asked for.
    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>>;
}

/// Where each page lies in a file.
#[derive(Debug)]
pub struct Directory {}

/// A database in memory.
#[derive(Debug)]
pub struct MemPages {}
