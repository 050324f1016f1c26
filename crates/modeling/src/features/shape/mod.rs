//! Things over voxels: pure geometry in metres of the database's system.
//!
//! ```text
//! prepare once: bridges of several ways are one; buildings that have parts are these
//! bind    once for each feature: what it stands on          (needs heights of the ground)
//! grade   for each feature and square of voxels: what it makes of the ground
//! raise   for each feature and square of voxels: its solids
//! ```
//! Squares do not know of each other: what a feature does to a voxel follows from the feature and the voxel's place alone.

mod bind;
mod building;
mod cover;
mod facade;
mod field_rows;
mod footprint;
#[cfg(test)]
mod footprint_tests;
mod frame;
mod junctions;
mod lane_lines;
#[cfg(test)]
mod marking_tests;
mod node;
mod patch;
mod prepare;
mod profile;
mod ribbon;
mod roof;
#[cfg(test)]
mod roof_tests;
mod round;
mod sectors;
mod solid;
mod strips;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod tree_kind;
mod walls;
mod way;
mod wire;

pub use bind::{Bound, bind};
pub use building::BoundBuilding;
pub(in super::super) use building::foot_of;
pub use cover::{BoundBarrier, BoundCover, BoundWood};
pub(in super::super) use footprint::Footprint;
pub use patch::HalfPlane;
pub use prepare::prepare;
pub use round::{BoundTree, BoundUpright};
pub use solid::{Ground, PlacedSolid, Solid, Square, Wall};
pub use tree_kind::{PlacedTree, TreeKind};
pub use way::{BoundBridge, BoundWay, Graded, Rank, settle};
pub use wire::BoundWire;
