//! Numbers as text files spell them.

use std::num::ParseFloatError;

/// Parses a number with a decimal point, or with a comma in its place.
#[inline]
pub(super) fn decimal(text: &str) -> Result<f64, ParseFloatError> {
    text.parse().or_else(|_| text.replace(',', ".").parse())
}
