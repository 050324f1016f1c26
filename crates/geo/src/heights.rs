//! Systems of heights: by code, by name, and in the terms of a PROJ definition.
//!
//! ```text
//! unit and direction   as stated, exactly
//! datum                EGM96, EGM2008, NAVD88, the ellipsoid, mean sea level by code or name
//! any other datum      (NGVD29, DHHN2016, …) by its name alone; heights are taken as above mean sea level, and a note says so
//! ```

use super::crs::is_three_dimensional;
use super::datum::{VerticalCrs, VerticalDatum};
use super::definition::Definition;
use super::wkt_names::plain;
use super::{registry, units};

/// Esri's codes of heights above the ellipsoid of a datum.
const ESRI_ELLIPSOIDAL: std::ops::RangeInclusive<u32> = 115_700..=115_999;

/// Codes among them that are of no datum.
const ESRI_UNKNOWN: std::ops::RangeInclusive<u32> = 115_807..=115_809;

/// Vertical codes of GeoTIFF 1.0 for heights above an ellipsoid (§6.3.4.1).
const GEOTIFF_ELLIPSOIDAL: std::ops::RangeInclusive<u32> = 5001..=5035;

/// Vertical codes of GeoTIFF 1.0 for heights above a sea (§6.3.4.2), with their EPSG codes of today.
const GEOTIFF_ORTHOMETRIC: [(u32, u32); 6] =
    [(5101, 5701), (5102, 5702), (5103, 5703), (5104, 5736), (5105, 5705), (5106, 5706)];

impl VerticalCrs {
    /// Heights above the ellipsoid of the horizontal datum, in metres.
    pub(super) fn ellipsoidal() -> Self {
        let datum = Some(VerticalDatum::Ellipsoid);
        Self { datum, metres_per_unit: Some(1.0), name: Some(VerticalDatum::Ellipsoid.label().to_owned()) }
    }

    /// Completes this with what `other` says of the rest.
    pub fn or(self, other: Self) -> Self {
        let is_named = self.datum.is_some() || self.name.is_some();
        Self {
            datum: if is_named { self.datum } else { other.datum },
            metres_per_unit: self.metres_per_unit.or(other.metres_per_unit),
            name: if is_named { self.name } else { other.name },
        }
    }

    /// Whether nothing is said of what heights are measured from.
    pub fn is_silent(&self) -> bool {
        self.datum.is_none() && self.name.is_none()
    }
}

/// The vertical system of a code, or of one of the older GeoTIFF codes.
pub(super) fn by_code(code: u32) -> Option<VerticalCrs> {
    let modern = GEOTIFF_ORTHOMETRIC.iter().find(|(old, _)| *old == code).map_or(code, |(_, modern)| *modern);
    let Some(system) = registry::vertical(modern) else {
        return GEOTIFF_ELLIPSOIDAL.contains(&code).then(VerticalCrs::ellipsoidal);
    };
    let is_ellipsoidal =
        ESRI_ELLIPSOIDAL.contains(&system.entry.code) && !ESRI_UNKNOWN.contains(&system.entry.code);
    let datum = if is_ellipsoidal { Some(VerticalDatum::Ellipsoid) } else { datum_of(system.entry.name) };
    let metres = units::exact(system.metres_per_unit);
    Some(VerticalCrs {
        datum,
        metres_per_unit: Some(if system.is_depth { -metres } else { metres }),
        name: Some(system.entry.to_string()),
    })
}

/// The vertical part of a compound code or of a three-dimensional geographic one.
pub(super) fn part_of(code: u32) -> Option<VerticalCrs> {
    if is_three_dimensional(code) {
        return Some(VerticalCrs::ellipsoidal());
    }
    by_code(registry::compound(code)?.vertical)
}

/// The datum that a name means, if it is one that is told apart here.
pub(super) fn datum_of(name: &str) -> Option<VerticalDatum> {
    let name = plain(name);
    let has = |words: &[&str]| words.iter().any(|word| name.contains(word));
    if has(&["navd88", "navd1988", "northamericanverticaldatum1988"]) {
        Some(VerticalDatum::Navd88)
    } else if has(&["egm96", "egm1996", "earthgravitationalmodel1996"]) {
        Some(VerticalDatum::Egm96)
    } else if has(&["egm2008", "egm08", "earthgravitationalmodel2008"]) {
        Some(VerticalDatum::Egm2008)
    } else if name.contains("ellipsoid") && !name.contains("geoid") {
        Some(VerticalDatum::Ellipsoid)
    } else if matches!(
        name.as_str(),
        "mslheight" | "msldepth" | "msl" | "meansealevel" | "mslheightft" | "msldepthft"
    ) {
        Some(VerticalDatum::Msl)
    } else {
        None
    }
}

/// Heights in the terms of a PROJ definition: `+vunits`, `+vto_meter`, `+geoidgrids`.
pub(super) fn of_definition(text: &str) -> Result<Option<VerticalCrs>, String> {
    let definition = Definition::parse(text)?;
    let unit = match (definition.get("vto_meter"), definition.get("vunits")) {
        (Some(text), _) => Some(
            ratio(text)
                .ok_or_else(|| format!("'+vto_meter={text}' is no size of a unit above 0 in metres"))?,
        ),
        (None, Some(name)) => Some(units::of_proj(name).ok_or_else(|| {
            format!("'+vunits={name}' is no unit of PROJ's; give its size as +vto_meter=metres")
        })?),
        (None, None) => None,
    };
    let grid = definition.get("geoidgrids");
    let vertical = VerticalCrs {
        datum: grid.and_then(datum_of),
        metres_per_unit: unit,
        name: grid.map(|grid| format!("the geoid of {grid}")),
    };
    Ok((vertical != VerticalCrs::default()).then_some(vertical))
}

/// `0.3048` or `1200/3937`.
fn ratio(text: &str) -> Option<f64> {
    let number = |text: &str| text.parse::<f64>().ok();
    let value = match text.split_once('/') {
        Some((above, below)) => number(above)? / number(below)?,
        None => number(text)?,
    };
    (value.is_finite() && value > 0.0).then_some(value)
}
