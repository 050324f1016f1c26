//! Horizontal reference systems.
//!
//! Every way to name a system (EPSG code, WKT, GeoTIFF keys, PROJ string) ends in a PROJ definition,
//! which is what the projections are computed from and what a database records.

use std::fs;
use std::path::Path;

use super::datum::VerticalCrs;
use super::definition::Definition;
use super::{choice, epsg, wkt};
use crate::error::{Error, Result};

/// What may be typed, for error messages.
const EXAMPLES: &str =
    "give for example EPSG:32633, local, '+proj=utm +zone=33 +datum=WGS84', WKT, or the path of a .prj file";

/// Longest text of a reference system that is read, in bytes.
const LONGEST_FILE: u64 = 1 << 20;

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

    /// From what a user types: `EPSG:32633`, `32633`, `local`, `+proj=…`, WKT, or a `.prj` file's path.
    pub fn from_user(text: &str) -> Result<Self> {
        Ok(Self::with_vertical_from_user(text)?.0)
    }

    /// As [`Crs::from_user`], with the system of the heights where the text names one
    /// (`EPSG:4326+5773`, `EPSG:9518`, compound WKT).
    pub fn with_vertical_from_user(text: &str) -> Result<(Self, Option<VerticalCrs>)> {
        let text = text.trim();
        if text.eq_ignore_ascii_case("local") {
            return Ok((Self::local(), None));
        }
        if looks_like_proj(text) {
            return from_proj_or_init(text).map(|crs| (crs, None));
        }
        if let Some(code) = strip_authority(text) {
            return from_codes(code).map_err(Error::Configuration);
        }
        if wkt::looks_like_wkt(text) {
            return Self::with_vertical_from_wkt(text);
        }
        if looks_like_path(text) {
            return from_file(Path::new(text));
        }
        Err(Error::Configuration(format!("'{}' names no reference system; {EXAMPLES}", shortened(text))))
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

    /// From WKT 1 (OGC or Esri dialect) or WKT 2; of a compound system the horizontal part.
    pub fn from_wkt(text: &str) -> Result<Self> {
        Ok(Self::with_vertical_from_wkt(text)?.0)
    }

    /// As [`Crs::from_wkt`], with the system of the heights where the text names one.
    pub fn with_vertical_from_wkt(text: &str) -> Result<(Self, Option<VerticalCrs>)> {
        wkt::read(text).map_err(Error::Configuration)
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

fn looks_like_proj(text: &str) -> bool {
    text.starts_with('+') || text.starts_with("proj=") || text.starts_with("init=")
}

fn from_proj_or_init(text: &str) -> Result<Crs> {
    let init = Definition::parse(text).map_err(Error::Configuration)?.get("init").map(str::to_owned);
    match init.as_deref().map(strip_authority) {
        None => Crs::from_proj(text, text),
        Some(Some(code)) => Ok(from_codes(code).map_err(Error::Configuration)?.0),
        Some(None) => {
            Err(Error::Configuration(format!("'{}' is not +init=epsg:CODE; {EXAMPLES}", shortened(text))))
        }
    }
}

/// `32633` of `EPSG:32633`, `epsg:32633`, `ESRI:102100`, `urn:ogc:def:crs:EPSG::32633`, `32633`.
fn strip_authority(text: &str) -> Option<&str> {
    let lower = text.to_ascii_lowercase();
    let prefixes = ["urn:ogc:def:crs:epsg::", "http://www.opengis.net/def/crs/epsg/0/", "epsg:", "esri:"];
    let skip = prefixes.iter().find(|prefix| lower.starts_with(**prefix)).map_or(0, |prefix| prefix.len());
    let rest = text.get(skip..)?.trim();
    let code = skip > 0 || rest.starts_with(|c: char| c.is_ascii_digit()) && !rest.contains(['/', '.', '\\']);
    code.then_some(rest)
}

/// `32633` or `4326+5773`.
fn from_codes(text: &str) -> Result<(Crs, Option<VerticalCrs>), String> {
    let code = |part: &str| {
        part.trim().parse::<u32>().map_err(|_| format!("'{}' is no EPSG code; {EXAMPLES}", shortened(text)))
    };
    let (horizontal, vertical) = match text.split_once('+') {
        Some((horizontal, vertical)) => (code(horizontal)?, Some(code(vertical)?)),
        None => (code(text)?, None),
    };
    let vertical = match vertical {
        None => epsg::vertical_part(horizontal),
        Some(code) => Some(epsg::vertical(code).ok_or_else(|| {
            format!("EPSG:{code} is not known here as a system of heights; say what the heights are measured from with --src-vdatum")
        })?),
    };
    Ok((Crs::by_code(horizontal)?, vertical))
}

fn looks_like_path(text: &str) -> bool {
    let path = Path::new(text);
    let extension =
        path.extension().and_then(|extension| extension.to_str()).unwrap_or("").to_ascii_lowercase();
    matches!(extension.as_str(), "prj" | "wkt" | "proj" | "txt") || path.is_file()
}

fn from_file(path: &Path) -> Result<(Crs, Option<VerticalCrs>)> {
    let length = fs::metadata(path).map_err(|error| Error::io(path, "read", error))?.len();
    if length > LONGEST_FILE {
        return Err(Error::invalid(
            path,
            format!("{length} bytes are too many for a reference system; {EXAMPLES}"),
        ));
    }
    let bytes = fs::read(path).map_err(|error| Error::io(path, "read", error))?;
    let text = String::from_utf8_lossy(&bytes);
    let text = text.trim_start_matches('\u{feff}').trim();
    let read = if looks_like_proj(text) {
        from_proj_or_init(text).map(|crs| (crs, None)).map_err(|error| error.to_string())
    } else if let Some(code) = strip_authority(text) {
        from_codes(code)
    } else {
        wkt::read(text)
    };
    read.map_err(|reason| Error::invalid(path, reason))
}

/// The first part of a text that may be of any length.
pub(super) fn shortened(text: &str) -> String {
    const LONGEST: usize = 80;
    let plain: String = text.chars().take(LONGEST).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(LONGEST).is_some() { format!("{plain}…") } else { plain }
}
