//! Which pages are resident.
//!
//! ```text
//!             first touch                    checksum and shape are right
//!   on disk ───────────────▶ read by the OS ──────────────────────────────▶ good: views cost nothing more
//!      ▲                          │ wrong                                        │
//!      │                          ▼                                              │
//!      │                     an error, at every touch                            │
//!      └─────────────────────────────────────────────────────────────────────────┘
//!            the OS drops clean pages when it needs memory; they stay known as good
//! ```
//!
//! Today this layer is the mapping of a database file ([`PageFile`]): the operating system decides what stays in
//! memory, a page is announced (`WILLNEED`) as a whole when it is first touched, and
//! [`PageFile::touched`] counts. A budget of bytes, eviction, and a thread that brings in pages ahead of
//! the flight belong here, between [`PageFile`] and the marchers; nothing above will change, since
//! marchers know pages only as a [`crate::voxel::PageSource`].

mod page_file;

pub use page_file::PageFile;
