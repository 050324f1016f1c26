//! Features and their tags as a GeoPackage: OGC 12-128r18 (2021), tables of features, a column for each tag.
//!
//! ```text
//! gpkg_spatial_ref_sys   the three systems that every file has, and this one's
//! gpkg_contents          a row for each table; gpkg_geometry_columns likewise
//! a geometry             "GP", version 0, flags 1 (little-endian, no box), system i32, well-known binary
//! ```

use std::collections::BTreeMap;
use std::error::Error;

use glam::DVec2;
use rusqlite::types::{Null, ToSql};
use rusqlite::{Connection, MAIN_DB, params_from_iter};

use crate::features::{Feature, Geometry, Tag, Value};
use crate::geotiff::ORIGIN;

/// WGS 84, UTM zone 32 north.
const SYSTEM: i32 = 32632;
const WKT: &str = r#"PROJCS["WGS 84 / UTM zone 32N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433],AUTHORITY["EPSG","4326"]],PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",9],PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1],AUTHORITY["EPSG","32632"]]"#;
const WGS_84: &str = r#"GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433],AUTHORITY["EPSG","4326"]]"#;

/// Tables that every file has. Pages are small: there is little on each.
const TABLES: &str = "
PRAGMA page_size = 1024;
PRAGMA application_id = 0x47504B47;
PRAGMA user_version = 10300;
CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT NOT NULL, srs_id INTEGER NOT NULL PRIMARY KEY, organization TEXT NOT NULL, organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT);
CREATE TABLE gpkg_contents (table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT UNIQUE, description TEXT DEFAULT '', last_change DATETIME NOT NULL, min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER, CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id));
CREATE TABLE gpkg_geometry_columns (table_name TEXT NOT NULL, column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL, srs_id INTEGER NOT NULL, z TINYINT NOT NULL, m TINYINT NOT NULL, CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name), CONSTRAINT uk_gc_table_name UNIQUE (table_name), CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) REFERENCES gpkg_contents(table_name), CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys (srs_id));
INSERT INTO gpkg_spatial_ref_sys VALUES ('Undefined Cartesian', -1, 'NONE', -1, 'undefined', NULL), ('Undefined geographic', 0, 'NONE', 0, 'undefined', NULL);
";

/// A table of the file.
pub struct FeatureTable {
    /// Name of the table.
    pub name: &'static str,
    /// Rows of the table.
    pub features: Vec<Feature>,
}

/// Encodes tables as the file's bytes.
pub fn encode(tables: &[FeatureTable]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut base = Connection::open_in_memory()?;
    base.execute_batch(TABLES)?;
    for (name, system, definition) in [("WGS 84", 4326, WGS_84), ("WGS 84 / UTM zone 32N", SYSTEM, WKT)] {
        base.execute(
            "INSERT INTO gpkg_spatial_ref_sys VALUES (?1, ?2, 'EPSG', ?2, ?3, NULL)",
            (name, system, definition),
        )?;
    }
    for FeatureTable { name, features } in tables {
        write_table(&base, name, features)?;
    }
    Ok(base.serialize(MAIN_DB)?.to_vec())
}

fn write_table(base: &Connection, name: &str, features: &[Feature]) -> Result<(), Box<dyn Error>> {
    // A tag is a number in all rows, or a text.
    let mut columns = BTreeMap::new();
    for Tag { key, value } in features.iter().flat_map(|feature| &feature.tags) {
        let kind = if matches!(value, Value::Number(_)) { "REAL" } else { "TEXT" };
        if *columns.entry(*key).or_insert(kind) != kind {
            return Err(format!("table {name}: {key} is both a number and a text").into());
        }
    }

    let listed: String = columns.iter().map(|(key, kind)| format!(", \"{key}\" {kind}")).collect();
    base.execute_batch(&format!(
        "CREATE TABLE \"{name}\" (fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, geom GEOMETRY{listed})"
    ))?;
    let [mut low, mut high] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];

    for feature in features {
        for DVec2 { x, y } in places(&feature.geometry).into_iter().map(georeferenced) {
            (low, high) = ([low[0].min(x), low[1].min(y)], [high[0].max(x), high[1].max(y)]);
        }
        let mut row: Vec<Box<dyn ToSql>> = vec![Box::new(geometry(&feature.geometry)?)];

        for column in columns.keys() {
            row.push(match feature.tags.iter().find(|tag| tag.key == *column).map(|tag| &tag.value) {
                Some(Value::Text(text)) => Box::new(text.clone()),
                Some(Value::Number(number)) => Box::new((number * 100.0).round() / 100.0),
                None => Box::new(Null),
            });
        }

        let marks = vec!["?"; row.len()].join(", ");
        base.execute(&format!("INSERT INTO \"{name}\" VALUES (NULL, {marks})"), params_from_iter(row))?;
    }

    // A day that stays.
    base.execute(
        "INSERT INTO gpkg_contents VALUES (?1, 'features', ?1, '', '2024-01-01T00:00:00.000Z', ?2, ?3, ?4, ?5, ?6)",
        (name, low[0], low[1], high[0], high[1], SYSTEM),
    )?;
    base.execute(
        "INSERT INTO gpkg_geometry_columns VALUES (?1, 'geom', 'GEOMETRY', ?2, 0, 0)",
        (name, SYSTEM),
    )?;

    Ok(())
}

/// A place of the reference system, in hundredths of a metre.
fn georeferenced(place: DVec2) -> DVec2 {
    let hundredths = |metres: f64| (metres * 100.0).round() / 100.0;
    (ORIGIN + place).map(hundredths)
}

fn places(geometry: &Geometry) -> Vec<DVec2> {
    match geometry {
        Geometry::Point(place) => vec![*place],
        Geometry::Line(line) => line.clone(),
        Geometry::Polygon(ring) => ring.iter().chain(ring.first()).copied().collect(),
    }
}

fn geometry(geometry: &Geometry) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut bytes = b"GP\x00\x01".to_vec();
    bytes.extend(SYSTEM.to_le_bytes());
    let places = places(geometry);
    let count = u32::try_from(places.len())?;
    // Little-endian; the kind of geometry, how many rings, how many places.
    bytes.push(1);
    let numbers = match geometry {
        Geometry::Point(_) => vec![1],
        Geometry::Line(_) => vec![2, count],
        Geometry::Polygon(_) => vec![3, 1, count],
    };
    bytes.extend(numbers.into_iter().flat_map(u32::to_le_bytes));
    bytes.extend(
        places.into_iter().map(georeferenced).flat_map(|place| place.to_array()).flat_map(f64::to_le_bytes),
    );
    Ok(bytes)
}
