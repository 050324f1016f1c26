#![doc = include_str!("FORMAT.md")]

mod format;
mod grid;
mod header;
mod page;
mod pyramid;
mod source;
mod verify;
mod writer;

pub use grid::{Grid, HeightCode, MIN_LEVELS, PAGE_SIDE, PageId, RADIX};
pub use header::{ContentHash, Header, Metadata, SourceRecord};
pub use page::{APRON, Attributes, EncodedPage, PageBuffer, PageView};
pub use pyramid::coarsen;
pub use source::{Directory, MemPages, PageSource};
pub use verify::{VerifyReport, verify};
pub use writer::{PageReadback, PageWriter};
