//! The image stage of the scan-plane engine: from the planes' inverse depth to the screen.
//!
//! ```text
//! for each strip of sixteen columns, each row of a band from the bottom up:
//!     where in the fan each pixel lies                        homography
//!     inverse depth there                                     linear between planes (and rows, with roll)
//!     place on the ground, footprint                          range, and its change since the row below
//!     radiance over the footprint                             one or two images of radiance pages
//!     haze before it, or sky                                  closed forms
//! ```
//!
//! What is resampled is inverse depth, which is linear over flat ground in any projection, and not colour: each
//! pixel is filtered once, over its own footprint, however the screen is pitched and rolled. Across
//! an edge, where inverse depth jumps, the nearest plane counts.

mod air;
mod band;
mod fan;

pub use band::{Band, ImageStage};
