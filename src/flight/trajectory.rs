//! A track bound to a database: a pose for any time.

use glam::DVec2;

use super::Track;
use crate::error::Result;
use crate::geo::Crs;
use crate::space::Pose;

/// How a track becomes a trajectory.
#[derive(Debug, Clone, Copy)]
pub struct BindOptions {
    /// Derived attitude is without bank.
    pub level: bool,
    /// Horizontal field of view where the track gives none, degrees.
    pub hfov: f64,
    /// Least height above ground, metres; lower fixes are raised. `None`: as the file says.
    pub clearance: Option<f64>,
}

/// A pose for any time between start and end.
#[derive(Debug, Clone)]
pub struct Trajectory {}

impl Trajectory {
    /// Binds a track to a database's CRS; `ground` gives the surface height (metres) below a position of that CRS,
    /// `None` outside the area or where there is no surface.
    pub fn bind(
        track: &Track,
        crs: &Crs,
        ground: &dyn Fn(DVec2) -> Option<f64>,
        options: &BindOptions,
    ) -> Result<Self> {
        let _ = (track, crs, ground, options);
        todo!()
    }
    /// Length, seconds.
    pub fn duration(&self) -> f64 {
        todo!()
    }
    /// Frames at `fps`: numbers 1 … count; frame n is at (n − 1)/fps seconds.
    pub fn frame_count(&self, fps: f64) -> u64 {
        let _ = fps;
        todo!()
    }
    /// Pose at `seconds` after the start, clamped to the trajectory.
    pub fn pose_at(&self, seconds: f64) -> Pose {
        let _ = seconds;
        todo!()
    }
    /// What was derived or assumed, as sentences.
    pub fn notes(&self) -> &[String] {
        todo!()
    }
}
