//! Trajectories: path files, interpolation, attitude.
//!
//! ```text
//! path file ──read_track──▶ Track (fixes, as the file says) ──Trajectory::bind──▶ pose_at(seconds)
//! Trajectory and Shots ──Rig::bind──▶ pose_at(seconds) of the camera
//! Views, without a path ──Rig::of_views──▶ the same
//! poses so far, without a file ──Extrapolation──▶ pose_at(seconds)
//! ```

mod aim;
mod angles;
mod assemble;
mod banded;
mod camera_row;
mod camera_shots;
mod csv;
mod extrapolation;
mod eye_path;
mod fit;
mod gpx;
mod ground;
mod igc;
mod kml;
mod motion;
mod moving;
mod noise;
mod parts;
mod rate;
mod raw;
mod read;
mod rig;
mod sampling;
mod shot;
mod site;
mod smooth;
mod spline;
mod timeline;
mod timestamp;
mod track;
mod trajectory;
mod views;
mod xml;

#[doc(hidden)]
pub use aim::Subject;
pub(crate) use angles::Samples;
#[doc(hidden)]
pub use camera_shots::camera_shots;
pub(crate) use csv::{Wanted, read_columns};
#[doc(hidden)]
pub use extrapolation::Extrapolation;
pub use rate::FrameRate;
pub use read::read_track;
#[doc(hidden)]
pub use rig::Rig;
#[doc(hidden)]
pub use shot::{Chase, Ease, Keys, Look, Mount, Orbit, Shot, Zoom};
#[doc(hidden)]
pub use site::FilmSite;
pub use smooth::Smoothing;
#[doc(hidden)]
pub use timeline::{FlightSpan, FlightTime, Pace, Playback, Timeline};
#[doc(hidden)]
pub use track::Horizontal;
pub use track::{Altitude, AltitudeMode, Fix, ReadOptions, Track, TrackClock};
pub use trajectory::{BindOptions, Trajectory};
#[doc(hidden)]
pub use views::{GridViews, OrbitViews, RandomViews, ViewLayout, Views};
