//! Keys of objects that are models.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;
use toml::Spanned;

use super::file::Reading;
use super::model::{Fit, Fitted, Models, Origin, Size};
use super::object::ObjectTable;
use crate::error::{Error, Result};
use crate::objects::{Form, Level, Mesh, Model};
use crate::space::Attitude;

/// Levels of detail of an object.
const MOST_LEVELS: usize = 16;

/// What points up in a model.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Up {
    Y,
    Z,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a level { model = \"...\", below_px = ... }")]
pub(super) struct LevelTable {
    model: Spanned<PathBuf>,
    below_px: Spanned<f64>,
}

/// What an object looks like, and what that was read from.
pub(super) struct Look {
    pub form: Form,
    pub files: Vec<PathBuf>,
    pub notes: Vec<String>,
}

/// Refuses keys of models.
pub(super) fn refuse_keys(reading: &Reading<'_>, table: &ObjectTable) -> Result<()> {
    let given = [
        ("scale", table.scale.as_ref().map(Spanned::span)),
        ("length_m", table.length_m.as_ref().filter(|_| !table.is_line()).map(Spanned::span)),
        ("turn_deg", table.turn_deg.as_ref().map(Spanned::span)),
        ("up", table.up.as_ref().map(Spanned::span)),
        ("origin", table.origin.as_ref().map(Spanned::span)),
        ("levels", table.levels.first().map(Spanned::span)),
    ];
    let found = given.into_iter().find_map(|(key, span)| Some((key, span?)));
    found.map_or(Ok(()), |(key, span)| {
        Err(reading.wrong(span, format!("{key} is for objects with a model; a shape has none")))
    })
}

/// The model of an object, and its coarser levels.
pub(super) fn model(
    reading: &Reading<'_>,
    table: &ObjectTable,
    path: &Spanned<PathBuf>,
    models: &mut Models,
    hasher: &mut blake3::Hasher,
) -> Result<Look> {
    let fit = fit(reading, table)?;
    let (mut all_files, mut all_notes) = (Vec::new(), Vec::new());
    let mut get = |path: &Spanned<PathBuf>| -> Result<Arc<Mesh>> {
        let at = place(reading, path)?;
        let got = models
            .get(&at, &fit, hasher)
            .map_err(|error| of_scene(reading, &table.name, path.span(), error))?;
        let Fitted { mesh, files, notes } = got;
        all_files.extend(files);
        all_notes.extend(notes);
        Ok(mesh)
    };
    let finest = get(path)?;
    if table.levels.len() > MOST_LEVELS {
        let span = table.levels[MOST_LEVELS].span();
        return Err(reading.wrong(span, format!("an object has at most {MOST_LEVELS} levels")));
    }
    let mut coarser: Vec<Level> = Vec::new();
    for level in &table.levels {
        let level = level.get_ref();
        let before = coarser.last().map_or(f64::INFINITY, |level| level.below);
        let below = reading.number(
            "below_px",
            &level.below_px,
            |pixels| pixels > 0.0 && pixels < before,
            "must be more than 0 pixels, and less from level to level",
        )?;
        coarser.push(Level { mesh: get(&level.model)?, below });
    }
    all_notes.dedup();
    Ok(Look { form: Arc::new(Model::new(finest, coarser)).into(), files: all_files, notes: all_notes })
}

fn fit(reading: &Reading<'_>, table: &ObjectTable) -> Result<Fit> {
    let size = match (&table.scale, &table.length_m) {
        (Some(_), Some(length)) => {
            return Err(reading.wrong(length.span(), "give scale or length_m, not both"));
        }
        (None, Some(length)) => {
            let is_length = |metres: f64| metres > 0.0 && metres <= super::object::LARGEST;
            Size::Length(reading.number(
                "length_m",
                length,
                is_length,
                "must be more than 0 m and at most 100 km",
            )?)
        }
        (Some(scale), None) => {
            let is_scale = |scale: f64| (1.0e-6..=1.0e6).contains(&scale);
            Size::Scale(reading.number("scale", scale, is_scale, "must lie between 0.000001 and 1000000")?)
        }
        (None, None) => Size::Scale(1.0),
    };
    let turn = match &table.turn_deg {
        Some(turn) => {
            let angles: [f64; 3] = reading.numbers("turn_deg", turn)?;
            if !angles.into_iter().all(|degrees| degrees.abs() <= 360.0) {
                let what =
                    format!("turn_deg must be [yaw, pitch, roll] of -360 to 360 degrees, not {angles:?}");
                return Err(reading.wrong(turn.span(), what));
            }
            let [yaw, pitch, roll] = angles;
            Attitude { yaw, pitch, roll }
        }
        None => Attitude::default(),
    };
    let is_z_up = table.up.as_ref().is_some_and(|up| *up.get_ref() == Up::Z);
    let origin = table.origin.as_ref().map_or(Origin::Model, |origin| *origin.get_ref());
    Ok(Fit { size, is_z_up, turn, origin })
}

/// Where a model's file is: a relative name counts from the scene's folder.
fn place(reading: &Reading<'_>, path: &Spanned<PathBuf>) -> Result<PathBuf> {
    let name = path.get_ref();
    if name.as_os_str().is_empty() || name.to_string_lossy().chars().any(char::is_control) {
        return Err(reading.wrong(path.span(), "model must be the name of a file"));
    }
    Ok(reading.path.parent().unwrap_or(Path::new(".")).join(name))
}

fn of_scene(reading: &Reading<'_>, name: &str, span: Range<usize>, error: Error) -> Error {
    reading.through(span, &format!("the model of object `{name}`"), error)
}
