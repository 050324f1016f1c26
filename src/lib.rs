//! Hedgehop: a CPU image generator for low flight over real terrain.

pub mod colour;
pub mod error;
pub mod flight;
pub mod frame;
pub mod geo;
pub mod memory;
pub mod modeling;
pub mod progress;
pub mod raymarch;
pub mod render;
pub mod sensor;
pub mod space;
pub mod subimage;
pub mod voxel;

pub use error::{Error, Result};
