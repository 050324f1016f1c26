//! Sensors: from a surface sample to radiance.

mod visual;

pub use visual::{Sun, VisualSensor};
