//! The table `[[object.part]]`: what moves on an object.

use std::fs;
use std::ops::Range;
use std::path::PathBuf;

use glam::{DMat3, DVec3};
use toml::Spanned;

use super::Object;
use super::appearance::{NodeAppearance, appearance};
use super::joint::{Axes, COLUMNS, Joint, JointCourse};
use super::model::{Models, Rest};
use super::place::finite;
use crate::flight::{Samples, read_columns};
use crate::scene::Part;
use crate::scene::contents::BETWEEN;
use crate::scene::object_table::{ObjectTable, check_name};
use hedgehop_base::document::Reading;
use hedgehop_base::error::{Error, Result};

/// Parts of an object.
const MOST_PARTS: usize = 100;

/// Turns a minute of the fastest part.
const FASTEST: f64 = 100_000.0;

/// Bytes of the largest table of angles.
const MOST_BYTES: u64 = 64 << 20;

/// Object or part that a table is of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Whole {
    Object,
    Part,
}

fn at<T>(value: &Option<Spanned<T>>) -> Option<Range<usize>> {
    value.as_ref().map(Spanned::span)
}

/// Refuses keys that are for objects alone, or for parts alone.
pub(super) fn refuse_keys(reading: &Reading<'_>, table: &ObjectTable, whole: Whole) -> Result<()> {
    let (given, what) = match whole {
        Whole::Object => (
            vec![
                ("node", at(&table.node)),
                ("parent", at(&table.parent)),
                ("offset_m", at(&table.offset_m)),
                ("axis", at(&table.axis)),
                ("angle_deg", at(&table.angle_deg)),
                ("turn_rpm", at(&table.turn_rpm)),
                ("angles", at(&table.angles)),
            ],
            "is for parts of objects, [[object.part]]",
        ),
        Whole::Part => (
            vec![
                ("at", at(&table.at)),
                ("at_lonlat", at(&table.at_lonlat)),
                ("altitude", at(&table.altitude)),
                ("slope", at(&table.slope)),
                ("track", at(&table.track)),
                ("bank", at(&table.bank)),
                ("from_aboard", at(&table.from_aboard)),
                ("beyond", at(&table.beyond)),
                ("to", at(&table.to)),
                ("part", table.part.first().map(Spanned::span)),
            ],
            "is for objects; a part is where offset_m says on its object, or on its parent",
        ),
    };

    let found = given.into_iter().find_map(|(key, span)| Some((key, span?)));
    found.map_or(Ok(()), |(key, span)| Err(reading.wrong(span, format!("{key} {what}"))))
}

/// Refuses what a node's model says.
fn refuse_appearance(reading: &Reading<'_>, table: &ObjectTable) -> Result<()> {
    let given = [
        ("shape", at(&table.shape)),
        ("model", at(&table.model)),
        ("offset_m", at(&table.offset_m)),
        ("radius_m", at(&table.radius_m)),
        ("radii_m", at(&table.radii_m)),
        ("size_m", at(&table.size_m)),
        ("height_m", at(&table.height_m)),
        ("width_m", at(&table.width_m)),
        ("width_px", at(&table.width_px)),
        ("size_px", at(&table.size_px)),
        ("scale", at(&table.scale)),
        ("length_m", at(&table.length_m)),
        ("turn_deg", at(&table.turn_deg)),
        ("up", at(&table.up)),
        ("origin", at(&table.origin)),
        ("levels", table.levels.first().map(Spanned::span)),
    ];

    let found = given.into_iter().find_map(|(key, span)| Some((key, span?)));
    found.map_or(Ok(()), |(key, span)| {
        Err(reading.wrong(span, format!("a node is as its object's model has it; leave out {key}, or node")))
    })
}

/// A part while it is read.
struct PartEntry<'t> {
    table: &'t ObjectTable,
    span: Range<usize>,
    /// Name in messages.
    whose: String,
    /// Number of the node of the model that it is.
    node: Option<usize>,
    /// Number of the entry that it goes with.
    parent: Option<usize>,
}

/// Reads the parts of an object, whose own table this is, and the nodes of whose model look so.
pub(super) fn parts(
    reading: &Reading<'_>,
    table: &ObjectTable,
    nodes: Vec<NodeAppearance>,
    object: &mut Object,
    models: &mut Models,
    hasher: &mut blake3::Hasher,
) -> Result<()> {
    let entries = entries(reading, table, &nodes)?;
    let mut order: Vec<(usize, usize)> = Vec::with_capacity(entries.len());
    for (index, entry) in entries.iter().enumerate() {
        order.push((depth(reading, &entries, entry)?, index));
    }

    // What others go with comes first, and the order of the file means nothing.
    order.sort_by(|(depth, index), (other_depth, other)| {
        let name = |index: usize| &entries[index].table.name;
        depth.cmp(other_depth).then_with(|| name(*index).cmp(name(*other)))
    });
    let number_of = |entry: usize| order.iter().position(|(_, index)| *index == entry);

    // Where each is on the object while nothing turns.
    let mut at_rest: Vec<Axes> = Vec::with_capacity(order.len());
    for (_, index) in &order {
        let PartEntry { table: own, span, whose, node, parent } = &entries[*index];
        let parent = parent.and_then(number_of);
        let below = parent.map_or(Axes { origin: DVec3::ZERO, turn: DMat3::IDENTITY }, |at| at_rest[at]);

        let (form, rest) = match node {
            Some(node) => {
                let NodeAppearance { form, rest, .. } = &nodes[*node];
                let Axes { origin: pivot, turn } = below.to(&Axes::from(*rest));
                (form.clone(), Rest { pivot, turn })
            }
            None => {
                let appearance = appearance(reading, own, whose, span, models, hasher)?;
                object.files.extend(appearance.files);
                object.notes.extend(appearance.notes);
                let offset = own.offset_m.as_ref();
                let offset = offset.map_or(Ok([0.0; 3]), |offset| finite(reading, "offset_m", offset))?;
                (appearance.form, Rest { pivot: offset.into(), turn: DMat3::IDENTITY })
            }
        };

        let table = own.angles.as_ref().map(|path| angles(reading, path, whose, hasher)).transpose()?;
        at_rest.push(below.with(&Axes::from(rest)));
        let (table, samples) = table.unzip();
        object.files.extend(table.clone());

        object.parts.push(Part {
            name: own.name.clone(),
            line: reading.line(span),
            form,
            albedo: own.albedo(reading)?.unwrap_or(object.albedo),
            priority: own.priority(reading)?.unwrap_or(object.priority),
            parent,
            turn_rpm: own.turn_rpm.as_ref().map_or(0.0, |rpm| *rpm.get_ref()),
            table,
            joint: joint(reading, own, rest, samples.unwrap_or_default(), object.start)?,
        });
    }

    object.notes.dedup();
    Ok(())
}

/// Checks names, and finds what each part goes with.
fn entries<'t>(
    reading: &Reading<'_>,
    object: &'t ObjectTable,
    nodes: &[NodeAppearance],
) -> Result<Vec<PartEntry<'t>>> {
    if let Some(beyond) = object.part.get(MOST_PARTS) {
        return Err(reading.wrong(beyond.span(), format!("an object has at most {MOST_PARTS} parts")));
    }

    let mut entries: Vec<PartEntry<'t>> = Vec::new();
    let mut node_entries = Vec::with_capacity(nodes.len());
    for table in &object.part {
        let (span, table) = (table.span(), table.get_ref());
        check_name(reading, "a part", &table.name, &span)?;
        if table.name.contains(BETWEEN) {
            let what =
                format!("a part's name has no `{BETWEEN}`, which stands between an object's and its own");
            return Err(reading.wrong(span, what));
        }

        let whose = format!("part `{}` of object `{}`", table.name, object.name);
        if entries.iter().any(|other| other.table.name == table.name) {
            return Err(reading.wrong(span, format!("there is a {whose} already; names tell parts apart")));
        }

        refuse_keys(reading, table, Whole::Part)?;
        let mut node = None;
        if table.node.is_some() {
            refuse_appearance(reading, table)?;
            node = Some(node_entries.len());
            node_entries.push(entries.len());
        }

        entries.push(PartEntry { table, span, whose, node, parent: None });
    }

    for index in 0..entries.len() {
        let PartEntry { table, whose, node, .. } = &entries[index];
        let parent = match (&table.parent, node) {
            (Some(name), _) => {
                let found = entries.iter().position(|other| other.table.name == *name.get_ref());
                Some(found.ok_or_else(|| {
                    let what = format!("{whose} goes with a part {:?}, and there is none", name.get_ref());
                    reading.wrong(name.span(), what)
                })?)
            }
            (None, Some(node)) => nodes[*node].above.map(|above| node_entries[above]),
            (None, None) => None,
        };

        entries[index].parent = parent;
    }

    Ok(entries)
}

/// Counts the parts that a part goes with, one on the other.
fn depth(reading: &Reading<'_>, entries: &[PartEntry<'_>], entry: &PartEntry<'_>) -> Result<usize> {
    let above = std::iter::successors(entry.parent, |parent| entries[*parent].parent);
    let depth = above.take(entries.len() + 1).count();
    if depth > entries.len() {
        let span = entry.table.parent.as_ref().map_or(entry.span.clone(), Spanned::span);
        let what = format!("{} goes with itself, by way of its parent; break the ring", entry.whose);
        return Err(reading.wrong(span, what));
    }
    Ok(depth)
}

/// Builds the motion of a part that is so at rest, with what its table of angles says.
fn joint(
    reading: &Reading<'_>,
    table: &ObjectTable,
    rest: Rest,
    samples: Vec<Option<Samples>>,
    start: f64,
) -> Result<Joint> {
    let keys = [&table.yaw_deg, &table.pitch_deg, &table.roll_deg, &table.angle_deg];
    let mut courses = [const { JointCourse::Constant(0.0) }; 7];
    for ((course, column), key) in courses.iter_mut().zip(COLUMNS).zip(keys) {
        if let Some(value) = key {
            let holds = |degrees: f64| degrees.abs() <= 360.0;
            let degrees =
                reading.number(column.name, value, holds, "must lie between -360 and 360 degrees")?;
            *course = JointCourse::Constant(degrees);
        }
    }

    for (index, samples) in samples.into_iter().enumerate() {
        let Some(samples) = samples else { continue };
        if let Some(value) = keys.get(index).copied().and_then(Option::as_ref) {
            let key = COLUMNS[index].name;
            return Err(
                reading.wrong(value.span(), format!("the table of angles says {key}, too; leave one out"))
            );
        }
        courses[index] = JointCourse::Given(samples);
    }

    let axis = match &table.axis {
        Some(axis) => {
            let way = DVec3::from_array(reading.numbers("axis", axis)?);
            way.try_normalize().filter(|_| way.is_finite()).ok_or_else(|| {
                let what =
                    format!("axis must be [right, forward, up] of some length, not {:?}", axis.get_ref());
                reading.wrong(axis.span(), what)
            })?
        }
        None => DVec3::Z,
    };

    let turns = match &table.turn_rpm {
        Some(rpm) => {
            let holds = |rpm: f64| rpm.abs() <= FASTEST;
            reading.number("turn_rpm", rpm, holds, "must be 100000 turns a minute at most either way")? / 60.0
        }
        None => 0.0,
    };

    if let Some(start) = &table.start_s
        && table.turn_rpm.is_none()
        && table.angles.is_none()
    {
        let what = "start_s says when turn_rpm or angles begin; give one, or leave start_s out";
        return Err(reading.wrong(start.span(), what));
    }

    let given = table.start_s.as_ref();
    let given =
        given.map(|start| reading.number("start_s", start, |_| true, "must be finite")).transpose()?;

    Ok(Joint { rest, courses, axis, turns, start: given.unwrap_or(start), waits: given.is_some() })
}

/// Reads a table of angles.
fn angles(
    reading: &Reading<'_>,
    name: &Spanned<PathBuf>,
    whose: &str,
    hasher: &mut blake3::Hasher,
) -> Result<(PathBuf, Vec<Option<Samples>>)> {
    let wrong = |what: String| Err(reading.wrong(name.span(), what));
    if name.get_ref().as_os_str().is_empty() || name.get_ref().to_string_lossy().chars().any(char::is_control)
    {
        return wrong("angles must be the name of a file".to_owned());
    }
    let path = reading.path.parent().unwrap_or(".".as_ref()).join(name.get_ref());
    let of_scene = |error: Error| reading.through(name.span(), &format!("the angles of {whose}"), error);
    let io = |source| of_scene(Error::io(&path, "read", source));
    let found = fs::metadata(&path).map_err(io)?;
    if !found.is_file() || found.len() > MOST_BYTES {
        return wrong(format!("angles of {whose} must be a file of {MOST_BYTES} bytes at most"));
    }
    let bytes = fs::read(&path).map_err(io)?;
    hasher.update(&(bytes.len() as u64).to_le_bytes()).update(&bytes);
    let columns = read_columns(&path, &bytes, &COLUMNS).map_err(of_scene)?;
    Ok((path, columns))
}
