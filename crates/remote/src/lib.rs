//! Databases on other machines, read by HTTP ranges.
//!
//! ```text
//! URL ──first bytes──▶ identity ──▶ CACHE/identity/area.hop   a sparse file, laid out as the database
//!                                                  present    which of its blocks are there
//! part of a page announced, or touched ──▶ queue of ranges ──▶ 8 connections ──▶ sparse file ──▶ checksum, as of any file
//! ```
//!
//! What reads databases does not know that one is remote: it maps the sparse file, and has holes [filled](hedgehop::memory::HoleFiller) before it
//! reads them. A database that is replaced on its server while it is read ends the run.

mod address;
mod backoff;
mod blocks;
mod cache;
mod client;
mod copy;
mod fetcher;
mod known;
mod open;
mod positioned;
mod queue;
mod validator;

pub use address::Address;
pub use cache::{CacheSettings, DEFAULT_SIZE, default_folder};
pub use open::open;
