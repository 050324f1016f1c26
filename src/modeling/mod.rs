//! Database modelling: rasters in, voxel pages out.

pub mod raster;

mod build;

pub use build::{BuildOptions, BuildReport, NodataFill, build};
