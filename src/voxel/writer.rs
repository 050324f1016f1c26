//! Writing a database: pages in any order of levels, then directory, metadata and header, then fsync and rename.

use std::path::Path;

use super::{ContentHash, EncodedPage, Grid, HeightCode, Metadata, PageBuffer, PageId};
use crate::error::Result;

/// Writes a database under a temporary name beside the target.
#[derive(Debug)]
pub struct PageWriter {}

impl PageWriter {
    /// Starts `path`; an error if it exists and `overwrite` is false.
    pub fn create(path: &Path, grid: Grid, heights: HeightCode, overwrite: bool) -> Result<Self> {
        let _ = (path, grid, heights, overwrite);
        todo!()
    }
    /// Appends a page; each id once.
    pub fn append(&mut self, page: &EncodedPage) -> Result<()> {
        let _ = page;
        todo!()
    }
    /// A handle that reads back pages appended so far, from any thread.
    pub fn readback(&self) -> PageReadback {
        todo!()
    }
    /// Writes directory, metadata and header, flushes to disk and gives the file its name. Returns identity and bytes.
    pub fn finish(self, metadata: &Metadata, height_range: (f64, f64)) -> Result<(ContentHash, u64)> {
        let _ = (metadata, height_range);
        todo!()
    }
}

/// Reads back pages of a database that is still being written.
#[derive(Debug, Clone)]
pub struct PageReadback {}

impl PageReadback {
    /// The page, or `None` if it has not been appended.
    pub fn page(&self, id: PageId) -> Result<Option<PageBuffer>> {
        let _ = id;
        todo!()
    }
}
