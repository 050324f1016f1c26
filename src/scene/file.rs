//! The file: its tables, and what they may hold.

use std::collections::BTreeMap;
use std::fs;
use std::ops::Range;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use super::light::{LightTable, MOST_LAMPS, light};
use super::model::Models;
use super::object::{ObjectTable, object};
use super::part::BETWEEN;
use super::picture::{HudTable, PictureTable};
use super::plume::{PlumeTable, plume};
use super::precipitation::{GroundTable, PrecipitationTable};
use super::sun::{NightTable, SunTable};
use super::weather::{self, CloudsTable, FogTable};
use super::{Object, Scene, Weather};
use crate::error::{Error, Result};

/// Bytes of the largest scene file.
const MOST_BYTES: u64 = 64 << 20;

/// Tables of the largest scene: each takes up to a kilobyte while it is read.
const MOST_TABLES: usize = 250_000;

/// Longest text after a line's number, characters.
const MOST_MESSAGE: usize = 500;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a scene")]
struct SceneTable {
    sun: Option<SunTable>,
    night: Option<NightTable>,
    air: Option<AirTable>,
    fog: Option<FogTable>,
    clouds: Option<CloudsTable>,
    precipitation: Option<PrecipitationTable>,
    ground: Option<GroundTable>,
    picture: Option<PictureTable>,
    hud: Option<HudTable>,
    #[serde(default)]
    object: Vec<Spanned<ObjectTable>>,
    #[serde(default)]
    light: Vec<Spanned<LightTable>>,
    #[serde(default)]
    plume: Vec<Spanned<PlumeTable>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, expecting = "the table [air]")]
struct AirTable {
    visibility_m: Option<Spanned<f64>>,
    glow: Option<Spanned<f64>>,
}

/// A scene file while it is read.
pub(super) struct Reading<'f> {
    pub path: &'f Path,
    /// Bytes behind the ends of lines.
    lines: Vec<usize>,
}

impl Reading<'_> {
    /// What is wrong at a place of the file.
    pub fn wrong(&self, span: Range<usize>, what: impl std::fmt::Display) -> Error {
        let line = self.line(&span);
        Error::invalid(self.path, format!("line {line}: {}", plain(&what.to_string())))
    }

    /// The line of a place of the file, from 1 on.
    pub fn line(&self, span: &Range<usize>) -> usize {
        1 + self.lines.partition_point(|end| *end <= span.start)
    }

    /// A number that `holds`; `want` says which do, beginning with a verb.
    pub fn number(
        &self,
        key: &str,
        value: &Spanned<f64>,
        holds: impl Fn(f64) -> bool,
        want: &str,
    ) -> Result<f64> {
        let number = *value.get_ref();
        if number.is_finite() && holds(number) {
            return Ok(number);
        }
        Err(self.wrong(value.span(), format!("{key} {want}, not {number}")))
    }

    /// Exactly so many numbers.
    pub fn numbers<const N: usize>(&self, key: &str, values: &Spanned<Vec<f64>>) -> Result<[f64; N]> {
        let given = values.get_ref();
        let what = || format!("{key} must be {N} numbers, not {}", given.len());
        <[f64; N]>::try_from(given.as_slice()).map_err(|_| self.wrong(values.span(), what()))
    }

    /// What is wrong with something that a place of the file names; `whose` says what that is.
    pub fn through(&self, span: Range<usize>, whose: &str, error: Error) -> Error {
        match error {
            Error::Io { path, action, source } => {
                let (line, scene) = (self.line(&span), self.path.display());
                let action = if action == "read" { "read it" } else { &action };
                Error::io(path, plain(&format!("{action}, {whose} (line {line} of {scene})")), source)
            }
            Error::Unsupported { path, what, remedy } => {
                let what = format!("line {}: {whose}: {}: {what}", self.line(&span), path.display());
                Error::unsupported(self.path, plain(&what), plain(&remedy))
            }
            stopped @ Error::Interrupted(_) => stopped,
            other => self.wrong(span, format!("{whose}: {other}")),
        }
    }
}

/// The line of a byte, from 1 on.
fn line_at(bytes: &[u8], at: usize) -> usize {
    1 + bytes[..at.min(bytes.len())].iter().filter(|byte| **byte == b'\n').count()
}

/// Text for a sentence: in one line, without characters that steer terminals, and of some length at most.
fn plain(text: &str) -> String {
    let shown = text.chars().map(|char| if char.is_control() { '\u{fffd}' } else { char });
    let mut plain: String = shown.clone().take(MOST_MESSAGE).collect();
    if shown.count() > MOST_MESSAGE {
        plain.push('…');
    }
    plain
}

pub(super) fn read(path: &Path) -> Result<Scene> {
    let bytes = bytes_of(path, MOST_BYTES)?;
    let text = str::from_utf8(&bytes).map_err(|error| {
        let line = line_at(&bytes, error.valid_up_to());
        Error::invalid(path, format!("line {line}: not UTF-8; save it as UTF-8"))
    })?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
    let reading = Reading { path, lines: ends.map(|(at, _)| at + 1).collect() };
    let tables = text.matches("[[").count() + text.matches('{').count();
    if tables > MOST_TABLES {
        return Err(Error::invalid(
            path,
            format!("has {tables} tables, more than the {MOST_TABLES} that a scene may have"),
        ));
    }
    let table: SceneTable = toml::from_str(text).map_err(|error| {
        let message = error.message().trim().replace('\n', ", ");
        let span = error.span().unwrap_or(0..0);
        let given = text.get(span.clone()).unwrap_or_default();
        if message.ends_with("expected a sequence") && given.starts_with('[') {
            let name = given.lines().next().unwrap_or_default().trim_matches(['[', ']', ' ']);
            return reading.wrong(span, format!("write [[{name}]], in two brackets: there may be several"));
        }
        reading.wrong(span, format!("{message}; docs/scene.md lists all keys"))
    })?;
    let mut hasher = blake3::Hasher::new();
    hasher.update(&bytes);
    let lines = table.sun.as_ref().map(|sun| sun.lines(&reading)).unwrap_or_default();
    let shadows = table.sun.as_ref().and_then(SunTable::shadows);
    let sun = table.sun.map_or(Ok(None), |sun| sun.read(&reading))?;
    let night = table.night.unwrap_or_default().read(&reading)?;
    let air = table.air.unwrap_or_default();
    let visibility = air.visibility_m.as_ref();
    let visibility = visibility
        .map(|metres| reading.number("visibility_m", metres, |metres| metres > 0.0, "must be more than 0 m"))
        .transpose()?;
    let precipitation = table.precipitation.map(|falls| falls.read(&reading)).transpose()?;
    let weather = Weather {
        precipitation,
        ground: table.ground.unwrap_or_default().read(&reading, precipitation.as_ref())?,
        glow: weather::glow(&reading, air.glow.as_ref(), sun.is_some())?,
        fog: table.fog.map(|fog| fog.read(&reading)).transpose()?,
        clouds: table.clouds.map(|clouds| clouds.read(&reading)).transpose()?,
    };
    let finish = table.picture.unwrap_or_default().read(&reading)?;
    let hud = table.hud.map(|hud| hud.read(&reading)).transpose()?.unwrap_or_default();
    let mut objects: BTreeMap<String, Object> = BTreeMap::new();
    let mut models = Models::default();
    for table in table.object {
        let span = table.span();
        let object = object(&reading, table, &mut models, &mut hasher)?;
        if objects.contains_key(&object.name) {
            let what = format!("there is an object `{}` already; names tell objects apart", object.name);
            return Err(reading.wrong(span, what));
        }
        objects.insert(object.name.clone(), object);
    }
    for object in objects.values() {
        for part in &object.parts {
            let name = format!("{}{BETWEEN}{}", object.name, part.name);
            if objects.contains_key(&name) {
                let what = format!("there is an object `{name}`, too; names tell objects and parts apart");
                return Err(Error::invalid(path, format!("line {}: {}", part.line, plain(&what))));
            }
        }
    }
    let mut lights = Vec::new();
    let mut lamps = 0;
    for (index, table) in table.light.iter().enumerate() {
        let light = light(&reading, table, index + 1)?;
        lamps += light.lamp_count();
        if lamps > MOST_LAMPS {
            return Err(reading.wrong(table.span(), format!("a scene has at most {MOST_LAMPS} lamps")));
        }
        lights.push(light);
    }
    let plumes = table.plume.into_iter().enumerate();
    let plumes = plumes.map(|(index, table)| plume(&reading, table, index + 1)).collect::<Result<_>>()?;
    let objects = objects.into_values().collect();
    Ok(Scene {
        path: path.to_owned(),
        digest: hasher.finalize().to_hex().to_string(),
        sun,
        shadows,
        night,
        lines,
        visibility,
        weather,
        finish,
        hud,
        objects,
        lights,
        plumes,
    })
}

/// All of a regular file.
fn bytes_of(path: &Path, most: u64) -> Result<Vec<u8>> {
    let found = fs::metadata(path).map_err(|source| Error::io(path, "read", source))?;
    if !found.is_file() {
        return Err(Error::invalid(path, "is no regular file; --scene takes a TOML file"));
    }
    if found.len() > most {
        return Err(Error::invalid(
            path,
            format!("holds {} bytes, more than the {most} that a scene may have", found.len()),
        ));
    }
    fs::read(path).map_err(|source| Error::io(path, "read", source))
}
