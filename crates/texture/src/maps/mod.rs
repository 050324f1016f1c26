//! Ground maps: texture of linear functions over the ground, of tables along axes, and of both by material.
//!
//! Source: Bunker and Ferris 1977 (AFHRL-TR-77-66), texture by modulation maps and quantities.

mod axis;
mod blend;
mod board;
mod face_axes;
mod material;
mod quantity;
mod six;
mod tiled;
mod wave;

pub use axis::ZoneTable;
pub use board::{BoardFace, TestBoard};
pub use face_axes::FaceAxes;
pub use material::MapMaterial;
pub use quantity::{LinearFunction, QuantityMode, QuantityTexture};
pub use six::SixMaps;
pub(crate) use tiled::{tiled_maps, tiled_quantity, tiled_waves};
pub use wave::Sinusoid;
