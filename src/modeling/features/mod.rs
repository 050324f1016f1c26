//! Features of maps: from files to what stands over each voxel.

mod kinds;
mod layer;
mod meaning;
mod read;

pub use kinds::{
    Barrier, Building, Cap, Class, Leaf, Meaning, Paint, PowerLine, Rise, Roof, RoofShape, Top, Tree,
    Upright, Way, WayKind, Wire, Wood,
};
pub use layer::{Area, Attributes, Columns, Geometry, Layer, LayerOptions, LeftOut, Path, Row, Value};
pub use meaning::{Interpreted, Material, interpret, interpret_all};
pub use read::read;
