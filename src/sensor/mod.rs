//! From surface samples to radiance; so far the visual sensor.

pub mod radiance;
mod visual;

pub use visual::VisualSensor;
