//! What heights are measured from.

use serde::{Deserialize, Serialize};

/// Vertical datum of heights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum VerticalDatum {
    /// Mean sea level, not further specified (assumed where a file is silent).
    Msl,
    /// EGM96 geoid.
    Egm96,
    /// EGM2008 geoid.
    Egm2008,
    /// WGS 84 ellipsoid.
    Ellipsoid,
    /// NAVD88.
    Navd88,
}

/// Height of the EGM96 geoid above the WGS 84 ellipsoid, metres. Longitude and latitude in degrees.
pub fn egm96_undulation(longitude: f64, latitude: f64) -> f64 {
    let _ = (longitude, latitude);
    todo!()
}
