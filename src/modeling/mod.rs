//! Database modelling: rasters in, voxel pages out.

pub mod raster;

mod budget;
mod build;
mod colour;
mod drape;
mod fill;
mod inputs;
mod kernel;
mod mosaic;
mod page;
mod plan;
mod scan;
#[cfg(test)]
mod tests;
mod tint;
mod vertical;
mod warp;
mod workers;

pub use build::{BuildOptions, BuildReport, NodataFill, build};
