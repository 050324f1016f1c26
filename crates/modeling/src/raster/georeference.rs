//! Place and system of a raster, as files beside it state them.

use std::path::Path;

use crate::raster::{GeoTransform, RasterInfo};
use hedgehop_geo::{Crs, LocalSystem};

/// Takes the CRS that a text in `source` states, or notes why it cannot be taken.
pub(super) fn set_crs(info: &mut RasterInfo, source: &Path, wkt: &str) {
    if info.local.is_none() {
        info.local = LocalSystem::from_wkt(wkt);
    }
    match Crs::with_vertical_from_text(wkt) {
        Ok((crs, vertical)) => {
            info.crs = Some(crs);
            info.vertical = std::mem::take(&mut info.vertical).or(vertical.unwrap_or_default());
        }
        Err(problem) if source == info.path => info.crs_problem = Some(problem),
        Err(problem) => info.crs_problem = Some(format!("in {}: {problem}", source.display())),
    }
}

/// A transform that takes pixels to distinct places.
pub(super) fn is_sound(geo: &GeoTransform) -> bool {
    let determinant = geo[1] * geo[5] - geo[2] * geo[4];
    geo.iter().all(|n| n.is_finite()) && determinant != 0.0 && determinant.is_finite()
}
