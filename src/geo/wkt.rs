//! WKT.
use super::{crs::Crs, datum::VerticalCrs};
pub(super) fn looks_like_wkt(_: &str) -> bool {
    false
}
pub(super) fn read(_: &str) -> Result<(Crs, Option<VerticalCrs>), String> {
    Err("not read yet".into())
}
