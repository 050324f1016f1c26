//! Units of coordinates and heights.

use super::geokey_directory::USER_DEFINED;
use super::registry;

/// Largest relative difference of two numbers that mean the same unit. The two feet differ by 2·10⁻⁶.
const SAME_RELATIVE: f64 = 1e-8;

/// Whether two sizes mean the same unit.
pub(super) fn same(one: f64, two: f64) -> bool {
    (one - two).abs() <= SAME_RELATIVE * one.abs()
}

/// The exact size of a foot that is given in a few digits; other sizes as they are.
pub(super) fn exact(metres: f64) -> f64 {
    let foot = [FOOT, US_SURVEY_FOOT].into_iter().find(|foot| same(*foot, metres));
    foot.unwrap_or(metres)
}

/// Metres per unit by PROJ's name of a unit (`+units`, `+vunits`).
pub(super) fn of_proj(name: &str) -> Option<f64> {
    Some(match name {
        "m" => 1.0,
        "km" => 1000.0,
        "dm" => 0.1,
        "cm" => 0.01,
        "mm" => 0.001,
        "kmi" => 1852.0,
        "in" => 0.0254,
        "ft" => FOOT,
        "yd" => 0.9144,
        "mi" => 1609.344,
        "fath" => 1.8288,
        "ch" => 20.1168,
        "link" => 0.201_168,
        "us-in" => US_SURVEY_FOOT / 12.0,
        "us-ft" => US_SURVEY_FOOT,
        "us-yd" => 3.0 * US_SURVEY_FOOT,
        "us-ch" => 66.0 * US_SURVEY_FOOT,
        "us-mi" => 5280.0 * US_SURVEY_FOOT,
        "ind-yd" => 0.914_395_23,
        "ind-ft" => 0.304_798_41,
        "ind-ch" => 20.116_695_06,
        _ => return None,
    })
}

/// Metres per unit of an EPSG unit code, or of one that GeoTIFF 1.0 has besides (section 6.3.1.3).
pub(super) fn linear(code: u32) -> Option<f64> {
    match code {
        // Modified American foot.
        9004 => Some(12.0 / 39.370_147),
        _ => registry::metres_per_unit(code).map(exact),
    }
}

/// Metres per unit from GeoTIFF's unit code and size; `None` where no unit is given.
pub(super) fn linear_of_keys(code: Option<u16>, size: Option<f64>) -> Result<Option<f64>, String> {
    match code {
        // 0 is what nobody defined.
        None | Some(0) => Ok(None),
        Some(USER_DEFINED) => match size {
            Some(size) if size > 0.0 => Ok(Some(size)),
            _ => Err("the unit is declared as user-defined, but has no size; write the right one with: gdal_edit.py -a_srs EPSG:CODE FILE".into()),
        },
        Some(code) => match linear(u32::from(code)) {
            Some(size) => Ok(Some(size)),
            None => Err(format!("the linear unit EPSG:{code} is not known here; convert the data with: gdalwarp -t_srs EPSG:4326 IN OUT.tif")),
        },
    }
}

/// Degrees per unit from GeoTIFF's unit code and size; degrees where no unit is given.
pub(super) fn angular_of_keys(code: Option<u16>, size: Option<f64>) -> Result<f64, String> {
    match code {
        // The last two are degrees, written otherwise.
        None | Some(0 | 9107 | 9108) => Ok(1.0),
        Some(USER_DEFINED) if size.is_some_and(|size| size > 0.0) => Ok(size.unwrap_or(1.0).to_degrees()),
        Some(code) => registry::degrees_per_unit(u32::from(code)).ok_or_else(|| {
            format!("the angular unit EPSG:{code} is not known here; convert the data with: gdalwarp -t_srs EPSG:4326 IN OUT.tif")
        }),
    }
}

/// International foot, metres.
pub(super) const FOOT: f64 = 0.3048;

/// US survey foot, metres (exactly 1200/3937).
pub(super) const US_SURVEY_FOOT: f64 = 1200.0 / 3937.0;
