//! Database modelling: rasters in, voxel pages out.

pub mod features;
pub mod raster;
pub mod shadow_height;

mod bake;
mod budget;
mod build;
mod census;
mod cloud;
mod corridor;
mod drape;
mod fill;
mod inputs;
mod kernel;
mod mosaic;
pub mod object;
mod options;
mod page;
mod placed;
mod plan;
mod scan;
mod standing;
mod steps;
pub mod synthetic;
#[cfg(test)]
mod tests;
mod tint;
mod vertical;
mod warp;
mod workers;
mod writing;

pub use bake::{bake_shadows, check_shadows};
pub use build::{BuildReport, Outline, build, outline};
pub use corridor::{Corridor, Place, Route};
pub use inputs::{Input, faults};
pub use options::{
    BuildOptions, CloudFile, ElevationFile, FeatureFile, ImageryFile, Interpolation, NodataFill,
};
pub use steps::{forget_steps, is_own_work};
