//! Shapefiles: *ESRI Shapefile Technical Description* (1998).
//!
//! ```text
//! header   100 bytes: 9994 (big-endian) … version 1000, shape type (little-endian)
//! records  number, length in 16-bit words (big-endian); shape type, then by type (little-endian):
//!     point         x y
//!     multipoint    box, count, count × (x y)
//!     line, polygon box, parts, points, parts × first point, points × (x y)
//!     … Z           then: range, count × z;  … M and Z: range, count × m, which may be missing
//! ```
//! The index (`.shx`) is not needed: records lie one after another. Attributes are in the `.dbf` beside it.

use std::fs;
use std::path::{Path as FilePath, PathBuf};

use glam::dvec2;

use super::super::layer::{Attributes, Geometry, Path, Row};
use super::bytes::{Bytes, Order};
use super::rings;
use super::table::Table;
use crate::features::read::found::{FoundRows, whole};
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// First bytes of a `.shp`.
pub(super) const MAGIC: [u8; 4] = [0, 0, 0x27, 0x0a];
const VERSION: u32 = 1000;
const HEADER: usize = 100;

/// All rows of the file with these bytes.
pub(super) fn read(path: &FilePath, bytes: &[u8]) -> Result<FoundRows> {
    let mut rest = Bytes::of(bytes);
    let version = rest.take(HEADER).and_then(|header| Bytes::of(&header[28..]).u32(Order::Little));
    match version {
        None => {
            return Err(Error::invalid(
                path,
                format!("has {} bytes, fewer than a Shapefile's header", bytes.len()),
            ));
        }
        Some(VERSION) => {}
        Some(other) => {
            return Err(Error::invalid(path, format!("byte 28: version {other} instead of {VERSION}")));
        }
    }

    let mut found = FoundRows { crs: system(path)?, ..FoundRows::default() };
    let table = match sibling(path, "dbf") {
        Some(file) => Some(Table::open(&file, sibling(path, "cpg").as_deref(), whole(&file)?)?),
        None => {
            found.notes.push("has no .dbf beside it, so that its features have no attributes".to_owned());
            None
        }
    };

    found.notes.extend(table.iter().flat_map(Table::notes));
    let mut index = 0;
    while rest.len() > 0 {
        let at = bytes.len() - rest.len();
        // Some writers leave zeros behind the last record.
        if rest.len() < 8 || bytes[at..].iter().take(8).all(|byte| *byte == 0) {
            break;
        }

        let place = format!("row {}", index + 1);
        let words = rest.u32(Order::Big).and_then(|_| rest.u32(Order::Big));
        let content = words.and_then(|words| rest.take((words as usize).checked_mul(2)?));

        let Some(content) = content else {
            return Err(Error::invalid(
                path,
                format!("byte {at}: {place} is cut off or damaged; copy the file again"),
            ));
        };

        match (shape(content), table.as_ref().map(|table| table.row(index))) {
            (_, Some(Err(reason))) | (Err(reason), _) => found.left_out.add(&place, reason),
            (Ok(geometry), _) if geometry.is_empty() => found.left_out.add(&place, "it has no geometry"),
            (Ok(geometry), row) => {
                let attributes = row.map_or_else(Attributes::default, |row| row.unwrap_or_default());
                found.rows.push(Row { place, geometry, attributes });
            }
        }

        index += 1;
    }

    if let Some(table) = table.filter(|table| table.len() != index) {
        found.notes.push(format!("has {index} rows, but its .dbf {}; they are taken in order", table.len()));
    }

    Ok(found)
}

/// The file beside it with another extension, in lower or upper case.
fn sibling(path: &FilePath, extension: &str) -> Option<PathBuf> {
    [extension.to_owned(), extension.to_ascii_uppercase()]
        .into_iter()
        .map(|extension| path.with_extension(extension))
        .find(|file| file.is_file())
}

fn system(path: &FilePath) -> Result<Option<Crs>> {
    let Some(file) = sibling(path, "prj") else { return Ok(None) };
    let length = fs::metadata(&file).map_err(|error| Error::io(&file, "read", error))?.len();
    if length == 0 {
        return Ok(None);
    }
    Crs::from_user(&file.to_string_lossy()).map(Some)
}

/// The form of a record, empty if it has none.
fn shape(content: &[u8]) -> Result<Geometry, String> {
    let mut rest = Bytes::of(content);
    let cut = || "its record is shorter than it says".to_owned();
    let kind = rest.u32(Order::Little).ok_or_else(cut)?;
    let has_z = (11..20).contains(&kind);
    let mut geometry = Geometry::default();

    match kind {
        0 => {}
        1 | 11 | 21 => {
            let mut path = places(&mut rest, 1).ok_or_else(cut)?;
            if has_z {
                path.heights.extend(rest.f64(Order::Little));
            }
            geometry.points = sound(path)?;
        }
        8 | 18 | 28 => {
            rest.take(32).ok_or_else(cut)?;
            let count = rest.count(Order::Little, 16).ok_or_else(cut)?;
            let path = places(&mut rest, count).ok_or_else(cut)?;
            geometry.points = sound(with_heights(path, has_z, &mut rest))?;
        }
        3 | 5 | 13 | 15 | 23 | 25 => {
            rest.take(32).ok_or_else(cut)?;
            let parts = parts(&mut rest, has_z).ok_or_else(cut)??;
            if matches!(kind, 5 | 15 | 25) {
                geometry.areas = rings::areas(parts);
            } else {
                geometry.lines = parts.into_iter().filter_map(Path::line).collect();
            }
        }
        31 => return Err("it is a multipatch, which is not read here".to_owned()),
        other => return Err(format!("its shape type {other} is none")),
    }

    Ok(geometry)
}

fn places(rest: &mut Bytes<'_>, count: usize) -> Option<Path> {
    let mut taken = Bytes::of(rest.take(count.checked_mul(16)?)?);
    let place = |_| Some(dvec2(taken.f64(Order::Little)?, taken.f64(Order::Little)?));
    Some(Path::flat((0..count).map(place).collect::<Option<_>>()?))
}

fn with_heights(mut path: Path, has_z: bool, rest: &mut Bytes<'_>) -> Path {
    let count = path.places.len();
    if let Some(bytes) = rest.take(16).filter(|_| has_z).and_then(|_| rest.take(count * 8)) {
        let mut bytes = Bytes::of(bytes);
        path.heights.extend((0..count).map_while(|_| bytes.f64(Order::Little)));
    }
    path
}

/// A path of finite numbers; heights below −10³⁸ mean that there is none.
fn sound(mut path: Path) -> Result<Path, String> {
    const NO_DATA: f64 = -1e38;
    if path.heights.iter().any(|height| !height.is_finite() || *height < NO_DATA) {
        path.heights.clear();
    }
    let is_sound = path.places.iter().all(|place| place.is_finite());
    if is_sound { Ok(path) } else { Err("a coordinate of it is no finite number".to_owned()) }
}

/// The parts of a line or polygon, behind their box.
fn parts(rest: &mut Bytes<'_>, has_z: bool) -> Option<Result<Vec<Path>, String>> {
    let mut counts = rest.clone();
    let parts = counts.u32(Order::Little)? as usize;
    let points = counts.u32(Order::Little)? as usize;
    if parts.checked_mul(4)?.checked_add(points.checked_mul(16)?)? > counts.len() {
        return None;
    }

    *rest = counts;
    let mut firsts: Vec<usize> =
        (0..parts).map(|_| rest.u32(Order::Little).map(|first| first as usize)).collect::<Option<_>>()?;
    let path = places(rest, points)?;
    let path = match sound(with_heights(path, has_z, rest)) {
        Ok(path) => path,
        Err(reason) => return Some(Err(reason)),
    };
    firsts.push(points);
    if firsts.windows(2).any(|pair| pair[0] > pair[1]) || firsts[0] != 0 {
        return Some(Err("its parts are out of order".to_owned()));
    }

    let part = |pair: &[usize]| Path {
        places: path.places[pair[0]..pair[1]].to_vec(),
        heights: path.heights.get(pair[0]..pair[1]).unwrap_or_default().to_vec(),
    };

    Some(Ok(firsts.windows(2).map(part).collect()))
}
