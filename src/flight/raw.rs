//! The common end of all readers: from fixes with line numbers to a checked [`Track`](super::track::Track).

use std::path::Path;

use super::camera_row::CameraRow;
use super::track::{Altitude, Fix, Horizontal, ReadOptions, TrackClock};
use hedgehop_base::error::Error;

/// Farthest coordinate from the origin, metres. Beyond any projection of the Earth, and small enough that splines
/// stay finite.
pub(super) const COORDINATE_LIMIT: f64 = 1e9;
/// Resolution of clocks in path files, seconds: none is finer than a microsecond, and seconds since 1970 in a double
/// are good to a quarter of one. Fixes that are closer have the same time.
pub(super) const CLOCK: f64 = 1e-6;
/// Seconds of a day.
pub(super) const DAY: f64 = 86_400.0;
/// Longest flight, seconds (about thirty years): catches a damaged date.
pub(super) const DURATION_LIMIT: f64 = 1e9;

/// A fix and the line where it stands.
#[derive(Debug, Clone, Copy)]
pub(super) struct RawFix {
    /// Line of the file, from 1.
    pub line: u64,
    /// The fix; `time` is in seconds since any epoch.
    pub fix: Fix,
}

impl RawFix {
    /// A fix that says where, when and how high, but nothing of attitude.
    pub fn positioned(line: u64, time: f64, horizontal: Horizontal, altitude: Altitude) -> Self {
        let (accuracy, [yaw, pitch, roll, hfov]) = (None, [None; 4]);
        let fix = Fix { time, horizontal, altitude, accuracy, yaw, pitch, roll, hfov };
        Self { line, fix }
    }
}

/// The file that is read, for messages, and what the user said about it.
#[derive(Debug, Clone, Copy)]
pub(super) struct PathSource<'a> {
    pub path: &'a Path,
    pub options: &'a ReadOptions,
}

impl PathSource<'_> {
    /// Something is wrong at `line`.
    pub fn at_line(&self, line: u64, what: impl std::fmt::Display) -> Error {
        Error::invalid(self.path, format!("line {line}: {what}"))
    }
}

/// Midnight, UTC, that times of a clock count from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Epoch {
    /// Midnight of a day that is not told.
    SomeDay,
    /// Midnight so many seconds after 1970-01-01T00:00:00Z.
    Day(f64),
}

impl Epoch {
    /// Midnight that seconds since 1970 count from.
    pub const UNIX: Self = Self::Day(0.0);

    /// Returns the clock that shows `time`, seconds after this midnight.
    pub fn clock_at(self, time: f64) -> TrackClock {
        let time_of_day = time.rem_euclid(DAY);
        let midnight = match self {
            Self::SomeDay => None,
            Self::Day(midnight) => Some(midnight + DAY * (time / DAY).floor()),
        };
        TrackClock { time_of_day, midnight }
    }
}

/// Everything that a reader found in a path file.
#[derive(Debug)]
pub(super) struct Reading {
    pub format: &'static str,
    pub fixes: Vec<RawFix>,
    /// Recordings that the fixes are of, in the file's order; none where the format has but one.
    pub parts: Vec<Recording>,
    /// Several of them in the format's own words.
    pub noun: &'static str,
    /// Moment that the fixes' times count from, if they are of a clock.
    pub epoch: Option<Epoch>,
    /// Cameras, a row for each fix, if the format has some.
    pub cameras: Vec<CameraRow>,
    pub notes: Vec<String>,
}

impl Reading {
    /// Fixes of a format that holds a single recording, and what their times count from.
    pub fn of_one(
        format: &'static str,
        fixes: Vec<RawFix>,
        epoch: Option<Epoch>,
        notes: Vec<String>,
    ) -> Self {
        Self { format, fixes, parts: Vec::new(), noun: "", epoch, cameras: Vec::new(), notes }
    }
}

/// A recording within a file.
#[derive(Debug, Clone)]
pub(super) struct Recording {
    /// Name in the file.
    pub name: Option<String>,
    /// Index of its first fix among those of the whole file; it ends where the next one begins.
    pub start: usize,
}
