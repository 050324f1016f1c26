//! Buildings with their heights as a table.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use csv::{StringRecord, WriterBuilder};
use serde_json::Value as Json;

use super::super::features::{Area, OutlineTable, Row, Value};
use super::write::{Change, changes};
use crate::shadow_height::ShadowReport;
use hedgehop_base::error::{Error, Result};

/// Columns that are put in place or added.
const COLUMNS: [&str; 4] = ["height", "height_error", "shadow_length", "shadow_note"];

/// Whether a file is a table by its name.
pub(super) fn is_table(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}

/// The report's layer as a table: its own with the changes, or one of its attributes and outlines.
pub(super) fn write(report: &ShadowReport) -> Result<String> {
    let layer = &report.layer;
    if is_table(&layer.path) {
        return edited(report);
    }

    let mut names: Vec<&str> = Vec::new();
    let mut places: HashMap<&str, usize> = HashMap::new();
    for (name, _) in layer.rows.iter().flat_map(|row| row.attributes.iter()) {
        places.entry(name).or_insert_with(|| {
            names.push(name);
            names.len() - 1
        });
    }

    let header: StringRecord = names.iter().copied().chain(["polygon"]).collect();
    let records = layer.rows.iter().zip(&report.answers).map(|(row, answer)| {
        let mut cells = vec![String::new(); names.len()];
        // The first of a name counts.
        for (name, value) in row.attributes.iter() {
            if let Some(cell) =
                places.get(name).and_then(|place| cells.get_mut(*place)).filter(|cell| cell.is_empty())
            {
                *cell = match value {
                    Value::Number(number) => number.to_string(),
                    Value::Text(text) => text.clone(),
                };
            }
        }

        cells.push(outline(row));
        (StringRecord::from(cells), changes(row, answer))
    });

    written(report, b',', header, records.collect())
}

/// Returns its own rows with the changes.
fn edited(report: &ShadowReport) -> Result<String> {
    let path = &report.layer.path;
    let bytes = fs::read(path).map_err(|error| Error::io(path, "read", error))?;
    let OutlineTable { header, records, delimiter, .. } = OutlineTable::open(path, &bytes)?;
    let rows = report.layer.rows.iter().zip(&report.answers);
    let mut known: HashMap<&str, Vec<Change>> =
        rows.map(|(row, answer)| (row.place.as_str(), changes(row, answer))).collect();
    let records =
        records.into_iter().map(|(place, record)| (record, known.remove(place.as_str()).unwrap_or_default()));
    written(report, delimiter, header, records.collect())
}

/// A table with the columns of heights in place or behind the others.
fn written(
    report: &ShadowReport,
    delimiter: u8,
    mut header: StringRecord,
    records: Vec<(StringRecord, Vec<Change>)>,
) -> Result<String> {
    let places = COLUMNS.map(|name| {
        header.iter().position(|known| known.eq_ignore_ascii_case(name)).unwrap_or_else(|| {
            header.push_field(name);
            header.len() - 1
        })
    });
    let failed =
        |what: String| Error::invalid(&report.layer.path, format!("cannot be written as a table: {what}"));
    let mut writer = WriterBuilder::new().delimiter(delimiter).from_writer(Vec::new());
    writer.write_record(&header).map_err(|error| failed(error.to_string()))?;

    for (record, changes) in records {
        let mut cells: Vec<String> = record.iter().map(str::to_owned).collect();
        cells.resize(header.len(), String::new());
        for (name, value) in changes {
            let place = COLUMNS.iter().position(|known| *known == name).map(|column| places[column]);
            if let Some(cell) = place.and_then(|place| cells.get_mut(place)) {
                *cell = match value {
                    None => String::new(),
                    Some(Json::String(text)) => text,
                    Some(number) => number.to_string(),
                };
            }
        }

        writer.write_record(&cells).map_err(|error| failed(error.to_string()))?;
    }

    let bytes = writer.into_inner().map_err(|error| failed(error.to_string()))?;
    String::from_utf8(bytes).map_err(|error| failed(error.to_string()))
}

/// The polygons of a row as well-known text.
fn outline(row: &Row) -> String {
    let ring = |places: &[glam::DVec2]| {
        let places: Vec<String> =
            places.iter().chain(places.first()).map(|place| format!("{} {}", place.x, place.y)).collect();
        format!("({})", places.join(", "))
    };
    let polygon = |area: &Area| {
        let rings = std::iter::once(&area.outer).chain(&area.holes);
        format!("({})", rings.map(|path| ring(&path.places)).collect::<Vec<_>>().join(", "))
    };
    match row.geometry.areas.as_slice() {
        [] => String::new(),
        [area] => format!("POLYGON {}", polygon(area)),
        areas => format!("MULTIPOLYGON ({})", areas.iter().map(polygon).collect::<Vec<_>>().join(", ")),
    }
}
