//! The table `[[trail]]`: ways that something flew, as lines.

use std::path::PathBuf;

use glam::Vec3;
use serde::Deserialize;
use toml::Spanned;

use super::place::Above;
use super::track_file::TrackFile;
use crate::flight::{BindOptions, Track};
use hedgehop_base::colour::{linear_from_srgb8, srgb8_from_hex};
use hedgehop_base::document::Reading;
use hedgehop_base::error::Result;

/// Widths of trails and of their outlines, pixels.
const WIDTHS: std::ops::RangeInclusive<f64> = 0.1..=100.0;
const OUTLINES: std::ops::RangeInclusive<f64> = 0.0..=20.0;

/// Longest tail, seconds: some thirty years.
const LONGEST: f64 = 1.0e9;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[trail]]")]
pub(super) struct TrailTable {
    name: Option<String>,
    object: Option<Spanned<String>>,
    track: Option<Spanned<PathBuf>>,
    track_number: Option<Spanned<usize>>,
    sort: Option<Spanned<bool>>,
    altitude: Option<Spanned<Above>>,
    start_s: Option<Spanned<f64>>,
    colour: Option<Spanned<String>>,
    by: Option<Spanned<TrailQuantity>>,
    range: Option<Spanned<Vec<f64>>>,
    width_px: Option<Spanned<f64>>,
    outline_px: Option<Spanned<f64>>,
    tail_s: Option<Spanned<f64>>,
    whole: Option<Spanned<bool>>,
}

/// Quantity that a trail is coloured by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TrailQuantity {
    /// Metres above the datum.
    Altitude,
    /// Speed over ground, metres per second.
    Speed,
    /// Rate of climb, metres per second.
    Climb,
}

/// Colours of a trail.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TrailColour {
    /// The same all along: linear Rec. 709, as pictures show it without haze.
    Plain(Vec3),
    /// Colours of a quantity, from a low value of it to a high one; `None`: from the track's own.
    By(TrailQuantity, Option<[f64; 2]>),
}

/// Something whose way a trail shows.
#[derive(Debug, Clone)]
pub enum TrailSource {
    /// Object of this name, which has a track.
    Object(String),
    /// A track.
    Track {
        /// Track of two fixes or more.
        track: Track,
        /// Seconds after the flight's first fix at which the track's first fix is.
        start: f64,
        /// Options by which it becomes a way.
        options: BindOptions,
    },
}

/// The way of something, as a line of a width in pixels.
#[derive(Debug, Clone)]
pub struct Trail {
    /// Name in messages.
    pub name: String,
    /// Line of the scene file, from 1 on; 0: of no file.
    pub line: usize,
    /// Something whose way it shows.
    pub source: TrailSource,
    /// Colours along the way.
    pub colour: TrailColour,
    /// Width, pixels, 0.1…100.
    pub width: f64,
    /// Width of the dark outline on either side, pixels, 0…20.
    pub outline: f64,
    /// Seconds that it reaches back, > 0; `None`: to the first fix.
    pub tail: Option<f64>,
    /// Whether it shows the way to come, too.
    pub is_whole: bool,
}

impl Trail {
    /// Width of a trail unless somebody says so, pixels.
    pub const WIDTH: f64 = 3.0;
    /// Width of an outline unless somebody says so, pixels.
    pub const OUTLINE: f64 = 1.0;
    /// Colour of a trail unless somebody says so, sRGB: seen before woods, rock, snow and sky.
    pub const COLOUR: [u8; 3] = [255, 140, 0];

    /// The file that it was read from, if it has one of its own.
    pub fn track(&self) -> Option<&Track> {
        match &self.source {
            TrailSource::Object(_) => None,
            TrailSource::Track { track, .. } => Some(track),
        }
    }
}

/// Reads the trail that is the `number`th of its scene, from 1 on; `fixes` tells how many the track of an object has, by its name.
pub(super) fn trail(
    reading: &Reading<'_>,
    table: &Spanned<TrailTable>,
    number: usize,
    fixes: &dyn Fn(&str) -> Option<usize>,
    hasher: &mut blake3::Hasher,
) -> Result<Trail> {
    let (span, table) = (table.span(), table.get_ref());
    let name = table.name.clone().unwrap_or_else(|| format!("trail {number}"));
    if name.trim().is_empty() || name.chars().any(char::is_control) || name.chars().count() > 200 {
        return Err(reading.wrong(span, "a trail's name must be 1 to 200 printable characters"));
    }

    let source = match (&table.object, &table.track) {
        (Some(object), None) => of_object(reading, table, object, fixes)?,
        (None, Some(track)) => of_file(reading, table, &name, track, hasher)?,
        (Some(_), Some(track)) => {
            return Err(reading.wrong(track.span(), "give object or track, not both"));
        }
        (None, None) => {
            let what = format!("trail `{name}` needs object, the name of one with a track, or track, a file");
            return Err(reading.wrong(span, what));
        }
    };

    let length = |key: &str,
                  value: &Option<Spanned<f64>>,
                  default: f64,
                  range: std::ops::RangeInclusive<f64>| {
        let want = format!("must be {} to {} pixels", range.start(), range.end());
        let value = value.as_ref();
        value.map_or(Ok(default), |value| reading.number(key, value, |pixels| range.contains(&pixels), &want))
    };
    let is_tail = |seconds: f64| seconds > 0.0 && seconds <= LONGEST;
    let tail = table.tail_s.as_ref().map(|tail| {
        let want = format!("must be more than 0 and at most {LONGEST} s");
        reading.number("tail_s", tail, is_tail, &want)
    });

    let is_whole = table.whole.as_ref().is_some_and(|whole| *whole.get_ref());
    if let (true, Some(tail)) = (is_whole, &table.tail_s) {
        let what = "whole shows all of the way, tail_s its last seconds; leave one of them out";
        return Err(reading.wrong(tail.span(), what));
    }

    Ok(Trail {
        line: reading.line(&span),
        source,
        colour: colour(reading, table)?,
        width: length("width_px", &table.width_px, Trail::WIDTH, WIDTHS)?,
        outline: length("outline_px", &table.outline_px, Trail::OUTLINE, OUTLINES)?,
        tail: tail.transpose()?,
        is_whole,
        name,
    })
}

/// The way of an object.
fn of_object(
    reading: &Reading<'_>,
    table: &TrailTable,
    name: &Spanned<String>,
    fixes: &dyn Fn(&str) -> Option<usize>,
) -> Result<TrailSource> {
    let given = [
        table.track_number.as_ref().map(Spanned::span),
        table.sort.as_ref().map(Spanned::span),
        table.altitude.as_ref().map(Spanned::span),
        table.start_s.as_ref().map(Spanned::span),
    ];
    if let Some(span) = given.into_iter().flatten().next() {
        let what = "track_number, sort, altitude and start_s are about a track; its object says them";
        return Err(reading.wrong(span, what));
    }

    let wanted = name.get_ref();
    let Some(count) = fixes(wanted) else {
        return Err(reading.wrong(name.span(), format!("there is no object `{wanted}`")));
    };
    if count < 2 {
        let what = format!("object `{wanted}` stands, and leaves no trail; give it a track");
        return Err(reading.wrong(name.span(), what));
    }
    Ok(TrailSource::Object(wanted.clone()))
}

/// The way of a file.
fn of_file(
    reading: &Reading<'_>,
    table: &TrailTable,
    name: &str,
    file: &Spanned<PathBuf>,
    hasher: &mut blake3::Hasher,
) -> Result<TrailSource> {
    let whose = format!("the track of trail `{name}`");
    let keys = TrackFile {
        whose: &whose,
        track: file,
        number: table.track_number.as_ref(),
        sort: table.sort.as_ref(),
        altitude: table.altitude.as_ref(),
    };
    let track = keys.read(reading, hasher)?;
    if track.fixes.len() < 2 {
        return Err(reading.wrong(file.span(), format!("{whose} has a single fix, and leaves no trail")));
    }
    let start = table.start_s.as_ref();
    let start =
        start.map_or(Ok(0.0), |start| reading.number("start_s", start, |_| true, "must be finite"))?;
    Ok(TrailSource::Track { track, start, options: BindOptions::default() })
}

/// Colours along the way.
fn colour(reading: &Reading<'_>, table: &TrailTable) -> Result<TrailColour> {
    match (&table.colour, &table.by, &table.range) {
        (Some(_), Some(by), _) => Err(reading.wrong(by.span(), "give colour or by, not both")),
        (_, None, Some(range)) => {
            Err(reading.wrong(range.span(), "range is what by goes from and to; give by, or leave range out"))
        }
        (colour, None, None) => {
            let Some(colour) = colour else {
                return Ok(TrailColour::Plain(linear_from_srgb8(Trail::COLOUR).into()));
            };
            let codes = srgb8_from_hex(colour.get_ref()).ok_or_else(|| {
                let what = format!("colour must be #rrggbb (sRGB), not {:?}", colour.get_ref());
                reading.wrong(colour.span(), what)
            })?;
            Ok(TrailColour::Plain(linear_from_srgb8(codes).into()))
        }
        (None, Some(by), range) => {
            let ends = range.as_ref().map(|range| {
                let ends: [f64; 2] = reading.numbers("range", range)?;
                let is_sound = ends[0].is_finite() && ends[1].is_finite() && ends[0] < ends[1];
                let what = || format!("range must be [low, high], low below high, not {ends:?}");
                is_sound.then_some(ends).ok_or_else(|| reading.wrong(range.span(), what()))
            });
            Ok(TrailColour::By(*by.get_ref(), ends.transpose()?))
        }
    }
}
