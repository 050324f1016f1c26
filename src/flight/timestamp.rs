//! Time stamps as path files write them.

use time::format_description::well_known::Iso8601;
use time::{OffsetDateTime, PrimitiveDateTime};

/// Seconds since 1970-01-01T00:00:00Z of an ISO 8601 date and time. Without an offset it is taken as UTC; a blank
/// may stand for the `T` and before the offset, as loggers write it (`2018-10-15 17:34:37.441 -0500`).
pub(super) fn unix_seconds(text: &str) -> Option<f64> {
    let text = text.trim();
    let canonical = match text.split_once(' ') {
        Some((date, clock)) => format!("{date}T{}", clock.replace(' ', "")),
        None => text.to_owned(),
    };
    let moment = OffsetDateTime::parse(&canonical, &Iso8601::PARSING)
        .or_else(|_| {
            PrimitiveDateTime::parse(&canonical, &Iso8601::PARSING).map(PrimitiveDateTime::assume_utc)
        })
        .ok()?;
    let whole = moment.unix_timestamp() as f64;
    Some(whole + f64::from(moment.nanosecond()) * 1e-9)
}

#[cfg(test)]
mod tests {
    use super::unix_seconds;

    #[test]
    fn iso_8601_in_the_shapes_of_loggers() {
        assert_eq!(unix_seconds("1970-01-01T00:00:01Z"), Some(1.0));
        assert_eq!(unix_seconds("1970-01-01T01:00:01.5+01:00"), Some(1.5));
        assert_eq!(unix_seconds("1970-01-01T00:00:02"), Some(2.0));
        assert_eq!(unix_seconds("2018-10-15 17:34:37.500 -0500"), Some(1_539_642_877.5));
        assert_eq!(unix_seconds("2018-10-15 22:34:37.5"), Some(1_539_642_877.5));
        for wrong in ["", "yesterday", "2018-13-01T00:00:00Z", "12:00", "é", "2018-10-15 25:00:00"] {
            assert_eq!(unix_seconds(wrong), None, "{wrong}");
        }
    }
}
