//! Hedgehop: a CPU image generator for low flight over real terrain.

pub mod error;
pub mod flight;
pub mod frame;
pub mod geo;
pub mod memory;
pub mod modeling;
pub mod progress;
pub mod space;
pub mod voxel;

pub use error::{Error, Result};
