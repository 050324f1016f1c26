//! Options and report of measuring heights.

use std::path::PathBuf;

use super::super::features::{Layer, LayerOptions};
use super::super::options::{ElevationFile, ImageryFile};
use crate::shadow_height::Answer;
use hedgehop::sunlight::{Sun, SunSetting};

/// Options of measuring heights.
#[derive(Debug, Clone)]
pub struct ShadowOptions {
    /// The buildings: GeoJSON, a Shapefile, a GeoPackage, or a table (`.csv`).
    pub buildings: PathBuf,
    /// Options of reading them.
    pub layer: LayerOptions,
    /// Time of the photograph, or position of the sun then; azimuths from grid north of the buildings' system.
    pub sun: SunSetting,
    /// Bare ground, highest priority first; may be empty: the ground is level then.
    pub elevation: Vec<ElevationFile>,
    /// Photographs, highest priority first; may be empty: rows state their shadows then.
    pub imagery: Vec<ImageryFile>,
    /// Coordinates of rasters without a CRS are metres.
    pub local: bool,
    /// Pixel size of rasters that have no georeferencing at all, metres.
    pub raw_spacing: Option<f64>,
    /// Highest that a building may be, metres, > 0: so far its shadow is looked for.
    pub highest_m: f64,
    /// Rows that state a height are measured, too.
    pub all: bool,
    /// Worker threads, ≥ 1.
    pub threads: usize,
}

/// Report of the measurement.
#[derive(Debug, Clone)]
pub struct ShadowReport {
    /// The buildings.
    pub layer: Layer,
    /// Answers for each row of the layer, in its order.
    pub answers: Vec<Answer>,
    /// The sun over the middle of the layer, its azimuth from true north (of local layers from the y axis).
    pub sun: Sun,
    /// Notes on what was assumed, and which rows have no height and why.
    pub notes: Vec<String>,
}
