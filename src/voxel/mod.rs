#![doc = include_str!("FORMAT.md")]

mod ahead;
mod arrays;
mod assembly;
mod block_spans;
mod bytes;
mod cut;
mod derived;
mod directory;
mod earlier;
mod empty;
mod fixed_header;
mod format;
mod grid;
mod header;
pub mod limits;
mod material;
mod page;
mod patch;
mod placement;
mod pyramid;
mod relief;
mod shelf;
mod source;
mod span;
mod span_table;
mod srgb;
mod store;
#[cfg(test)]
mod tests;
mod trust;
mod undo;
mod used;
mod verify;
mod version_7;
mod window;
mod writer;

pub use arrays::{Arrays, SpanArrays, build_in_memory, build_standing, write_arrays};
pub use assembly::{PageReadback, most_page_bytes};
pub use block_spans::BlockSpans;
pub use bytes::AlignedBytes;
pub use cut::Cut;
pub use derived::{Bytes, KeyedCache};
pub use directory::{Directory, ENTRY_BYTES, PageEntry};
pub use earlier::{EarlierFile, EarlierPage};
pub use grid::{BARE, Grid, HeightCode, MIN_LEVELS, PAGE_SIDE, PageId, RADIX};
pub use header::{ContentHash, CorridorRecord, Header, MaterialRecord, Metadata, SourceRecord};
pub use material::{Group, Material};
pub use page::{
    APRON, Attributes, BoundsView, EncodedPage, HeightsView, PageBuffer, PageNeeds, PagePart, PageView,
    RELIEF_APRON,
};
pub use placement::{Placement, SharedObject, SharedObjects, Symmetry};
pub use pyramid::{coarse_page, sparse_page};
pub use relief::{Relief, ReliefLanes, half_steps, half_steps_of};
pub use shelf::Shelf;
pub use source::PageSource;
pub use span::Span;
pub use span_table::{BLOCK_SIDE, SpanBlock, SpanTable, SpansView};
pub use store::{FileBytes, MemPages, PageStore, Touched};
pub use trust::{Damaged, Trust, Verify};
pub use undo::open_to_read;
pub use used::{Lent, Used};

pub use verify::{Problem, VerifyReport, verify};
#[doc(hidden)]
pub use version_7::in_full;
pub use window::{FinerPages, StandIn, VoxelBlock, finer_pages};
pub use writer::{PageWriter, SealedFile};
