//! Procedural texture that is fixed to the ground: each value is a function of the place alone.
//!
//! ```text
//! cyclic codes ──▶ XorPattern ──▶ Cells ──broad_band──▶ Tile: 255 × 255 cells, zero mean over each voxel
//!                                                         └──▶ exact mean over any box, four looks
//! ```
//!
//! Sources: the study of cyclic codes for surface texture that the Air Force Human Resources Laboratory ran
//! on ACTES (author and year unknown to us), for codes, their averages and estimators; Bunker and Ferris 1977
//! (AFHRL-TR-77-66), for ground maps.

mod cell_box;
mod cells;
mod code;
mod octaves;
mod pattern;
mod polynomial;
mod projection;
mod rounding;
mod strand;
mod tile;

#[cfg(test)]
mod spectrum;

pub use cell_box::CellBox;
pub use cells::{Cells, SIDE};
pub use code::CyclicCode;
pub use octaves::broad_band;
pub use pattern::{Direction, Strand, XorPattern};
pub use polynomial::primitive_polynomials;
pub use projection::{GroundExtent, Projection};
pub use strand::{FixedBox, StrandMeans};
pub use tile::{CELLS_PER_VOXEL, Tile};
