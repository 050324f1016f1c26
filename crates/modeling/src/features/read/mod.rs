//! Files of features to rows.
//!
//! ```text
//! what the file is:   SQLite format 3 → GeoPackage | 00 00 27 0A → Shapefile | { → GeoJSON | named .csv → table of outlines
//!                     else an error that says how to convert it
//! its system:         its own | that of the options | WGS 84 for GeoJSON and tables | an error
//! each row:           form and attributes, or left out and counted; a file that is cut off or damaged is an error
//! ```
//! All readers take nothing on trust: what a file promises is compared with what is left of it before any memory is taken for it,
//! and no byte of it can make them panic or go round in circles.

mod bytes;
mod found;
mod geojson;
mod geopackage;
mod hstore;
mod outlines;
pub(super) mod rings;
mod shapefile;
mod sql;
mod sqlite;
mod table;
#[cfg(test)]
mod tests;
mod wkb;

pub(in super::super) use outlines::OutlineTable;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::layer::{Layer, LayerOptions, bounds};
use crate::features::read::found::whole;
use crate::naming::contradiction;
use hedgehop_base::document::unmarked;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// Reads a file of features.
///
/// # Errors
/// A file that cannot be read, is damaged or of another kind, states no reference system where one is needed, or has coordinates
/// that cannot be of its system.
pub fn read(path: &Path, options: &LayerOptions) -> Result<Layer> {
    let found = match kind_of(path)? {
        FileKind::GeoPackage => geopackage::read(path, options.table.as_deref())?,
        FileKind::Shapefile => shapefile::read(path, &whole(path)?)?,
        FileKind::GeoJson => geojson::read(path, whole(path)?)?,
        FileKind::Outlines => outlines::read(path, &whole(path)?)?,
    };
    if let Some((count, reason)) = found.left_out.most().filter(|_| found.rows.is_empty()) {
        let (all, are) = if count == 1 {
            ("its only row".to_owned(), "is")
        } else {
            (format!("all its {count} rows"), "are")
        };
        return Err(Error::invalid(path, format!("{all} {are} of no use: {reason}")));
    }

    let file = crate::naming::file_name(path);
    let mut notes: Vec<String> = found.notes.iter().map(|note| format!("{file}: {note}")).collect();
    let crs = match (&found.crs, &options.crs, found.otherwise) {
        (Some(crs), given, _) => {
            notes.extend(contradiction(&file, crs, given.as_deref(), "`crs` of [[features]]")?);
            crs.clone()
        }
        (None, Some(given), _) => {
            let crs = Crs::from_user(given)?;
            notes.push(format!("{file}: states no reference system, taken as {}, as given", crs.name()));
            crs
        }
        (None, None, Some(crs)) => crs,
        (None, None, None) => {
            return Err(Error::unsupported(
                path,
                "states no coordinate reference system",
                "put a .prj file to it, or say the system with crs = \"EPSG:…\" (\"local\" for plain metres)",
            ));
        }
    };

    if let Some(bounds) = bounds(found.rows.iter().flat_map(|row| row.geometry.places())) {
        notes.extend(crs.doubt(bounds).map(|doubt| format!("{file}: {doubt}")));
        plausible(path, &crs, bounds)?;
    }

    notes.extend(found.left_out.into_notes(&file));
    Ok(Layer { path: path.to_owned(), crs, rows: found.rows, notes })
}

enum FileKind {
    GeoPackage,
    Shapefile,
    GeoJson,
    Outlines,
}

fn kind_of(path: &Path) -> Result<FileKind> {
    let mut head = Vec::new();
    let file = File::open(path).map_err(|error| Error::io(path, "read", error))?;
    file.take(256).read_to_end(&mut head).map_err(|error| Error::io(path, "read", error))?;
    if head.starts_with(sqlite::MAGIC) {
        return Ok(FileKind::GeoPackage);
    }
    if head.starts_with(&shapefile::MAGIC) {
        return Ok(FileKind::Shapefile);
    }

    let text = unmarked(path, &head)?;
    let first = text.iter().find(|byte| !byte.is_ascii_whitespace() && **byte != 0x1e);
    if first == Some(&b'{') {
        return Ok(FileKind::GeoJson);
    }

    let extension =
        path.extension().and_then(|extension| extension.to_str()).unwrap_or("").to_ascii_lowercase();
    if ["dbf", "shx", "prj", "cpg"].contains(&extension.as_str()) {
        return Err(Error::unsupported(path, "is a part of a Shapefile", "name the .shp file beside it"));
    }
    if extension == "csv" && first.is_some() {
        return Ok(FileKind::Outlines);
    }

    let convert = "convert it: ogr2ogr -f GPKG FEATURES.gpkg FILE";
    Err(match first {
        None => Error::invalid(
            path,
            "is empty; it must be GeoJSON, a Shapefile (.shp), a GeoPackage (.gpkg) or a table (.csv)",
        ),
        _ if head.starts_with(b"PK\x03\x04") => {
            Error::unsupported(path, "is a ZIP archive", "unpack it and name what is in it")
        }
        _ if head.windows(9).any(|window| window == b"OSMHeader") => {
            Error::unsupported(path, "is OpenStreetMap's own format", convert)
        }
        Some(b'<') => Error::unsupported(path, "is XML (KML, GML or OpenStreetMap)", convert),
        Some(_) => Error::unsupported(
            path,
            "is neither GeoJSON, nor a Shapefile, nor a GeoPackage, nor a table named .csv",
            convert,
        ),
    })
}

/// Refuses coordinates that cannot be what the reference system says.
fn plausible(path: &Path, crs: &Crs, [west, south, east, north]: [f64; 4]) -> Result<()> {
    let extent = format!("its coordinates, {west} … {east} east and {south} … {north} north,");
    let in_degrees = west >= -360.0 && east <= 540.0 && south >= -90.0 && north <= 90.0;
    let name = crs.name();
    if crs.is_geographic() {
        if in_degrees {
            return Ok(());
        }
        return Err(Error::unsupported(
            path,
            format!("{extent} cannot be degrees of {name}"),
            "it was written in another system, or with northings first: say so in the file (ogr2ogr -a_srs EPSG:…), or, of one that states none, with `crs` of [[features]]",
        ));
    }

    if !crs.is_local() && in_degrees {
        return Err(Error::unsupported(
            path,
            format!("{extent} look like degrees, but would be taken as metres ({name})"),
            "say the right system in the file (ogr2ogr -a_srs EPSG:4326), or, of one that states none, with `crs` of [[features]]",
        ));
    }

    Ok(())
}
