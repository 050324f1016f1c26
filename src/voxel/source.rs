//! Where pages come from.

use super::{Header, PageId, PageView};
use crate::error::Result;

/// Gives out pages. The marchers are generic over it.
pub trait PageSource: Sync {
    /// What the database is.
    fn header(&self) -> &Header;

    /// The page, `None` where it is absent (stored at a coarser level only, or outside the area).
    /// A page whose checksum or shape is wrong is an error, every time it is asked for. The first touch of a
    /// page reads all of it; later ones cost some tens of nanoseconds.
    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>>;

    /// Whether the page is stored, damaged or not; told without reading it where that can be.
    fn has(&self, id: PageId) -> bool {
        !matches!(self.page(id), Ok(None))
    }
}
