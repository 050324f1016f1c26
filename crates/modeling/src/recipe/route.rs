//! Route of a path file over the ground.

use std::path::Path;

use crate::{Place, Route};
use hedgehop::flight::{Fix, Horizontal, ReadOptions, read_track};
use hedgehop_base::error::Result;

/// Reads the route of a path file over the ground.
///
/// # Errors
/// A file that is no path.
pub fn route(file: &Path, options: &ReadOptions) -> Result<Route> {
    let place = |fix: &Fix| match fix.horizontal {
        Horizontal::LonLat(longitude, latitude) => Place::LonLat(longitude, latitude),
        Horizontal::Xy(x, y) => Place::Xy(x, y),
    };
    let track = read_track(file, options)?;
    Ok(Route { file: file.to_owned(), places: track.fixes.iter().map(place).collect() })
}
