//! Features of maps: from files to what stands over each voxel.

mod kinds;
mod layer;
mod meaning;
mod place;
mod read;
mod shape;

pub use kinds::{
    Barrier, Building, Cap, Dashes, FeatureClass, FieldRows, LaneLines, Leaf, Meaning, Paint, PowerLine,
    Rise, Roof, RoofShape, Top, Tree, Upright, Way, WayKind, Wire, Wood,
};
pub use layer::{
    Area, Attributes, Columns, Geometry, Junction, Layer, LayerOptions, LeftOut, Path, Row, Value,
};
pub use meaning::{Interpreted, WATER, colour, interpret, interpret_all, unknown_columns};
pub(super) use meaning::{length, mix, share};
pub use place::{Feature, place};
pub(super) use read::OutlineTable;
pub use read::read;
pub use shape::{
    Bound, BoundBarrier, BoundBridge, BoundBuilding, BoundCover, BoundTree, BoundUpright, BoundWay,
    BoundWire, BoundWood, Graded, Ground, PlacedSolid, PlacedTree, Rank, Solid, Square, TreeKind, Wall, bind,
    prepare, settle,
};
pub(super) use shape::{Footprint, HalfPlane, foot_of};
