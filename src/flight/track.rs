//! Tracks: the content of path files, before it is bound to a database.

use std::path::PathBuf;

use super::camera_row::TimedRow;

/// Horizontal position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Horizontal {
    /// WGS 84 longitude and latitude (geodetic), degrees.
    LonLat(f64, f64),
    /// Metres in the database's CRS (x east, y north).
    Xy(f64, f64),
}

/// Level that an altitude is measured from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AltitudeMode {
    /// Mean sea level (the database's datum).
    Msl,
    /// The ground below.
    Agl,
    /// The WGS 84 ellipsoid; EGM96 is subtracted.
    Ellipsoid,
}

/// Altitude, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Altitude {
    /// Metres.
    pub metres: f64,
    /// Level that it is measured from.
    pub mode: AltitudeMode,
}

/// One fix of a track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fix {
    /// Seconds since the first fix, increasing.
    pub time: f64,
    /// Horizontal position.
    pub horizontal: Horizontal,
    /// Altitude and its level.
    pub altitude: Altitude,
    /// Error of the position that the receiver expects, above 0, if the file gives it: metres, or a dilution of precision.
    /// Only its ratio to that of other fixes counts.
    pub accuracy: Option<f64>,
    /// Clockwise from true north, degrees, if the file gives it.
    pub yaw: Option<f64>,
    /// Nose up, degrees, if given.
    pub pitch: Option<f64>,
    /// Right wing down, degrees, if given.
    pub roll: Option<f64>,
    /// Horizontal field of view, degrees, if given.
    pub hfov: Option<f64>,
}

/// A path file's content.
#[derive(Debug, Clone)]
pub struct Track {
    /// The file.
    pub path: PathBuf,
    /// Format for people: `CSV`, `JSBSim CSV`, `KML gx:Track`, `GPX`, `IGC`.
    pub format: &'static str,
    /// At least one fix, times strictly increasing.
    pub fixes: Vec<Fix>,
    /// Clock at the first fix, if the file tells the time.
    pub clock: Option<TrackClock>,
    /// Assumptions made and data dropped, as sentences.
    pub notes: Vec<String>,
    /// Rows of the file's columns of cameras, if it has some.
    pub cameras: Vec<TimedRow>,
}

/// Clock of a path file at its first fix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackClock {
    /// Seconds after midnight, UTC.
    pub time_of_day: f64,
    /// Midnight before it, seconds since 1970-01-01T00:00:00Z, if the file tells the day.
    pub midnight: Option<f64>,
}

impl TrackClock {
    /// Returns the seconds since 1970-01-01T00:00:00Z, if the file tells the day.
    pub fn unix_seconds(&self) -> Option<f64> {
        self.midnight.map(|midnight| midnight + self.time_of_day)
    }
}

/// Answers of the user to what a file leaves open.
#[derive(Debug, Clone, Default)]
pub struct ReadOptions {
    /// Altitude mode where the file does not state one.
    pub altitude_mode: Option<AltitudeMode>,
    /// The one of several tracks (segments of GPX, `gx:Track`s of KML) that is read, counted from 1; `None`: all of them, joined.
    pub track: Option<usize>,
    /// Whether fixes are put in the order of their times; without it, times that go back are an error.
    pub sort: bool,
}
