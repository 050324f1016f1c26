//! One object of a scene file.

use std::fs;
use std::ops::Range;
use std::path::PathBuf;

use glam::DVec3;
use serde::Deserialize;
use toml::Spanned;

use super::file::Reading;
use super::look::{LevelTable, Look, Up, model, refuse_keys};
use super::model::{Models, Origin};
use super::place::{Above, PLACE_KEYS, Place};
use super::{Beyond, Object};
use crate::colour::linear_from_srgb8;
use crate::error::{Error, Result};
use crate::flight::{AltitudeMode, ReadOptions, Track, read_track};
use crate::objects::{Form, Shape};

/// Grey of objects that are given no colour.
const GREY: [u8; 3] = [150; 3];

/// Characters of the longest name.
const MOST_NAME: usize = 200;

/// Pixels of the greatest width that a line or a point is to have at least.
const MOST_PIXELS: f64 = 100.0;

/// Metres of the largest object: what is larger is ground.
pub(super) const LARGEST: f64 = 100_000.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[object]]")]
pub(super) struct ObjectTable {
    pub(super) name: String,
    pub(super) shape: Option<Spanned<Kind>>,
    radius_m: Option<Spanned<f64>>,
    radii_m: Option<Spanned<Vec<f64>>>,
    size_m: Option<Spanned<Vec<f64>>>,
    height_m: Option<Spanned<f64>>,
    width_m: Option<Spanned<f64>>,
    width_px: Option<Spanned<f64>>,
    size_px: Option<Spanned<f64>>,
    to: Option<Spanned<Vec<f64>>>,
    colour: Option<Spanned<String>>,
    at: Option<Spanned<Vec<f64>>>,
    at_lonlat: Option<Spanned<Vec<f64>>>,
    altitude: Option<Spanned<Above>>,
    yaw_deg: Option<Spanned<f64>>,
    pitch_deg: Option<Spanned<f64>>,
    roll_deg: Option<Spanned<f64>>,
    track: Option<Spanned<PathBuf>>,
    start_s: Option<Spanned<f64>>,
    bank: Option<Spanned<bool>>,
    beyond: Option<Spanned<Beyond>>,
    pub(super) model: Option<Spanned<PathBuf>>,
    pub(super) scale: Option<Spanned<f64>>,
    pub(super) length_m: Option<Spanned<f64>>,
    pub(super) turn_deg: Option<Spanned<Vec<f64>>>,
    pub(super) up: Option<Spanned<Up>>,
    pub(super) origin: Option<Spanned<Origin>>,
    #[serde(default)]
    pub(super) levels: Vec<Spanned<LevelTable>>,
}

impl ObjectTable {
    /// Whether it says how long a line is.
    pub(super) fn is_line(&self) -> bool {
        self.shape.as_ref().is_some_and(|kind| matches!(kind.get_ref(), Kind::Line))
    }
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Kind {
    Sphere,
    Ellipsoid,
    Box,
    Cylinder,
    Cone,
    Disc,
    Line,
    Point,
}

/// Keys that say how large a shape is.
struct Sizes<'t, 'f> {
    reading: &'t Reading<'f>,
    table: &'t ObjectTable,
    shape: Range<usize>,
    name: &'static str,
}

pub(super) fn object(
    reading: &Reading<'_>,
    table: Spanned<ObjectTable>,
    models: &mut Models,
    hasher: &mut blake3::Hasher,
) -> Result<Object> {
    let span = table.span();
    let table = table.into_inner();
    let line = reading.line(&span);
    let name = &table.name;
    if name.trim().is_empty() || name.chars().any(char::is_control) || name.chars().count() > MOST_NAME {
        return Err(
            reading.wrong(span, format!("an object's name must be 1 to {MOST_NAME} printable characters"))
        );
    }
    let Look { form, files, notes } = match (&table.shape, &table.model) {
        (Some(given), None) => {
            refuse_keys(reading, &table)?;
            Look { form: form(reading, &table, given)?, files: Vec::new(), notes: Vec::new() }
        }
        (None, Some(path)) => {
            let none = Sizes { reading, table: &table, shape: path.span(), name: "model" };
            none.takes(&[])?;
            model(reading, &table, path, models, hasher)?
        }
        (Some(_), Some(path)) => return Err(reading.wrong(path.span(), "give shape or model, not both")),
        (None, None) => return Err(reading.wrong(span, format!("object `{name}` needs shape or model"))),
    };
    let albedo = match &table.colour {
        Some(colour) => srgb(colour.get_ref()).ok_or_else(|| {
            reading.wrong(colour.span(), format!("colour must be #rrggbb (sRGB), not {:?}", colour.get_ref()))
        })?,
        None => GREY,
    };
    let start = match &table.start_s {
        Some(_) if table.track.is_none() => {
            return Err(
                reading.wrong(span, "start_s says when a track begins; give one, or leave start_s out")
            );
        }
        Some(start) => reading.number("start_s", start, |_| true, "must be finite")?,
        None => 0.0,
    };
    let track = match &table.track {
        Some(track) => moving(reading, &table, track, hasher)?,
        None => standing(reading, &table, span)?,
    };
    let to = table.to.as_ref().map(|to| end(reading, &table, to)).transpose()?;
    let beyond = match &table.beyond {
        Some(beyond) if table.track.is_none() => {
            let what = "beyond says what an object does beyond its track; give one, or leave beyond out";
            return Err(reading.wrong(beyond.span(), what));
        }
        beyond => beyond.as_ref().map(|beyond| *beyond.get_ref()).unwrap_or_default(),
    };
    let banks = table.bank.as_ref().is_some_and(|bank| *bank.get_ref());
    let albedo = linear_from_srgb8(albedo);
    Ok(Object { name: table.name, line, form, files, notes, albedo, track, to, start, beyond, banks })
}

fn form(reading: &Reading<'_>, table: &ObjectTable, given: &Spanned<Kind>) -> Result<Form> {
    let (kind, shape) = (*given.get_ref(), given.span());
    let sizes = |name| Sizes { reading, table, shape: shape.clone(), name };
    let shape = match kind {
        Kind::Line => {
            let sizes = sizes("line");
            sizes.takes(&["width_m", "width_px", "to"])?;
            let length = match (&table.to, &table.length_m) {
                // Until both ends are known in the database's reference system.
                (Some(_), None) => 1.0,
                (None, length) => sizes.one("length_m, or to", length)?,
                (Some(_), Some(length)) => {
                    return Err(reading.wrong(length.span(), "give to or length_m, not both"));
                }
            };
            let width = sizes.one("width_m", &table.width_m)?;
            return Ok(Form::Line { length, width, pixels: sizes.pixels("width_px", &table.width_px)? });
        }
        Kind::Point => {
            let sizes = sizes("point");
            sizes.takes(&["radius_m", "size_px"])?;
            let width = 2.0 * sizes.one("radius_m", &table.radius_m)?;
            return Ok(Form::Point { width, pixels: sizes.pixels("size_px", &table.size_px)? });
        }
        Kind::Sphere => {
            let sizes = sizes("sphere");
            sizes.takes(&["radius_m"])?;
            Shape::Ellipsoid { radii: DVec3::splat(sizes.one("radius_m", &table.radius_m)?) }
        }
        Kind::Ellipsoid => {
            let sizes = sizes("ellipsoid");
            sizes.takes(&["radii_m"])?;
            Shape::Ellipsoid { radii: sizes.three("radii_m", &table.radii_m)? }
        }
        Kind::Box => {
            let sizes = sizes("box");
            sizes.takes(&["size_m"])?;
            Shape::Box { size: sizes.three("size_m", &table.size_m)? }
        }
        Kind::Cylinder => {
            let sizes = sizes("cylinder");
            sizes.takes(&["radius_m", "height_m"])?;
            let radius = sizes.one("radius_m", &table.radius_m)?;
            Shape::Cylinder { radius, height: sizes.one("height_m", &table.height_m)? }
        }
        Kind::Cone => {
            let sizes = sizes("cone");
            sizes.takes(&["radius_m", "height_m"])?;
            let radius = sizes.one("radius_m", &table.radius_m)?;
            Shape::Cone { radius, height: sizes.one("height_m", &table.height_m)? }
        }
        Kind::Disc => {
            let sizes = sizes("disc");
            sizes.takes(&["radius_m"])?;
            Shape::Disc { radius: sizes.one("radius_m", &table.radius_m)? }
        }
    };
    Ok(shape.into())
}

impl Sizes<'_, '_> {
    /// Refuses keys of other shapes.
    fn takes(&self, keys: &[&str]) -> Result<()> {
        let table = self.table;
        let given = [
            ("radius_m", table.radius_m.as_ref().map(Spanned::span)),
            ("radii_m", table.radii_m.as_ref().map(Spanned::span)),
            ("size_m", table.size_m.as_ref().map(Spanned::span)),
            ("height_m", table.height_m.as_ref().map(Spanned::span)),
            ("width_m", table.width_m.as_ref().map(Spanned::span)),
            ("width_px", table.width_px.as_ref().map(Spanned::span)),
            ("size_px", table.size_px.as_ref().map(Spanned::span)),
            ("to", table.to.as_ref().map(Spanned::span)),
        ];
        let other =
            given.into_iter().find_map(|(key, span)| Some(key).zip(span).filter(|_| !keys.contains(&key)));
        other.map_or(Ok(()), |(key, span)| {
            let what = match keys {
                [] => format!("a {} has no {key}; scale or length_m say how large it is", self.name),
                keys => format!("a {} has no {key}; its size is {}", self.name, keys.join(" and ")),
            };
            Err(self.reading.wrong(span, what))
        })
    }

    fn missing(&self, key: &str) -> Error {
        self.reading.wrong(self.shape.clone(), format!("a {} needs {key}", self.name))
    }

    fn one(&self, key: &str, value: &Option<Spanned<f64>>) -> Result<f64> {
        let value = value.as_ref().ok_or_else(|| self.missing(key))?;
        self.reading.number(key, value, is_size, "must be more than 0 m and at most 100 km")
    }

    fn pixels(&self, key: &str, value: &Option<Spanned<f64>>) -> Result<f64> {
        let holds = |pixels| (0.0..=MOST_PIXELS).contains(&pixels);
        let number = |value| self.reading.number(key, value, holds, "must be 0 to 100 pixels");
        value.as_ref().map_or(Ok(0.0), number)
    }

    fn three(&self, key: &str, value: &Option<Spanned<Vec<f64>>>) -> Result<DVec3> {
        let value = value.as_ref().ok_or_else(|| self.missing(key))?;
        let sizes: [f64; 3] = self.reading.numbers(key, value)?;
        if sizes.into_iter().all(is_size) {
            return Ok(sizes.into());
        }
        let what = format!("{key} must be three lengths of more than 0 m and at most 100 km, not {sizes:?}");
        Err(self.reading.wrong(value.span(), what))
    }
}

fn is_size(metres: f64) -> bool {
    metres > 0.0 && metres <= LARGEST
}

/// `#rrggbb`.
pub(super) fn srgb(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii())?;
    let [_, red, green, blue] =
        u32::from_str_radix(digits, 16).ok().filter(|_| !digits.starts_with('+'))?.to_be_bytes();
    Some([red, green, blue])
}

/// The track of something that stands.
fn standing(reading: &Reading<'_>, table: &ObjectTable, object: Range<usize>) -> Result<Track> {
    if table.at.is_none() && table.at_lonlat.is_none() {
        let what = format!("object `{}` needs at, at_lonlat or track", table.name);
        return Err(reading.wrong(object, what));
    }
    if let Some(bank) = &table.bank {
        return Err(
            reading.wrong(bank.span(), "bank is for objects with a track; a standing one has roll_deg")
        );
    }
    place(table, &format!("object `{}`", table.name), object).track(reading)
}

/// Where its table says that it stands.
fn place<'t>(table: &'t ObjectTable, whose: &'t str, span: Range<usize>) -> Place<'t> {
    Place {
        whose,
        keys: PLACE_KEYS,
        at: table.at.as_ref(),
        at_lonlat: table.at_lonlat.as_ref(),
        altitude: table.altitude.as_ref().map(|above| *above.get_ref()),
        yaw: table.yaw_deg.as_ref(),
        pitch: table.pitch_deg.as_ref(),
        roll: table.roll_deg.as_ref(),
        span,
    }
}

/// Where a line ends.
fn end(reading: &Reading<'_>, table: &ObjectTable, to: &Spanned<Vec<f64>>) -> Result<Track> {
    if table.track.is_some() {
        let what = "to is where a line ends that stands; one with a track has length_m";
        return Err(reading.wrong(to.span(), what));
    }
    let angles = [&table.yaw_deg, &table.pitch_deg, &table.roll_deg];
    if let Some(angle) = angles.into_iter().flatten().next() {
        return Err(reading.wrong(angle.span(), "a line goes to its other end; leave angles out, or to"));
    }
    let whose = format!("object `{}`", table.name);
    let begin = place(table, &whose, to.span());
    let is_xy = table.at_lonlat.is_none();
    let end = Place {
        keys: ["to"; 2],
        at: Some(to).filter(|_| is_xy),
        at_lonlat: Some(to).filter(|_| !is_xy),
        ..begin
    };
    end.track(reading)
}

/// The track of something that moves.
fn moving(
    reading: &Reading<'_>,
    table: &ObjectTable,
    track: &Spanned<PathBuf>,
    hasher: &mut blake3::Hasher,
) -> Result<Track> {
    let places = [table.at.as_ref().map(Spanned::span), table.at_lonlat.as_ref().map(Spanned::span)];
    let angles = [&table.yaw_deg, &table.pitch_deg, &table.roll_deg];
    let angles = angles.into_iter().map(|angle| angle.as_ref().map(Spanned::span));
    if let Some(span) = places.into_iter().chain(angles).flatten().next() {
        return Err(reading.wrong(span, "an object with a track is where, and turned as, its track says"));
    }
    let path = reading.path.parent().unwrap_or(".".as_ref()).join(track.get_ref());
    let whose = format!("the track of object `{}`", table.name);
    let of_scene = |error: Error| reading.through(track.span(), &whose, error);
    if track.get_ref().to_string_lossy().chars().any(char::is_control) {
        return Err(reading.wrong(track.span(), "track must be the name of a file"));
    }
    let read = read_track(&path, &ReadOptions { altitude_mode: mode(table) }).map_err(of_scene)?;
    let bytes = fs::read(&path).map_err(|source| of_scene(Error::io(&path, "read", source)))?;
    hasher.update(&(bytes.len() as u64).to_le_bytes()).update(&bytes);
    Ok(read)
}

fn mode(table: &ObjectTable) -> Option<AltitudeMode> {
    table.altitude.as_ref().map(|above| (*above.get_ref()).into())
}
