//! Bytes of a database besides its pages, found from its first ones.

use std::ops::Range;
use std::path::Path;

use super::ContentHash;
use super::fixed_header::FixedHeader;
use super::format::PAGE_ALIGNMENT;
use super::format::header as at;
use hedgehop_base::error::Result;

/// Bytes of the header, with which a file begins.
pub const HEADER_BYTES: usize = at::SIZE;

/// Places of what is read of a database before its pages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FileEnds {
    /// Identity of the content.
    pub content_hash: ContentHash,
    /// First byte behind the pages: objects, directory and metadata follow, up to the end of the file.
    pages_end: u64,
    /// Bytes of the file.
    file_length: u64,
}

impl FileEnds {
    /// Reads them from the `start` of a file of `length` bytes, at least its header; `path` is for the error's sentence.
    ///
    /// # Errors
    /// The file is no database, of a version that is not read, damaged, or of another length.
    pub fn of_start(path: &Path, start: &[u8], length: u64) -> Result<Self> {
        let fixed = FixedHeader::decode_start(path, start, length)?;
        Ok(Self {
            content_hash: fixed.content_hash,
            pages_end: fixed.pages_end(),
            file_length: fixed.file_length,
        })
    }

    /// Lists the stretches of the file that hold no pages: the header, and what lies behind the pages.
    pub fn stretches(&self) -> [Range<u64>; 2] {
        [0..PAGE_ALIGNMENT.min(self.pages_end), self.pages_end..self.file_length]
    }
}
