//! Tables of outlines: CSV (RFC 4180) with a column of polygons, all others are attributes.
//!
//! ```text
//! polygon | wkt | geometry    POLYGON ((x y, x y, …), (…)) or MULTIPOLYGON, heights are passed over: OGC 06-103r4 (2011), well-known text
//!                             or a list of corners: x y, x y, …   or   x,y; x,y; …
//! ```
//! Cells are separated by comma, semicolon or tab, whichever the first line has most of.

use std::path::Path as FilePath;
use std::sync::Arc;

use csv::{ReaderBuilder, StringRecord, Trim};
use glam::{DVec2, dvec2};

use super::super::layer::{Attributes, Geometry, Path, Row, Value};
use super::rings;
use crate::features::read::found::{FoundRows, plain};
use hedgehop_base::document::unmarked;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// Columns that may hold the outline.
const OUTLINES: [&str; 4] = ["polygon", "wkt", "geometry", "geom"];

/// All rows of a table.
pub(super) fn read(path: &FilePath, bytes: &[u8]) -> Result<FoundRows> {
    let table = OutlineTable::open(path, bytes)?;
    let mut found = FoundRows { otherwise: Some(Crs::wgs84()), ..FoundRows::default() };
    let names: Vec<Arc<str>> = table.header.iter().map(Arc::from).collect();
    for (place, record) in &table.records {
        let outline = record.get(table.outline).unwrap_or_default();
        match geometry(outline) {
            Err(reason) => found.left_out.add(place, reason),
            Ok(geometry) => {
                let mut attributes = Attributes::default();
                let cells =
                    names.iter().zip(record).enumerate().filter(|(column, _)| *column != table.outline);
                for (_, (name, cell)) in cells {
                    let number = cell.parse().ok().filter(|number: &f64| number.is_finite());
                    attributes.push(
                        name.clone(),
                        number.map_or_else(|| Value::Text(cell.to_owned()), Value::Number),
                    );
                }
                found.rows.push(Row { place: place.clone(), geometry, attributes });
            }
        }
    }

    if table.records.is_empty() {
        found.notes.push("has no rows".to_owned());
    }

    Ok(found)
}

/// A table as it stands.
#[derive(Debug)]
pub(in super::super::super) struct OutlineTable {
    pub header: StringRecord,
    /// The column of outlines.
    outline: usize,
    /// Rows with their places.
    pub records: Vec<(String, StringRecord)>,
    pub delimiter: u8,
}

impl OutlineTable {
    /// The table of a file's bytes.
    ///
    /// # Errors
    /// Text that is not UTF-8, damaged rows, no column of outlines.
    pub fn open(path: &FilePath, bytes: &[u8]) -> Result<Self> {
        let bytes = unmarked(path, bytes)?;
        let first = bytes.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let count = |separator: u8| first.iter().filter(|byte| **byte == separator).count();

        // Of equals the last wins: comma.
        let delimiter =
            [b'\t', b';', b','].into_iter().max_by_key(|separator| count(*separator)).unwrap_or(b',');
        let mut reader =
            ReaderBuilder::new().flexible(true).trim(Trim::All).delimiter(delimiter).from_reader(bytes);
        let damaged = |error: csv::Error| {
            let line = error.position().map_or(1, csv::Position::line);
            Error::invalid(path, format!("line {line}: the table is damaged: {}", plain(&error.to_string())))
        };
        let header = reader.headers().map_err(damaged)?.clone();
        let is_outline = |name: &str| OUTLINES.iter().any(|known| name.eq_ignore_ascii_case(known));
        let outline = header.iter().position(is_outline).ok_or_else(|| {
            let columns = plain(&header.iter().collect::<Vec<_>>().join(", "));
            let what = format!("line 1 names no column \"polygon\", but {columns}; a table of features needs one, with POLYGON ((x y, x y, …))");
            Error::invalid(path, what)
        })?;
        let mut records = Vec::new();

        for record in reader.records() {
            let record = record.map_err(damaged)?;
            let line = record.position().map_or(0, csv::Position::line);
            if record.len() > header.len() {
                let what = format!(
                    "line {line}: {} cells, but line 1 names {}; outlines with commas must stand in quotation marks",
                    record.len(),
                    header.len()
                );
                return Err(Error::invalid(path, what));
            }
            records.push((format!("line {line}"), record));
        }

        Ok(Self { header, outline, records, delimiter })
    }
}

/// The polygons of a text.
fn geometry(text: &str) -> Result<Geometry, String> {
    let text = text.trim();
    if text.is_empty() {
        return Err("it has no outline".to_owned());
    }
    let wrong = || "its outline is none: write POLYGON ((x y, x y, …))".to_owned();
    let upper = text.to_ascii_uppercase();
    let mut geometry = Geometry::default();
    if upper.starts_with("POLYGON") || upper.starts_with("MULTIPOLYGON") {
        let (_, body) = text.split_once('(').ok_or_else(wrong)?;
        // Rings are what parentheses hold that hold none.
        let parts = body.split('(').filter_map(|part| part.split_once(')').map(|(ring, _)| ring));
        let found: Option<Vec<Path>> = parts.map(|ring| corners(ring, ',').map(Path::flat)).collect();
        geometry.areas = rings::areas(found.ok_or_else(wrong)?);
    } else {
        let separator = if text.contains(';') { ';' } else { ',' };
        geometry.areas = rings::areas(vec![Path::flat(corners(text, separator).ok_or_else(wrong)?)]);
    }
    if geometry.areas.is_empty() { Err(wrong()) } else { Ok(geometry) }
}

/// Places with a separator between.
fn corners(text: &str, separator: char) -> Option<Vec<DVec2>> {
    let corner = |text: &str| {
        let mut numbers = text
            .split(|c: char| c.is_whitespace() || c == ',')
            .filter(|number| !number.is_empty())
            .map(|number| number.parse::<f64>().ok().filter(|number| number.is_finite()));
        Some(dvec2(numbers.next()??, numbers.next()??))
    };
    text.split(separator).filter(|part| !part.trim().is_empty()).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<FoundRows> {
        read(FilePath::new("a.csv"), text.as_bytes())
    }

    #[test]
    fn outlines_are_well_known_text_or_corners() {
        let text = "name;polygon;height\n\
            a;POLYGON ((0 0, 9 0, 9 9, 0 9, 0 0), (2 2, 3 2, 3 3));12\n\
            b;multipolygon z (((0 0 1, 1 0 1, 1 1 1)), ((5 5 1, 6 5 1, 6 6 1)));\n\
            c;0 0, 4 0, 4 4;tall\n\
            d;\n\
            e;POINT (1 2);3\n\
            f;POLYGON ((0 0, 1 x, 2 2));3\n";
        let found = read_text(text).unwrap();
        let shapes: Vec<_> =
            found.rows.iter().map(|row| (row.place.as_str(), row.geometry.areas.len())).collect();
        assert_eq!(shapes, [("line 2", 1), ("line 3", 2), ("line 4", 1)]);
        assert_eq!(found.rows[0].geometry.areas[0].holes.len(), 1);
        assert_eq!(found.rows[0].attributes.get("height"), Some(&Value::Number(12.0)));
        assert_eq!(found.rows[2].attributes.get("height"), Some(&Value::Text("tall".to_owned())));
        assert_eq!(found.left_out.into_notes("a.csv").len(), 2);
        let quoted = read_text("polygon,n\n\"0,0; 4,0; 4,4\",1\n").unwrap();
        assert_eq!(quoted.rows[0].geometry.areas[0].outer.places[1], dvec2(4.0, 0.0));
    }

    #[test]
    fn tables_without_outlines_are_refused_with_their_columns() {
        let told = |text: &str| read_text(text).unwrap_err().to_string();
        assert!(told("name,height\na,3\n").contains("name, height"));
        assert!(told("polygon\n0 0, 1 0, 1 1\n").contains("quotation marks"));
        // A quotation without an end is no outline either, but a row by itself.
        assert!(read_text("polygon\n\"\u{0}").is_ok_and(|found| found.rows.is_empty()));
    }
}
