//! Meaning of a table's columns, from their names.
//!
//! A name is a quantity, then perhaps qualifiers (a datum, `true`) and a unit, in any case and with any separators:
//! `alt_msl_m`, `Altitude ASL (ft)`, `true_heading_deg`. A unit that is known but not read here is an error, never a
//! guess; a name that says nothing known is ignored, and a note says so.

use csv::StringRecord;

use super::super::raw::PathSource;
use super::super::track::AltitudeMode;
use super::camera::CameraColumns;
use hedgehop_base::error::{Error, Result};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Time,
    Longitude,
    Latitude,
    X,
    Y,
    /// Altitude, with the mode that the name states.
    Altitude(Option<AltitudeMode>),
    Yaw,
    Pitch,
    Roll,
    Hfov,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Dimension {
    Time,
    Angle,
    Length,
}

impl Quantity {
    fn dimension(self) -> Dimension {
        match self {
            Self::Time => Dimension::Time,
            Self::X | Self::Y | Self::Altitude(_) => Dimension::Length,
            _ => Dimension::Angle,
        }
    }

    /// Lists spellings of such a column, for messages.
    fn spellings(self) -> &'static str {
        match self {
            Self::Time => "t, time_s, unix_time_s, time_ms, or time with ISO 8601 dates",
            Self::Longitude => "lon, lon_deg, longitude, longitude_rad",
            Self::Latitude => "lat, lat_deg, latitude, latitude_rad",
            Self::X => "x, x_m, easting_m",
            Self::Y => "y, y_m, northing_m",
            Self::Altitude(_) => "alt_msl_m, alt_agl_m, alt_ellipsoid_m (also _ft), or alt_m with --alt-mode",
            Self::Yaw => "yaw_deg, heading_deg, true_heading_deg (also _rad)",
            Self::Pitch => "pitch_deg, pitch_rad",
            Self::Roll => "roll_deg, bank_deg (also _rad)",
            Self::Hfov => "hfov_deg, hfov_rad",
        }
    }
}

/// First words of a name and what they mean. Of several columns for one quantity the name that stands first here is read.
const QUANTITIES: [(&str, Quantity); 37] = [
    ("unix_time", Quantity::Time),
    ("sim_time", Quantity::Time),
    ("t", Quantity::Time),
    ("time", Quantity::Time),
    ("timestamp", Quantity::Time),
    ("datetime", Quantity::Time),
    ("date_time", Quantity::Time),
    ("utc", Quantity::Time),
    ("longitude", Quantity::Longitude),
    ("long_gc", Quantity::Longitude),
    ("long", Quantity::Longitude),
    ("lon", Quantity::Longitude),
    ("lng", Quantity::Longitude),
    ("latitude_geodetic", Quantity::Latitude),
    ("lat_geod", Quantity::Latitude),
    ("latitude", Quantity::Latitude),
    ("lat", Quantity::Latitude),
    ("x", Quantity::X),
    ("easting", Quantity::X),
    ("east", Quantity::X),
    ("y", Quantity::Y),
    ("northing", Quantity::Y),
    ("north", Quantity::Y),
    ("altitude", Quantity::Altitude(None)),
    ("alt", Quantity::Altitude(None)),
    ("elevation", Quantity::Altitude(None)),
    ("ele", Quantity::Altitude(None)),
    ("height", Quantity::Altitude(None)),
    ("z", Quantity::Altitude(None)),
    ("h", Quantity::Altitude(None)),
    ("yaw", Quantity::Yaw),
    ("true_heading", Quantity::Yaw),
    ("heading", Quantity::Yaw),
    ("pitch", Quantity::Pitch),
    ("roll", Quantity::Roll),
    ("bank", Quantity::Roll),
    ("hfov", Quantity::Hfov),
];

/// JSBSim's words for attitude; elsewhere phi is as often a latitude.
const JSBSIM_QUANTITIES: [(&str, Quantity); 4] = [
    ("psi", Quantity::Yaw),
    ("heading_true", Quantity::Yaw),
    ("theta", Quantity::Pitch),
    ("phi", Quantity::Roll),
];

const UNITS: [(&str, Dimension, f64); 31] = [
    ("s", Dimension::Time, 1.0),
    ("sec", Dimension::Time, 1.0),
    ("second", Dimension::Time, 1.0),
    ("seconds", Dimension::Time, 1.0),
    ("ms", Dimension::Time, 1e-3),
    ("milliseconds", Dimension::Time, 1e-3),
    ("us", Dimension::Time, 1e-6),
    ("ns", Dimension::Time, 1e-9),
    ("min", Dimension::Time, 60.0),
    ("minutes", Dimension::Time, 60.0),
    ("deg", Dimension::Angle, 1.0),
    ("degree", Dimension::Angle, 1.0),
    ("degrees", Dimension::Angle, 1.0),
    ("dege7", Dimension::Angle, 1e-7),
    ("e7", Dimension::Angle, 1e-7),
    ("rad", Dimension::Angle, 180.0 / std::f64::consts::PI),
    ("radian", Dimension::Angle, 180.0 / std::f64::consts::PI),
    ("radians", Dimension::Angle, 180.0 / std::f64::consts::PI),
    ("m", Dimension::Length, 1.0),
    ("metre", Dimension::Length, 1.0),
    ("metres", Dimension::Length, 1.0),
    ("meter", Dimension::Length, 1.0),
    ("meters", Dimension::Length, 1.0),
    ("mm", Dimension::Length, 1e-3),
    ("cm", Dimension::Length, 1e-2),
    ("km", Dimension::Length, 1e3),
    ("ft", Dimension::Length, 0.3048),
    ("foot", Dimension::Length, 0.3048),
    ("feet", Dimension::Length, 0.3048),
    ("nm", Dimension::Length, 1852.0),
    ("nmi", Dimension::Length, 1852.0),
];

/// Units that people write and that are not read: better an error than a guess.
const FOREIGN_UNITS: [&str; 13] = [
    "fl",
    "mi",
    "mile",
    "miles",
    "yd",
    "grad",
    "gon",
    "mil",
    "mils",
    "semicircles",
    "turns",
    "hours",
    "days",
];

/// Qualifiers that change nothing.
const NEUTRAL: [&str; 8] = ["wgs84", "wgs", "true", "utc", "iso", "iso8601", "gps", "gnss"];

#[derive(Debug, Clone)]
pub(super) struct CsvColumn {
    pub index: usize,
    pub name: String,
    pub quantity: Quantity,
    /// Cell × scale = seconds, degrees or metres.
    pub scale: f64,
    /// The name states no unit.
    pub plain: bool,
    /// Rank among several columns for one quantity, of which the lowest is read.
    rank: usize,
}

#[derive(Debug)]
pub(super) enum Position {
    LonLat(CsvColumn, CsvColumn),
    Xy(CsvColumn, CsvColumn),
}

/// The columns that are read.
#[derive(Debug)]
pub(super) struct CsvColumns {
    pub format: &'static str,
    pub time: CsvColumn,
    pub horizontal: Position,
    pub altitude: CsvColumn,
    pub yaw: Option<CsvColumn>,
    pub pitch: Option<CsvColumn>,
    pub roll: Option<CsvColumn>,
    pub hfov: Option<CsvColumn>,
    pub notes: Vec<String>,
}

enum Meaning {
    Column(CsvColumn),
    /// A quantity in a unit that is not read.
    Foreign(Quantity),
    Other,
}

impl CsvColumns {
    pub fn understand(source: &PathSource<'_>, line: u64, header: &StringRecord) -> Result<Self> {
        if header.iter().all(|cell| cell.is_empty() || cell.parse::<f64>().is_ok()) {
            return Err(source.at_line(
                line,
                "there is no header; the first row names the columns, e.g. time_s,lon_deg,lat_deg,alt_msl_m",
            ));
        }

        let jsbsim = is_jsbsim(header);
        let mut candidates = Vec::new();
        let mut ignored = Vec::new();
        for (index, name) in header.iter().enumerate() {
            match meaning(index, name, jsbsim) {
                Meaning::Column(column) => candidates.push(column),
                Meaning::Foreign(quantity) => {
                    return Err(source.at_line(
                        line,
                        format!("the unit of column {name:?} is not read; use {}", quantity.spellings()),
                    ));
                }
                Meaning::Other if CameraColumns::is_one(name) => {}
                Meaning::Other => ignored.push(name.to_owned()),
            }
        }

        let mut choice = Choice { source, line, candidates };
        let altitude = choice.altitude()?;
        let mut notes = Vec::new();
        if matches!(altitude.quantity, Quantity::Altitude(None)) && source.options.altitude_mode.is_none() {
            notes.push(format!(
                "Column {} is taken as altitude above mean sea level (--alt-mode says otherwise).",
                altitude.name
            ));
        }

        let columns = Self {
            format: if jsbsim { "JSBSim CSV" } else { "CSV" },
            time: choice.needed(Quantity::Time)?,
            horizontal: choice.horizontal(jsbsim)?,
            altitude,
            yaw: choice.take(Quantity::Yaw),
            pitch: choice.take(Quantity::Pitch),
            roll: choice.take(Quantity::Roll),
            hfov: choice.take(Quantity::Hfov),
            notes: Vec::new(),
        };

        ignored.extend(choice.candidates.into_iter().map(|column| column.name));
        notes.extend(ignored_note(&ignored));
        Ok(Self { notes, ..columns })
    }
}

/// Picks columns from the candidates.
struct Choice<'a> {
    source: &'a PathSource<'a>,
    line: u64,
    candidates: Vec<CsvColumn>,
}

impl Choice<'_> {
    fn take(&mut self, quantity: Quantity) -> Option<CsvColumn> {
        let best = (0..self.candidates.len())
            .filter(|&index| self.candidates[index].quantity == quantity)
            .min_by_key(|&index| self.candidates[index].rank)?;
        Some(self.candidates.remove(best))
    }

    fn needed(&mut self, quantity: Quantity) -> Result<CsvColumn> {
        self.take(quantity).ok_or_else(|| self.missing(quantity.spellings()))
    }

    fn missing(&self, spellings: &str) -> Error {
        self.source.at_line(self.line, format!("a column is missing: {spellings}"))
    }

    fn horizontal(&mut self, jsbsim: bool) -> Result<Position> {
        if let (Some(longitude), Some(latitude)) =
            (self.take(Quantity::Longitude), self.take(Quantity::Latitude))
        {
            return Ok(Position::LonLat(longitude, latitude));
        }
        if jsbsim {
            return Err(self.missing(
                "Latitude Geodetic (deg) and Longitude (deg); JSBSim's \"Latitude (deg)\" is geocentric, up to 21 km off",
            ));
        }
        match (self.take(Quantity::X), self.take(Quantity::Y)) {
            (Some(x), Some(y)) => Ok(Position::Xy(x, y)),
            _ => Err(self.missing("lon_deg and lat_deg, or x_m and y_m in the database's metres")),
        }
    }

    /// The mode that the user asked for, else sea level, ellipsoid, ground, unstated.
    fn altitude(&mut self) -> Result<CsvColumn> {
        let stated = [AltitudeMode::Msl, AltitudeMode::Ellipsoid, AltitudeMode::Agl].map(Some);
        let order = self.source.options.altitude_mode.map(Some).into_iter().chain(stated).chain([None]);
        for mode in order {
            if let Some(column) = self.take(Quantity::Altitude(mode)) {
                return Ok(column);
            }
        }
        Err(self.missing(Quantity::Altitude(None).spellings()))
    }
}

/// JSBSim's text output, or its property names.
fn is_jsbsim(header: &StringRecord) -> bool {
    let has = |name: &str| header.iter().any(|cell| cell.eq_ignore_ascii_case(name));
    header.iter().any(|cell| cell.starts_with("/fdm/jsbsim/"))
        || (has("Altitude ASL (ft)") && (has("Phi (deg)") || has("Latitude Geodetic (deg)")))
}

fn meaning(index: usize, name: &str, jsbsim: bool) -> Meaning {
    // In JSBSim's output this one is geocentric.
    if jsbsim && name.eq_ignore_ascii_case("Latitude (deg)") {
        return Meaning::Other;
    }
    let words = words_of(name, jsbsim);
    let table = JSBSIM_QUANTITIES.iter().filter(|_| jsbsim).chain(&QUANTITIES).enumerate();
    let best = table
        .filter_map(|(rank, &(base, quantity))| rest_after(&words, base).map(|rest| (rank, quantity, rest)))
        .min_by_key(|(_, _, rest)| rest.len());
    let Some((rank, quantity, rest)) = best else { return Meaning::Other };
    qualified(index, name, rank, quantity, rest)
}

/// Reads the words after the quantity: datum, unit, neutral words.
fn qualified(index: usize, name: &str, rank: usize, mut quantity: Quantity, rest: &[String]) -> Meaning {
    let mut scale = 1.0;
    let mut plain = true;
    let mut rank = 10 * rank;
    for word in rest {
        let word = word.as_str();
        if let Some(&(_, dimension, factor)) = UNITS.iter().find(|(unit, ..)| *unit == word) {
            if dimension != quantity.dimension() {
                return Meaning::Other;
            }
            (scale, plain) = (factor, false);
        } else if FOREIGN_UNITS.contains(&word) {
            return Meaning::Foreign(quantity);
        } else if let (Quantity::Altitude(None), Some(mode)) = (quantity, mode_of(word)) {
            quantity = Quantity::Altitude(Some(mode));
        } else if word == "local" {
            rank += 5; // a clock without offset: only if there is no better
        } else if !NEUTRAL.contains(&word) {
            return Meaning::Other;
        }
    }

    // Seconds are surer than dates.
    if quantity == Quantity::Time && plain {
        rank += 1000;
    }

    Meaning::Column(CsvColumn { index, name: name.to_owned(), quantity, scale, plain, rank })
}

fn mode_of(word: &str) -> Option<AltitudeMode> {
    match word {
        "msl" | "asl" | "amsl" | "sl" => Some(AltitudeMode::Msl),
        "agl" => Some(AltitudeMode::Agl),
        "ellipsoid" | "ellipsoidal" | "hae" => Some(AltitudeMode::Ellipsoid),
        _ => None,
    }
}

fn words_of(name: &str, jsbsim: bool) -> Vec<String> {
    let name = name.to_lowercase();
    let words = name.split(|letter: char| !letter.is_alphanumeric()).filter(|word| !word.is_empty());
    let folders = ["fdm", "jsbsim", "position", "attitude", "simulation"];
    let origins = ["gps", "gnss", "wgs84"];
    words
        .skip_while(|word| origins.contains(word) || (jsbsim && folders.contains(word)))
        .map(str::to_owned)
        .collect()
}

fn rest_after<'w>(words: &'w [String], base: &str) -> Option<&'w [String]> {
    let mut count = 0;
    for part in base.split('_') {
        if words.get(count).is_none_or(|word| word != part) {
            return None;
        }
        count += 1;
    }
    words.get(count..)
}

fn ignored_note(names: &[String]) -> Option<String> {
    const SHOWN: usize = 8;
    if names.is_empty() {
        return None;
    }
    let more = names.len().saturating_sub(SHOWN);
    let shown = names.iter().take(SHOWN).map(String::as_str).collect::<Vec<_>>().join(", ");
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    Some(format!("Columns that are not read: {shown}{more}."))
}
