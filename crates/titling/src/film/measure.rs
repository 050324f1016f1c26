//! Measures in the units that an audience knows.

use hedgehop::scene::Units;

/// Metres of a foot, of a nautical mile, of a mile (exact, by definition).
const FOOT: f64 = 0.3048;
const NAUTICAL_MILE: f64 = 1852.0;
const MILE: f64 = 1609.344;

/// Seconds of a day.
const DAY: f64 = 86_400.0;

/// Returns a height as text; metres.
pub fn height(metres: f64, units: Units) -> String {
    match units {
        Units::Metric => format!("{} m", whole(metres)),
        Units::Aviation | Units::Imperial => format!("{} ft", whole(metres / FOOT)),
    }
}

/// Returns a speed over ground as text; metres a second.
pub fn speed(metres: f64, units: Units) -> String {
    match units {
        Units::Metric => format!("{} km/h", whole(3.6 * metres)),
        Units::Aviation => format!("{} kt", whole(3600.0 * metres / NAUTICAL_MILE)),
        Units::Imperial => format!("{} mph", whole(3600.0 * metres / MILE)),
    }
}

/// Returns a rate of climb as text; metres a second upward.
pub fn climb(metres: f64, units: Units) -> String {
    let signed = |value: f64| if value > 0.0 { format!("+{value}") } else { whole_minus(value) };
    match units {
        Units::Metric => {
            let tenths = (10.0 * metres).round() / 10.0;
            let sign = if tenths < 0.0 {
                "−"
            } else if tenths > 0.0 {
                "+"
            } else {
                ""
            };
            format!("{sign}{:.1} m/s", tenths.abs())
        }
        Units::Aviation | Units::Imperial => {
            format!("{} ft/min", signed(10.0 * (6.0 * metres / FOOT).round()))
        }
    }
}

/// Returns a distance as text; metres.
pub fn distance(metres: f64, units: Units) -> String {
    let (length, unit, small, small_unit) = match units {
        Units::Metric => (1000.0, "km", 1.0, "m"),
        Units::Aviation => (NAUTICAL_MILE, "NM", FOOT, "ft"),
        Units::Imperial => (MILE, "mi", FOOT, "ft"),
    };
    let long = metres / length;
    if long >= 10.0 {
        format!("{} {unit}", whole(long))
    } else if long >= 0.5 {
        let tenths = format!("{long:.1}");
        format!("{} {unit}", tenths.strip_suffix(".0").unwrap_or(&tenths))
    } else {
        format!("{} {small_unit}", whole(metres / small))
    }
}

/// Returns the longest length not above a given one that is a round number of its unit, as metres.
pub fn round_length(longest: f64, units: Units) -> f64 {
    let (large, small) = match units {
        Units::Metric => (1000.0, 1.0),
        Units::Aviation => (NAUTICAL_MILE, FOOT),
        Units::Imperial => (MILE, FOOT),
    };
    let unit = if longest >= 0.5 * large { large } else { small };
    let count = longest / unit;
    let power = 10.0_f64.powf(count.log10().floor());
    let steps = [5.0, 2.0, 1.0];
    let step = steps.into_iter().find(|step| step * power <= count * (1.0 + 1e-9)).unwrap_or(1.0);
    step * power * unit
}

/// Returns a time of day, seconds after midnight UTC, as a clock that is some hours before it.
pub fn clock(seconds: f64, utc_offset: f64) -> String {
    let seconds = (seconds + 3600.0 * utc_offset + 1e-6).rem_euclid(DAY) as u32;
    format!("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60)
}

/// Returns the name of a clock.
pub fn clock_name(utc_offset: f64) -> String {
    let minutes = (60.0 * utc_offset).round() as i32;
    let sign = if minutes < 0 { '−' } else { '+' };
    match (minutes.abs() / 60, minutes.abs() % 60) {
        (0, 0) => "UTC".to_owned(),
        (hours, 0) => format!("UTC{sign}{hours}"),
        (hours, minutes) => format!("UTC{sign}{hours}:{minutes:02}"),
    }
}

/// Returns a length of time as hours, minutes and seconds.
pub fn elapsed(seconds: f64) -> String {
    let seconds = (seconds + 1e-6).max(0.0) as u64;
    format!("{}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60)
}

/// Returns longitude and latitude, degrees, as text.
pub fn geographic([longitude, latitude]: [f64; 2]) -> [String; 2] {
    let part = |degrees: f64, names: [char; 2]| {
        let name = names[usize::from(degrees < 0.0)];
        format!("{:.4}° {name}", degrees.abs())
    };
    [part(latitude, ['N', 'S']), part(longitude, ['E', 'W'])]
}

/// Rounds to a whole number, without a minus before 0, and with a true minus.
fn whole(value: f64) -> String {
    whole_minus(value.round())
}

fn whole_minus(value: f64) -> String {
    if value < 0.0 { format!("−{}", -value) } else { value.abs().to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Units::{Aviation, Imperial, Metric};

    #[test]
    fn measures_are_written_in_their_units() {
        assert_eq!(
            [height(1234.5, Metric), height(-0.3, Metric), height(-12.0, Metric)],
            ["1235 m", "0 m", "−12 m"]
        );
        assert_eq!(
            [height(304.8, Aviation), speed(10.0, Metric), speed(51.444_444, Aviation)],
            ["1000 ft", "36 km/h", "100 kt"]
        );
        assert_eq!(
            [speed(44.704, Imperial), climb(1.26, Metric), climb(-0.04, Metric)],
            ["100 mph", "+1.3 m/s", "0.0 m/s"]
        );
        assert_eq!(
            [climb(-2.54, Aviation), climb(0.0, Aviation), climb(-1.25, Metric)],
            ["−500 ft/min", "0 ft/min", "−1.3 m/s"]
        );
        let distances = [
            (24_400.0, Metric),
            (1500.0, Metric),
            (2000.0, Metric),
            (300.0, Metric),
            (18_520.0, Aviation),
            (100.0, Imperial),
        ];
        assert_eq!(
            distances.map(|(metres, units)| distance(metres, units)),
            ["24 km", "1.5 km", "2 km", "300 m", "10 NM", "328 ft"]
        );
    }

    #[test]
    fn bars_are_of_round_lengths_that_fit() {
        for (longest, units, told) in [
            (1999.0, Metric, "1 km"),
            (2000.0, Metric, "2 km"),
            (730.0, Metric, "0.5 km"),
            (499.0, Metric, "200 m"),
            (5.2, Metric, "5 m"),
            (30_000.0, Aviation, "10 NM"),
            (100.0, Imperial, "200 ft"),
        ] {
            let length = round_length(longest, units);
            assert!(length <= longest * 1.000_001 && length > 0.19 * longest, "{longest} {length}");
            assert_eq!(distance(length, units), told);
        }
    }

    #[test]
    fn clocks_pass_midnight_and_name_themselves() {
        assert_eq!(clock(86_399.0, 2.0), "01:59:59");
        assert_eq!(clock(3600.0, -5.5), "19:30:00");
        // Frames lie a rounding beside their seconds.
        assert_eq!([clock(50_400.0 - 1e-9, 0.0), elapsed(3725.0 - 1e-9)], ["14:00:00", "1:02:05"]);
        assert_eq!([0.0, 2.0, -3.5, 5.75].map(clock_name), ["UTC", "UTC+2", "UTC−3:30", "UTC+5:45"]);
        assert_eq!(geographic([-10.271_14, 47.331_26]), ["47.3313° N", "10.2711° W"]);
    }
}
