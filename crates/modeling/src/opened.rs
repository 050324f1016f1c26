//! A source that was opened.

use std::path::PathBuf;

use super::kernel::Samples;
use crate::raster::GeoTransform;
use hedgehop::Size;
use hedgehop_geo::{Crs, VerticalDatum};

/// A raster and where it says it lies.
pub(super) struct Opened<T> {
    pub path: PathBuf,
    pub samples: Box<dyn Samples<T>>,
    /// Natural block for reading.
    pub block: Size,
    pub geo: GeoTransform,
    pub crs: Crs,
    /// Datum of heights, as stated, given or assumed; means nothing for imagery.
    pub datum: VerticalDatum,
    pub description: String,
    /// All that its side files and the user say of it, for keys of steps.
    pub facts: String,
}

/// A part of a build.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// A file of points, by its place in [`crate::BuildOptions::clouds`].
    Cloud(usize),
    /// Elevation, by its place in [`crate::BuildOptions::elevation`].
    Elevation(usize),
    /// Imagery, by its place in [`crate::BuildOptions::imagery`].
    Imagery(usize),
    /// Land cover, by its place in [`crate::BuildOptions::land_cover`].
    LandCover(usize),
    /// Features, by their place in [`crate::BuildOptions::features`].
    Features(usize),
    /// Object, by its place in [`crate::BuildOptions::objects`].
    Object(usize),
    /// Scatter, by its place in [`crate::BuildOptions::scatters`].
    Scatter(usize),
    /// A shape of the ground, by its place in [`super::synthetic::Synthetic::terrain`].
    Terrain(usize),
    /// A pattern on it, by its place in [`super::synthetic::Synthetic::textures`].
    Texture(usize),
    /// Paint on it, by its place in [`super::synthetic::Synthetic::patches`].
    Patch(usize),
}
