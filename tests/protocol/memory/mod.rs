//! The modules of `src/memory` that decide which pages are in memory, over threads that run in a chosen order and over a disk that takes its time.

#![allow(dead_code, reason = "what the protocol does not need of these modules")]

#[path = "../../../src/memory/clock.rs"]
mod clock;
#[path = "../../../src/memory/flight.rs"]
mod flight;
#[path = "../../../src/memory/leaving.rs"]
mod leaving;
#[path = "../../../src/memory/live.rs"]
mod live;
mod page_file;
#[path = "../../../src/memory/resident/mod.rs"]
mod resident;
pub mod sync;
#[path = "../../../src/memory/tally.rs"]
mod tally;

pub use flight::Foresight;
pub use page_file::PageFile;
pub use resident::{PresentPages, ResidentPages};
pub use tally::Paging;
