//! The geo keys of a GeoTIFF as they stand: which keys there are, and the value of each.
//!
//! Source: OGC 19-008r4, *GeoTIFF Standard* 1.1 (2019), §7.1 and annex D. What they mean is in `geokeys`.

use std::collections::BTreeMap;

/// Key ids (OGC 19-008r4, annex D).
pub(super) mod key {
    pub const MODEL_TYPE: u16 = 1024;
    pub const RASTER_TYPE: u16 = 1025;
    pub const CITATION: u16 = 1026;
    pub const GEODETIC_CRS: u16 = 2048;
    pub const GEODETIC_CITATION: u16 = 2049;
    pub const GEODETIC_DATUM: u16 = 2050;
    pub const ANGULAR_UNITS: u16 = 2054;
    pub const ANGULAR_UNIT_SIZE: u16 = 2055;
    pub const ELLIPSOID: u16 = 2056;
    pub const SEMI_MAJOR: u16 = 2057;
    pub const SEMI_MINOR: u16 = 2058;
    pub const INVERSE_FLATTENING: u16 = 2059;
    pub const PRIME_MERIDIAN_LONGITUDE: u16 = 2061;
    pub const TO_WGS84: u16 = 2062;
    pub const PROJECTED_CRS: u16 = 3072;
    pub const PROJECTED_CITATION: u16 = 3073;
    pub const PROJECTION: u16 = 3074;
    pub const METHOD: u16 = 3075;
    pub const LINEAR_UNITS: u16 = 3076;
    pub const LINEAR_UNIT_SIZE: u16 = 3077;
    pub const VERTICAL_CRS: u16 = 4096;
    pub const VERTICAL_CITATION: u16 = 4097;
    pub const VERTICAL_DATUM: u16 = 4098;
    pub const VERTICAL_UNITS: u16 = 4099;
}

/// Code for "defined by the other keys".
pub(super) const USER_DEFINED: u16 = 32_767;

const DOUBLES_TAG: u16 = 34_736;
const ASCII_TAG: u16 = 34_737;

/// Remedy for keys that cannot be read.
pub(super) const REPAIR: &str = "write the right one with: gdal_edit.py -a_srs EPSG:CODE FILE";

/// Value of a key.
#[derive(Debug, Clone)]
enum Value {
    Code(u16),
    Doubles(Vec<f64>),
    Text(String),
}

/// The directory, read.
#[derive(Debug, Default)]
pub(super) struct Keys {
    values: BTreeMap<u16, Value>,
    /// The directory announces more keys than it holds.
    pub(super) broken: bool,
}

impl Keys {
    /// Reads the tags 34735 (directory), 34736 (doubles) and 34737 (text), checking every index.
    pub(super) fn read(directory: &[u16], doubles: &[f64], ascii: &str) -> Result<Self, String> {
        let Some((header, entries)) = directory.split_first_chunk::<4>() else {
            return Err(format!(
                "tag 34735 (GeoKeyDirectory) has {} values, fewer than its header of 4",
                directory.len()
            ));
        };

        let [version, _, _, count] = *header;
        if version != 1 {
            return Err(format!(
                "tag 34735 (GeoKeyDirectory) has version {version}; only 1 is known; {REPAIR}"
            ));
        }

        let mut keys = Self::default();
        for index in 0..usize::from(count) {
            let entry = entries.get(4 * index..4 * index + 4);
            let Some(&[id, location, length, value]) = entry else {
                keys.broken = true;
                break;
            };
            if id != 0 {
                let read = value_at(location, usize::from(length), value, doubles, ascii);
                keys.values.insert(id, read.map_err(|reason| format!("geo key {id} {reason}; {REPAIR}"))?);
            }
        }

        Ok(keys)
    }

    /// A code; 0 means undefined.
    pub(super) fn code(&self, id: u16) -> Option<u16> {
        match self.values.get(&id)? {
            Value::Code(0) => None,
            Value::Code(code) => Some(*code),
            _ => None,
        }
    }

    /// A number, finite.
    pub(super) fn number(&self, id: u16) -> Option<f64> {
        match self.values.get(&id)? {
            Value::Doubles(values) => values.first().copied().filter(|value| value.is_finite()),
            Value::Code(code) => Some(f64::from(*code)),
            Value::Text(_) => None,
        }
    }

    pub(super) fn numbers(&self, id: u16) -> Option<&[f64]> {
        match self.values.get(&id)? {
            Value::Doubles(values) => Some(values),
            _ => None,
        }
    }

    pub(super) fn text(&self, id: u16) -> Option<&str> {
        match self.values.get(&id)? {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }
}

fn value_at(location: u16, length: usize, value: u16, doubles: &[f64], ascii: &str) -> Result<Value, String> {
    let start = usize::from(value);
    match location {
        0 => Ok(Value::Code(value)),
        DOUBLES_TAG => {
            let values = doubles.get(start..start + length).filter(|values| !values.is_empty());
            let values = values.ok_or_else(|| {
                format!(
                    "points at values {start} to {} of the {} in tag 34736 (GeoDoubleParams)",
                    start + length,
                    doubles.len()
                )
            })?;
            Ok(Value::Doubles(values.to_vec()))
        }
        ASCII_TAG => {
            // By characters: a reader that turned foreign bytes into one character each keeps the places.
            let text: String = ascii.chars().skip(start).take(length).collect();
            if text.is_empty() && length > 0 {
                return Err(format!(
                    "points at character {start} of the {} in tag 34737 (GeoAsciiParams)",
                    ascii.len()
                ));
            }
            Ok(Value::Text(text.trim_end_matches(['|', '\0']).trim().to_owned()))
        }
        other => Err(format!("points at tag {other}, where no values are")),
    }
}
