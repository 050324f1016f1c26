//! Spaces, units and axes.
//!
//! *World*: metres in the database's coordinate reference system, x east, y north (grid north),
//! z up from the database's vertical datum. *View*: x right, y up, z forward. *Screen*: pixels,
//! column 0 at the left, row 0 at the top; the centre of pixel (c, r) is at (c + ½, r + ½).
//! Transforms are named `a_from_b`.

mod attitude;
mod camera;
mod distortion;
mod screen;
mod table;
mod tabulate;
#[cfg(test)]
mod tests;

pub use attitude::{Attitude, Pose};
pub use camera::{Camera, Ray};
pub use screen::{Footprint, Screen};
pub use table::RayTable;
