//! Options of a build: inputs and settings.

use std::path::{Path, PathBuf};

use super::corridor::Corridor;
use super::features::LayerOptions;
use super::land_cover::LandCoverFile;
use super::materials::Materials;
use super::object::{ObjectFile, ScatterFile};
use super::synthetic::Synthetic;
use hedgehop_geo::VerticalDatum;

/// File that a database is written to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutputFile<'a> {
    /// Path of the file.
    pub path: &'a Path,
    /// Whether a file that is there may be replaced.
    pub overwrite: bool,
}

/// Treatment of voxels whose source has no data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NodataFill {
    /// Leaves them without a surface; rays pass.
    None,
    /// Interpolates those that are enclosed by heights and at most 64 finest voxels long and wide; others stay without a surface.
    Small,
    /// Interpolated from the heights around.
    Interpolate,
    /// A fixed height, metres above the database's datum.
    Value(f64),
}

/// Interpolation of heights between posts, where voxels are finer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight between two by two posts.
    #[default]
    Linear,
    /// Rounded between four by four.
    Bicubic,
    /// Rounded between six by six.
    Spline,
}

/// An elevation raster, and what it does not say of itself.
#[derive(Debug, Clone, Default)]
pub struct ElevationFile {
    /// The file.
    pub path: PathBuf,
    /// CRS of the file, if it states none.
    pub crs: Option<String>,
    /// Datum of its heights, if it does not state that.
    pub datum: Option<VerticalDatum>,
    /// Values that mean "no data" besides what it declares.
    pub nodata: Vec<f64>,
}

/// A point cloud, and what it does not say of itself.
#[derive(Debug, Clone, Default)]
pub struct CloudFile {
    /// The file: LAS or LAZ.
    pub path: PathBuf,
    /// CRS of the file, if it states none.
    pub crs: Option<String>,
    /// Datum of its heights, if it does not state that.
    pub datum: Option<VerticalDatum>,
    /// Whether its ground alone is taken: no buildings, plants, wires.
    pub ground_only: bool,
}

/// An image of the ground, and what it does not say of itself.
#[derive(Debug, Clone, Default)]
pub struct ImageryFile {
    /// The file.
    pub path: PathBuf,
    /// CRS of the file, if it states none.
    pub crs: Option<String>,
    /// One-based bands to take as red, green, blue; `None` chooses.
    pub bands: Option<[u32; 3]>,
    /// Edges of its outer pixels, if it has no georeferencing: west, south, east, north in coordinates of `crs`; without that in degrees
    /// (WGS 84) where they can be, else in coordinates of the first elevation file.
    pub extent: Option<[f64; 4]>,
}

/// A file of features, and what it does not say of itself.
#[derive(Debug, Clone, Default)]
pub struct FeatureFile {
    /// The file: GeoJSON, a Shapefile, a GeoPackage, or a table of outlines.
    pub path: PathBuf,
    /// Options of reading it.
    pub options: LayerOptions,
}

impl From<PathBuf> for FeatureFile {
    fn from(path: PathBuf) -> Self {
        Self { path, ..Self::default() }
    }
}

impl From<PathBuf> for CloudFile {
    fn from(path: PathBuf) -> Self {
        Self { path, ..Self::default() }
    }
}

impl From<PathBuf> for ElevationFile {
    fn from(path: PathBuf) -> Self {
        Self { path, ..Self::default() }
    }
}

impl From<PathBuf> for ImageryFile {
    fn from(path: PathBuf) -> Self {
        Self { path, ..Self::default() }
    }
}

/// Options of a build.
#[derive(Debug, Clone)]
pub struct BuildOptions {
    /// Point clouds: ground above all other elevation, and what stands on it; may be empty.
    pub clouds: Vec<CloudFile>,
    /// Elevation, highest priority first; at least one, unless there are clouds or synthetic ground has a base.
    pub elevation: Vec<ElevationFile>,
    /// Imagery, highest priority first; may be empty.
    pub imagery: Vec<ImageryFile>,
    /// Maps of land cover, highest priority first; may be empty.
    pub land_cover: Vec<LandCoverFile>,
    /// The materials of the place.
    pub materials: Materials,
    /// Features that stand or lie on the ground; may be empty.
    pub features: Vec<FeatureFile>,
    /// Models that stand on it; may be empty.
    pub objects: Vec<ObjectFile>,
    /// Models that are scattered over it; may be empty.
    pub scatters: Vec<ScatterFile>,
    /// Terrain and detail that no file holds.
    pub synthetic: Synthetic,
    /// Interpolation of heights between posts.
    pub interpolation: Interpolation,
    /// The database to write.
    pub output: PathBuf,
    /// Replace an existing file.
    pub overwrite: bool,
    /// Note beside the output what each step was made of, so that the next build of it makes only what changed.
    pub steps: bool,
    /// The database that this one is kept for, if it is the one without its shadows: noted with the steps, see [`is_kept_for`](super::is_kept_for).
    pub kept_for: Option<PathBuf>,
    /// CRS of the database as the user typed it; `None` chooses.
    pub crs: Option<String>,
    /// Coordinates of files without a CRS are metres; the database has no place on Earth.
    pub local: bool,
    /// Side of the finest voxel, metres; `None`: that of the finest elevation input, or the finest of the corridors' spacings.
    pub spacing: Option<f64>,
    /// Parts that are stored more finely than the rest; empty: the whole area is stored at its finest.
    pub corridors: Vec<Corridor>,
    /// Side of the finest voxels outside of all corridors, metres: 4, 16, 64, … times the finest of all; `None`: of these the largest
    /// that is no wider than the pixels of the coarsest elevation input. Means nothing without corridors.
    pub outside: Option<f64>,
    /// Pixel size for inputs that have no georeferencing at all (PNG, raw), metres.
    pub raw_spacing: Option<f64>,
    /// Area to build: west, south, east, north in the database's CRS; `None`: all that elevation covers. Without elevation it must be given.
    pub bbox: Option<[f64; 4]>,
    /// Treatment of voids.
    pub nodata_fill: NodataFill,
    /// Bytes that the build may hold resident.
    pub memory: u64,
    /// Worker threads, ≥ 1.
    pub threads: usize,
}

/// Bytes that a build may hold unless told otherwise.
const DEFAULT_MEMORY: u64 = 512 << 20;

impl BuildOptions {
    /// Everything that `elevation` covers, draped with `imagery`, into the new file `output`: all choices left to
    /// the program, voids kept, 512 MiB, one worker per core.
    pub fn new(elevation: Vec<PathBuf>, imagery: Vec<PathBuf>, output: PathBuf) -> Self {
        Self {
            clouds: Vec::new(),
            elevation: elevation.into_iter().map(ElevationFile::from).collect(),
            imagery: imagery.into_iter().map(ImageryFile::from).collect(),
            land_cover: Vec::new(),
            materials: Materials::default(),
            features: Vec::new(),
            objects: Vec::new(),
            scatters: Vec::new(),
            synthetic: Synthetic::default(),
            interpolation: Interpolation::default(),
            output,
            overwrite: false,
            steps: false,
            kept_for: None,
            crs: None,
            local: false,
            spacing: None,
            corridors: Vec::new(),
            outside: None,
            raw_spacing: None,
            bbox: None,
            nodata_fill: NodataFill::None,
            memory: DEFAULT_MEMORY,
            threads: std::thread::available_parallelism().map_or(1, usize::from),
        }
    }
}
