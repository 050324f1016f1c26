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
mod estimate;
mod footprint;
mod octaves;
mod pattern;
mod pixel_tone;
mod polynomial;
mod projection;
mod rounding;
mod shades;
mod strand;
mod subterrain;
mod tile;

#[cfg(test)]
mod spectrum;

pub use cell_box::CellBox;
pub use cells::{Cells, SIDE};
pub use code::CyclicCode;
pub use estimate::{GroupEstimate, group_means};
pub use footprint::{Footprint, Slice, Stacking, TonalGroups};
pub use octaves::broad_band;
pub use pattern::{Direction, Strand, XorPattern};
pub use pixel_tone::{Averaging, PixelTones};
pub use polynomial::primitive_polynomials;
pub use projection::{GroundExtent, Projection};
pub use shades::Shades;
pub use strand::{FixedBox, StrandMeans};
pub use subterrain::{Subterrain, SubterrainCode};
pub use tile::{CELLS_PER_VOXEL, Tile};
