//! Database modelling: rasters in, voxel pages out.

pub mod features;
pub mod raster;
pub mod recipe;
pub mod shadow_height;

mod bake;
mod bare;
mod budget;
mod build;
mod build_cache;
mod built;
mod cloud;
mod corridor;
mod counts;
mod disk_space;
mod drape;
mod elevation_survey;
mod extract;
mod faults;
mod feather;
mod feature_solids;
mod fineness;
mod footprint;
mod groves;
mod inputs;
mod kernel;
mod land_cover;
mod materials;
mod merge;
mod mosaic;
mod naming;
mod natural;
pub mod object;
mod opened;
mod options;
mod page;
mod page_keys;
mod placed;
mod placing;
mod plan;
mod plausible;
mod reach;
mod source_heights;
mod sources;
mod survey_result;
pub mod synthetic;
#[cfg(test)]
mod tests;
mod texture_match;
mod tint;
mod vertical;
mod void_fill;
mod warnings;
mod warp;
mod workers;
mod writing;

pub use bake::{Baked, Baking, bake_shadows, check_shadows};
pub use build::{BuildReport, Outline, build, check_name, check_output, outline};
pub use build_cache::{forget_steps, is_kept_for, is_own_work, take_over};
pub use corridor::{Corridor, Place, Route};
pub use extract::{ExtractPart, extract};
pub use faults::faults;
pub use land_cover::{LandCoverFile, Scheme};
pub use materials::{Finish, Materials};
pub use merge::{Join, MergeInput, Merged, Merger};
pub use opened::Input;
pub use options::{
    BuildOptions, CloudFile, ElevationFile, FeatureFile, ImageryFile, Interpolation, NodataFill, OutputFile,
};
