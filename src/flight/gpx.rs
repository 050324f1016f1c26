//! GPX 1.0 and 1.1: the points of all tracks, in the file's order.
//!
//! <https://www.topografix.com/GPX/1/1/>. `ele` is metres above mean sea level, `hdop` tells how sure a point
//! is. Routes and waypoints carry no times of flight and are not flown.

use super::raw::{Epoch, PathSource, RawFix, Reading};
use super::timestamp::unix_seconds;
use super::track::{Altitude, AltitudeMode, Horizontal};
use super::xml::{XmlPlace, XmlStep, attribute, walk};
use crate::flight::raw::Recording;
use hedgehop_base::error::{Error, Result};

/// A track point while its element is open.
struct TrackPoint {
    line: u64,
    depth: usize,
    longitude: f64,
    latitude: f64,
    elevation: Option<f64>,
    time: Option<f64>,
    /// Horizontal dilution of precision.
    hdop: Option<f64>,
}

/// Points so far, and what was met on the way.
#[derive(Default)]
struct Points {
    open: Option<TrackPoint>,
    fixes: Vec<RawFix>,
    /// Depth of the open track's element, and what it is called.
    track: usize,
    name: Option<String>,
    segments: Vec<Recording>,
    without_elevation: usize,
    routes_or_waypoints: bool,
}

pub(super) fn read(source: &PathSource<'_>, text: &str) -> Result<Reading> {
    let mut points = Points::default();
    walk(source, text, |place, step| points.visit(source, place, step))?;
    let mut notes = Vec::new();
    if points.fixes.is_empty() {
        return Err(points.nothing_to_fly(source));
    }
    if points.without_elevation > 0 {
        notes.push(format!("{} points without elevation were dropped.", points.without_elevation));
    }
    if source.options.altitude_mode.is_none() {
        notes.push("Elevations are taken as metres above mean sea level, as GPX defines them.".into());
    }
    Ok(Reading {
        format: "GPX",
        fixes: points.fixes,
        parts: points.segments,
        noun: "track segments",
        epoch: Some(Epoch::UNIX),
        cameras: Vec::new(),
        notes,
    })
}

impl Points {
    fn visit(&mut self, source: &PathSource<'_>, place: XmlPlace<'_>, step: XmlStep<'_>) -> Result<()> {
        match (place.name, step) {
            ("trk", XmlStep::Open(_)) => (self.track, self.name) = (place.depth, None),
            ("name", XmlStep::Close(text)) if place.depth == self.track + 1 && self.open.is_none() => {
                self.name = Some(text.to_owned()).filter(|name| !name.is_empty());
            }
            ("trkseg", XmlStep::Open(_)) => {
                self.segments.push(Recording { name: self.name.clone(), start: self.fixes.len() });
            }
            ("rtept" | "wpt", XmlStep::Open(_)) => self.routes_or_waypoints = true,
            ("trkpt", XmlStep::Open(start)) => {
                let degrees = |name: &str| {
                    let text = attribute(start, name);
                    let value = text.as_deref().and_then(|text| text.trim().parse::<f64>().ok());
                    value.filter(|value| value.is_finite()).ok_or_else(|| {
                        let found = text.map_or("is missing".into(), |text| format!("is {text:?}"));
                        source.at_line(
                            place.line,
                            format!("{name} of this trkpt {found}; write decimal degrees"),
                        )
                    })
                };

                self.open = Some(TrackPoint {
                    line: place.line,
                    depth: place.depth,
                    longitude: degrees("lon")?,
                    latitude: degrees("lat")?,
                    elevation: None,
                    time: None,
                    hdop: None,
                });
            }
            ("trkpt", XmlStep::Close(_)) => self.close(source)?,
            ("ele", XmlStep::Close(text)) => {
                if let Some(point) = self.child(place) {
                    point.elevation = Some(number(source, place, text)?);
                }
            }
            // A value that is no number tells nothing; the point is sound without it.
            ("hdop", XmlStep::Close(text)) => {
                if let Some(point) = self.child(place) {
                    point.hdop = text.parse().ok().filter(|hdop: &f64| hdop.is_finite() && *hdop > 0.0);
                }
            }
            ("time", XmlStep::Close(text)) => {
                if let Some(point) = self.child(place) {
                    point.time = Some(unix_seconds(text).ok_or_else(|| {
                        source.at_line(
                            place.line,
                            format!(
                                "time {text:?} is no ISO 8601 date and time; write e.g. 2026-05-01T12:00:00Z"
                            ),
                        )
                    })?);
                }
            }
            _ => {}
        }

        Ok(())
    }

    /// The open point, if `place` is its direct child (extensions have elements of the same names).
    fn child(&mut self, place: XmlPlace<'_>) -> Option<&mut TrackPoint> {
        self.open.as_mut().filter(|point| place.depth == point.depth + 1)
    }

    fn close(&mut self, source: &PathSource<'_>) -> Result<()> {
        let Some(point) = self.open.take() else { return Ok(()) };
        let time = point.time.ok_or_else(|| {
            source.at_line(
                point.line,
                "this trkpt has no time, and without times there is no speed; record with times, or write a CSV with \
                 a time_s column",
            )
        })?;
        let Some(metres) = point.elevation else {
            self.without_elevation += 1;
            return Ok(());
        };
        let mode = source.options.altitude_mode.unwrap_or(AltitudeMode::Msl);
        let horizontal = Horizontal::LonLat(point.longitude, point.latitude);
        let mut raw = RawFix::positioned(point.line, time, horizontal, Altitude { metres, mode });
        raw.fix.accuracy = point.hdop;
        self.fixes.push(raw);
        Ok(())
    }

    fn nothing_to_fly(&self, source: &PathSource<'_>) -> Error {
        let (what, remedy) = if self.without_elevation > 0 {
            ("no track point has an elevation (ele)", "write a CSV with an alt_agl_m column")
        } else if self.routes_or_waypoints {
            ("there are waypoints or routes but no track (trk), and so no times", "export a recorded track")
        } else {
            ("there is no track point (trkpt)", "export a recorded track")
        };
        Error::unsupported(source.path, what, remedy)
    }
}

fn number(source: &PathSource<'_>, place: XmlPlace<'_>, text: &str) -> Result<f64> {
    text.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(|| {
        source.at_line(
            place.line,
            format!("{} {text:?} is no finite number; write metres, with a point", place.name),
        )
    })
}
