//! Horizontal reference systems.
//!
//! Every way to name a system (EPSG code, WKT, GeoTIFF keys, PROJ string) ends in a PROJ definition,
//! which is what the projections are computed from and what a database records. What people type is read in
//! `user`, WKT in `wkt_system`, GeoTIFF keys in `geokeys`.

use super::definition::Definition;
use super::{choice, epsg};
use crate::error::{Error, Result};

/// A horizontal coordinate reference system. Axes are always (east or longitude, north or
/// latitude), whatever order the authority gives; units are metres, or degrees if geographic, or
/// what [`Crs::metres_per_unit`] says.
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

    /// From an EPSG code; of a compound system the horizontal part.
    pub fn from_epsg(code: u32) -> Result<Self> {
        Self::by_code(code).map_err(Error::Configuration)
    }

    pub(super) fn by_code(code: u32) -> Result<Self, String> {
        let code = epsg::current(code);
        let definition = epsg::definition(code)?;
        Ok(Self { name: epsg::name(code), epsg: Some(code), proj: Some(definition.to_string()) })
    }

    /// From a PROJ definition and a name for people.
    pub fn from_proj(definition: &str, name: &str) -> Result<Self> {
        Self::by_definition(definition, name).map_err(Error::Configuration)
    }

    pub(super) fn by_definition(definition: &str, name: &str) -> Result<Self, String> {
        let definition = Definition::loadable(definition)?;
        Ok(Self { name: name.to_owned(), epsg: None, proj: Some(definition.to_string()) })
    }

    /// What a database header says (name, EPSG code, PROJ definition). The definition decides; without
    /// one the code does, and without both the system is local.
    pub fn from_record(name: &str, epsg: Option<u32>, proj: Option<&str>) -> Result<Self> {
        let mut crs = match (proj, epsg) {
            (Some(proj), _) => Self::from_proj(proj, name)?,
            (None, Some(code)) => Self::from_epsg(code)?,
            (None, None) => Self::local(),
        };
        crs.name = name.to_owned();
        crs.epsg = epsg;
        Ok(crs)
    }

    /// WGS 84 longitude and latitude, degrees.
    pub fn wgs84() -> Self {
        Self { name: epsg::name(4326), epsg: Some(4326), proj: Some("+proj=longlat +datum=WGS84".to_owned()) }
    }

    /// The metric system for an area given in degrees (west, south, east, north): the UTM zone of its centre
    /// (WGS 84), polar stereographic beyond UTM's latitudes, or World Equidistant Cylindrical (EPSG:4087)
    /// where UTM would distort more. An east below the west means an area across the 180th meridian.
    pub fn metric_for(bounds: [f64; 4]) -> Self {
        let code = choice::metric_code(bounds);
        // All codes that the choice knows are in the definitions (a test holds that); local metres are
        // unreachable, and harmless.
        Self::by_code(code).unwrap_or_else(|_| Self::local())
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
        self.definition().is_some_and(|definition| definition.is_geographic())
    }

    /// Plain metres without a place on Earth.
    pub fn is_local(&self) -> bool {
        self.proj.is_none()
    }

    /// Metres per unit of the coordinates, above 0: 1 for metres and local systems; `None` for degrees.
    pub fn metres_per_unit(&self) -> Option<f64> {
        match self.definition() {
            None => Some(1.0),
            Some(definition) if definition.is_geographic() => None,
            Some(definition) => definition.load().ok().map(|proj| proj.to_meter()),
        }
    }

    /// Coordinates are metres, as a database needs them.
    pub fn is_metric(&self) -> bool {
        self.metres_per_unit() == Some(1.0)
    }

    /// Whether both put every place at the same coordinates, by whatever name. Datums that agree with WGS 84
    /// within a metre or two and have no shift to it (NAD83, ETRS89, SIRGAS 2000) count as WGS 84.
    pub fn is_equivalent(&self, other: &Self) -> bool {
        match (self.definition(), other.definition()) {
            (None, None) => true,
            (Some(one), Some(two)) => one.is_equivalent(&two),
            _ => false,
        }
    }

    pub(super) fn definition(&self) -> Option<Definition> {
        Definition::parse(self.proj.as_deref()?).ok()
    }

    pub(super) fn named(mut self, name: &str) -> Self {
        if !name.trim().is_empty() {
            self.name = shortened(name.trim());
        }
        self
    }
}

/// The first part of a text that may be of any length.
pub(super) fn shortened(text: &str) -> String {
    const LONGEST: usize = 80;
    let plain: String = text.chars().take(LONGEST).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(LONGEST).is_some() { format!("{plain}…") } else { plain }
}
