//! Assembly of a track from the fixes of a file.

use std::collections::BTreeMap;

use super::camera_row::{CameraRow, TimedRow};
use super::parts;
use super::track::{Fix, Horizontal, Track};
use crate::flight::raw::{CLOCK, COORDINATE_LIMIT, DURATION_LIMIT, PathSource, RawFix, Reading};
use hedgehop_base::error::{Error, Result};

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
    let rows: BTreeMap<u64, &CameraRow> = reading.cameras.iter().map(|row| (row.line, row)).collect();
    let mut cameras = Vec::new();

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

        cameras.extend(rows.get(&raw.line).map(|row| TimedRow { time, row: **row }));
        kept.push(Fix { time, horizontal: wrapped(raw.fix.horizontal), ..raw.fix });
        last = *raw;
    }

    let mut notes = reading.notes;
    if repeated > 0 {
        notes.push(format!("{repeated} fixes repeat the time of the fix before them and were dropped."));
    }

    let clock = reading.epoch.map(|epoch| epoch.clock_at(first.fix.time));
    Ok(Track { path: source.path.to_owned(), format, fixes: kept, clock, notes, cameras })
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
