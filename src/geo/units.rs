//! Units of coordinates and heights.

use super::geokey_directory::USER_DEFINED;
use super::heights::{FOOT, US_SURVEY_FOOT};

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

/// Metres per unit of an EPSG unit code.
pub(super) fn linear(code: u32) -> Option<f64> {
    Some(match code {
        9001 => 1.0,
        9002 => FOOT,
        9003 => US_SURVEY_FOOT,
        // Modified American foot, and the feet and links of Clarke, Sears and India, as in EPSG's unit table.
        9004 => 12.0 / 39.370_147,
        9005 => 0.304_797_265_4,
        9014 => 1.8288,
        9030 => 1852.0,
        9036 => 1000.0,
        9040 => 0.914_398_414_616_028_7,
        9041 => 0.304_799_471_538_676_3,
        9080 => 0.304_799_510_248_147,
        9084 => 0.914_398_530_744_440_8,
        9093 => 1609.344,
        9096 => 0.9144,
        1025 => 0.001,
        1033 => 0.01,
        1034 => 20.1168,
        _ => return None,
    })
}

/// Metres per unit from GeoTIFF's unit code and size; `None` where no unit is given.
pub(super) fn linear_of_keys(code: Option<u16>, size: Option<f64>) -> Result<Option<f64>, String> {
    match code {
        None => Ok(None),
        Some(USER_DEFINED) => match size {
            Some(size) if size > 0.0 => Ok(Some(size)),
            _ => Err("the unit of the coordinates is declared as user-defined, but has no size; write the right one with: gdal_edit.py -a_srs EPSG:CODE FILE".into()),
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
        // 9107, 9108 and 9122 are degrees, written otherwise.
        None | Some(9102 | 9107 | 9108 | 9122) => Ok(1.0),
        Some(9101) => Ok(1f64.to_degrees()),
        Some(9103) => Ok(1.0 / 60.0),
        Some(9104) => Ok(1.0 / 3600.0),
        Some(9105 | 9106) => Ok(0.9),
        Some(USER_DEFINED) if size.is_some_and(|size| size > 0.0) => Ok(size.unwrap_or(1.0).to_degrees()),
        Some(code) => Err(format!(
            "the angular unit EPSG:{code} is not known here; convert the data with: gdalwarp -t_srs EPSG:4326 IN OUT.tif"
        )),
    }
}
