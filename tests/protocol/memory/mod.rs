//! The modules of `src/memory` that decide which pages are in memory, over threads that run in a chosen order and over a disk that takes its time.

#![allow(dead_code, reason = "what the protocol does not need of these modules")]

#[path = "../../../src/memory/clock.rs"]
mod clock;
#[path = "../../../src/memory/counters.rs"]
mod counters;
#[path = "../../../src/memory/deferred_eviction.rs"]
mod deferred_eviction;
#[path = "../../../src/memory/flight.rs"]
mod flight;
#[path = "../../../src/memory/live.rs"]
mod live;
mod page_file;
#[path = "../../../src/memory/resident/mod.rs"]
mod resident;
pub mod sync;

pub use counters::Paging;
pub use flight::PagePlanner;
pub use page_file::PageFile;
pub use resident::{PresentPages, ResidentPages};
