//! Buildings with their heights as GeoJSON.
//!
//! ```text
//! of GeoJSON:   its own text, feature for feature; in `properties` the members of below are put in place or added
//! of others:    RFC 7946, with the older `crs` where the system is not WGS 84, as it is read again
//!
//! height, height_error, shadow_length   of rows that have got a height, to a centimetre
//! shadow_note                           of rows that have none, and why
//! ```

use std::collections::HashMap;
use std::fmt::{self, Write};
use std::fs::{self, File};
use std::io::Read;

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde_json::Value as Json;
use serde_json::value::RawValue;

use super::super::features::{Area, Geometry, Path, Row, Value};
use super::answer::{Answer, Origin};
use crate::shadow_height::ShadowReport;
use hedgehop_base::document::unmarked;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// A member of a row that changes, and its new value; `None`: it goes.
pub(super) type Change = (&'static str, Option<Json>);

/// Returns the changes of a row.
pub(super) fn changes(row: &Row, answer: &Answer) -> Vec<Change> {
    let number = |metres: f64| Some(Json::from((metres * 100.0).round() / 100.0));
    match answer {
        Answer::Kept => Vec::new(),
        Answer::Nothing(reason) => vec![("shadow_note", Some(Json::from(reason.as_str())))],
        Answer::Height(found) => {
            let mut changes =
                vec![("height", number(found.height_m)), ("height_error", number(found.error_m))];
            // What a row states of its shadow stays as it was.
            if found.origin == Origin::Photograph || row.attributes.get("shadow_length").is_none() {
                changes.push(("shadow_length", number(found.length_m)));
            }
            changes.push(("shadow_note", None));
            changes
        }
    }
}

/// An object's members in order, their values as they stand.
#[derive(Debug)]
struct Members<'t>(Vec<(String, &'t RawValue)>);

impl<'de: 't, 't> Deserialize<'de> for Members<'t> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        struct InOrder;
        impl<'de> Visitor<'de> for InOrder {
            type Value = Members<'de>;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("an object")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<Self::Value, A::Error> {
                let mut members = Vec::new();
                while let Some(member) = map.next_entry()? {
                    members.push(member);
                }
                Ok(Members(members))
            }
        }
        deserializer.deserialize_map(InOrder)
    }
}

impl Members<'_> {
    fn get(&self, name: &str) -> Option<&RawValue> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }

    fn kind(&self) -> String {
        self.get("type").and_then(|kind| serde_json::from_str(kind.get()).ok()).unwrap_or_default()
    }
}

/// The report's layer as GeoJSON.
pub(super) fn geojson(report: &ShadowReport) -> Result<String> {
    let path = &report.layer.path;
    let refused = |error| Error::io(path, "read", error);
    let mut head = Vec::new();
    File::open(path).map_err(refused)?.take(HEAD).read_to_end(&mut head).map_err(refused)?;
    if !is_geojson(unmarked(path, &head)?) {
        return Ok(made(report));
    }
    let bytes = fs::read(path).map_err(refused)?;
    edited(report, unmarked(path, &bytes)?)
}

/// Bytes of a file's beginning by which it is told what it is, as when it is read.
const HEAD: u64 = 256;

fn is_geojson(text: &[u8]) -> bool {
    text.iter().find(|byte| !byte.is_ascii_whitespace() && **byte != 0x1e) == Some(&b'{')
}

/// Returns its own text with the changes.
fn edited(report: &ShadowReport, text: &[u8]) -> Result<String> {
    let path = &report.layer.path;
    let wrong = |error: serde_json::Error| {
        Error::invalid(
            path,
            format!("{error}: the file has changed since it was read; run the command again"),
        )
    };
    let text: Vec<u8> = text.iter().map(|byte| if *byte == 0x1e { b' ' } else { *byte }).collect();
    let rows = report.layer.rows.iter().zip(&report.answers);
    let rows: HashMap<&str, Vec<Change>> =
        rows.map(|(row, answer)| (row.place.as_str(), changes(row, answer))).collect();
    let (mut count, mut out) = (0_usize, String::new());

    for object in serde_json::Deserializer::from_slice(&text).into_iter::<Members<'_>>() {
        let object = object.map_err(wrong)?;
        if object.kind() != "FeatureCollection" {
            count += 1;
            feature(&object, rows.get(format!("feature {count}").as_str()), &mut out).map_err(wrong)?;
            out.push('\n');
            continue;
        }

        let mut separator = '{';
        for (name, value) in &object.0 {
            out.push(separator);
            separator = ',';
            push_name(name, &mut out);
            if name != "features" {
                out.push_str(value.get());
                continue;
            }

            let features: Option<Vec<Members<'_>>> = serde_json::from_str(value.get()).map_err(wrong)?;
            out.push('[');
            for (number, member) in features.iter().flatten().enumerate() {
                out.push_str(if number == 0 { "\n" } else { ",\n" });
                count += 1;
                feature(member, rows.get(format!("feature {count}").as_str()), &mut out).map_err(wrong)?;
            }

            out.push_str("\n]");
        }

        out.push_str("}\n");
    }

    Ok(out)
}

fn push_name(name: &str, out: &mut String) {
    out.push_str(&Json::from(name).to_string());
    out.push(':');
}

/// A feature with its changes; a bare geometry becomes one if there are any.
fn feature(object: &Members<'_>, changes: Option<&Vec<Change>>, out: &mut String) -> serde_json::Result<()> {
    let changes = changes.map(Vec::as_slice).unwrap_or_default();
    let is_feature = object.kind() == "Feature";
    let is_wrapped = !is_feature && !changes.is_empty();

    // The reference system is stated outside of geometries.
    let is_outside = |name: &str| is_wrapped && name == "crs";
    if is_wrapped {
        out.push_str(r#"{"type":"Feature","#);
        for (name, value) in object.0.iter().filter(|(name, _)| is_outside(name)) {
            push_name(name, out);
            out.push_str(value.get());
            out.push(',');
        }
        out.push_str(r#""properties":"#);
        properties(None, changes, out)?;
        out.push_str(r#","geometry":"#);
    }

    let mut separator = '{';
    let mut has_properties = false;
    for (name, value) in object.0.iter().filter(|(name, _)| !is_outside(name)) {
        out.push(separator);
        separator = ',';
        push_name(name, out);
        if is_feature && name == "properties" {
            has_properties = true;
            properties(Some(value), changes, out)?;
        } else {
            out.push_str(value.get());
        }
    }

    if is_feature && !has_properties && !changes.is_empty() {
        out.push_str(r#","properties":"#);
        properties(None, changes, out)?;
    }

    out.push('}');
    if is_wrapped {
        out.push('}');
    }

    Ok(())
}

/// Properties with changes.
fn properties(value: Option<&RawValue>, changes: &[Change], out: &mut String) -> serde_json::Result<()> {
    let members = match value.map(RawValue::get) {
        Some(text) if text.starts_with('{') => serde_json::from_str::<Members<'_>>(text)?,
        // Nothing to change: whatever it is, it stays.
        Some(text) if changes.is_empty() => {
            out.push_str(text);
            return Ok(());
        }
        _ => Members(Vec::new()),
    };

    let mut separator = "";
    let mut push = |name: &str, text: &str| {
        out.push_str(if separator.is_empty() { "{" } else { separator });
        separator = ",";
        push_name(name, out);
        out.push_str(text);
    };

    for (name, value) in &members.0 {
        match changes.iter().find(|(changed, _)| changed == name) {
            None => push(name, value.get()),
            Some((_, Some(new))) => push(name, &new.to_string()),
            Some((_, None)) => {}
        }
    }

    for (name, value) in changes {
        if let (Some(value), None) = (value, members.get(name)) {
            push(name, &value.to_string());
        }
    }

    out.push_str(if separator.is_empty() { "{}" } else { "}" });
    Ok(())
}

/// A layer that was no GeoJSON.
fn made(report: &ShadowReport) -> String {
    let mut out = String::from(r#"{"type":"FeatureCollection","#);
    if let Some(name) = system(&report.layer.crs) {
        let name = Json::from(name);
        // Writing to a string does not fail.
        let _ = write!(out, r#""crs":{{"type":"name","properties":{{"name":{name}}}}},"#);
    }

    out.push_str(r#""features":["#);
    for (number, (row, answer)) in report.layer.rows.iter().zip(&report.answers).enumerate() {
        out.push_str(if number == 0 { "\n" } else { ",\n" });
        let mut properties = serde_json::Map::new();
        for (name, value) in row.attributes.iter() {
            let value = match value {
                Value::Number(number) => Json::from(*number),
                Value::Text(text) => Json::from(text.as_str()),
            };
            // The first of a name counts.
            properties.entry(name).or_insert(value);
        }

        for (name, value) in changes(row, answer) {
            match value {
                Some(value) => drop(properties.insert(name.to_owned(), value)),
                None => drop(properties.remove(name)),
            }
        }

        let _ = write!(
            out,
            r#"{{"type":"Feature","properties":{},"geometry":{}}}"#,
            Json::Object(properties),
            geometry(&row.geometry)
        );
    }

    out.push_str("\n]}\n");
    out
}

/// The name of a system as it is read again; `None`: WGS 84.
fn system(crs: &Crs) -> Option<String> {
    match (crs.epsg(), crs.proj()) {
        _ if crs.is_equivalent(&Crs::wgs84()) => None,
        (Some(code), _) => Some(format!("urn:ogc:def:crs:EPSG::{code}")),
        (None, Some(definition)) => Some(definition.to_owned()),
        (None, None) => Some("local".to_owned()),
    }
}

fn geometry(geometry: &Geometry) -> Json {
    let mut parts = Vec::new();
    let part =
        |kind: &str, coordinates: Json| serde_json::json!({ "type": kind, "coordinates": coordinates });
    if !geometry.points.places.is_empty() {
        parts.push(part("MultiPoint", line(&geometry.points)));
    }
    if !geometry.lines.is_empty() {
        parts.push(part("MultiLineString", geometry.lines.iter().map(line).collect()));
    }
    match geometry.areas.as_slice() {
        [] => {}
        [area] => parts.push(part("Polygon", polygon(area))),
        areas => parts.push(part("MultiPolygon", areas.iter().map(polygon).collect())),
    }
    if parts.len() == 1 {
        return parts.swap_remove(0);
    }
    serde_json::json!({ "type": "GeometryCollection", "geometries": parts })
}

fn polygon(area: &Area) -> Json {
    std::iter::once(&area.outer).chain(&area.holes).map(ring).collect()
}

/// A ring ends where it begins.
fn ring(path: &Path) -> Json {
    let closing = Path {
        places: path.places.first().copied().into_iter().collect(),
        heights: path.heights.first().copied().into_iter().collect(),
    };
    let (Json::Array(mut ring), Json::Array(end)) = (line(path), line(&closing)) else { return Json::Null };
    ring.extend(end);
    Json::Array(ring)
}

fn line(path: &Path) -> Json {
    let place = |(index, place): (usize, &glam::DVec2)| match path.heights.get(index) {
        Some(height) => Json::from(vec![place.x, place.y, *height]),
        None => Json::from(vec![place.x, place.y]),
    };
    path.places.iter().enumerate().map(place).collect()
}
