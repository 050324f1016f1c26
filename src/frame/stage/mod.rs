//! The image stage of the scan-plane engine: from the profiles that planes see to the screen.
//!
//! ```text
//! each group of planes, a chunk of segments after the other:
//!     light of each segment                     radiance over its footprint, haze before it      paint
//!     light of each row                         stretches by their share of it, then sky         rows
//! each band of the screen's rows:
//!     pixel's place among planes and rows       homography                                       plane image
//!     its light                                 linear between planes; cubic between planes and rows, with roll
//!     8-bit sRGB, or light and range                                                             band
//! ```
//!
//! Light is filtered where it is known exactly: along the planes by the rows' boxes, across them by the width of a
//! line's texels. What is left to resample are pixels of nearly the right size.

mod band;
mod cell;
mod edge_marks;
mod paint;
mod plane_image;
mod row_detail;
mod rows;
mod segment_light;
mod sky;
mod solids;
#[cfg(test)]
mod tests;

pub use band::Band;
pub use cell::{Cell, Scale};
pub use paint::{Painter, Painting};
pub use plane_image::{Depths, PlaneSource};
pub use row_detail::{DetailView, RowDetail};
pub use rows::{EdgeSums, PlaneAir, RowFill};
pub use solids::SpanPaint;
