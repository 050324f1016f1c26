//! Numbers with units, as people tag them.
//!
//! `12` `12.5` `12,5` `12 m` `40 ft` `40'` `5'11"` — OpenStreetMap's wiki, *Map features/Units* (2024): metres unless a unit is said.

/// Metres per unit.
const UNITS: [(&str, f64); 15] = [
    ("", 1.0),
    ("m", 1.0),
    ("metre", 1.0),
    ("metres", 1.0),
    ("meter", 1.0),
    ("meters", 1.0),
    ("km", 1000.0),
    ("cm", 0.01),
    ("mm", 0.001),
    ("ft", 0.3048),
    ("feet", 0.3048),
    ("'", 0.3048),
    ("in", 0.0254),
    ("\"", 0.0254),
    ("yd", 0.9144),
];

/// A length in metres.
pub(in super::super::super) fn length(text: &str) -> Option<f64> {
    let text = text.trim().replace(['’', '′'], "'").replace(['”', '″'], "\"");
    let (first, unit, rest) = leading(&text)?;
    let metres = first * factor(unit)?;
    if rest.is_empty() {
        return Some(metres);
    }
    // Feet and inches.
    let (second, smaller, rest) = leading(rest)?;
    let inches = rest.is_empty() && factor(unit) == Some(0.3048) && factor(smaller) == Some(0.0254);
    inches.then_some(metres + second * 0.0254)
}

fn factor(unit: &str) -> Option<f64> {
    UNITS.iter().find(|(known, _)| known.eq_ignore_ascii_case(unit)).map(|(_, factor)| *factor)
}

/// A number at a text's beginning, the unit behind it, and what follows.
fn leading(text: &str) -> Option<(f64, &str, &str)> {
    let digits = |c: char| c.is_ascii_digit() || matches!(c, '.' | ',' | '-' | '+');
    let end = text.find(|c| !digits(c)).unwrap_or(text.len());
    let (value, rest) = text.split_at(end);
    let rest = rest.trim_start();
    let end = rest.find(|c: char| digits(c) || c == ' ').unwrap_or(rest.len());
    let (unit, rest) = rest.split_at(end);
    Some((number(value)?, unit, rest.trim_start()))
}

/// A number, with a point or a comma.
pub(super) fn number(text: &str) -> Option<f64> {
    let text = text.trim();
    let text = if text.matches(',').count() == 1 && !text.contains('.') {
        text.replace(',', ".")
    } else {
        text.to_owned()
    };
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

/// The greatest of several voltages, volts: `220000;110000`, `110 kV`.
pub(super) fn voltage(text: &str) -> Option<f64> {
    let one = |part: &str| {
        let lower = part.trim().to_ascii_lowercase();
        match lower.strip_suffix("kv") {
            Some(kilovolts) => number(kilovolts).map(|kilovolts| kilovolts * 1000.0),
            None => number(lower.trim_end_matches('v')),
        }
    };
    text.split(';').filter_map(one).reduce(f64::max).filter(|volts| *volts > 0.0)
}

/// Degrees clockwise from north: `225`, `225°`, `SW`.
pub(super) fn direction(text: &str) -> Option<f64> {
    const POINTS: [&str; 16] =
        ["N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE", "S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW"];
    let text = text.trim();
    let point = POINTS.iter().position(|point| point.eq_ignore_ascii_case(text));
    point.map(|point| 22.5 * point as f64).or_else(|| degrees(text).map(|degrees| degrees.rem_euclid(360.0)))
}

/// Degrees, with or without their sign.
pub(super) fn degrees(text: &str) -> Option<f64> {
    number(text.trim().trim_end_matches('°'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_with_every_unit() {
        for (text, metres) in [
            ("12", 12.0),
            (" 12.5 m", 12.5),
            ("12,5m", 12.5),
            ("40 ft", 12.192),
            ("40'", 12.192),
            ("5'11\"", 1.8034),
            ("5 ft 11 in", 1.8034),
            ("0.5 km", 500.0),
            ("-3", -3.0),
        ] {
            let found = length(text).unwrap_or(f64::NAN);
            assert!((found - metres).abs() < 1e-9, "{text}: {found}");
        }

        for text in [
            "",
            "tall",
            "12;14",
            "12 - 14",
            "12 bananas",
            "3 m 4 m",
            "1,000.5",
            "1e999",
            "NaN",
            "inf",
            "5'11'",
        ] {
            assert_eq!(length(text), None, "{text}");
        }
    }

    #[test]
    fn voltages_and_directions() {
        assert_eq!(voltage("110000"), Some(110_000.0));
        assert_eq!(voltage("110000;220 kV;x"), Some(220_000.0));
        assert_eq!(voltage("high"), None);
        assert_eq!(direction("SW"), Some(225.0));
        assert_eq!(direction("-90°"), Some(270.0));
        assert_eq!(direction("up"), None);
    }
}
