//! Appearance of objects and their parts: shapes, and models with levels and nodes.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use toml::Spanned;

use super::form::{form, refuse_sizes};
use super::model::{Models, NodeSplit, Rest};
use crate::objects::{Form, Level, Model};
use crate::scene::model::{Fit, Origin, Size};
use crate::scene::object_table::{ObjectTable, Up};
use crate::space::Attitude;
use hedgehop_base::document::Reading;
use hedgehop_base::error::Result;

/// Levels of detail of an object.
const MOST_LEVELS: usize = 16;

/// Appearance of an object or a part, and what that was read from.
#[derive(Debug)]
pub(super) struct Appearance {
    pub form: Form,
    pub files: Vec<PathBuf>,
    pub notes: Vec<String>,
    /// Nodes of its model that are parts of their own, in the order in which these name them.
    pub nodes: Vec<NodeAppearance>,
}

/// A node of an object's model.
#[derive(Debug)]
pub(super) struct NodeAppearance {
    pub form: Form,
    pub rest: Rest,
    /// Number of the nearest of these nodes that it is below of.
    pub above: Option<usize>,
}

/// Nodes of the model of a coarser level of detail.
#[derive(Debug)]
struct CoarserSplit {
    /// The model, cut into its nodes.
    cut: Arc<NodeSplit>,
    /// Size on the screen below which the level is shown, pixels.
    below: f64,
}

/// Reads what a table's shape or model looks like; `whose` says what that is of, and `span` is that of its table.
pub(super) fn appearance(
    reading: &Reading<'_>,
    table: &ObjectTable,
    whose: &str,
    span: &Range<usize>,
    models: &mut Models,
    hasher: &mut blake3::Hasher,
) -> Result<Appearance> {
    match (&table.shape, &table.model) {
        (Some(given), None) => {
            refuse_keys(reading, table)?;
            if let Some(node) = table.part.iter().find_map(|part| part.get_ref().node.as_ref()) {
                let what = format!("node is of an object's model; {whose} has a shape");
                return Err(reading.wrong(node.span(), what));
            }
            let form = form(reading, table, given)?;
            Ok(Appearance { form, files: Vec::new(), notes: Vec::new(), nodes: Vec::new() })
        }
        (None, Some(path)) => {
            refuse_sizes(reading, table, path.span())?;
            model(reading, table, path, whose, models, hasher)
        }
        (Some(_), Some(path)) => Err(reading.wrong(path.span(), "give shape or model, not both")),
        (None, None) => Err(reading.wrong(span.clone(), format!("{whose} needs shape or model"))),
    }
}

/// Refuses keys of models.
fn refuse_keys(reading: &Reading<'_>, table: &ObjectTable) -> Result<()> {
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

/// A model of an object, and its coarser levels.
fn model(
    reading: &Reading<'_>,
    table: &ObjectTable,
    path: &Spanned<PathBuf>,
    whose: &str,
    models: &mut Models,
    hasher: &mut blake3::Hasher,
) -> Result<Appearance> {
    let fit = fit(reading, table)?;
    let is_vox = path.get_ref().extension().is_some_and(|extension| extension.eq_ignore_ascii_case("vox"));
    if let Some(up) = table.up.as_ref().filter(|up| is_vox && *up.get_ref() == Up::Y) {
        return Err(reading.wrong(up.span(), "up of a .vox model is \"z\": MagicaVoxel has no other"));
    }

    let named: Vec<&Spanned<String>> =
        table.part.iter().filter_map(|part| part.get_ref().node.as_ref()).collect();
    for (index, node) in named.iter().enumerate() {
        if named[..index].iter().any(|other| other.get_ref() == node.get_ref()) {
            let what = format!("another part of {whose} is the node {:?} already", node.get_ref());
            return Err(reading.wrong(node.span(), what));
        }
    }

    let mut nodes: Vec<Option<&str>> = named.iter().map(|node| Some(node.get_ref().as_str())).collect();
    let (mut files, mut notes) = (Vec::new(), Vec::new());
    let mut get =
        |path: &Spanned<PathBuf>, nodes: &[Option<&str>], rests: &[Rest]| -> Result<Arc<NodeSplit>> {
            let at = place(reading, path)?;
            let got = models.get(&at, &fit, nodes, rests, hasher);
            let got =
                got.map_err(|error| reading.through(path.span(), &format!("the model of {whose}"), error))?;
            files.extend(got.files);
            notes.extend(got.notes);
            Ok(got.cut)
        };

    let finest = get(path, &nodes, &[])?;
    for (node, found) in named.iter().zip(&finest.nodes) {
        if let Err(what) = found {
            return Err(reading.wrong(node.span(), format!("the model of {whose} {what}")));
        }
    }

    let found = || finest.nodes.iter().filter_map(|found| found.as_ref().ok());
    let rests: Vec<Rest> = found().map(|node| node.rest).collect();
    if table.levels.len() > MOST_LEVELS {
        let span = table.levels[MOST_LEVELS].span();
        return Err(reading.wrong(span, format!("an object has at most {MOST_LEVELS} levels")));
    }

    let mut coarser: Vec<CoarserSplit> = Vec::new();
    for level in &table.levels {
        let level = level.get_ref();
        let before = coarser.last().map_or(f64::INFINITY, |coarser| coarser.below);
        let below = reading.number(
            "below_px",
            &level.below_px,
            |pixels| pixels > 0.0 && pixels < before,
            "must be more than 0 pixels, and less from level to level",
        )?;
        let cut = get(&level.model, &nodes, &rests)?;

        // What a level shows at rest, coarser ones do not move again.
        for (node, _) in nodes.iter_mut().zip(&cut.nodes).filter(|(_, found)| found.is_err()) {
            *node = None;
        }
        coarser.push(CoarserSplit { cut, below });
    }

    notes.dedup();
    let size = whole_size(&finest, &coarser);
    let above = found().map(|node| node.above).enumerate();
    let node_appearances = above.map(|(index, above)| NodeAppearance {
        form: Arc::new(node_model(index, &finest, &coarser, size)).into(),
        rest: rests[index],
        above,
    });
    let levels = coarser.iter().map(|level| Level { mesh: level.cut.rest.clone(), below: level.below });
    let rest = Model::new(finest.rest.clone(), levels);
    let form = Arc::new(if rests.is_empty() { rest } else { rest.seen_with(size) }).into();

    Ok(Appearance { form, files, notes, nodes: node_appearances.collect() })
}

/// Diameter of the sphere around the box of all levels, nodes at rest included, metres.
fn whole_size(finest: &NodeSplit, coarser: &[CoarserSplit]) -> f64 {
    let all = coarser.iter().map(|level| level.cut.corners);
    let [low, high] = all.fold(finest.corners, |[low, high], [least, most]| [low.min(least), high.max(most)]);
    (high - low).length()
}

/// The node of that number, of a model of `size` metres: it is seen down to the first level that has no such node, which shows it at rest.
fn node_model(index: usize, finest: &NodeSplit, coarser: &[CoarserSplit], size: f64) -> Model {
    let mesh = |cut: &NodeSplit| cut.nodes[index].as_ref().ok().map(|node| node.mesh.clone());
    let own = coarser.iter().map_while(|level| Some(Level { mesh: mesh(&level.cut)?, below: level.below }));
    let first_without = coarser.iter().find(|level| mesh(&level.cut).is_none());
    let hidden = first_without.map_or(0.0, |level| level.below);
    // A node that is not in the finest level has been refused.
    let finest = mesh(finest).unwrap_or_else(|| finest.rest.clone());
    Model::new(finest, own).hidden_below(hidden).seen_with(size)
}

fn fit(reading: &Reading<'_>, table: &ObjectTable) -> Result<Fit> {
    let size = match (&table.scale, &table.length_m) {
        (Some(_), Some(length)) => {
            return Err(reading.wrong(length.span(), "give scale or length_m, not both"));
        }
        (None, Some(length)) => {
            let is_length = |metres: f64| metres > 0.0 && metres <= super::form::LARGEST;
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

/// Finds a model's file: a relative name counts from the scene's folder.
fn place(reading: &Reading<'_>, path: &Spanned<PathBuf>) -> Result<PathBuf> {
    let name = path.get_ref();
    if name.as_os_str().is_empty() || name.to_string_lossy().chars().any(char::is_control) {
        return Err(reading.wrong(path.span(), "model must be the name of a file"));
    }
    Ok(reading.path.parent().unwrap_or(Path::new(".")).join(name))
}
