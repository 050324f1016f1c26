//! Conversion of surface samples to radiance; so far the visual sensor.

mod facets;
pub mod radiance;
mod visual;

pub use facets::{Facets, ShadedFacets};
pub use visual::VisualSensor;
