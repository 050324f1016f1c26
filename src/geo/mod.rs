//! Coordinate reference systems and vertical datums.

mod crs;
mod datum;
mod wkt;

pub use crs::{Crs, Transform};
pub use datum::{VerticalDatum, egm96_undulation};
