//! Layer of features in a file, whatever its format.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec2;

use super::kinds::FeatureClass;
use crate::Materials;
use hedgehop_geo::{Crs, Transform};

/// Places in order, in the layer's reference system (eastward or longitude, northward or latitude).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Path {
    /// The places, all finite.
    pub places: Vec<DVec2>,
    /// Heights as the file has them, as many as places; empty if it has none. Their unit and datum are not known.
    pub heights: Vec<f64>,
}

/// A polygon. Rings do not repeat their first place at their end, may run either way, and have three places at least.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Area {
    /// The outside.
    pub outer: Path,
    /// Rings of the ground that is left out.
    pub holes: Vec<Path>,
}

/// All that one row shows; collections may have several kinds of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Geometry {
    /// Points, each for itself.
    pub points: Path,
    /// Lines of two places at least.
    pub lines: Vec<Path>,
    /// Polygons.
    pub areas: Vec<Area>,
    /// Joints where lines meet those of other rows; known of roads once all layers are.
    pub joints: Vec<Joint>,
    /// Junctions of its lines with other roads; known likewise.
    pub junctions: Vec<Junction>,
}

/// A place where a road's line meets other roads, three arms at least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Junction {
    /// Place of the junction, in the units of the system.
    pub place: DVec2,
    /// Half the width of the widest other road there, metres.
    pub half_m: f64,
    /// Whether the road is wider than all others there, and so goes on through it.
    pub goes_on: bool,
}

/// A place where a line meets one of another row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    /// Place of the joint, in the units of the system.
    pub place: DVec2,
    /// Half the width of the wider way there, on which this one goes on, metres; 0 on the widest.
    pub half_m: f64,
}

impl Path {
    /// Places without heights.
    pub fn flat(places: Vec<DVec2>) -> Self {
        Self { places, heights: Vec::new() }
    }

    /// A ring without the repetition of its first place; `None` if it encloses nothing.
    pub(super) fn ring(mut self) -> Option<Self> {
        while self.places.len() > 1 && self.places.first() == self.places.last() {
            self.places.pop();
        }
        self.heights.truncate(self.places.len());
        (self.places.len() >= 3).then_some(self)
    }

    /// A line; `None` if it has no length.
    pub(super) fn line(self) -> Option<Self> {
        self.places.windows(2).any(|pair| pair[0] != pair[1]).then_some(self)
    }

    fn transformed(&self, transform: &Transform) -> Option<Self> {
        let places = self.places.iter().map(|place| transform.apply(place.x, place.y).map(DVec2::from));
        Some(Self { places: places.collect::<Option<_>>()?, heights: self.heights.clone() })
    }
}

impl Geometry {
    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        self.points.places.is_empty() && self.lines.is_empty() && self.areas.is_empty()
    }

    /// The same in another system; `None` where a place of it has none there.
    pub fn transformed(&self, transform: &Transform) -> Option<Self> {
        let area = |area: &Area| {
            let holes = area.holes.iter().map(|hole| hole.transformed(transform));
            Some(Area { outer: area.outer.transformed(transform)?, holes: holes.collect::<Option<_>>()? })
        };
        Some(Self {
            points: self.points.transformed(transform)?,
            lines: self.lines.iter().map(|line| line.transformed(transform)).collect::<Option<_>>()?,
            areas: self.areas.iter().map(area).collect::<Option<_>>()?,
            joints: Vec::new(),
            junctions: Vec::new(),
        })
    }

    /// All places.
    pub fn places(&self) -> impl Iterator<Item = DVec2> + '_ {
        let rings = self.areas.iter().flat_map(|area| std::iter::once(&area.outer).chain(&area.holes));
        let paths = std::iter::once(&self.points).chain(&self.lines).chain(rings);
        paths.flat_map(|path| path.places.iter().copied())
    }

    /// West, south, east, north of all places; `None` if there is none.
    pub fn bounds(&self) -> Option<[f64; 4]> {
        bounds(self.places())
    }

    /// Adds all of another one.
    pub(super) fn absorb(&mut self, other: Self) {
        // Heights are all or none: a mixture of both kinds of points keeps none.
        let had = self.points.heights.len() == self.points.places.len();
        let has = other.points.heights.len() == other.points.places.len();
        self.points.places.extend(other.points.places);
        self.points.heights.extend(other.points.heights);
        if !(had && has) {
            self.points.heights.clear();
        }
        self.lines.extend(other.lines);
        self.areas.extend(other.areas);
    }
}

/// West, south, east, north of places; `None` if there is none.
pub(super) fn bounds(places: impl IntoIterator<Item = DVec2>) -> Option<[f64; 4]> {
    let mut places = places.into_iter();
    let first = places.next()?;
    let (low, high) =
        places.fold((first, first), |(low, high): (DVec2, DVec2), place| (low.min(place), high.max(place)));
    Some([low.x, low.y, high.x, high.y])
}

/// An attribute's value.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number of the file, finite.
    Number(f64),
    /// Text, not empty.
    Text(String),
}

/// A row's attributes; the first of a name counts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Attributes(Vec<(Arc<str>, Value)>);

impl Attributes {
    /// Adds a value; numbers that are none and empty texts are left out.
    pub fn push(&mut self, name: impl Into<Arc<str>>, value: Value) {
        let says = match &value {
            Value::Number(number) => number.is_finite(),
            Value::Text(text) => !text.trim().is_empty(),
        };
        if says {
            self.0.push((name.into(), value));
        }
    }

    /// The value of a name; if there is none, of one that differs in upper and lower case alone (dBASE knows upper case only).
    pub fn get(&self, name: &str) -> Option<&Value> {
        let exact = self.0.iter().find(|(known, _)| &**known == name);
        let found = exact.or_else(|| self.0.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)));
        found.map(|(_, value)| value)
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.0.iter().map(|(name, value)| (&**name, value))
    }
}

/// One feature.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Row {
    /// Place in its file, for messages: `feature 12`, `row 12`, `table "roads", row 12`; counted from 1.
    pub place: String,
    /// Form of the row, not empty.
    pub geometry: Geometry,
    /// Attributes of the row.
    pub attributes: Attributes,
}

/// A file of features.
#[derive(Debug, Clone)]
pub struct Layer {
    /// The file.
    pub path: PathBuf,
    /// The reference system of its places.
    pub crs: Crs,
    /// Rows that have a form, in the file's order.
    pub rows: Vec<Row>,
    /// Notes on what was assumed, and how many rows were left out and why. They name the file without its folders.
    pub notes: Vec<String>,
}

/// Attributes of a file by what they hold; `None`: those of OpenStreetMap.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Columns {
    /// Height of the top above the ground: metres, or with a unit.
    pub height: Option<String>,
    /// Height of the lower end above the ground.
    pub min_height: Option<String>,
    /// Number of levels above the ground.
    pub levels: Option<String>,
    /// Width of roads, rivers, walls.
    pub width: Option<String>,
    /// Diameter of tanks, masts, crowns.
    pub diameter: Option<String>,
    /// Roof shape by OpenStreetMap's words.
    pub roof_shape: Option<String>,
    /// Height of the roof alone.
    pub roof_height: Option<String>,
    /// Colour of façades, surfaces, crowns.
    pub colour: Option<String>,
    /// Colour of roofs.
    pub roof_colour: Option<String>,
    /// Material of façades or surfaces.
    pub material: Option<String>,
    /// Kind of building, road or water, by OpenStreetMap's words (`house`, `motorway`, …).
    pub class: Option<String>,
}

impl Columns {
    /// All names that are given.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let Self { height, min_height, levels, width, diameter, .. } = self;
        let Self { roof_shape, roof_height, colour, roof_colour, material, class, .. } = self;
        let sizes = [height, min_height, levels, width, diameter, roof_height];
        let kinds = [roof_shape, colour, roof_colour, material, class];
        sizes.into_iter().chain(kinds).filter_map(|name| name.as_deref())
    }
}

/// Options of what a file of features does not say of itself.
#[derive(Debug, Clone, Default)]
pub struct LayerOptions {
    /// Reference system, if the file states none.
    pub crs: Option<String>,
    /// The table to read of a GeoPackage; `None`: all that have features.
    pub table: Option<String>,
    /// Class of all of its rows; `None`: what their tags say.
    pub kind: Option<FeatureClass>,
    /// Names of its attributes.
    pub columns: Columns,
    /// The materials of the place, by whose names rows may say theirs.
    pub materials: Materials,
    /// Walls of buildings are plain, without façades.
    pub plain_walls: bool,
    /// Roads and fields are plain, without lines and rows.
    pub plain_ground: bool,
}

/// Rows that are left out, all of them or in part, counted by reason.
#[derive(Debug, Default)]
pub struct LeftOut {
    reasons: BTreeMap<String, (usize, String)>,
    in_part: bool,
}

/// Reasons that are told apart.
const MOST_REASONS: usize = 20;

impl LeftOut {
    /// None yet, of which only a part is left out.
    pub fn in_part() -> Self {
        Self { in_part: true, ..Self::default() }
    }

    /// One more row, by its place.
    pub fn add(&mut self, place: &str, reason: impl Into<String>) {
        let reason = reason.into();
        let known = self.reasons.len() < MOST_REASONS || self.reasons.contains_key(&reason);
        let reason = if known { reason } else { "other reasons".to_owned() };
        self.reasons.entry(reason).or_insert_with(|| (0, place.to_owned())).0 += 1;
    }

    /// Returns how many rows there are, and the reason of most of them; `None`: nothing is left out.
    pub fn most(&self) -> Option<(usize, &str)> {
        let count = self.reasons.values().map(|(count, _)| count).sum();
        let (reason, _) = self.reasons.iter().max_by_key(|(_, (count, _))| *count)?;
        Some((count, reason))
    }

    /// One sentence for each reason, after the name of the file.
    pub fn into_notes(self, file: &str) -> Vec<String> {
        let part = if self.in_part { " in part" } else { "" };
        let note = |(reason, (count, first)): (String, (usize, String))| match count {
            1 => format!("{file}: {first} is left out{part}: {reason}"),
            _ => format!("{file}: {count} rows are left out{part}: {reason} (the first of them is {first})"),
        };
        self.reasons.into_iter().map(note).collect()
    }
}
