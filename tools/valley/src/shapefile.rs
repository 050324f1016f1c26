//! Lines and their tags as a Shapefile: *ESRI Shapefile Technical Description* (1998), attributes as dBASE's level 3.
//!
//! ```text
//! .shp   header of 100 bytes; records: number and 16-bit words (big-endian), then type 3, box, parts 1, points, 0, points × (x y)
//! .shx   the same header; for each record where it begins and its length, in words (big-endian)
//! .dbf   header of 32 bytes, 32 for each column, 0x0D; rows: ' ', then texts, filled up with spaces; 0x1A
//! .prj   the reference system's text    .cpg   the letters of the .dbf
//! ```

use std::error::Error;

use glam::DVec2;

use crate::features::{Feature, Geometry, Value};
use crate::geotiff::ORIGIN;

/// The parts of a Shapefile, by the endings of their names.
pub struct Shapefile {
    pub shp: Vec<u8>,
    pub shx: Vec<u8>,
    pub dbf: Vec<u8>,
    pub prj: Vec<u8>,
    pub cpg: Vec<u8>,
}

/// Columns: a tag of ten letters at most, letters that its texts may have, decimals if it is a number.
const COLUMNS: [(&str, u8, Option<u8>); 8] = [
    ("barrier", 8, None),
    ("natural", 8, None),
    ("leaf_type", 12, None),
    ("highway", 8, None),
    ("surface", 8, None),
    ("colour", 8, None),
    ("height", 8, Some(2)),
    ("width", 8, Some(2)),
];

/// WGS 84, UTM zone 32 north (EPSG:32632), as ESRI writes it.
const SYSTEM: &str = r#"PROJCS["WGS_1984_UTM_Zone_32N",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["False_Easting",500000.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",9.0],PARAMETER["Scale_Factor",0.9996],PARAMETER["Latitude_Of_Origin",0.0],UNIT["Meter",1.0]]"#;

const HEADER: usize = 100;
/// Shape type of lines.
const LINES: u32 = 3;

/// The files' bytes; an error if a feature is no line or a tag has no column.
pub fn encode(features: &[Feature]) -> Result<Shapefile, Box<dyn Error>> {
    let (mut shapes, mut index, mut all) = (Vec::new(), Vec::new(), Vec::new());
    for (row, feature) in features.iter().enumerate() {
        let Geometry::Line(line) = &feature.geometry else { return Err("a row that is no line".into()) };
        let line: Vec<DVec2> = line.iter().map(|&place| georeferenced(place)).collect();
        let record = record(&line)?;
        for number in [(HEADER + shapes.len()) / 2, record.len() / 2] {
            index.extend(u32::try_from(number)?.to_be_bytes());
        }
        for number in [row + 1, record.len() / 2] {
            shapes.extend(u32::try_from(number)?.to_be_bytes());
        }
        shapes.extend(record);
        all.extend(line);
    }

    let with_header = |content: Vec<u8>| -> Result<Vec<u8>, Box<dyn Error>> {
        let mut bytes = header(&all, content.len())?;
        bytes.extend(content);
        Ok(bytes)
    };

    Ok(Shapefile {
        shp: with_header(shapes)?,
        shx: with_header(index)?,
        dbf: table(features)?,
        prj: SYSTEM.into(),
        cpg: "UTF-8".into(),
    })
}

/// A place of the reference system, in hundredths of a metre.
fn georeferenced(place: DVec2) -> DVec2 {
    let hundredths = |metres: f64| (metres * 100.0).round() / 100.0;
    (ORIGIN + place).map(hundredths)
}

fn header(places: &[DVec2], content: usize) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut bytes = 9994u32.to_be_bytes().to_vec();
    bytes.resize(24, 0);
    bytes.extend(u32::try_from((HEADER + content) / 2)?.to_be_bytes());
    bytes.extend([1000, LINES].iter().flat_map(|number| number.to_le_bytes()));
    bytes.extend(bounds(places));
    bytes.resize(HEADER, 0);
    Ok(bytes)
}

/// West, south, east, north.
fn bounds(places: &[DVec2]) -> impl Iterator<Item = u8> {
    let low = places.iter().fold(DVec2::MAX, |low, place| low.min(*place));
    let high = places.iter().fold(DVec2::MIN, |high, place| high.max(*place));
    [low.x, low.y, high.x, high.y].into_iter().flat_map(f64::to_le_bytes)
}

/// Encodes a record after its number and length.
fn record(line: &[DVec2]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut bytes = LINES.to_le_bytes().to_vec();
    bytes.extend(bounds(line));
    bytes.extend([1, u32::try_from(line.len())?, 0].iter().flat_map(|number| number.to_le_bytes()));
    bytes.extend(line.iter().flat_map(|place| place.to_array()).flat_map(f64::to_le_bytes));
    Ok(bytes)
}

fn table(features: &[Feature]) -> Result<Vec<u8>, Box<dyn Error>> {
    let width: usize = COLUMNS.iter().map(|(_, width, _)| usize::from(*width)).sum();
    // A day that stays: 1 January 2024.
    let mut bytes = vec![3, 124, 1, 1];
    bytes.extend(u32::try_from(features.len())?.to_le_bytes());
    for length in [32 * (1 + COLUMNS.len()) + 1, 1 + width] {
        bytes.extend(u16::try_from(length)?.to_le_bytes());
    }

    bytes.resize(32, 0);
    for (name, width, decimals) in COLUMNS {
        let start = bytes.len();
        bytes.extend(name.as_bytes());
        bytes.resize(start + 11, 0);
        bytes.push(if decimals.is_some() { b'N' } else { b'C' });
        bytes.extend([0, 0, 0, 0, width, decimals.unwrap_or(0)]);
        bytes.resize(start + 32, 0);
    }

    bytes.push(b'\r');
    for feature in features {
        bytes.push(b' ');
        bytes.extend(cells(feature)?.into_bytes());
    }

    bytes.push(0x1a);
    Ok(bytes)
}

/// A row's texts, each as wide as its column: texts to the left, numbers to the right.
fn cells(feature: &Feature) -> Result<String, Box<dyn Error>> {
    let mut met = 0;
    let cells = COLUMNS.map(|(column, width, decimals)| {
        let width = usize::from(width);
        let value = feature.tags.iter().find(|tag| tag.key == column).map(|tag| &tag.value);
        met += usize::from(value.is_some());
        match value {
            Some(Value::Number(number)) => format!("{number:>width$.*}", usize::from(decimals.unwrap_or(0))),
            Some(Value::Text(text)) => format!("{text:<width$}"),
            None => " ".repeat(width),
        }
    });
    let fits = cells.iter().zip(COLUMNS).all(|(cell, (_, width, _))| cell.len() == usize::from(width));
    if met < feature.tags.len() || !fits {
        return Err("a tag that has no column, or does not fit in it".into());
    }
    Ok(cells.concat())
}
