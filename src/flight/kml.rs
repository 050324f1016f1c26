//! KML `gx:Track`: `when` and `gx:coord` in step, `gx:angles` if there are any.
//!
//! OGC 12-007r2 (KML 2.3), clause 11.7 (Track). `when` and `coord` are two lists of one length, however they are
//! interleaved. Angles are heading, tilt, roll; tilt is taken as nose up, roll as right wing down.
//!
//! Altitude modes: `absolute` is above mean sea level, `relativeToGround` above ground, `clampToGround` (KML's default)
//! puts the eye on the ground. A track with altitudes but without any mode is read as `absolute`, with a note, because
//! exporters forget the element more often than they mean a clamped flight.

use super::raw::{Epoch, PathSource, RawFix, Reading};
use super::timestamp::unix_seconds;
use super::track::{Altitude, AltitudeMode, Fix, Horizontal};
use super::xml::{XmlPlace, XmlStep, walk};
use crate::flight::raw::Recording;
use hedgehop_base::error::{Error, Result};

/// The lists of one `gx:Track`.
#[derive(Default)]
struct Lists {
    line: u64,
    times: Vec<f64>,
    /// Line and numbers; no numbers where the data is missing.
    coordinates: Vec<(u64, Vec<f64>)>,
    angles: Vec<Vec<f64>>,
    mode: Option<String>,
}

#[derive(Default)]
struct Tracks {
    open: Option<Lists>,
    fixes: Vec<RawFix>,
    /// Name of the placemark around.
    name: Option<String>,
    tracks: Vec<Recording>,
    lines_without_time: bool,
    missing: usize,
    notes: Vec<String>,
}

pub(super) fn read(source: &PathSource<'_>, text: &str) -> Result<Reading> {
    let mut tracks = Tracks::default();
    walk(source, text, |place, step| tracks.visit(source, place, step))?;
    if tracks.fixes.is_empty() {
        let (what, remedy) = if tracks.lines_without_time {
            (
                "there is a LineString but no gx:Track, and a line has no times",
                "export with times (gx:Track), or write a CSV with a time_s column",
            )
        } else {
            ("there is no gx:Track with a position", "export a recorded track, with times")
        };
        return Err(Error::unsupported(source.path, what, remedy));
    }

    let mut notes = tracks.notes;
    if tracks.missing > 0 {
        notes.push(format!("{} fixes without position were dropped.", tracks.missing));
    }

    notes.dedup();
    Ok(Reading {
        format: "KML gx:Track",
        fixes: tracks.fixes,
        parts: tracks.tracks,
        noun: "tracks",
        epoch: Some(Epoch::UNIX),
        cameras: Vec::new(),
        notes,
    })
}

impl Tracks {
    fn visit(&mut self, source: &PathSource<'_>, place: XmlPlace<'_>, step: XmlStep<'_>) -> Result<()> {
        match (place.name, step, self.open.as_mut()) {
            ("Placemark", XmlStep::Open(_), _) => self.name = None,
            ("name", XmlStep::Close(text), None) => {
                self.name = Some(text.to_owned()).filter(|name| !name.is_empty());
            }
            ("Track", XmlStep::Open(_), _) => {
                self.open = Some(Lists { line: place.line, ..Lists::default() })
            }
            ("LineString", XmlStep::Open(_), _) => self.lines_without_time = true,
            ("Track", XmlStep::Close(_), _) => {
                if let Some(lists) = self.open.take() {
                    self.tracks.push(Recording { name: self.name.clone(), start: self.fixes.len() });
                    self.close(source, lists)?;
                }
            }
            ("when", XmlStep::Close(text), Some(lists)) => {
                lists.times.push(unix_seconds(text).ok_or_else(|| {
                    source.at_line(
                        place.line,
                        format!(
                            "when {text:?} is no ISO 8601 date and time; write e.g. 2026-05-01T12:00:00Z"
                        ),
                    )
                })?)
            }
            ("coord", XmlStep::Close(text), Some(lists)) => {
                lists.coordinates.push((place.line, numbers(source, place, text)?));
            }
            ("angles", XmlStep::Close(text), Some(lists)) => lists.angles.push(numbers(source, place, text)?),
            ("altitudeMode", XmlStep::Close(text), Some(lists)) => lists.mode = Some(text.to_owned()),
            _ => {}
        }

        Ok(())
    }

    fn close(&mut self, source: &PathSource<'_>, lists: Lists) -> Result<()> {
        let count = lists.coordinates.len();
        if lists.times.len() != count || !(lists.angles.is_empty() || lists.angles.len() == count) {
            return Err(source.at_line(
                lists.line,
                format!(
                    "this gx:Track has {} when, {count} gx:coord and {} gx:angles; give one of each per fix",
                    lists.times.len(),
                    lists.angles.len()
                ),
            ));
        }

        let mode = self.altitude_mode(source, &lists)?;
        for (index, (line, coordinate)) in lists.coordinates.iter().enumerate() {
            let &[longitude, latitude, ref rest @ ..] = coordinate.as_slice() else {
                self.missing += 1;
                continue;
            };

            let metres = match (mode, rest.first()) {
                (None, _) => 0.0,
                (Some(_), Some(&metres)) => metres,
                (Some(_), None) => {
                    return Err(source
                        .at_line(*line, "this gx:coord has no altitude; write longitude latitude altitude"));
                }
            };

            let altitude = Altitude { metres, mode: mode.unwrap_or(AltitudeMode::Agl) };
            let horizontal = Horizontal::LonLat(longitude, latitude);
            let mut raw = RawFix::positioned(*line, lists.times[index], horizontal, altitude);
            let angle = |which: usize| lists.angles.get(index).and_then(|angles| angles.get(which)).copied();
            raw.fix = Fix { yaw: angle(0), pitch: angle(1), roll: angle(2), ..raw.fix };
            self.fixes.push(raw);
        }

        Ok(())
    }

    /// `None`: clamped to the ground, whatever altitudes say.
    fn altitude_mode(&mut self, source: &PathSource<'_>, lists: &Lists) -> Result<Option<AltitudeMode>> {
        match lists.mode.as_deref() {
            Some("absolute") => Ok(Some(AltitudeMode::Msl)),
            Some("relativeToGround") => Ok(Some(AltitudeMode::Agl)),
            Some("clampToGround" | "clampToSeaFloor") => {
                self.notes
                    .push("The track is clamped to the ground; --clearance lifts the eye above it.".into());
                Ok(None)
            }
            Some("relativeToSeaFloor") => Err(source.at_line(
                lists.line,
                "altitudeMode relativeToSeaFloor is not flown; use absolute or relativeToGround",
            )),
            Some(other) => Err(source.at_line(
                lists.line,
                format!("altitudeMode {other:?} is unknown; use absolute or relativeToGround"),
            )),
            None => {
                if source.options.altitude_mode.is_none() {
                    self.notes.push(
                        "The track states no altitudeMode; altitudes are taken as metres above mean sea level \
                         (--alt-mode says otherwise)."
                            .into(),
                    );
                }
                Ok(Some(source.options.altitude_mode.unwrap_or(AltitudeMode::Msl)))
            }
        }
    }
}

/// Numbers between blanks (Google's tools) or commas (others).
fn numbers(source: &PathSource<'_>, place: XmlPlace<'_>, text: &str) -> Result<Vec<f64>> {
    text.split(|letter: char| letter.is_whitespace() || letter == ',')
        .filter(|word| !word.is_empty())
        .map(|word| {
            word.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(|| {
                source.at_line(place.line, format!("{word:?} in {} is no finite number", place.name))
            })
        })
        .collect()
}
