//! The reference marcher: one ray at a time through the hierarchy of voxels, in double precision.
//!
//! ```text
//! for each level L whose band of ground distance the ray crosses, nearest first:
//!     walk the voxels of the coarsest level along the ray:
//!         the ray stays above the voxel's upper bound   → next voxel
//!         else walk the voxels one level finer inside it, down to the level above L
//!         there, walk the cells of level L's surface and intersect each exactly
//! no cell was hit: the sky
//! ```
//!
//! After Nack et al., *Digital visual and sensor simulation system*, US 5,317,689 (1994): levels
//! 1/4/16/64, stepping from voxel border to voxel border, and a range threshold per level,
//! `TH_L = L / A_PIX`. Skipping by upper bounds is that of maximum mipmaps (Tevs, Ihrke and Seidel,
//! *Maximum mipmaps for fast, accurate, and scalable dynamic height field rendering*, 2008).
//!
//! Where this deviates, and why:
//!
//! 1. The patent steps at level 64 until opaque and then refines; here a coarse voxel is only ever
//!    skipped when its bound proves that nothing in it is hit, so the answer is exact.
//! 2. The thresholds are compared with [`LevelBands`]' measure, which depends on ground distance
//!    alone within a frame. Then all rays of a vertical plane see the same surface at the same
//!    place, and range coherence within the plane is exact across changes of level.
//! 3. The surface is bilinear between the posts (voxel centres) of the level by default;
//!    [`Surface::Blocks`] gives the voxels themselves. Near the eye the finest one may be
//!    [displaced](crate::detail::Displacement): bounds grow by as much as it may be there.
//!
//! The surface is the top of a solid: a ray that is under it where it starts, where a level begins,
//! or beyond a hole, ends right there.

mod bands;
mod blocks;
mod column;
mod cursor;
mod displaced;
mod filter;
mod ground_lanes;
mod march;
mod ray;
#[doc(hidden)]
pub mod scan;
mod sectors;
mod solid;
mod surface;
#[cfg(test)]
mod tests;
mod walk;
#[cfg(test)]
mod world_tests;

pub use bands::{LevelBands, SPAN_PIXELS, SpanBand};
pub(crate) use blocks::BlockTable;
#[doc(hidden)]
pub use column::{Column, march_column};
#[doc(hidden)]
pub use cursor::PageCursor;
#[doc(hidden)]
pub use filter::{SurfaceFilter, SurfaceSample};
#[doc(hidden)]
pub use ground_lanes::{
    GroundLanes, MOST_PIXELS_ALONG, MOST_SECANTS, MetGround, NEAR_ENOUGH, NEAR_ENOUGH_PER_METRE, RayLanes,
};
#[doc(hidden)]
pub use march::Contact;
pub use march::Marcher;
pub use ray::GridRay;
#[doc(hidden)]
pub use sectors::SectorHorizons;
#[doc(hidden)]
pub use solid::{Face, SolidHit, Solids};
#[doc(hidden)]
pub use surface::endless_ground_height;
pub use surface::{Surface, ground_height};
#[doc(hidden)]
pub use walk::{CellRect, CellStep, CellWalk, Extent, Lattice};
