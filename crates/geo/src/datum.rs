//! Vertical datums: surfaces that heights are measured from.
//!
//! A database's heights are above mean sea level, for which EGM96 stands. Heights above the ellipsoid are
//! lowered by the EGM96 undulation, which is computed here. For EGM2008 and NAVD88 no grid is at hand, so
//! that such heights are kept as they are, as the database's own datum, or refused where they would meet
//! another one. A missing grid never counts as no shift.

use serde::{Deserialize, Serialize};

use super::undulation::egm96_undulation;
use hedgehop_base::error::{Error, Result};

/// Vertical datum of heights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum VerticalDatum {
    /// Mean sea level, not further specified (assumed where a file is silent).
    Msl,
    /// EGM96 geoid.
    Egm96,
    /// EGM2008 geoid.
    Egm2008,
    /// WGS 84 ellipsoid.
    Ellipsoid,
    /// NAVD88.
    Navd88,
}

/// A system of heights as a file or a user states it; any part may be missing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VerticalCrs {
    /// Datum of the heights; `None` where none is stated, or one that is not told apart from mean sea level here.
    pub datum: Option<VerticalDatum>,
    /// Metres upward per unit, never 0; below 0 for depths. `None` where no unit is stated.
    pub metres_per_unit: Option<f64>,
    /// Name as stated, for messages.
    pub name: Option<String>,
}

/// Shift that brings a height to another datum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VerticalShift {
    /// Nothing.
    None,
    /// Subtract the undulation: from ellipsoid to mean sea level.
    MinusEgm96Undulation,
    /// Add the undulation: from mean sea level to ellipsoid.
    PlusEgm96Undulation,
}

impl VerticalShift {
    /// The shifted height, metres. Longitude and latitude in degrees, WGS 84.
    pub fn apply(self, longitude: f64, latitude: f64, height: f64) -> f64 {
        match self {
            Self::None => height,
            Self::MinusEgm96Undulation => height - egm96_undulation(longitude, latitude),
            Self::PlusEgm96Undulation => height + egm96_undulation(longitude, latitude),
        }
    }
}

impl VerticalDatum {
    /// Parses a user's word: `egm96`, `egm2008`, `ellipsoid`, `navd88`, `msl`.
    pub fn parse(text: &str) -> Result<Self> {
        match text.trim().to_ascii_lowercase().as_str() {
            "msl" => Ok(Self::Msl),
            "egm96" => Ok(Self::Egm96),
            "egm2008" => Ok(Self::Egm2008),
            "ellipsoid" => Ok(Self::Ellipsoid),
            "navd88" => Ok(Self::Navd88),
            _ => Err(Error::Configuration(format!(
                "'{text}' is no vertical datum; give one of egm96, egm2008, ellipsoid, navd88, msl"
            ))),
        }
    }

    /// Name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Msl => "mean sea level",
            Self::Egm96 => "EGM96 mean sea level",
            Self::Egm2008 => "EGM2008 mean sea level",
            Self::Ellipsoid => "WGS 84 ellipsoid",
            Self::Navd88 => "NAVD88",
        }
    }

    /// Name for a command line, as [`VerticalDatum::parse`] takes it.
    pub fn key(self) -> &'static str {
        match self {
            Self::Msl => "msl",
            Self::Egm96 => "egm96",
            Self::Egm2008 => "egm2008",
            Self::Ellipsoid => "ellipsoid",
            Self::Navd88 => "navd88",
        }
    }

    /// Finds how heights above `from` become heights above `to`; an error where that needs a grid that is not at hand.
    /// Unspecified mean sea level counts as EGM96.
    pub fn conversion(from: Self, to: Self) -> Result<VerticalShift> {
        use VerticalDatum::{Egm96, Ellipsoid, Msl};
        match (from, to) {
            (Msl | Egm96, Msl | Egm96) => Ok(VerticalShift::None),
            (Ellipsoid, Msl | Egm96) => Ok(VerticalShift::MinusEgm96Undulation),
            (Msl | Egm96, Ellipsoid) => Ok(VerticalShift::PlusEgm96Undulation),
            (from, to) if from == to => Ok(VerticalShift::None),
            (from, to) => Err(Error::Configuration(format!(
                "heights above {} cannot be brought to {}: the grid between them is not at hand; convert them \
                 with PROJ's grids (gdalwarp -s_srs EPSG:…+{} -t_srs EPSG:…+5773 IN OUT.tif), or accept the \
                 difference with --src-vdatum {}",
                from.label(),
                to.label(),
                from.epsg(),
                to.key()
            ))),
        }
    }

    /// The height above mean sea level (EGM96), metres. Longitude and latitude in degrees, WGS 84.
    pub fn to_msl(self, longitude: f64, latitude: f64, height: f64) -> Result<f64> {
        Ok(Self::conversion(self, Self::Msl)?.apply(longitude, latitude, height))
    }

    /// EPSG code of heights above the datum, metres.
    fn epsg(self) -> u32 {
        match self {
            Self::Msl => 5714,
            Self::Egm96 => 5773,
            Self::Egm2008 => 3855,
            Self::Ellipsoid => 4979,
            Self::Navd88 => 5703,
        }
    }
}
