//! The flight that a film shows, of which a scene may hold the body.

use std::path::{Path, PathBuf};

use super::contents::Object;
use crate::flight::BindOptions;

/// A flight whose body is where the flight is: as smooth, and as high above the ground.
#[derive(Debug, Clone)]
pub struct OwnFlight {
    /// File of its path, without links on the way.
    file: PathBuf,
    /// Options by which its path is bound.
    options: BindOptions,
}

impl OwnFlight {
    /// Names the flight of a path file and how it is bound; `None`: there is no such file.
    pub fn new(file: &Path, options: BindOptions) -> Option<Self> {
        Some(Self { file: file.canonicalize().ok()?, options })
    }

    /// Whether an object has the flight's path as its track.
    pub fn has_body(&self, object: &Object) -> bool {
        object.track.path.canonicalize().is_ok_and(|track| track == self.file)
    }

    /// Returns the options by which an object's track is bound.
    pub(super) fn options_of(flight: Option<&Self>, object: &Object) -> BindOptions {
        let own = flight.filter(|flight| flight.has_body(object)).map(|flight| flight.options);
        BindOptions { level: !object.banks, ..own.unwrap_or_default() }
    }
}
