//! Models in the database: read from files, made of voxels, placed one by one or scattered.
//!
//! ```text
//! model ──soup──▶ triangles over its foot, in pieces that enclose something or are sheets
//!       ──rays──▶ over each voxel: where vertical rays are inside, and which faces are steep
//!       ──fit───▶ a few solids over each voxel: a shape                                        once for all that are placed alike
//! [[object]], [[scatter]] ──▶ placements ──raise──▶ solids over a block                         (standing, scatter, placement)
//! ```

mod bands;
mod built_in;
mod fit;
mod mask;
mod open;
mod options;
mod placement;
mod placing;
mod rays;
mod scatter;
mod shape;
mod soup;
#[cfg(test)]
mod tests;

pub use built_in::BuiltIn;
pub(super) use open::{OpenObject, OpenScatter, open_object, open_scatter};
pub use options::{ObjectFile, ScatterFile, ScatterForm};
pub(super) use placing::{ObjectGround, Objects};
pub(super) use shape::Shape;
pub use soup::Stance;
