//! Readers, one per format: each has a function `open` that gives a [`Raster`](super::Raster); `detect.rs` chooses one.
//!
//! Samples that lie in the file as they are become a `RawRaster`, what is decoded in pieces a `BlockRaster` over a
//! `BlockSource`. Short examples are `hgt.rs` (samples without a header), `bt.rs` (behind one) and `esri_ascii.rs` (text).

pub(super) mod bt;
pub(super) mod dted;
pub(super) mod envi;
pub(super) mod esri_ascii;
pub(super) mod esri_header;
pub(super) mod headerless;
pub(super) mod hgt;
pub(super) mod picture;
pub(super) mod tiff;
