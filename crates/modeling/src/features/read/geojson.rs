//! GeoJSON: RFC 7946 (Butler and others, 2016), the older form with a reference system (2008), and rows of it one after another
//! (RFC 8142 with and without its separators).
//!
//! ```text
//! for each object of the file:  FeatureCollection: each of its features | Feature | bare geometry
//! coordinates are numbers in lists of any depth; what a geometry's type makes of them is looked at afterwards,
//! so that one bad feature costs itself alone
//! ```

use std::fmt;
use std::sync::Arc;

use glam::dvec2;
use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::Value as Json;

use super::super::layer::{Area, Attributes, Geometry, Path, Row, Value};
use super::{hstore, rings};
use crate::features::read::found::FoundRows;
use hedgehop_base::document::unmarked;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// Nested arrays under `coordinates`.
#[derive(Debug)]
enum Nest {
    Place([f64; 3], bool),
    List(Vec<Nest>),
    Wrong,
}

/// A number or a list, inside of a list.
enum Item {
    Number(f64),
    Nest(Nest),
}

struct ItemVisitor;

impl<'de> Deserialize<'de> for Item {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ItemVisitor)
    }
}

impl<'de> Visitor<'de> for ItemVisitor {
    type Value = Item;
    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("coordinates")
    }
    fn visit_f64<E>(self, number: f64) -> Result<Item, E> {
        Ok(Item::Number(number))
    }
    fn visit_u64<E>(self, number: u64) -> Result<Item, E> {
        Ok(Item::Number(number as f64))
    }
    fn visit_i64<E>(self, number: i64) -> Result<Item, E> {
        Ok(Item::Number(number as f64))
    }
    fn visit_bool<E>(self, _: bool) -> Result<Item, E> {
        Ok(Item::Nest(Nest::Wrong))
    }
    fn visit_str<E>(self, _: &str) -> Result<Item, E> {
        Ok(Item::Nest(Nest::Wrong))
    }
    fn visit_unit<E>(self) -> Result<Item, E> {
        Ok(Item::Nest(Nest::Wrong))
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Item, A::Error> {
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(Item::Nest(Nest::Wrong))
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Item, A::Error> {
        let (mut place, mut count, mut list, mut wrong) = ([0.0; 3], 0, Vec::new(), false);
        while let Some(item) = sequence.next_element()? {
            match item {
                Item::Number(number) => {
                    // A fourth number and more is allowed, and means nothing.
                    if let Some(slot) = place.get_mut(count) {
                        *slot = number;
                    }
                    count += 1;
                }
                Item::Nest(Nest::Wrong) => wrong = true,
                Item::Nest(nest) => list.push(nest),
            }
        }

        Ok(Item::Nest(match (count, list.is_empty()) {
            _ if wrong => Nest::Wrong,
            (0, _) => Nest::List(list),
            (2.., true) => Nest::Place(place, count > 2),
            _ => Nest::Wrong,
        }))
    }
}

impl<'de> Deserialize<'de> for Nest {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match Item::deserialize(deserializer)? {
            Item::Nest(nest) => nest,
            Item::Number(_) => Self::Wrong,
        })
    }
}

/// Any object of GeoJSON.
#[derive(Debug, Deserialize)]
struct Object {
    #[serde(rename = "type")]
    kind: Option<Json>,
    features: Option<Vec<Object>>,
    geometry: Option<Box<Object>>,
    geometries: Option<Vec<Object>>,
    coordinates: Option<Nest>,
    properties: Option<Json>,
    #[serde(default, deserialize_with = "present")]
    crs: Option<Json>,
    // By these other formats are told.
    #[serde(rename = "geometryType")]
    esri_kind: Option<IgnoredAny>,
    #[serde(rename = "spatialReference")]
    esri_system: Option<IgnoredAny>,
    elements: Option<IgnoredAny>,
    kml: Option<IgnoredAny>,
    asset: Option<IgnoredAny>,
    error: Option<IgnoredAny>,
}

/// Tells `null` from nothing.
fn present<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Json>, D::Error> {
    Json::deserialize(deserializer).map(Some)
}

impl Object {
    fn kind(&self) -> &str {
        self.kind.as_ref().and_then(Json::as_str).unwrap_or_default()
    }

    /// Another format in JSON than GeoJSON, and what helps.
    fn foreign(&self) -> Option<(&'static str, &'static str)> {
        const CONVERT: &str = "convert it: ogr2ogr -f GPKG FEATURES.gpkg FILE";

        Some(match self.kind() {
            "Topology" => ("is TopoJSON", CONVERT),
            "CityJSON" | "CityJSONFeature" => {
                ("is CityJSON", "write its footprints as GeoPackage, as QGIS does with its CityJSON loader")
            }
            "" if self.esri_kind.is_some() || self.esri_system.is_some() => ("is Esri JSON", CONVERT),
            "" if self.elements.is_some() => (
                "is OpenStreetMap's JSON, as Overpass answers it",
                "convert it: osmtogeojson FILE > FEATURES.geojson",
            ),
            "" if self.kml.is_some() => {
                ("is KML in JSON", "convert the KML itself: ogr2ogr -f GPKG FEATURES.gpkg FILE.kml")
            }
            "" if self.asset.is_some() => ("is glTF, a model", "name it as `file` of [[object]]"),
            "" if self.error.is_some() => {
                ("holds the error of a server in the place of features", "fetch it again")
            }
            "" => ("is JSON, but no GeoJSON: it has no \"type\"", CONVERT),
            _ => return None,
        })
    }
}

/// All rows of a text.
pub(super) fn read(path: &std::path::Path, mut text: Vec<u8>) -> Result<FoundRows> {
    // The separator of RFC 8142 stands nowhere else: strings must escape it.
    text.iter_mut().filter(|byte| **byte == 0x1e).for_each(|byte| *byte = b' ');
    let text = unmarked(path, &text)?;
    let mut found = FoundRows::default();
    let (mut count, mut stated) = (0, None);

    for object in serde_json::Deserializer::from_slice(text).into_iter::<Object>() {
        let object = object.map_err(|error| {
            Error::invalid(
                path,
                format!("{}: this is no GeoJSON", crate::features::read::found::plain(&error.to_string())),
            )
        })?;
        if let Some(crs) = &object.crs {
            stated = Some(crs.clone());
        }

        match object.kind() {
            "FeatureCollection" => {
                for feature in object.features.unwrap_or_default() {
                    add(feature, &mut count, &mut found);
                }
            }
            _ => match object.foreign() {
                Some((what, remedy)) => return Err(Error::unsupported(path, what, remedy)),
                None => add(object, &mut count, &mut found),
            },
        }
    }

    if count == 0 && found.rows.is_empty() {
        found.notes.push("has no features".to_owned());
    }
    found.crs = system(path, stated.as_ref(), &mut found.notes)?;
    found.otherwise = Some(Crs::wgs84());

    Ok(found)
}

/// The system that the older form states.
fn system(path: &std::path::Path, stated: Option<&Json>, notes: &mut Vec<String>) -> Result<Option<Crs>> {
    let Some(stated) = stated else { return Ok(None) };
    if stated.is_null() {
        notes.push("says that its reference system is unknown".to_owned());
        return Ok(None);
    }
    let Some(name) = stated.pointer("/properties/name").and_then(Json::as_str) else {
        return Err(Error::unsupported(
            path,
            "states its reference system by a link, or not at all, in \"crs\"",
            "take \"crs\" out and say the system beside the file",
        ));
    };
    Crs::from_user(name).map(Some).map_err(|error| Error::invalid(path, format!("\"crs\": {error}")))
}

fn add(object: Object, count: &mut usize, found: &mut FoundRows) {
    *count += 1;
    let place = format!("feature {count}");
    let (geometry, properties) = match object.kind() {
        "Feature" => (object.geometry, object.properties),
        _ => (Some(Box::new(object)), None),
    };
    let read = geometry.as_deref().map(geometry_of);
    match read {
        None => found.left_out.add(&place, "it has no geometry"),
        Some(Err(reason)) => found.left_out.add(&place, reason),
        Some(Ok(geometry)) if geometry.is_empty() => found.left_out.add(&place, "its geometry is empty"),
        Some(Ok(geometry)) => found.rows.push(Row { place, geometry, attributes: attributes(properties) }),
    }
}

fn geometry_of(object: &Object) -> Result<Geometry, String> {
    let mut geometry = Geometry::default();
    let kind = object.kind();
    if kind == "GeometryCollection" {
        for part in object.geometries.iter().flatten() {
            geometry.absorb(geometry_of(part)?);
        }
        return Ok(geometry);
    }

    let wrong = || format!("its coordinates are not those of a {kind}");
    let nest = object.coordinates.as_ref();
    let known = ["Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon"];
    if !known.contains(&kind) {
        return Err("its geometry has a type that GeoJSON does not have".to_owned());
    }

    let nest = nest.ok_or_else(wrong)?;
    match kind {
        "Point" => {
            // An empty list is a point without a place.
            let place = if matches!(nest, Nest::List(list) if list.is_empty()) {
                &[][..]
            } else {
                std::slice::from_ref(nest)
            };
            geometry.points = path_of(place).ok_or_else(wrong)?;
        }
        "MultiPoint" => geometry.points = path(nest).ok_or_else(wrong)?,
        "LineString" => geometry.lines.extend(path(nest).ok_or_else(wrong)?.line()),
        "MultiLineString" => {
            for line in list(nest).ok_or_else(wrong)? {
                geometry.lines.extend(path(line).ok_or_else(wrong)?.line());
            }
        }
        "Polygon" => geometry.areas = polygon(nest).ok_or_else(wrong)?,
        _ => {
            for part in list(nest).ok_or_else(wrong)? {
                geometry.areas.extend(polygon(part).ok_or_else(wrong)?);
            }
        }
    }

    Ok(geometry)
}

fn list(nest: &Nest) -> Option<&[Nest]> {
    match nest {
        Nest::List(list) => Some(list),
        _ => None,
    }
}

fn path(nest: &Nest) -> Option<Path> {
    path_of(list(nest)?)
}

fn path_of(places: &[Nest]) -> Option<Path> {
    let mut path = Path::default();
    let mut all = !places.is_empty();
    for place in places {
        let Nest::Place([x, y, z], has_height) = place else { return None };
        if !(x.is_finite() && y.is_finite() && z.is_finite()) {
            return None;
        }
        path.places.push(dvec2(*x, *y));
        path.heights.push(*z);
        all &= has_height;
    }
    if !all {
        path.heights.clear();
    }
    Some(path)
}

fn polygon(nest: &Nest) -> Option<Vec<Area>> {
    Some(rings::areas(list(nest)?.iter().map(path).collect::<Option<_>>()?))
}

fn attributes(properties: Option<Json>) -> Attributes {
    let mut attributes = Attributes::default();
    let Some(Json::Object(properties)) = properties else { return attributes };
    let mut nested = Vec::new();
    for (name, value) in properties {
        match value {
            // Overpass and others keep the tags in a table of their own.
            Json::Object(tags) if name == "tags" => nested.extend(tags),
            value => push(&mut attributes, name, value),
        }
    }
    nested.into_iter().for_each(|(name, value)| push(&mut attributes, name, value));
    attributes
}

fn push(attributes: &mut Attributes, name: String, value: Json) {
    match value {
        Json::Number(number) => {
            attributes.push(name, Value::Number(number.as_f64().unwrap_or(f64::NAN)));
        }
        Json::Bool(value) => attributes.push(name, Value::Text(if value { "yes" } else { "no" }.to_owned())),
        Json::String(text) if name == "other_tags" => hstore::add(attributes, &text),
        Json::String(text) => attributes.push(Arc::from(name), Value::Text(text)),
        Json::Array(items) if (2..=3).contains(&items.len()) && items.iter().all(Json::is_number) => {
            // A place.
            let numbers: Vec<String> = items.iter().map(Json::to_string).collect();
            attributes.push(Arc::from(name), Value::Text(numbers.join(",")));
        }
        Json::Null | Json::Array(_) | Json::Object(_) => {}
    }
}
