//! Values that mean "no data", as files spell them.

use super::decimal::decimal;
use crate::raster::SampleType;

/// Parses a nodata value as files spell it: `-9999`, ` -3.4e+38 `, `nan`, `-1.#QNAN`, `-9999,0`, `none`.
/// The answer is rounded to the sample type, so that it compares equal with stored samples.
/// `Ok(None)` if the text says that there is none.
///
/// # Errors
/// The text, if it is no number.
pub(super) fn parse(text: &str, sample: SampleType) -> Result<Option<f64>, String> {
    let text = text.trim_matches(|c: char| c.is_whitespace() || c == '\0' || c == '"').to_ascii_lowercase();
    if text.is_empty() || text == "none" || text == "null" {
        return Ok(None);
    }
    if ["nan", "#qnan", "#snan", "#ind"].iter().any(|spelling| text.contains(spelling)) {
        return Ok(Some(f64::NAN));
    }
    let value = decimal(&text).map_err(|_| text.clone())?;
    Ok(Some(sample.round(value)))
}

/// Whether a sample is the nodata value; NaN matches NaN.
pub(super) fn matches(sample: f64, nodata: Option<f64>) -> bool {
    nodata.is_some_and(|nodata| sample == nodata || sample.is_nan() && nodata.is_nan())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings() {
        let f32 = |text| parse(text, SampleType::F32).unwrap();
        assert_eq!(f32("-3.4e+38\0"), Some(f64::from(-3.4e38f32)));
        assert_ne!(f32("-3.4e+38"), Some(-3.4e38));
        assert_eq!(f32(" -9999,0 "), Some(-9999.0));
        assert_eq!(f32("none"), None);
        assert!(f32("-1.#QNAN").is_some_and(f64::is_nan));
        assert!(f32("NaN").is_some_and(f64::is_nan));
        assert!(parse("void", SampleType::F32).is_err());
        assert_eq!(parse("-9999", SampleType::I16), Ok(Some(-9999.0)));
    }
}
