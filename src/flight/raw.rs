//! The common end of all readers: from fixes with line numbers to a checked [`Track`].

use std::path::Path;

use super::parts::{self, Recording};
use super::track::{Altitude, Fix, Horizontal, ReadOptions, Track};
use hedgehop_base::error::{Error, Result};

/// Farthest coordinate from the origin, metres. Beyond any projection of the Earth, and small enough that splines
/// stay finite.
pub(super) const COORDINATE_LIMIT: f64 = 1e9;
/// Resolution of clocks in path files, seconds: none is finer than a microsecond, and seconds since 1970 in a double
/// are good to a quarter of one. Fixes that are closer have the same time.
pub(super) const CLOCK: f64 = 1e-6;
/// Longest flight, seconds (about thirty years): catches a damaged date.
const DURATION_LIMIT: f64 = 1e9;

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
        let fix = Fix { time, horizontal, altitude, yaw: None, pitch: None, roll: None, hfov: None };
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

/// Everything that a reader found in a path file.
#[derive(Debug)]
pub(super) struct Reading {
    pub format: &'static str,
    pub fixes: Vec<RawFix>,
    /// Recordings that the fixes are of, in the file's order; none where the format has but one.
    pub parts: Vec<Recording>,
    /// Several of them in the format's own words.
    pub noun: &'static str,
    pub notes: Vec<String>,
}

impl Reading {
    /// Fixes of a format that holds a single recording.
    pub fn of_one(format: &'static str, fixes: Vec<RawFix>, notes: Vec<String>) -> Self {
        Self { format, fixes, parts: Vec::new(), noun: "", notes }
    }
}

/// Checks ranges and the order of times, drops fixes with the time of their predecessor, and starts the clock at 0.
pub(super) fn assemble(source: &PathSource<'_>, mut reading: Reading) -> Result<Track> {
    parts::choose(source, &mut reading)?;
    let Reading { format, ref fixes, .. } = reading;
    let Some(first) = fixes.first().copied() else {
        return Err(Error::invalid(
            source.path,
            format!("this {format} holds no fix; give at least one position"),
        ));
    };

    let swapped = looks_swapped(fixes);
    let mut kept: Vec<Fix> = Vec::with_capacity(fixes.len());
    let mut last = first;
    let mut repeated = 0_usize;

    for raw in fixes {
        check_ranges(source, raw, swapped)?;
        let step = raw.fix.time - last.fix.time;
        if step < 0.0 {
            return Err(source.at_line(
                raw.line,
                format!(
                    "times are out of order: this fix is {:.3} s before the one of line {}; {}",
                    -step,
                    last.line,
                    parts::remedy(&reading)
                ),
            ));
        }

        let time = raw.fix.time - first.fix.time;
        if !time.is_finite() || time > DURATION_LIMIT {
            return Err(source.at_line(raw.line, "the time is more than thirty years after the first fix"));
        }
        if step < CLOCK && !kept.is_empty() {
            repeated += 1;
            continue;
        }

        kept.push(Fix { time, horizontal: wrapped(raw.fix.horizontal), ..raw.fix });
        last = *raw;
    }

    let mut notes = reading.notes;
    if repeated > 0 {
        notes.push(format!("{repeated} fixes repeat the time of the fix before them and were dropped."));
    }

    Ok(Track { path: source.path.to_owned(), format, fixes: kept, notes })
}

/// Some latitude is none, and all longitudes could be latitudes.
fn looks_swapped(fixes: &[RawFix]) -> bool {
    let mut outside = false;
    for raw in fixes {
        if let Horizontal::LonLat(longitude, latitude) = raw.fix.horizontal {
            outside |= latitude.abs() > 90.0;
            if longitude.abs() > 90.0 {
                return false;
            }
        }
    }
    outside
}

fn check_ranges(source: &PathSource<'_>, raw: &RawFix, swapped: bool) -> Result<()> {
    let fix = &raw.fix;
    let fail = |what: String| Err(source.at_line(raw.line, what));
    let within = |value: f64, limit: f64| value.abs() <= limit; // false for NaN
    if !fix.time.is_finite() {
        return fail("the time is not a finite number".into());
    }

    match fix.horizontal {
        Horizontal::LonLat(longitude, latitude) => {
            if !within(latitude, 90.0) {
                let remedy = if swapped {
                    "longitude and latitude are swapped; exchange the two column names"
                } else {
                    "a latitude lies within −90…90 degrees"
                };
                return fail(format!("latitude {latitude} is outside the Earth; {remedy}"));
            }
            if !(-180.0..=360.0).contains(&longitude) {
                return fail(format!("longitude {longitude} is outside −180…360 degrees"));
            }
        }
        Horizontal::Xy(x, y) => {
            if !within(x, COORDINATE_LIMIT) || !within(y, COORDINATE_LIMIT) {
                return fail(format!(
                    "position ({x:e}, {y:e}) is more than {COORDINATE_LIMIT:e} m from the origin"
                ));
            }
        }
    }

    if !within(fix.altitude.metres, COORDINATE_LIMIT) {
        return fail(format!("altitude {:e} m is more than {COORDINATE_LIMIT:e} m", fix.altitude.metres));
    }
    if let Some(pitch) = fix.pitch.filter(|&pitch| !within(pitch, 90.0)) {
        return fail(format!("pitch {pitch} is outside −90…90 degrees (nose up is positive)"));
    }

    for (name, angle) in [("yaw", fix.yaw), ("roll", fix.roll)] {
        if let Some(angle) = angle.filter(|&angle| !within(angle, 3600.0)) {
            return fail(format!("{name} {angle} is more than ten turns; give degrees"));
        }
    }

    if let Some(hfov) = fix.hfov.filter(|&hfov| !(hfov > 0.0 && hfov < 180.0)) {
        return fail(format!("hfov {hfov} is not between 0 and 180 degrees"));
    }

    Ok(())
}

/// Longitudes of 180…360° as −180…0°.
fn wrapped(horizontal: Horizontal) -> Horizontal {
    match horizontal {
        Horizontal::LonLat(longitude, latitude) if longitude > 180.0 => {
            Horizontal::LonLat(longitude - 360.0, latitude)
        }
        other => other,
    }
}
