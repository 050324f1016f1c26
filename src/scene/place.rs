//! Keys that say where something stands.

use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;

use crate::flight::{Altitude, AltitudeMode, Fix, Horizontal, Track};
use hedgehop_base::document::Reading;
use hedgehop_base::error::Result;

/// Metres from the origin of a reference system beyond which nothing is.
const FARTHEST: f64 = 1.0e9;

/// Keys of a place.
pub(super) const PLACE_KEYS: [&str; 2] = ["at", "at_lonlat"];

/// Surface that altitudes are measured from.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Above {
    Agl,
    Msl,
    Ellipsoid,
}

impl From<Above> for AltitudeMode {
    fn from(above: Above) -> Self {
        match above {
            Above::Agl => Self::Agl,
            Above::Msl => Self::Msl,
            Above::Ellipsoid => Self::Ellipsoid,
        }
    }
}

/// Place of something, as its table says.
pub(super) struct Place<'t> {
    /// Owner of the place, as a clause.
    pub whose: &'t str,
    /// Keys of its two places: metres of the database's reference system, and degrees.
    pub keys: [&'t str; 2],
    pub at: Option<&'t Spanned<Vec<f64>>>,
    pub at_lonlat: Option<&'t Spanned<Vec<f64>>>,
    pub altitude: Option<Above>,
    pub yaw: Option<&'t Spanned<f64>>,
    pub pitch: Option<&'t Spanned<f64>>,
    pub roll: Option<&'t Spanned<f64>>,
    /// Span of its table.
    pub span: Range<usize>,
}

impl Place<'_> {
    /// Anchors a light here, or to the object that it goes with.
    pub fn anchor(&self, reading: &Reading<'_>, object: Option<&Spanned<String>>) -> Result<Anchor> {
        let Some(object) = object else { return self.track(reading).map(Anchor::At) };
        let places = [self.at, self.at_lonlat].into_iter().flatten().map(Spanned::span);
        match places.into_iter().next() {
            Some(span) => {
                let what = "what goes with an object is where that is; offset_m says where on it";
                Err(reading.wrong(span, what))
            }
            None => Ok(Anchor::On(object.get_ref().clone())),
        }
    }

    /// Converts to a track of one fix.
    pub fn track(&self, reading: &Reading<'_>) -> Result<Track> {
        let (horizontal, metres) = match (self.at, self.at_lonlat) {
            (Some(at), None) => {
                let [x, y, z] = finite(reading, self.keys[0], at)?;
                (Horizontal::Xy(x, y), z)
            }
            (None, Some(at)) => {
                let [lon, lat, z] = finite(reading, self.keys[1], at)?;
                if lon.abs() > 360.0 || lat.abs() > 90.0 {
                    let what = format!(
                        "{} must be [longitude, latitude, altitude], not {:?}",
                        self.keys[1],
                        at.get_ref()
                    );
                    return Err(reading.wrong(at.span(), what));
                }
                (Horizontal::LonLat(lon, lat), z)
            }
            (Some(_), Some(second)) => {
                return Err(reading.wrong(second.span(), "give at or at_lonlat, not both"));
            }
            (None, None) => {
                let what = format!("{} needs at or at_lonlat", self.whose);
                return Err(reading.wrong(self.span.clone(), what));
            }
        };

        let angle = |key: &str, value: Option<&Spanned<f64>>, most: f64| match value {
            Some(value) => {
                let want = format!("must lie between -{most} and {most} degrees");
                reading.number(key, value, |degrees| degrees.abs() <= most, &want)
            }
            None => Ok(0.0),
        };

        let fix = Fix {
            time: 0.0,
            horizontal,
            altitude: Altitude { metres, mode: self.altitude.unwrap_or(Above::Agl).into() },
            accuracy: None,
            yaw: Some(angle("yaw_deg", self.yaw, 360.0)?),
            pitch: Some(angle("pitch_deg", self.pitch, 90.0)?),
            roll: Some(angle("roll_deg", self.roll, 360.0)?),
            hfov: None,
        };

        let path = format!("{}, {}", reading.path.display(), self.whose).into();
        Ok(Track {
            path,
            format: "single place",
            fixes: vec![fix],
            clock: None,
            notes: Vec::new(),
            cameras: Vec::new(),
        })
    }
}

/// Three numbers that may be a place.
pub(super) fn finite(reading: &Reading<'_>, key: &str, at: &Spanned<Vec<f64>>) -> Result<[f64; 3]> {
    let place: [f64; 3] = reading.numbers(key, at)?;
    if place.into_iter().all(|value| value.abs() <= FARTHEST) {
        return Ok(place);
    }
    Err(reading.wrong(at.span(), format!("{key} must be three numbers of 10⁹ at most, not {place:?}")))
}

/// Anchor of a light.
#[derive(Debug, Clone)]
pub enum Anchor {
    /// Fixed place; the only fix.
    At(Track),
    /// Object of this name, in whose axes its lamps lie.
    On(String),
}
