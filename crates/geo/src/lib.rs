//! Coordinate reference systems and vertical datums.

mod choice;
mod crs;
mod datum;
mod definition;
mod geodetic;
mod geokey_directory;
mod geokeys;
mod geokeys_projection;
mod heights;
mod local;
mod notation;
mod projection;
mod registry;
mod shift;
mod transform;
mod undulation;
mod units;
mod user;
mod wkt;
mod wkt_names;
mod wkt_system;
mod written;

pub use crs::Crs;
pub use datum::{VerticalCrs, VerticalDatum, VerticalShift};
pub use geokeys::{GeoKeys, parse_geokeys};
pub use local::LocalSystem;
pub use transform::{GridNorth, Transform, grid_convergence};
pub use undulation::egm96_undulation;
pub use written::WrittenKeys;
#[cfg(test)]
mod tests;
