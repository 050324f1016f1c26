//! PROJ definitions (`+proj=utm +zone=33 +datum=WGS84`): reading, making loadable, comparing.
//!
//! PROJ strings are the common tongue in which EPSG codes, WKT and GeoTIFF keys meet. Three things
//! are done to each before [`proj4rs`] sees it:
//!
//! - Grid shifts are replaced, because no grid is shipped and a missing grid would otherwise count as
//!   no shift at all: NAD27 takes the mean shift of the conterminous United States (about 10 m), a
//!   definition that has `+towgs84` beside its grid takes that, any other grid is refused.
//! - Web Mercator, whose sphere is only a trick of notation, becomes `+proj=webmerc +datum=WGS84`.
//! - What does not concern horizontal positions (`+vunits`, `+geoidgrids`, `+type`, …) is dropped.

use std::collections::BTreeMap;
use std::fmt;

use proj4rs::Proj;

use super::geodetic::on_earth;
use super::projection::CONVERT;

/// Longest definition that is read, in bytes; real ones stay below 300.
const LONGEST: usize = 2000;

/// Mean shift from NAD27 to WGS 84 in the conterminous United States, metres (EPSG transformation 1173).
const NAD27_TO_WGS84: &str = "-8,160,176";

/// Keys that say nothing about horizontal positions.
const IRRELEVANT: [&str; 9] =
    ["no_defs", "type", "wktext", "vunits", "vto_meter", "geoidgrids", "geoid_crs", "lon_wrap", "title"];

/// Keys that say what the datum is.
const GEODETIC: [&str; 8] = ["datum", "ellps", "a", "b", "rf", "R", "f", "towgs84"];

/// Keys that are read beside those of [`GEODETIC`].
const PROJECTING: [&str; 31] = [
    "proj",
    "pm",
    "lat_0",
    "lat_1",
    "lat_2",
    "lat_ts",
    "lon_0",
    "lon_1",
    "lon_2",
    "lonc",
    "x_0",
    "y_0",
    "k",
    "k_0",
    "units",
    "to_meter",
    "zone",
    "south",
    "alpha",
    "gamma",
    "no_off",
    "no_uoff",
    "no_rot",
    "axis",
    "over",
    "approx",
    "h",
    "azi",
    "tilt",
    "hyperbolic",
    "guam",
];

/// Cylindrical projections whose longitudes may run on beyond ±180°.
const CYLINDRICAL: [&str; 5] = ["eqc", "merc", "webmerc", "cea", "mill"];

/// Azimuth of Krovak's cone, degrees (EPSG guidance note 7-2: the co-latitude of its axis).
const KROVAK_AZIMUTH: f64 = 30.288_139_752_777_8;

/// Largest relative difference of two parameters that mean the same; at 10,000 km it is 0.1 mm.
const SAME_RELATIVE: f64 = 1e-11;

/// Largest difference of semi-axes that mean the same ellipsoid, metres. GRS 80 and WGS 84 differ by 0.0001 m.
const SAME_AXIS_METRES: f64 = 1e-3;

/// A PROJ definition as key-value pairs in their order.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Definition(Vec<(String, Option<String>)>);

impl Definition {
    /// Reads `+key=value` words; the plus signs may be missing.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        if text.len() > LONGEST {
            return Err(format!(
                "a PROJ definition of {} bytes is too long (the limit is {LONGEST})",
                text.len()
            ));
        }

        let mut pairs = Vec::new();
        for word in text.split_whitespace() {
            let word = word.strip_prefix('+').unwrap_or(word);
            let (key, value) = match word.split_once('=') {
                Some((key, value)) => (key, Some(value)),
                None => (word, None),
            };
            let sound = |part: &str| part.chars().all(|c| c.is_ascii_graphic() && c != '"');
            if key.is_empty() || value == Some("") || !sound(word) {
                return Err(format!("'{word}' in '{text}' is not of the form +key=value"));
            }

            if !pairs.iter().any(|(known, _)| known == key) {
                pairs.push((key.to_owned(), value.map(str::to_owned)));
            }
        }

        Ok(Self(pairs))
    }

    /// Returns longitude and latitude on WGS 84, degrees.
    pub(super) fn wgs84_degrees() -> Self {
        let term = |key: &str, value: &str| (key.to_owned(), Some(value.to_owned()));
        Self(vec![term("proj", "longlat"), term("datum", "WGS84")])
    }

    /// Reads a definition and makes it loadable as the module's account says.
    pub(super) fn loadable(text: &str) -> Result<Self, String> {
        let mut definition = Self::parse(text)?;
        definition.0.retain(|(key, _)| !IRRELEVANT.contains(&key.as_str()));
        definition.name_geographic();
        definition.replace_grids()?;
        definition.check_axes()?;
        definition.check_terms()?;
        on_earth(&definition.to_string(), text)?;
        definition.load()?;
        Ok(definition)
    }

    /// Value of `key`; `None` where it is absent or has no value.
    pub(super) fn get(&self, key: &str) -> Option<&str> {
        self.0.iter().find(|(known, _)| known == key)?.1.as_deref()
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.0.iter().any(|(known, _)| known == key)
    }

    fn number(&self, key: &str) -> Option<f64> {
        self.get(key)?.parse().ok()
    }

    fn remove(&mut self, keys: &[&str]) {
        self.0.retain(|(known, _)| !keys.contains(&known.as_str()));
    }

    fn push(&mut self, key: &str, value: &str) {
        self.0.push((key.to_owned(), Some(value.to_owned())));
    }

    /// Whether coordinates are angles.
    pub(super) fn is_geographic(&self) -> bool {
        self.get("proj") == Some("longlat")
    }

    /// All spellings of geographic coordinates become `longlat`.
    fn name_geographic(&mut self) {
        for (key, value) in &mut self.0 {
            if key == "proj" && value.as_deref().is_some_and(|v| matches!(v, "latlong" | "lonlat" | "latlon"))
            {
                *value = Some("longlat".to_owned());
            }
        }
    }

    fn replace_grids(&mut self) -> Result<(), String> {
        if self.get("nadgrids") == Some("@null") {
            self.remove(&["nadgrids"]);
            let sphere = self.number("a").is_some() && self.number("a") == self.number("b");
            if self.get("proj") == Some("merc") && sphere && self.number("a") == Some(6_378_137.0) {
                self.remove(&["proj", "a", "b", "lat_ts"]);
                self.0.insert(0, ("proj".to_owned(), Some("webmerc".to_owned())));
                self.push("datum", "WGS84");
            } else if !self.has("towgs84") && !self.has("datum") {
                self.push("towgs84", "0,0,0");
            }
        } else if let Some(grids) = self.get("nadgrids") {
            if !self.has("towgs84") {
                return Err(format!(
                    "the datum shift grid '{grids}' is not at hand; give the shift as +towgs84=dx,dy,dz instead of +nadgrids"
                ));
            }
            self.remove(&["nadgrids"]);
        }

        if self.get("datum").is_some_and(|datum| datum.eq_ignore_ascii_case("NAD27")) {
            self.remove(&["datum"]);
            self.push("ellps", "clrk66");
            if !self.has("towgs84") {
                self.push("towgs84", NAD27_TO_WGS84);
            }
        }

        Ok(())
    }

    /// Terms that would be dropped are refused; the azimuth of an oblique Mercator's grid goes without saying.
    fn check_terms(&mut self) -> Result<(), String> {
        let is_read = |key: &str| {
            PROJECTING.contains(&key) || GEODETIC.contains(&key) || key == "nadgrids" || key == "czech"
        };
        if let Some((key, _)) = self.0.iter().find(|(key, _)| !is_read(key)) {
            return Err(format!("the term '+{key}' of '{self}' is not read; {CONVERT}"));
        }
        let azimuth = self.number("alpha");
        if self.get("proj") == Some("krovak") {
            if azimuth.is_some_and(|azimuth| (azimuth - KROVAK_AZIMUTH).abs() > 1e-4) {
                return Err(format!(
                    "Krovak's projection is only read with +alpha={KROVAK_AZIMUTH}; {CONVERT}"
                ));
            }
        } else if let Some(azimuth) = azimuth.filter(|_| !self.has("gamma")) {
            self.push("gamma", &azimuth.to_string());
        }
        Ok(())
    }

    /// Axes to the east and north go without saying; others are kept, and heights among them do not matter.
    fn check_axes(&mut self) -> Result<(), String> {
        let Some(axis) = self.get("axis").map(str::to_owned) else { return Ok(()) };
        let letters: Vec<char> = axis.chars().collect();
        let is_one = |pair: [char; 2]| letters.iter().filter(|letter| pair.contains(letter)).count() == 1;
        if letters.len() != 3 || !is_one(['e', 'w']) || !is_one(['n', 's']) || letters[2] != 'u' {
            return Err(format!(
                "the axes '{axis}' are not two of e, w, n, s and 'u', as in +axis=wsu; {CONVERT}"
            ));
        }
        if axis == "enu" {
            self.remove(&["axis"]);
        } else if self.is_geographic() {
            return Err(format!(
                "the axes of degrees run '{axis}', and only east, north ones are read; {CONVERT}"
            ));
        }
        Ok(())
    }

    /// Longitude of the prime meridian, radians east of Greenwich.
    pub(super) fn meridian(&self) -> Result<f64, String> {
        if !self.has("pm") {
            return Ok(0.0);
        }
        let mut degrees = self.clone();
        degrees.0.retain(|(key, _)| key == "pm" || GEODETIC.contains(&key.as_str()));
        degrees.push("proj", "longlat");
        let mut place = (0.0, 0.5, 0.0);
        proj4rs::transform::transform(&degrees.load()?, &self.own_degrees()?, &mut place)
            .map_err(|error| format!("'{self}' is no usable PROJ definition: {error}"))?;
        Ok(place.0)
    }

    /// Degrees on the same datum, from Greenwich, as [`proj4rs`] computes them.
    pub(super) fn own_degrees(&self) -> Result<Proj, String> {
        let words = self.0.iter().filter(|(key, _)| GEODETIC.contains(&key.as_str()));
        let words: Vec<String> = words.map(|(key, value)| word(key, value.as_deref())).collect();
        Self::parse(&format!("+proj=longlat {}", words.join(" ")))?.load()
    }

    /// The same with another shift to WGS 84, or with none.
    pub(super) fn with_shift(&self, towgs84: Option<&str>) -> Self {
        let mut definition = self.clone();
        definition.remove(&["towgs84"]);
        if let Some(shift) = towgs84 {
            definition.push("towgs84", shift);
        }
        definition
    }

    /// The projection as [`proj4rs`] computes it.
    pub(super) fn load(&self) -> Result<Proj, String> {
        let name = self.get("proj").ok_or_else(|| format!("'{self}' has no +proj=…"))?;
        if matches!(name, "geocent" | "cart") {
            return Err("geocentric coordinates are no map; convert the data with: gdalwarp -t_srs EPSG:4326 IN OUT.tif".into());
        }

        let mut text = self.to_string();
        // Longitudes run on across the border of the map, so that a pixel that reaches beyond ±180°
        // stays beside its neighbour. That needs the border to lie there.
        if CYLINDRICAL.contains(&name) && self.number("lon_0").unwrap_or(0.0) == 0.0 && !self.has("over") {
            text.push_str(" +over");
        }

        let proj = Proj::from_proj_string(&text).map_err(|error| match error {
            proj4rs::errors::Error::ProjectionNotFound => {
                format!("the projection '{name}' is not supported; convert the data with: gdalwarp -t_srs EPSG:4326 IN OUT.tif")
            }
            other => format!("'{self}' is no usable PROJ definition: {other}"),
        })?;
        let (a, b) = proj.ellipse_parameters();

        let sound = a.is_finite()
            && b.is_finite()
            && b > 0.0
            && a >= b
            && proj.to_meter().is_finite()
            && proj.to_meter() > 0.0;
        if !sound || !proj.has_forward() || !proj.has_inverse() {
            return Err(format!("'{self}' is no usable PROJ definition: check ellipsoid and units"));
        }

        Ok(proj)
    }

    /// Whether both put every place at the same coordinates (within 0.1 mm).
    pub(super) fn is_equivalent(&self, other: &Self) -> bool {
        self == other
            || matches!((Canonical::new(self), Canonical::new(other)), (Some(one), Some(two)) if one.is_same(&two))
    }
}

impl fmt::Display for Definition {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words: Vec<String> = self.0.iter().map(|(key, value)| word(key, value.as_deref())).collect();
        formatter.write_str(&words.join(" "))
    }
}

fn word(key: &str, value: Option<&str>) -> String {
    match value {
        Some(value) => format!("+{key}={value}"),
        None => format!("+{key}"),
    }
}

/// Parameters that decide where a place comes to lie, with defaults left out and synonyms resolved.
#[derive(Debug)]
struct Canonical {
    /// Projection and what else is not a number.
    words: BTreeMap<String, String>,
    /// Parameters: degrees, metres, ratios.
    numbers: BTreeMap<String, f64>,
    /// Semi-axes, metres.
    axes: (f64, f64),
}

impl Canonical {
    fn new(definition: &Definition) -> Option<Self> {
        const RESOLVED: [&str; 11] =
            ["datum", "ellps", "a", "b", "rf", "R", "f", "towgs84", "units", "to_meter", "over"];
        let proj = definition.load().ok()?;
        let mut canonical =
            Self { words: BTreeMap::new(), numbers: BTreeMap::new(), axes: proj.ellipse_parameters() };
        for (key, value) in &definition.0 {
            if !RESOLVED.contains(&key.as_str()) {
                canonical.insert(key, value.as_deref().unwrap_or(""));
            }
        }
        canonical.numbers.insert("to_meter".into(), proj.to_meter());
        canonical.words.insert("shift".into(), canonical.shift(definition));
        canonical.expand_utm()?;
        canonical.numbers.retain(|key, value| *value != default_of(key));
        Some(canonical)
    }

    fn insert(&mut self, key: &str, value: &str) {
        let key = if matches!(key, "k" | "k_0") { "k0" } else { key };
        match value.parse() {
            Ok(number) => drop(self.numbers.insert(key.to_owned(), number)),
            Err(_) => drop(self.words.insert(key.to_owned(), value.to_owned())),
        }
    }

    /// Returns the datum's shift to WGS 84. Systems on its ellipsoid (NAD83, ETRS89, SIRGAS 2000, …) agree with it within
    /// a metre or two, and no shift is defined between them; they count as one.
    fn shift(&self, definition: &Definition) -> String {
        let same_ellipsoid = (self.axes.0 - 6_378_137.0).abs() < SAME_AXIS_METRES
            && (self.axes.1 - 6_356_752.314_2).abs() < SAME_AXIS_METRES;
        let shift = definition.get("towgs84").or(definition.get("datum")).unwrap_or("");
        let zero = shift.split(',').all(|term| term.parse() == Ok(0.0));
        let none = zero || matches!(shift, "" | "WGS84" | "NAD83");
        let geodetic = same_ellipsoid || self.words.get("proj").is_some_and(|proj| proj == "webmerc");
        if geodetic && none { "none".to_owned() } else { shift.to_owned() }
    }

    fn expand_utm(&mut self) -> Option<()> {
        let south = self.words.remove("south").is_some();
        let name = self.words.get_mut("proj")?;
        match name.as_str() {
            "utm" => {
                *name = "tmerc".to_owned();
                let zone = self.numbers.remove("zone")?;
                let northing = if south { 1e7 } else { 0.0 };
                let terms = [
                    ("lon_0", 6.0 * zone - 183.0),
                    ("k0", 0.9996),
                    ("x_0", 5e5),
                    ("y_0", northing),
                    ("lat_0", 0.0),
                ];
                self.numbers.extend(terms.map(|(key, value)| (key.to_owned(), value)));
            }
            "etmerc" => *name = "tmerc".to_owned(),
            _ if south => drop(self.words.insert("south".into(), String::new())),
            _ => {}
        }

        Some(())
    }

    fn is_same(&self, other: &Self) -> bool {
        let close =
            |one: f64, two: f64| (one - two).abs() <= SAME_RELATIVE * one.abs().max(two.abs()).max(1.0);
        let axes = (self.axes.0 - other.axes.0).abs() < SAME_AXIS_METRES
            && (self.axes.1 - other.axes.1).abs() < SAME_AXIS_METRES;
        let keys = || self.numbers.keys().eq(other.numbers.keys());
        let values = || self.numbers.values().zip(other.numbers.values()).all(|(one, two)| close(*one, *two));
        axes && self.words == other.words && keys() && values()
    }
}

fn default_of(key: &str) -> f64 {
    if matches!(key, "k0" | "to_meter") { 1.0 } else { 0.0 }
}
