//! The scan-plane engine: sixteen vertical planes in lockstep, from the eye outward.
//!
//! ```text
//! for each block of lines along the major axis, nearest first:
//!     its highest surface lies below the next open row of every plane → next block
//!     for each line of the block, a stride apart:
//!         z = height of the line where each plane crosses it           one gather
//!         z is above the ray of a plane's next open row →
//!             for each row up to z:  row's inverse depth, from the segment since the last line
//! ```
//!
//! A *line* is a row of posts of one level, across the planes' *major axis* (x or y, whichever they run along):
//! all sixteen cross it at once, a few voxels apart, and interpolation is needed along it only. Over a
//! single-valued surface a ray with a higher elevation angle cannot end nearer, so each plane keeps
//! the first row that is still open, and rows fill from the bottom to the top (range coherence: Nack et al.,
//! US 5,317,689, 1994, claim 14; lines in lockstep and highest row reached: VoxelSpace, 1992).
//!
//! A *row* is given by the tangent of its elevation angle alone: projections with other rows only need
//! another table. What is written is inverse depth, 0 for the sky: between two lines the surface
//! is a segment, and the row's ray meets it at
//!
//! ```text
//! e = z − t·w at both ends (height above the ray);  1/w = (e₁ − e₀) / (e₁·w₀ − e₀·w₁)
//! ```
//!
//! which is exact for the segment, so that silhouettes end where the surface does and not at a step.
//!
//! How far lines lie apart follows from the footprint of a pixel, see [`Strides`].

mod blocks;
mod bounds;
mod fan;
mod ground;
mod lines;
mod march;
mod pages;
mod segment;
mod strides;
#[cfg(test)]
mod tests;
mod upright;

pub use fan::PlaneGroup;
pub use march::{PlaneMarch, Rows};
pub use pages::Pages;
pub use segment::EDGE_STEPS;
pub use strides::Strides;
pub use upright::{LevelRow, Look, Upright};
