//! Horizontal reference systems.
//!
//! Every way to name a system (code, WKT, GeoTIFF keys, PROJ string) ends in a PROJ definition, which is what the
//! projections are computed from and what a database records, and in the shifts of its datum to WGS 84. What people
//! type is read in `user`, WKT in `wkt_system`, GeoTIFF keys in `geokeys`; the registries of codes are in `registry`.

use super::choice;
use super::definition::Definition;
use super::geodetic::{Geodetic, in_degrees};
use super::projection::CONVERT;
use super::registry::{self, Dimensions, Entry, Geographic};
use super::shift::{Shift, Shifts};
use hedgehop_base::error::{Error, Result};

/// A horizontal coordinate reference system. Coordinates are (east or longitude, north or latitude), whatever order
/// the authority gives, in metres, or degrees if geographic, or what [`Crs::metres_per_unit`] says. Grids that count
/// to the west and south keep that: [`Crs::is_metric`] is false of them.
#[derive(Debug, Clone)]
pub struct Crs {
    pub(super) name: String,
    epsg: Option<u32>,
    /// `None` for local metres.
    definition: Option<LoadedDefinition>,
    /// Shifts of the datum, if there is more than one; the definition has that of places without one of their own.
    shifts: Shifts,
    pub(super) doubt: Option<String>,
}

impl PartialEq for Crs {
    fn eq(&self, other: &Self) -> bool {
        (&self.name, self.epsg, &self.definition) == (&other.name, other.epsg, &other.definition)
    }
}

/// A definition that can be loaded, read once, and its text.
#[derive(Debug, Clone, PartialEq)]
struct LoadedDefinition {
    terms: Definition,
    text: String,
}

impl From<Definition> for LoadedDefinition {
    fn from(terms: Definition) -> Self {
        Self { text: terms.to_string(), terms }
    }
}

impl Crs {
    /// Plain metres without a place on Earth.
    pub fn local() -> Self {
        Self::unplaced("local")
    }

    fn unplaced(name: &str) -> Self {
        Self { name: name.into(), epsg: None, definition: None, shifts: Shifts::default(), doubt: None }
    }

    /// Finds the system of a code of EPSG or Esri; of a compound system the horizontal part.
    pub fn from_epsg(code: u32) -> Result<Self> {
        Self::by_code(code).map_err(Error::Configuration)
    }

    pub(super) fn by_code(code: u32) -> Result<Self, String> {
        let compound = registry::compound(code);
        let horizontal = compound.map_or(code, |compound| compound.horizontal);
        let (definition, geodetic, entry) = if let Some(projected) = registry::projected(horizontal) {
            let terms = projected.terms.map_err(|method| {
                format!("{} is projected by '{method}', which is not read; {CONVERT}", projected.entry)
            })?;
            let base = projected.geographic.and_then(registry::geographic);
            let base = base.ok_or_else(|| {
                format!(
                    "{} is built on a geographic system that is not known here; {CONVERT}",
                    projected.entry
                )
            })?;
            (format!("+proj={terms}"), Geodetic::of_map(&base, projected.order)?, projected.entry)
        } else if let Some(geographic) = registry::geographic(horizontal) {
            in_degrees(&geographic)?;
            ("+proj=longlat".to_owned(), Geodetic::registered(&geographic)?, geographic.entry)
        } else {
            return Err(unknown(code));
        };

        let entry = compound.map_or(entry, |compound| compound.entry);
        let mut crs = Self::of(&definition, &geodetic, entry.name)
            .map_err(|reason| format!("{entry} cannot be used: {reason}"))?;
        crs.epsg = (!entry.is_esri).then_some(entry.code);
        if entry.is_esri {
            crs.name = entry.to_string();
        }

        Ok(crs)
    }

    /// A projection (`+proj=…` and its terms) on a datum.
    pub(super) fn of(projection: &str, geodetic: &Geodetic, name: &str) -> Result<Self, String> {
        let shift = geodetic.shifts.elsewhere().and_then(|shift| shift.towgs84.as_deref());
        let definition = Definition::loadable(&format!("{projection} {}", geodetic.terms_with(shift)))?;
        let list = geodetic.shifts.list();
        let is_one = list.iter().all(|other| other.towgs84.as_deref() == shift);
        Ok(Self {
            name: shortened(name),
            epsg: None,
            definition: Some(definition.into()),
            shifts: match geodetic.shifts.clone() {
                _ if is_one => Shifts::default(),
                shifts => shifts,
            },
            doubt: geodetic.doubt.clone(),
        })
    }

    /// Degrees or a UTM zone (below 0: south of the equator) on the datum of an EPSG datum's code.
    ///
    /// # Errors
    /// A sentence without a place, if the datum is not known here.
    pub fn on_datum(datum: u32, zone: Option<i64>) -> Result<Self, String> {
        let system = registry::geographic_of_datum(datum);
        let system = system.ok_or_else(|| format!("the datum EPSG:{datum} is not known here"))?;
        Self::utm_or_degrees(&system, zone)
    }

    /// The same by the datum's name.
    ///
    /// # Errors
    /// A sentence without a place, if the datum is not known here.
    pub fn on_named_datum(datum: &str, zone: Option<i64>) -> Result<Self, String> {
        let system = Geodetic::named(datum);
        let system = system.ok_or_else(|| format!("the datum '{}' is not known here", shortened(datum)))?;
        Self::utm_or_degrees(&system, zone)
    }

    fn utm_or_degrees(system: &Geographic, zone: Option<i64>) -> Result<Self, String> {
        in_degrees(system)?;
        let geodetic = Geodetic::registered(system)?;
        let half = zone.map_or("", |zone| if zone < 0 { " +south" } else { "" });
        let Some(zone) = zone.map(i64::unsigned_abs) else {
            return Self::by_code(system.entry.code);
        };
        let name =
            format!("{} / UTM zone {zone}{}", system.entry.name, if half.is_empty() { "N" } else { "S" });
        let crs = Self::of(&format!("+proj=utm +zone={zone}{half}"), &geodetic, &name)?;
        // Of WGS 84 all zones have codes, by which databases are known.
        let first = if half.is_empty() { 32_600 } else { 32_700 };
        let code = u32::try_from(zone).ok().map(|zone| first + zone).filter(|_| system.entry.code == 4326);
        Ok(Self { epsg: code, ..crs })
    }

    /// Builds the system of a PROJ definition, with a name for people.
    pub fn from_proj(definition: &str, name: &str) -> Result<Self> {
        Self::by_definition(definition, name).map_err(Error::Configuration)
    }

    pub(super) fn by_definition(definition: &str, name: &str) -> Result<Self, String> {
        let stated = Definition::parse(definition)?;
        let definition = Definition::loadable(definition)?;
        let mut crs = Self { definition: Some(definition.into()), ..Self::unplaced(name) };

        // PROJ's names of datums that lie otherwise from place to place.
        let code = match stated.get("datum").map(str::to_ascii_uppercase).as_deref() {
            Some("NAD27") => Some(4267),
            Some("NAD83") => Some(4269),
            _ => None,
        };
        let is_given = stated.get("towgs84").or(stated.get("nadgrids")).is_some();
        if let Some(system) = code.filter(|_| !is_given).and_then(registry::geographic) {
            let geodetic = Geodetic::registered(&system)?;
            crs.shifts = geodetic.shifts;
            crs.doubt = geodetic.doubt;
        }
        Ok(crs)
    }

    /// Builds the system that a database header states (name, EPSG code, PROJ definition). The definition decides; without
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
        let definition = Some(Definition::wgs84_degrees().into());
        Self { epsg: Some(4326), definition, ..Self::unplaced("WGS 84") }
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

    /// The same system with the one shift of its datum that holds at a place (longitude, latitude in degrees), as
    /// a database records it: near and far parts of it must not lie apart.
    pub fn settled(&self, longitude: f64, latitude: f64) -> Self {
        let mut settled = Self { shifts: Shifts::default(), ..self.clone() };
        if let (Some(definition), Some(shift)) = (self.definition(), self.shifts.at(longitude, latitude)) {
            settled.definition = Some(definition.with_shift(shift.towgs84.as_deref()).into());
        }
        settled
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
        self.definition.as_ref().map(|definition| definition.text.as_str())
    }

    /// Coordinates are degrees.
    pub fn is_geographic(&self) -> bool {
        self.definition().is_some_and(Definition::is_geographic)
    }

    /// Plain metres without a place on Earth.
    pub fn is_local(&self) -> bool {
        self.definition.is_none()
    }

    /// Metres per unit of the coordinates, above 0: 1 for metres and local systems; `None` for degrees.
    pub fn metres_per_unit(&self) -> Option<f64> {
        match self.definition() {
            None => Some(1.0),
            Some(definition) if definition.is_geographic() => None,
            Some(definition) => definition.load().ok().map(|proj| proj.to_meter()),
        }
    }

    /// Coordinates are metres to the east and to the north, as a database needs them.
    pub fn is_metric(&self) -> bool {
        let is_turned = self.definition().is_some_and(|definition| definition.get("axis").is_some());
        self.metres_per_unit() == Some(1.0) && !is_turned
    }

    /// Whether both put every place at the same coordinates, by whatever name. Datums that agree with WGS 84
    /// within a metre or two and have no shift to it (ETRS89, SIRGAS 2000) count as WGS 84.
    pub fn is_equivalent(&self, other: &Self) -> bool {
        let (Some(one), Some(two)) = (self.definition(), other.definition()) else {
            return self.is_local() && other.is_local();
        };
        one.is_equivalent(two) || self.is_same(other)
    }

    /// Whether positions pass unchanged from one to the other, to the last metre: a datum that counts as WGS 84, but
    /// lies otherwise in some places, as NAD83 does in Hawaii, is not the same.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        let (Some(one), Some(two)) = (self.definition(), other.definition()) else {
            return self.is_local() && other.is_local();
        };
        // A map takes those shifts of a datum alone that hold in its area.
        let is_one_datum = one.get("datum") == Some("NAD83") && two.get("datum") == Some("NAD83");
        if self.shifts == other.shifts || is_one_datum {
            return one.is_equivalent(two);
        }
        // One of them is settled, or both: the same system all the same, or one that has a shift of the other.
        let is_named_alike = self.epsg.is_some() && self.epsg == other.epsg
            || self.epsg.or(other.epsg).is_none() && self.name == other.name;
        let has = |crs: &Self, shift: Option<&str>| {
            let is_of =
                |own: &Shift| shift.is_some_and(|shift| shift != "0,0,0") && own.towgs84.as_deref() == shift;
            crs.shifts.list().iter().any(is_of)
        };
        let is_shared = has(self, two.get("towgs84")) || has(other, one.get("towgs84"));
        (is_named_alike || is_shared) && one.with_shift(None).is_equivalent(&two.with_shift(None))
    }

    pub(super) fn definition(&self) -> Option<&Definition> {
        self.definition.as_ref().map(|definition| &definition.terms)
    }

    /// Whether its datum has the same shift to WGS 84 everywhere.
    #[cfg(test)]
    pub(super) fn has_one_shift(&self) -> bool {
        self.shifts.list().is_empty()
    }

    /// Shifts of the datum from place to place; empty where one holds everywhere.
    pub(super) fn shifts(&self) -> &Shifts {
        &self.shifts
    }

    pub(super) fn named(mut self, name: &str) -> Self {
        if !name.trim().is_empty() {
            self.name = shortened(name.trim());
        }
        self
    }
}

/// Why a code has no horizontal system.
fn unknown(code: u32) -> String {
    if let Some(vertical) = registry::vertical(code) {
        return format!(
            "{} measures only heights; give the horizontal system, and the heights beside it (EPSG:32633+{code}) or as --src-vdatum",
            vertical.entry
        );
    }
    format!(
        "EPSG:{code} is not known here; give the system as a PROJ string instead, for example --crs '+proj=utm +zone=33 +datum=WGS84' (epsg.io shows one for each code)"
    )
}

/// The registry's entry of a code, whatever it is.
pub(super) fn entry(code: u32) -> Option<Entry> {
    let compound = registry::compound(code).map(|compound| compound.entry);
    let projected = || registry::projected(code).map(|projected| projected.entry);
    let geographic = || registry::geographic(code).map(|geographic| geographic.entry);
    compound.or_else(projected).or_else(geographic)
}

/// Whether a code is a geographic system with heights above the ellipsoid.
pub(super) fn is_three_dimensional(code: u32) -> bool {
    registry::geographic(code).is_some_and(|system| system.dimensions == Dimensions::Three)
}

/// The first part of a text that may be of any length.
pub(super) fn shortened(text: &str) -> String {
    const LONGEST: usize = 80;
    let plain: String = text.chars().take(LONGEST).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(LONGEST).is_some() { format!("{plain}…") } else { plain }
}
