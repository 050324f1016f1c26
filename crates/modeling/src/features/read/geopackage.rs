//! GeoPackages: OGC 12-128r18 (2021), tables of features.
//!
//! ```text
//! gpkg_geometry_columns  which table has its geometry in which column, in which system
//! gpkg_spatial_ref_sys   what that system is: an organization's code, and WKT
//! a geometry             "GP", version, flags, system i32, box (by the flags), well-known binary
//! ```

use std::path::Path;
use std::sync::Arc;

use super::super::layer::{Attributes, Geometry, Row, Value};
use super::sqlite::{Database, SqlCell, SqlTable};
use super::{hstore, wkb};
use crate::features::read::found::FoundRows;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// A table of features.
struct Features {
    table: SqlTable,
    column: usize,
    system: i64,
}

/// All rows of the tables of features, or of the one with a name.
pub(super) fn read(path: &Path, name: Option<&str>) -> Result<FoundRows> {
    let mut database = Database::open(path)?;
    let tables = database.tables()?;
    let mut found = FoundRows::default();
    let chosen = features(path, &mut database, &tables, name, &mut found.notes)?;
    let Some(first) = chosen.first() else {
        found.notes.push("has no table of features".to_owned());
        found.otherwise = Some(Crs::wgs84());
        return Ok(found);
    };

    if let Some(other) = chosen.iter().find(|features| features.system != first.system) {
        return Err(Error::unsupported(
            path,
            format!(
                "its tables \"{}\" and \"{}\" are in different reference systems",
                first.table.name, other.table.name
            ),
            "read them one by one: say which with layer = \"…\"",
        ));
    }

    found.crs = system(path, &mut database, &tables, first.system)?;
    let several = chosen.len() > 1 || name.is_none();
    for Features { table, column, .. } in &chosen {
        let names: Vec<Arc<str>> = table.columns.iter().map(|name| Arc::from(name.as_str())).collect();
        database.rows(table, |id, values| {
            let place =
                if several { format!("table \"{}\", row {id}", table.name) } else { format!("row {id}") };
            match values.get(*column).map(geometry) {
                Some(Ok(geometry)) if !geometry.is_empty() => {
                    let attributes = attributes(&names, values);
                    found.rows.push(Row { place, geometry, attributes });
                }
                Some(Err(reason)) => found.left_out.add(&place, reason),
                _ => found.left_out.add(&place, "it has no geometry"),
            }
            Ok(())
        })?;
    }

    Ok(found)
}

/// The tables of features, in the file's order.
fn features(
    path: &Path,
    database: &mut Database,
    tables: &[SqlTable],
    name: Option<&str>,
    notes: &mut Vec<String>,
) -> Result<Vec<Features>> {
    let columns = tables.iter().find(|table| table.name == "gpkg_geometry_columns").ok_or_else(|| {
        Error::unsupported(
            path,
            "is an SQLite database, but no GeoPackage: it has no table gpkg_geometry_columns",
            "convert it: ogr2ogr -f GPKG FEATURES.gpkg FILE",
        )
    })?;

    let (mut found, mut names) = (Vec::new(), Vec::new());
    database.rows(columns, |_, values| {
        let of = |column: &str| {
            columns.columns.iter().position(|name| name == column).and_then(|at| values.get(at))
        };
        let text = |column: &str| of(column).and_then(SqlCell::text);
        let (Some(owner), Some(column)) = (text("table_name"), text("column_name")) else { return Ok(()) };
        names.push(owner.to_owned());
        if name.is_some_and(|name| name != owner) {
            return Ok(());
        }

        let table = tables.iter().find(|table| table.name.eq_ignore_ascii_case(owner));
        let at =
            table.and_then(|table| table.columns.iter().position(|name| name.eq_ignore_ascii_case(column)));
        match table.cloned().zip(at) {
            Some((table, column)) => {
                let system = of("srs_id").and_then(SqlCell::integer).unwrap_or(-1);
                found.push(Features { table, column, system });
            }
            None => notes.push(format!(
                "table \"{owner}\" is left out: it is a view, or is stored in a way that is not read here"
            )),
        }

        Ok(())
    })?;

    match name {
        Some(name) if !names.iter().any(|known| known == name) => Err(Error::invalid(
            path,
            format!("has no table \"{name}\" of features; it has {}", names.join(", ")),
        )),
        _ => Ok(found),
    }
}

/// Finds the system of a number of the file's own; `None` for the two that say that the system is not known.
fn system(path: &Path, database: &mut Database, tables: &[SqlTable], wanted: i64) -> Result<Option<Crs>> {
    if wanted <= 0 {
        return Ok(None);
    }

    let mut found = None;
    if let Some(table) = tables.iter().find(|table| table.name == "gpkg_spatial_ref_sys") {
        database.rows(table, |_, values| {
            let of = |column: &str| {
                table.columns.iter().position(|name| name == column).and_then(|at| values.get(at))
            };
            let text = |column: &str| of(column).and_then(SqlCell::text).unwrap_or_default().to_owned();
            if of("srs_id").and_then(SqlCell::integer) == Some(wanted) {
                let code = of("organization_coordsys_id").and_then(SqlCell::integer);
                found = Some((text("organization"), code, text("definition"), text("definition_12_063")));
            }
            Ok(())
        })?;
    }

    let Some((organization, code, definition, newer)) = found else {
        return Err(Error::invalid(
            path,
            format!("table gpkg_spatial_ref_sys does not say what system {wanted} is"),
        ));
    };

    let code =
        code.filter(|_| organization.eq_ignore_ascii_case("epsg")).and_then(|code| u32::try_from(code).ok());
    if let Some(crs) = code.and_then(|code| Crs::from_epsg(code).ok()) {
        return Ok(Some(crs));
    }

    let wkt = if definition.is_empty() || definition == "undefined" { newer } else { definition };
    Crs::from_user(&wkt)
        .map(Some)
        .map_err(|error| Error::invalid(path, format!("its reference system {wanted}: {error}")))
}

/// The geometry of a value, empty if it has none.
fn geometry(value: &SqlCell) -> Result<Geometry, String> {
    let bytes = match value {
        SqlCell::Blob(bytes) => bytes,
        SqlCell::Null => return Ok(Geometry::default()),
        _ => return Err("its geometry is none of a GeoPackage".to_owned()),
    };
    let [b'G', b'P', _, flags, _, _, _, _, rest @ ..] = bytes.as_slice() else {
        return Err("its geometry is none of a GeoPackage".to_owned());
    };

    const EMPTY: u8 = 1 << 4;
    const EXTENDED: u8 = 1 << 5;

    if flags & EXTENDED != 0 {
        return Err("its geometry is of an extension that is not read here".to_owned());
    }

    let envelope = match flags >> 1 & 7 {
        0 => 0,
        1 => 32,
        2 | 3 => 48,
        4 => 64,
        _ => return Err("its geometry has a box that is none".to_owned()),
    };

    if flags & EMPTY != 0 {
        return Ok(Geometry::default());
    }

    wkb::geometry(rest.get(envelope..).ok_or("its geometry is cut off")?)
}

fn attributes(names: &[Arc<str>], values: Vec<SqlCell>) -> Attributes {
    let mut attributes = Attributes::default();
    let mut others = None;
    for (name, value) in names.iter().zip(values) {
        match value {
            SqlCell::Integer(number) => attributes.push(name.clone(), Value::Number(number as f64)),
            SqlCell::Real(number) => attributes.push(name.clone(), Value::Number(number)),
            SqlCell::Text(text) if &**name == "other_tags" => others = Some(text),
            SqlCell::Text(text) => attributes.push(name.clone(), Value::Text(text)),
            SqlCell::Null | SqlCell::Blob(_) => {}
        }
    }
    // What has a column of its own counts before what has none.
    if let Some(text) = others {
        hstore::add(&mut attributes, &text);
    }
    attributes
}
