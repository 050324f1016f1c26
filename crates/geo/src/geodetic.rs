//! The datum of a system: ellipsoid, prime meridian, and how it lies to WGS 84.

use super::projection::CONVERT;
use super::registry::{self, Dimensions, Geographic};
use super::shift::{Shift, Shifts};
use super::wkt_names::plain;

/// Accuracy from which on it is worth a word, metres.
const WORTH_A_NOTE: f64 = 3.0;

/// A datum, from a registry or from a file's own words.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Geodetic {
    /// PROJ's terms of ellipsoid and prime meridian.
    pub terms: String,
    /// Shifts to WGS 84; empty where none is known.
    pub shifts: Shifts,
    /// A sentence about how well places are known.
    pub doubt: Option<String>,
}

impl Geodetic {
    /// The datum of a geographic system of the registries.
    pub(super) fn registered(system: &Geographic) -> Result<Self, String> {
        Self::of_map(system, None)
    }

    /// The same as a map of the system takes it, by the order of its shifts.
    pub(super) fn of_map(system: &Geographic, order: Option<&str>) -> Result<Self, String> {
        let meridian = match system.meridian {
            "0" => String::new(),
            degrees => format!(" +pm={degrees}"),
        };
        let terms = format!("{}{meridian}", system.ellipsoid);
        let mut shifts = system.shifts_of(order);
        if is_modern(&terms) {
            shifts.take_unknown_for("0,0,0");
        }

        let mut geodetic = Self { terms, shifts, doubt: None };
        on_earth(&geodetic.terms, &system.entry.to_string())?;
        if system.is_offset_by_degrees() {
            return Err(format!(
                "{} lies to WGS 84 by an offset of degrees, which is not served; {CONVERT}",
                system.entry
            ));
        }

        if geodetic.shifts.list().is_empty() {
            // Realisations of NAD83 lie within two metres of each other and of WGS 84.
            let is_near = system.entry.name.starts_with("NAD83") && is_modern(&geodetic.terms);
            if let Some(grid) = system.grid(None).filter(|_| !is_near) {
                return Err(format!(
                    "{} lies to WGS 84 as the grid {} says, which is not at hand; {CONVERT}",
                    system.entry, grid.names
                ));
            }
        }

        if geodetic.shifts.list().iter().all(Shift::is_unknown) {
            geodetic.assume(system.entry.name);
        }
        geodetic.doubt = geodetic.doubt.or_else(|| inexact(system, &geodetic.shifts));

        Ok(geodetic)
    }

    /// A datum by its name in a text, if it is known.
    pub(super) fn named(name: &str) -> Option<Geographic> {
        let name = plain(name.strip_prefix("D_").unwrap_or(name));
        registry::geographic_of_name(&name)
    }

    /// A datum by ellipsoid and meridian alone, with the shift that is stated beside them.
    pub(super) fn stated(terms: String, towgs84: Option<&str>, name: &str) -> Result<Self, String> {
        on_earth(&terms, name)?;
        let shifts = towgs84.map(Shifts::everywhere).unwrap_or_default();
        let mut geodetic = Self { terms, shifts, doubt: None };
        if towgs84.is_none() {
            geodetic.assume(name);
        }
        Ok(geodetic)
    }

    /// Takes the datum for WGS 84, as it must be where nothing says how it lies to it: without a word on its
    /// ellipsoid, since no datum of satellites is a metre or two off; with one on others.
    fn assume(&mut self, name: &str) {
        if is_modern(&self.terms) {
            self.shifts = Shifts::everywhere("0,0,0");
            return;
        }
        self.doubt = Some(format!(
            "how '{name}' lies to WGS 84 is not known here: its places are taken as those of WGS 84, and may be \
             hundreds of metres off beside other data (give the shift with +towgs84=dx,dy,dz in a PROJ definition)"
        ));
    }

    /// PROJ's terms with one shift, or with none.
    pub(super) fn terms_with(&self, towgs84: Option<&str>) -> String {
        match towgs84 {
            // Of WGS 84 itself it goes without saying.
            Some("0,0,0") if self.terms.contains("+datum=") => self.terms.clone(),
            Some(shift) => format!("{} +towgs84={shift}", self.terms.replace("+datum=NAD83", "+ellps=GRS80")),
            None => self.terms.clone(),
        }
    }
}

/// A sentence on shifts that are only good to some metres.
fn inexact(system: &Geographic, shifts: &Shifts) -> Option<String> {
    let worst = shifts.list().iter().filter_map(|shift| shift.accuracy).fold(0.0, f64::max);
    let best = shifts.list().iter().filter_map(|shift| shift.accuracy).fold(f64::INFINITY, f64::min);
    if worst < WORTH_A_NOTE {
        return None;
    }
    let good = if best == worst { format!("{best}") } else { format!("{best} to {worst}") };
    let grid = system.grid(None).filter(|grid| grid.accuracy < best);
    let better = grid.map_or_else(String::new, |grid| {
        format!("; PROJ's grid {} would place them to {} m", grid.names, grid.accuracy)
    });
    Some(format!("places of {} are good to {good} m, as its shift to WGS 84 is{better}", system.entry.name))
}

/// Degrees, refused where the system counts in another unit.
pub(super) fn in_degrees(system: &Geographic) -> Result<(), String> {
    match system.dimensions {
        Dimensions::Geocentric => {
            Err(format!("{} has geocentric coordinates, which are no map; {CONVERT}", system.entry))
        }
        _ if system.degrees_per_unit != 1.0 => Err(format!(
            "{} counts in units of {} degrees, and only degrees are read; {CONVERT}",
            system.entry, system.degrees_per_unit
        )),
        _ => Ok(()),
    }
}

/// Semi-major axes that can be the Earth's, metres.
const EARTH: std::ops::RangeInclusive<f64> = 6.33e6..=6.42e6;

/// Refuses ellipsoids of other bodies.
pub(super) fn on_earth(terms: &str, name: &str) -> Result<(), String> {
    let axis = |key: &str| {
        let word = terms.split_whitespace().find_map(|word| word.strip_prefix(key));
        word.and_then(|value| value.parse::<f64>().ok())
    };
    match axis("+a=").or_else(|| axis("+R=")) {
        Some(axis) if axis.is_finite() && axis > 0.0 && !EARTH.contains(&axis) => Err(format!(
            "'{name}' is of a body with a radius of {axis} m, which is not the Earth; bring the data to metres of that \
             body (gdalwarp -t_srs '+proj=eqc +R={axis}' IN OUT.tif) and take them as plain metres with --local"
        )),
        _ => Ok(()),
    }
}

/// Whether the ellipsoid is that of WGS 84 or GRS 80, which differ by 0.1 mm.
fn is_modern(terms: &str) -> bool {
    terms.split_whitespace().any(|word| {
        matches!(
            word,
            "+datum=WGS84" | "+ellps=WGS84" | "+ellps=GRS80" | "+rf=298.257222101" | "+rf=298.257223563"
        )
    }) && !terms.contains("+pm=")
        && terms.split_whitespace().all(|word| word.strip_prefix("+a=").is_none_or(|a| a == "6378137"))
}
