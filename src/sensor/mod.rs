//! Conversion of surface samples to radiance; so far the visual sensor.

mod facets;
#[doc(hidden)]
pub mod radiance;
mod visual;

#[doc(hidden)]
pub use facets::{Facets, ShadedFacets};
#[doc(hidden)]
pub use visual::VisualSensor;
