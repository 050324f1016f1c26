//! Memory management: pages that are resident, and their coming in time.
//!
//! ```text
//! poses ──page planner──▶ pages of frames I+1 … I+30 ──memory thread──▶ resident ──▶ marchers, as a PageSource
//!                                                        ▲    │
//!                                          evictions ────┘    └──▶ the frame may begin
//! ```
//!
//! [`PageFile`] is the mapping of a database file: bytes are the system's, and checked when they are first touched. A file that is cut short
//! meanwhile would end the process; [`guard_mapped_files`] makes an error of it. Of one on another machine there is a sparse copy,
//! whose holes a [`HoleFiller`] fills before they are read.
//! [`ResidentPages`] bounds how many of them are in memory, and counts ([`Paging`]); [`ResidentPages::ahead_of`] has a thread
//! bring in what a flight needs. What a frame needs is told by a [`PagePlanner`]; this layer knows nothing of
//! rays, and marchers know pages only as a [`crate::voxel::PageSource`]. [`PagePlan`] says what a flight will need without flying it.
//!
//! Of a live flight nobody knows the path: [`ResidentPages::live`] has its frames begin at once with what is in memory, as [`PresentPages`], and a
//! coarser level stands in for what comes late.

mod clock;
mod counters;
mod deferred_eviction;
mod flight;
#[cfg(unix)]
mod guard;
#[cfg(not(unix))]
#[path = "unguarded.rs"]
mod guard;
mod hole_filler;
#[cfg(test)]
mod hole_filler_tests;
mod live;
mod page_file;
mod plan;
mod resident;
mod sync;
#[cfg(test)]
mod tests;

#[doc(hidden)]
pub use counters::Paging;
pub use flight::Flight;
#[doc(hidden)]
pub use flight::{LOOKAHEAD, PagePlanner};
pub use guard::guard_mapped_files;
#[doc(hidden)]
pub use hole_filler::HoleFiller;
#[doc(hidden)]
pub use live::LiveFlight;
pub use page_file::PageFile;
#[doc(hidden)]
pub use plan::{FrameNeeds, PagePlan};
#[doc(hidden)]
pub use resident::PresentPages;
pub use resident::ResidentPages;
