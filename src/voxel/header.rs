//! The header: what a database is, before any page is read.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::format::METADATA_LIMIT;
use super::{DetailRecord, Grid, HeightCode, SharedObjects};

/// Identity of a database: BLAKE3 over what it says, independent of page order on disk.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct ContentHash(pub [u8; 32]);

impl std::fmt::Display for ContentHash {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl std::fmt::Debug for ContentHash {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ContentHash({self})")
    }
}

/// Lowest and highest surface of a database, metres above the vertical datum; both 0 if there is none at all.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HeightRange {
    /// The lowest surface.
    pub low: f64,
    /// The highest surface.
    pub high: f64,
}

/// Everything that is known when a database is opened.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    /// Format version of the file.
    pub version: u32,
    /// The voxel grid.
    pub grid: Grid,
    /// Levels stored, ≥ 4.
    pub level_count: u8,
    /// Coding of heights.
    pub heights: HeightCode,
    /// Lowest and highest surface, bare ground and what stands on it included.
    pub height_range: HeightRange,
    /// Whether something stands on the ground somewhere: there are pages of [bare ground](super::BARE).
    pub has_spans: bool,
    /// Objects that stand in many places.
    pub objects: Arc<SharedObjects>,
    /// Identity of the content.
    pub content_hash: ContentHash,
    /// Provenance and reference systems.
    pub metadata: Metadata,
}

/// Reference systems and provenance; stored as JSON.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Metadata {
    /// Name of the coordinate reference system, or `local` for plain metres.
    pub crs_name: String,
    /// EPSG code of it, where it has one.
    pub crs_epsg: Option<u32>,
    /// PROJ definition of it; `None` for local metres.
    pub crs_proj: Option<String>,
    /// Datum that heights are measured from, e.g. `EGM96 mean sea level`.
    pub vertical_datum: String,
    /// Rasters in order; a voxel's source id is an index into this list.
    pub sources: Vec<SourceRecord>,
    /// Parts that are stored more finely than the rest; none if all of the area is stored at its finest.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub corridors: Vec<CorridorRecord>,
    /// Classes of material that its voxels and spans hold, by rising number; none in a database that was written before they were told, or that
    /// knows no materials.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<MaterialRecord>,
    /// Assumptions and repairs of the build, as sentences.
    pub notes: Vec<String>,
    /// Share of level-1 voxels whose source had no data, 0…1 (filled ones included).
    pub void_share: f64,
    /// Share of level-1 voxels without data in the sources that have a surface all the same, filled from around or with a height, 0…1; `None`: none of them,
    /// or not told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filled_share: Option<f64>,
    /// Share of level-1 voxels without any surface, 0…1.
    pub empty_share: f64,
    /// Azimuth (clockwise from grid north) and elevation of the sun whose shadows its colours hold, degrees; `None`: they hold none but those of the imagery.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baked_sun: Option<[f64; 2]>,
    /// Side of the pixels of its finest imagery, metres, where that is coarser than the finest voxels; `None` otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub imagery_pixel: Option<f64>,
    /// Detail below its finest voxels; `None`: as usual.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detail: Option<DetailRecord>,
    /// Program and version that wrote the file.
    pub writer: String,
}

/// One input raster.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SourceRecord {
    /// File name, without folders.
    pub file: String,
    /// `elevation` or `imagery`.
    pub role: String,
    /// Kind of the file, e.g. `GeoTIFF int16 3601x3601, EPSG:4326, EGM96 heights, metres`.
    pub description: String,
}

/// A strip along a route that is stored more finely than what lies around it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CorridorRecord {
    /// File name of the route, without folders.
    pub route: String,
    /// Width from side to side, metres.
    pub width: f64,
    /// Side of the finest voxels, metres.
    pub spacing: f64,
}

/// A class of material.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MaterialRecord {
    /// Number of the class in voxels and spans, 1…255.
    pub number: u8,
    /// Name of the class, e.g. `bare-soil`.
    pub name: String,
    /// The class of the table that it behaves as, if it is one of the place's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub like: Option<String>,
    /// Colour where nothing else says one, sRGB.
    pub colour: [u8; 3],
}

impl Metadata {
    /// Returns the name of a class of material in this database.
    pub fn material_name(&self, number: u8) -> String {
        let recorded = self.materials.iter().find(|record| record.number == number);
        let known = || super::Material::of_code(number).name().map(str::to_owned);
        recorded.map(|record| record.name.clone()).or_else(known).unwrap_or_else(|| format!("class {number}"))
    }

    /// The class of the table that a class of material is, or behaves as.
    pub fn material(&self, number: u8) -> super::Material {
        let recorded = self.materials.iter().find(|record| record.number == number);
        let like = recorded.and_then(|record| super::Material::named(record.like.as_deref()?));
        like.unwrap_or_else(|| super::Material::of_code(number))
    }

    /// Encodes as stored, or says what is wrong with it.
    pub(super) fn to_json(&self) -> Result<Vec<u8>, String> {
        self.check()?;
        let json = serde_json::to_vec(self).map_err(|error| format!("metadata: {error}"))?;
        if json.len() as u64 > METADATA_LIMIT {
            return Err(format!("metadata: {} bytes, but at most {METADATA_LIMIT} are stored", json.len()));
        }
        Ok(json)
    }
}
