//! Features of maps: from files to what stands over each voxel.

mod kinds;
mod layer;
mod read;

pub use kinds::Class;
pub use layer::{Area, Attributes, Columns, Geometry, Layer, LayerOptions, LeftOut, Path, Row, Value};
pub use read::read;
