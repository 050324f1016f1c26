//! Horizontal reference systems and the transforms between them.

use crate::error::Result;

/// A horizontal coordinate reference system. Axes are always (east or longitude, north or
/// latitude), whatever order the authority gives; units are metres, or degrees if geographic.
#[derive(Debug, Clone, PartialEq)]
pub struct Crs {
    name: String,
    epsg: Option<u32>,
    proj: Option<String>,
}

impl Crs {
    /// Plain metres without a place on Earth.
    pub fn local() -> Self {
        Self { name: "local".into(), epsg: None, proj: None }
    }
    /// From what a user types: `EPSG:32633`, `32633`, `local`, `+proj=…`, WKT, or a `.prj` file's path.
    pub fn from_user(text: &str) -> Result<Self> {
        let _ = text;
        todo!()
    }
    /// From an EPSG code.
    pub fn from_epsg(code: u32) -> Result<Self> {
        let _ = code;
        todo!()
    }
    /// From WKT 1 (OGC or Esri dialect) or WKT 2.
    pub fn from_wkt(text: &str) -> Result<Self> {
        let _ = text;
        todo!()
    }
    /// From a PROJ definition and a name for people.
    pub fn from_proj(definition: &str, name: &str) -> Result<Self> {
        let _ = (definition, name);
        todo!()
    }
    /// What a database header says (name, EPSG code, PROJ definition).
    pub fn from_record(name: &str, epsg: Option<u32>, proj: Option<&str>) -> Result<Self> {
        let _ = (name, epsg, proj);
        todo!()
    }
    /// WGS 84 longitude and latitude, degrees.
    pub fn wgs84() -> Self {
        todo!()
    }
    /// The metric system for an area given in degrees (west, south, east, north): the UTM zone of its centre
    /// (WGS 84), polar stereographic beyond UTM's latitudes, or World Equidistant Cylindrical (EPSG:4087) where UTM would distort.
    pub fn metric_for(bounds: [f64; 4]) -> Self {
        let _ = bounds;
        todo!()
    }
    /// Name for people.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// EPSG code, where known.
    pub fn epsg(&self) -> Option<u32> {
        self.epsg
    }
    /// PROJ definition; `None` for local metres.
    pub fn proj(&self) -> Option<&str> {
        self.proj.as_deref()
    }
    /// Coordinates are degrees.
    pub fn is_geographic(&self) -> bool {
        todo!()
    }
    /// Plain metres without a place on Earth.
    pub fn is_local(&self) -> bool {
        self.proj.is_none()
    }
}

/// Takes positions from one system to another.
#[derive(Debug)]
pub struct Transform {}

impl Transform {
    /// From `from` to `to`; an error if one of them is local and the other not.
    pub fn new(from: &Crs, to: &Crs) -> Result<Self> {
        let _ = (from, to);
        todo!()
    }
    /// The position in the target system, or `None` where there is none (outside the projection's domain).
    pub fn apply(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        let _ = (x, y);
        todo!()
    }
    /// Whether both systems are the same, so that positions pass unchanged.
    pub fn is_identity(&self) -> bool {
        todo!()
    }
}
