//! Trajectories: path files, interpolation, attitude.

mod track;
mod trajectory;

pub use track::{Altitude, AltitudeMode, Fix, Horizontal, ReadOptions, Track, read_track};
pub use trajectory::{BindOptions, Trajectory};
