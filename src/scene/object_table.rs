//! Table of an object, or of a part of one.

use std::ops::Range;
use std::path::PathBuf;

use serde::Deserialize;
use toml::Spanned;

use super::Beyond;
use super::place::Above;
use crate::scene::model::Origin;
use hedgehop_base::colour::{linear_from_srgb8, srgb8_from_hex};
use hedgehop_base::document::Reading;
use hedgehop_base::error::Result;

/// Priorities go so far either way.
const MOST_PRIORITY: i64 = 1000;

/// Characters of the longest name.
const MOST_NAME: usize = 200;

/// An object, or a part of one: `part.rs` says which keys are for which.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[object]] or [[object.part]]")]
pub(super) struct ObjectTable {
    pub name: String,
    pub shape: Option<Spanned<FormKind>>,
    pub radius_m: Option<Spanned<f64>>,
    pub radii_m: Option<Spanned<Vec<f64>>>,
    pub size_m: Option<Spanned<Vec<f64>>>,
    pub height_m: Option<Spanned<f64>>,
    pub width_m: Option<Spanned<f64>>,
    pub width_px: Option<Spanned<f64>>,
    pub size_px: Option<Spanned<f64>>,
    pub to: Option<Spanned<Vec<f64>>>,
    pub colour: Option<Spanned<String>>,
    pub priority: Option<Spanned<i64>>,
    pub at: Option<Spanned<Vec<f64>>>,
    pub at_lonlat: Option<Spanned<Vec<f64>>>,
    pub altitude: Option<Spanned<Above>>,
    pub slope: Option<Spanned<bool>>,
    pub yaw_deg: Option<Spanned<f64>>,
    pub pitch_deg: Option<Spanned<f64>>,
    pub roll_deg: Option<Spanned<f64>>,
    pub track: Option<Spanned<PathBuf>>,
    pub track_number: Option<Spanned<usize>>,
    pub sort: Option<Spanned<bool>>,
    pub start_s: Option<Spanned<f64>>,
    pub bank: Option<Spanned<bool>>,
    pub from_aboard: Option<Spanned<bool>>,
    pub beyond: Option<Spanned<Beyond>>,
    pub model: Option<Spanned<PathBuf>>,
    pub scale: Option<Spanned<f64>>,
    pub length_m: Option<Spanned<f64>>,
    pub turn_deg: Option<Spanned<Vec<f64>>>,
    pub up: Option<Spanned<Up>>,
    pub origin: Option<Spanned<Origin>>,
    #[serde(default)]
    pub levels: Vec<Spanned<LevelTable>>,
    pub node: Option<Spanned<String>>,
    pub parent: Option<Spanned<String>>,
    pub offset_m: Option<Spanned<Vec<f64>>>,
    pub axis: Option<Spanned<Vec<f64>>>,
    pub angle_deg: Option<Spanned<f64>>,
    pub turn_rpm: Option<Spanned<f64>>,
    pub angles: Option<Spanned<PathBuf>>,
    #[serde(default)]
    pub part: Vec<Spanned<ObjectTable>>,
}

impl ObjectTable {
    /// Whether it says how long a line is.
    pub fn is_line(&self) -> bool {
        self.shape.as_ref().is_some_and(|kind| matches!(kind.get_ref(), FormKind::Line))
    }

    /// Whether it leans as the ground below it does.
    pub(super) fn leans(&self) -> bool {
        self.slope.as_ref().is_some_and(|slope| *slope.get_ref())
    }

    /// Returns the rank among bodies at the same range, if it says any.
    pub fn priority(&self, reading: &Reading<'_>) -> Result<Option<i32>> {
        let Some(priority) = &self.priority else { return Ok(None) };
        let number = *priority.get_ref();
        if number.abs_diff(0) > MOST_PRIORITY.unsigned_abs() {
            let what = format!("priority must be −{MOST_PRIORITY} to {MOST_PRIORITY}, not {number}");
            return Err(reading.wrong(priority.span(), what));
        }
        Ok(Some(number as i32))
    }

    /// Returns the linear colour, if it says any.
    pub fn albedo(&self, reading: &Reading<'_>) -> Result<Option<[f32; 3]>> {
        let Some(colour) = &self.colour else { return Ok(None) };
        let albedo = srgb8_from_hex(colour.get_ref()).ok_or_else(|| {
            reading.wrong(colour.span(), format!("colour must be #rrggbb (sRGB), not {:?}", colour.get_ref()))
        })?;
        Ok(Some(linear_from_srgb8(albedo)))
    }
}

/// Refuses names that would not do in a sentence; `whose` says what has it.
pub(super) fn check_name(reading: &Reading<'_>, whose: &str, name: &str, table: &Range<usize>) -> Result<()> {
    if name.trim().is_empty() || name.chars().any(char::is_control) || name.chars().count() > MOST_NAME {
        let what = format!("{whose}'s name must be 1 to {MOST_NAME} printable characters");
        return Err(reading.wrong(table.clone(), what));
    }
    Ok(())
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum FormKind {
    Sphere,
    Ellipsoid,
    Box,
    Cylinder,
    Cone,
    Disc,
    Ellipse,
    Line,
    Point,
}

/// Axis that points up in a model.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Up {
    Y,
    Z,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a level { model = \"...\", below_px = ... }")]
pub(super) struct LevelTable {
    pub(super) model: Spanned<PathBuf>,
    pub(super) below_px: Spanned<f64>,
}
