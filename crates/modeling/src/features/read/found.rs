//! Findings of every reader of features.

use std::fs;
use std::path::Path;

use super::super::layer::{LeftOut, Row};
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// Largest GeoJSON and Shapefile, bytes: they are read whole. GeoPackages are read page by page.
const MOST_BYTES: u64 = 2 << 30;

/// Findings of every reader.
#[derive(Debug, Default)]
pub(super) struct FoundRows {
    pub(super) rows: Vec<Row>,
    pub(super) left_out: LeftOut,
    /// Notes, as what follows the file's name.
    pub(super) notes: Vec<String>,
    /// Reference system that the file states.
    pub(super) crs: Option<Crs>,
    /// Reference system that its format means where neither it nor the options say.
    pub(super) otherwise: Option<Crs>,
}

/// All bytes of a file that is not too large for that.
pub(super) fn whole(path: &Path) -> Result<Vec<u8>> {
    let length = fs::metadata(path).map_err(|error| Error::io(path, "read", error))?.len();
    if length > MOST_BYTES {
        return Err(Error::unsupported(
            path,
            format!("has {length} bytes, more than {MOST_BYTES}"),
            "convert it: ogr2ogr -f GPKG FEATURES.gpkg FILE",
        ));
    }
    fs::read(path).map_err(|error| Error::io(path, "read", error))
}

/// A message of other code, in one line of bounded length.
pub(super) fn plain(message: &str) -> String {
    message.chars().take(200).map(|c| if c.is_control() { ' ' } else { c }).collect()
}
