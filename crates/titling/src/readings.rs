//! Readings of a flight, as figures and instruments show them.

use glam::DVec2;

/// State of a flight in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Readings {
    /// Heading of the aircraft's nose, degrees clockwise from grid north.
    pub heading: f64,
    /// Above the database's datum, metres.
    pub altitude: f64,
    /// Above the ground straight below, metres; `None` where there is none.
    pub above_ground: Option<f64>,
    /// Over ground, and upward, metres per second; `None` where nothing moves.
    pub speed: Option<[f64; 2]>,
    /// The frame's number.
    pub frame: u64,
    /// Since the film's first frame, seconds of the film.
    pub film_seconds: f64,
    /// Since the flight's first fix, seconds.
    pub seconds: f64,
    /// Time of day, UTC, seconds after midnight; `None`: the track tells none.
    pub clock: Option<f64>,
    /// Place of what flies, metres.
    pub place: DVec2,
    /// Longitude and latitude of that place, degrees (WGS 84); `None`: the area has no place on Earth.
    pub lonlat: Option<[f64; 2]>,
}
