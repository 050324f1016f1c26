//! Reference systems by code and by name, from tables of the EPSG and Esri registries.
//!
//! The tables beside this file are made by `tools/crs/tables.py` from the registries as PROJ's package has them; nobody
//! edits them. A code is one number, whichever registry gave it: the two have one number in common, and EPSG keeps it.
//!
//! ```text
//! compound.tsv   → a horizontal and a vertical system
//! projected.tsv  → a projection on a geographic system
//! geographic.tsv → ellipsoid, prime meridian, unit, shifts to WGS 84
//! vertical.tsv   → unit and direction of heights
//! units.tsv      → metres or degrees of a unit
//! datums.tsv     → a geographic system by the name of its datum
//! systems.tsv    → shifts by the name of a system, where they are not those that its datum has by name
//! ```

mod table;

use super::shift::{Degrees, Shifts, contains};
use table::{Row, Table};

static GEOGRAPHIC: Table = Table::new(include_str!("geographic.tsv"));
static PROJECTED: Table = Table::new(include_str!("projected.tsv"));
static VERTICAL: Table = Table::new(include_str!("vertical.tsv"));
static UNITS: Table = Table::new(include_str!("units.tsv"));
static COMPOUND: Table = Table::new(include_str!("compound.tsv"));
static DATUMS: &str = include_str!("datums.tsv");
static SYSTEMS: &str = include_str!("systems.tsv");

/// A code with the name of its system, as messages show it: `EPSG:27700 (OSGB36 / British National Grid)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Entry {
    pub code: u32,
    /// Given by Esri, not by EPSG.
    pub is_esri: bool,
    pub name: &'static str,
}

/// A geographic system: what all systems on its datum share.
#[derive(Debug, Clone, Copy)]
pub(super) struct Geographic {
    pub entry: Entry,
    pub dimensions: Dimensions,
    /// PROJ's terms, `+ellps=airy` say.
    pub ellipsoid: &'static str,
    /// Longitude of the prime meridian, degrees east of Greenwich.
    pub meridian: &'static str,
    /// Degrees per unit of its coordinates.
    pub degrees_per_unit: f64,
    shifts: &'static str,
    grids: &'static str,
    /// Order of its shifts where a text names it without a code, if that is another.
    pub text_order: Option<&'static str>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dimensions {
    Two,
    /// Three dimensions, with heights above the ellipsoid.
    Three,
    Geocentric,
}

/// A projected system.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projected {
    pub entry: Entry,
    /// Code of the geographic system that it projects, where that is known.
    pub geographic: Option<u32>,
    /// PROJ's terms without those of the datum, or the name of the method that is not served.
    pub terms: Result<&'static str, &'static str>,
    /// Order of its shifts, where it is not that of the geographic system.
    pub order: Option<&'static str>,
}

/// A vertical system.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vertical {
    pub entry: Entry,
    /// Metres per unit.
    pub metres_per_unit: f64,
    /// Counts downward.
    pub is_depth: bool,
}

/// A compound system.
#[derive(Debug, Clone, Copy)]
pub(super) struct Compound {
    pub entry: Entry,
    pub horizontal: u32,
    pub vertical: u32,
}

/// A grid that would place more exactly than the shifts that are at hand.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    /// Greatest error of a place, metres.
    pub accuracy: f64,
    area: Degrees,
    /// File names of PROJ.
    pub names: &'static str,
}

/// Looks up a geographic or geocentric system.
pub(super) fn geographic(code: u32) -> Option<Geographic> {
    let row = GEOGRAPHIC.find(code)?;
    let dimensions = match row.field(1) {
        "2" => Dimensions::Two,
        "3" => Dimensions::Three,
        _ => Dimensions::Geocentric,
    };
    Some(Geographic {
        entry: entry(row, 2),
        dimensions,
        ellipsoid: row.field(4),
        meridian: row.field(5),
        degrees_per_unit: row.number(6)?,
        shifts: row.field(7),
        grids: row.field(8),
        text_order: Some(row.field(9)).filter(|order| !order.is_empty()),
    })
}

/// Looks up the geographic system of a datum's code.
pub(super) fn geographic_of_datum(code: u32) -> Option<Geographic> {
    let text = code.to_string();
    let row = GEOGRAPHIC.rows().find(|row| row.field(3) == text && row.field(1) == "2")?;
    geographic(row.code())
}

/// Looks up a geographic system by the name of its datum (or its own), in letters and digits alone.
pub(super) fn geographic_of_name(plain: &str) -> Option<Geographic> {
    let line = DATUMS.lines().find(|line| line.split('\t').next() == Some(plain))?;
    geographic(line.split('\t').nth(1)?.parse().ok()?)
}

/// Looks up what a system on the datum of `on` is known for by its own name, in letters and digits alone, and by its inverse flattening: the
/// geographic system whose shifts it has, and their order; `None` if they are those that the datum has.
pub(super) fn named_system(
    plain: &str,
    on: &Geographic,
    flattening: f64,
) -> Option<(Geographic, Option<&'static str>)> {
    /// Relative difference of flattenings that are the same, in fewer digits.
    const ROUNDED: f64 = 1e-9;
    let datum = on.entry.code.to_string();
    let is_it = |row: &Vec<&str>| {
        let own = row.get(2).and_then(|number| number.parse::<f64>().ok());
        row.starts_with(&[plain, &datum])
            && own.is_some_and(|own| (own - flattening).abs() <= ROUNDED * own.abs())
    };
    let row = SYSTEMS.lines().map(|line| line.split('\t').collect::<Vec<_>>()).find(is_it)?;
    let order = row.get(4).copied().filter(|order| !order.is_empty());
    Some((geographic(row.get(3)?.parse().ok()?)?, order))
}

/// Looks up a projected system.
pub(super) fn projected(code: u32) -> Option<Projected> {
    let row = PROJECTED.find(code)?;
    let terms = row.field(3);
    let terms = terms.strip_prefix('!').map_or(Ok(terms), Err);
    let order = Some(row.field(4)).filter(|order| !order.is_empty());
    Some(Projected { entry: entry(row, 1), geographic: row.field(2).parse().ok(), terms, order })
}

/// Looks up a vertical system.
pub(super) fn vertical(code: u32) -> Option<Vertical> {
    let row = VERTICAL.find(code)?;
    Some(Vertical { entry: entry(row, 1), metres_per_unit: row.number(2)?, is_depth: row.field(3) == "d" })
}

/// Looks up the metres of a unit of length.
pub(super) fn metres_per_unit(code: u32) -> Option<f64> {
    UNITS.find(code).filter(|row| row.field(1) == "l")?.number(3)
}

/// Looks up the degrees of a unit of angles.
pub(super) fn degrees_per_unit(code: u32) -> Option<f64> {
    UNITS.find(code).filter(|row| row.field(1) == "a")?.number(3)
}

/// Looks up a compound system.
pub(super) fn compound(code: u32) -> Option<Compound> {
    let row = COMPOUND.find(code)?;
    let part = |index| row.field(index).parse().ok();
    Some(Compound { entry: entry(row, 1), horizontal: part(2)?, vertical: part(3)? })
}

fn entry(row: Row, name: usize) -> Entry {
    Entry { code: row.code(), is_esri: row.is_esri(), name: row.field(name) }
}

impl Geographic {
    /// Shifts of the datum to WGS 84 that need no grid, as a map of the system takes them by its `order`.
    pub(super) fn shifts_of(&self, order: Option<&str>) -> Shifts {
        Shifts::read(self.own_or_shared().0, order).unwrap_or_default()
    }

    /// The datum lies to WGS 84 by an offset of degrees that no shift of seven parameters comes near.
    pub(super) fn is_offset_by_degrees(&self) -> bool {
        self.shifts == "!"
    }

    /// The most exact grid for a place (degrees), or for any.
    pub(super) fn grid(&self, place: Option<(f64, f64)>) -> Option<Grid> {
        let holds = |grid: &Grid| place.is_none_or(|(x, y)| contains(grid.area, x, y));
        self.own_or_shared().1.split(';').filter_map(read_grid).find(holds)
    }

    /// Fields of shifts and grids, which may be those of another system on the same datum.
    fn own_or_shared(&self) -> (&'static str, &'static str) {
        let shared = self.shifts.strip_prefix('=').and_then(|code| GEOGRAPHIC.find(code.parse().ok()?));
        shared.map_or((self.shifts, self.grids), |row| (row.field(7), row.field(8)))
    }
}

fn read_grid(entry: &'static str) -> Option<Grid> {
    let mut parts = entry.splitn(6, ',');
    let mut number = || parts.next()?.parse::<f64>().ok();
    let accuracy = number()?;
    let area = [number()?, number()?, number()?, number()?];
    Some(Grid { accuracy, area, names: parts.next()? })
}

impl Entry {
    /// `EPSG` or `ESRI`.
    pub(super) fn authority(self) -> &'static str {
        if self.is_esri { "ESRI" } else { "EPSG" }
    }
}

impl std::fmt::Display for Entry {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}:{} ({})", self.authority(), self.code, self.name)
    }
}
