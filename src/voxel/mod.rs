#![doc = include_str!("FORMAT.md")]

mod ahead;
mod arrays;
mod assembly;
mod block_spans;
mod bytes;
mod coarse_spans;
mod cut;
mod detail_record;
mod directory;
mod earlier;
mod empty;
mod facade;
mod file_ends;
mod fixed_header;
mod folders;
mod format;
mod grid;
mod header;
#[doc(hidden)]
pub mod limits;
mod material;
mod page;
mod page_entry;
mod page_part;
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
mod stored_spans;
#[cfg(test)]
mod tests;
mod trust;
mod undo;
mod verify;
mod version_7;
mod window;
mod writer;
mod zeros;

pub use arrays::{Arrays, build_in_memory, write_arrays};
#[doc(hidden)]
pub use arrays::{SpanArrays, build_standing};
#[doc(hidden)]
pub use assembly::{PageReadback, most_page_bytes};
#[doc(hidden)]
pub use block_spans::BlockSpans;
#[doc(hidden)]
pub use bytes::AlignedBytes;
#[doc(hidden)]
pub use cut::Cut;
pub use detail_record::DetailRecord;
#[doc(hidden)]
pub use directory::{Directory, ENTRY_BYTES};
#[doc(hidden)]
pub use earlier::{EarlierFile, EarlierPage};
#[doc(hidden)]
pub use facade::{Bays, Facade, FacadeStyle};
#[doc(hidden)]
pub use file_ends::{FileEnds, HEADER_BYTES};
#[doc(hidden)]
pub use grid::{BARE, HeightCode, MIN_LEVELS, PAGE_SIDE, RADIX};
pub use grid::{Grid, PageId};
#[doc(hidden)]
pub use header::{ContentHash, CorridorRecord, MaterialRecord, SourceRecord};
pub use header::{Header, HeightRange, Metadata};
#[doc(hidden)]
pub use material::Group;
pub use material::Material;
#[doc(hidden)]
pub use page::{Attributes, BoundsView, EncodedPage, HeightsView, PageBuffer, PageView};
#[doc(hidden)]
pub use page_entry::PageEntry;
#[doc(hidden)]
pub use page_part::{APRON, PageNeeds, PagePart, RELIEF_APRON};
#[doc(hidden)]
pub use placement::{Placement, SharedObject, SharedObjects, Symmetry};
#[doc(hidden)]
pub use pyramid::{coarse_page, sparse_page};
#[doc(hidden)]
pub use relief::{Relief, ReliefLanes, half_steps, half_steps_of};
#[doc(hidden)]
pub use shelf::Shelf;
pub use source::PageSource;
#[doc(hidden)]
pub use span::Span;
#[doc(hidden)]
pub use span_table::{BLOCK_SIDE, SpanBlock, SpanTable, SpansView};
pub use store::MemPages;
#[doc(hidden)]
pub use store::{FileBytes, PageStore, Touched};
#[doc(hidden)]
pub use stored_spans::StoredSpans;
pub use trust::Verify;
#[doc(hidden)]
pub use trust::{Damaged, Trust};
#[doc(hidden)]
pub use undo::open_to_read;

#[doc(hidden)]
pub use verify::Problem;
pub use verify::{VerifyReport, verify};
#[doc(hidden)]
pub use version_7::in_full;
#[doc(hidden)]
pub use window::{FinerPages, StandIn, VoxelBlock, finer_pages};
#[doc(hidden)]
pub use writer::{PageWriter, SealedFile};
