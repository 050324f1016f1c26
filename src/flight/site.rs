//! Site of a film: the ground below its cameras, and places on it.

use std::fmt;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::aim::Subject;
use super::track::Track;
use super::trajectory::{BindOptions, Trajectory};
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// Least height of an eye of its own above the ground and what stands there, metres, unless the user says otherwise.
pub(super) const CLEARANCE: f64 = 2.0;

/// Place that a film is made in.
pub struct FilmSite<'a> {
    /// Reference system of the database.
    pub crs: &'a Crs,
    /// Surface height (metres) below a position of that system; `None` outside the area or where there is no surface.
    pub ground: &'a dyn Fn(DVec2) -> Option<f64>,
    /// Finds an object of the scene by its name.
    pub object: &'a dyn Fn(&str) -> Option<Arc<dyn Subject>>,
    /// Least height of the eye above the ground, metres; `None`: cameras of their own keep 2 m.
    pub clearance: Option<f64>,
}

impl fmt::Debug for FilmSite<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("FilmSite").field("clearance", &self.clearance).finish_non_exhaustive()
    }
}

/// A place, metres of the database's system.
pub(super) fn place(track: &Track, site: &FilmSite<'_>) -> Result<DVec3> {
    bound_place(track, site, &BindOptions::default()).map(|bound| bound.pose_at(0.0).eye)
}

/// Binds places that are no flight.
pub(super) fn bound_place(track: &Track, site: &FilmSite<'_>, options: &BindOptions) -> Result<Trajectory> {
    match Trajectory::bind(track, site.crs, site.ground, options) {
        Ok(bound) => Ok(bound),
        // Remedies for a path are none for a place.
        Err(Error::Invalid { what, .. }) => {
            let what = what.split(';').next().unwrap_or_default();
            let whose = track.path.display();
            Err(Error::Configuration(format!(
                "{whose}: {what}; take a place on the database's ground, or give its altitude above sea level"
            )))
        }
        Err(other) => Err(other),
    }
}
