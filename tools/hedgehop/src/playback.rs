//! Flags of a film's time: which part of a flight it shows, and how fast.

use clap::Args;
use serde_json::{Value, json};

use hedgehop::flight::{FlightTime, Pace, Playback, Trajectory};
use hedgehop::progress::Observer;

/// Fastest and slowest pace, seconds of flight in a second of the film.
const SPEEDS: [f64; 2] = [1.0e-4, 1.0e6];

/// Seconds of a day.
const DAY: f64 = 86_400.0;

/// Seconds of a film that are too long for what hardly moves.
const TOO_LONG: f64 = 2.0;

/// Longest film, seconds.
const LONGEST: f64 = 1.0e6;

/// Flags of the film's time.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct PlaybackArgs {
    /// Pace of the film: 30x shows half a minute of the flight in a second, 0.5x is slow motion [default: 1x, or as --duration says]
    #[arg(long, value_name = "FACTOR", value_parser = speed, allow_hyphen_values = true, conflicts_with_all = ["eye", "views"])]
    pub speed: Option<f64>,

    /// Length of the film, whatever the flight lasts: 90s, 2m30s, 1:30
    #[arg(long, value_name = "TIME", value_parser = duration, allow_hyphen_values = true, conflicts_with_all = ["eye", "views", "speed"])]
    pub duration: Option<f64>,

    /// Moment of the flight that the film begins at: after the first fix (90s, 2m30s), by the clock of the file, UTC (14:05, 14:05:30, 16:05+02:00), or departure,
    /// which leaves out that it stands or taxies before it [default: the first fix; with --duration the departure of a recording]
    #[arg(long, value_name = "TIME", value_parser = flight_time, allow_hyphen_values = true, conflicts_with_all = ["eye", "views"])]
    pub from: Option<FlightTime>,

    /// Moment of the flight that it ends at, as --from, or arrival [default: the last fix; with --duration the arrival of a recording]
    #[arg(long, value_name = "TIME", value_parser = flight_time, allow_hyphen_values = true, conflicts_with_all = ["eye", "views"])]
    pub to: Option<FlightTime>,
}

impl PlaybackArgs {
    /// Returns what the flags ask for of a flight. What a receiver recorded at its beginning and end on the ground is left out of a film that
    /// has a length of its own, or is told.
    pub fn playback(&self, flown: &Trajectory, observer: &dyn Observer) -> Playback {
        let pace = match (self.duration, self.speed) {
            (Some(seconds), _) => Pace::Duration(seconds),
            (None, speed) => Pace::Speed(speed.unwrap_or(1.0)),
        };
        let mut playback = Playback { pace, from: self.from, to: self.to };
        if !flown.lacks_pitch() || self.from.is_some() || self.to.is_some() {
            return playback;
        }

        let span = flown.span();
        let speed = match pace {
            Pace::Speed(speed) => speed,
            Pace::Duration(seconds) => span.duration / seconds,
        };
        let (before, after) = (span.departure, span.duration - span.arrival);
        let [stands_before, stands_after] = [before, after].map(|stands| stands > speed * TOO_LONG);
        let times = match (stands_before, stands_after) {
            (true, true) => format!("for its first {before:.0} s and its last {after:.0} s"),
            (true, false) => format!("for its first {before:.0} s"),
            (false, true) => format!("for its last {after:.0} s"),
            (false, false) => return playback,
        };

        if self.duration.is_some() {
            playback.from = stands_before.then_some(FlightTime::Departure);
            playback.to = stands_after.then_some(FlightTime::Arrival);
            let end = (10.0 * span.duration).floor() / 10.0;
            observer.note(&format!(
                "what flies hardly moves {times}; the film leaves that out, --from 0 --to {end}s does not"
            ));
        } else {
            observer.note(&format!(
                "what flies hardly moves {times}; --from departure --to arrival leave that out"
            ));
        }
        playback
    }

    /// Records what decides which moments frames show; defaults are not mentioned.
    pub fn record(&self, settings: &mut Value) {
        let moment = |time: FlightTime| match time {
            FlightTime::Seconds(seconds) => json!({ "seconds": seconds }),
            FlightTime::OfDay(seconds) => json!({ "seconds_of_day": seconds }),
            FlightTime::Departure => json!("departure"),
            FlightTime::Arrival => json!("arrival"),
        };
        let said = [
            ("speed", self.speed.filter(|speed| *speed != 1.0).map(Value::from)),
            ("duration_s", self.duration.map(Value::from)),
            ("from", self.from.map(moment)),
            ("to", self.to.map(moment)),
        ];
        for (key, value) in said {
            if let Some(value) = value {
                settings[key] = value;
            }
        }
    }
}

/// `30x`, `30`, `0.5x`.
fn speed(text: &str) -> Result<f64, String> {
    let number = text.strip_suffix(['x', 'X', '×']).unwrap_or(text);
    let [slowest, fastest] = SPEEDS;
    plain(number).filter(|speed| (slowest..=fastest).contains(speed)).ok_or_else(|| {
        format!("want how many times as fast as it was flown, {slowest} to {fastest}, such as 30x or 0.5x")
    })
}

/// A length of time above 0, seconds.
pub fn duration(text: &str) -> Result<f64, String> {
    length(text)
        .filter(|seconds| *seconds > 0.0 && *seconds <= LONGEST)
        .ok_or_else(|| "want how long the film lasts, above 0, such as 90s, 2m30s or 1:30".to_owned())
}

/// Seconds after the first fix, a time of the day, `departure` or `arrival`.
pub fn flight_time(text: &str) -> Result<FlightTime, String> {
    let time = match text {
        "departure" => Some(FlightTime::Departure),
        "arrival" => Some(FlightTime::Arrival),
        text if text.contains(':') => time_of_day(text).map(FlightTime::OfDay),
        text => length(text).map(FlightTime::Seconds),
    };
    time.ok_or_else(|| {
        "want a time after the first fix, such as 90s or 2m30s, one of the day, UTC, such as 14:05:30 or 16:05+02:00, departure or arrival".to_owned()
    })
}

/// `90`, `90s`, `2m30s`, `1h`, and `1:30`, minutes and seconds, or `1:02:30`.
fn length(text: &str) -> Option<f64> {
    if text.contains(':') {
        return sexagesimal(text);
    }

    let (mut rest, mut seconds) = (text, 0.0);
    for (unit, length) in [('h', 3600.0), ('m', 60.0)] {
        if let Some((number, behind)) = rest.split_once(unit) {
            seconds += length * plain(number)?;
            rest = behind;
        }
    }
    if rest.is_empty() && rest.len() < text.len() {
        return Some(seconds);
    }

    Some(seconds + plain(rest.strip_suffix('s').unwrap_or(rest))?)
}

/// `14:05`, hours and minutes, or `14:05:30.5`; `Z`, or an offset from UTC, may follow. Seconds after midnight, UTC.
fn time_of_day(text: &str) -> Option<f64> {
    let (clock, offset) = match text.strip_suffix(['Z', 'z']) {
        Some(clock) => (clock, 0.0),
        None => match text.rfind(['+', '-']) {
            Some(at) => {
                let offset = clock_seconds(&text[at + 1..])?;
                (&text[..at], if text[at..].starts_with('-') { -offset } else { offset })
            }
            None => (text, 0.0),
        },
    };
    Some(clock_seconds(clock)? - offset)
}

/// `HH:MM[:SS]` as seconds.
fn clock_seconds(text: &str) -> Option<f64> {
    let seconds = if text.matches(':').count() == 1 { 60.0 * sexagesimal(text)? } else { sexagesimal(text)? };
    (seconds < DAY).then_some(seconds)
}

/// Two or three numbers with colons between, the last one in units of 1, each but the first below 60.
fn sexagesimal(text: &str) -> Option<f64> {
    let parts: Vec<f64> = text.split(':').map(plain).collect::<Option<_>>()?;
    let is_sound = (2..=3).contains(&parts.len())
        && parts[1..].iter().all(|part| *part < 60.0)
        && parts[..parts.len() - 1].iter().all(|part| part.fract() == 0.0);
    is_sound.then(|| parts.iter().fold(0.0, |sum, part| 60.0 * sum + part))
}

/// A decimal number without sign or exponent.
fn plain(text: &str) -> Option<f64> {
    let is_plain = text.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    text.parse().ok().filter(|number: &f64| is_plain && number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_read_as_people_write_them() {
        for (text, seconds) in [
            ("90", 90.0),
            ("90s", 90.0),
            ("0.5", 0.5),
            ("2m30s", 150.0),
            ("2m", 120.0),
            ("1h2m3s", 3723.0),
            ("1.5h", 5400.0),
            ("1:30", 90.0),
            ("1:02:30.5", 3750.5),
        ] {
            assert_eq!(length(text), Some(seconds), "{text}");
        }
        for wrong in
            ["", "s", "m", "-5", "1e3", "2m30m", "1:60", "1:2:3:4", "1.5:30", "inf", "nan", "90x", "3s2m"]
        {
            assert_eq!(length(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn times_of_day_are_utc_unless_they_say_otherwise() {
        let of_day = |text: &str| flight_time(text).unwrap();
        for (text, seconds) in [
            ("14:05", 50_700.0),
            ("14:05:30Z", 50_730.0),
            ("16:05+02:00", 50_700.0),
            ("09:00:00-05:30", 52_200.0),
            ("00:30+02:00", -5400.0),
        ] {
            assert_eq!(of_day(text), FlightTime::OfDay(seconds), "{text}");
        }
        assert_eq!(of_day("150"), FlightTime::Seconds(150.0));
        for wrong in ["24:00", "12:", ":30", "12:30+", "12:30+25:00", "noon", "12:30:61", "1:2:3:4"] {
            assert!(flight_time(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn paces_have_an_x_or_none() {
        assert_eq!((speed("30x"), speed("0.5"), speed("2.5X")), (Ok(30.0), Ok(0.5), Ok(2.5)));
        for wrong in ["0", "0x", "-1x", "x", "", "1e9", "fast", "1/2", "inf"] {
            assert!(speed(wrong).is_err(), "{wrong}");
        }
        assert!(duration("0s").is_err() && duration("90s") == Ok(90.0));
    }

    #[test]
    fn only_what_departs_from_the_default_is_recorded() {
        let mut settings = json!({});
        PlaybackArgs { speed: Some(1.0), ..PlaybackArgs::default() }.record(&mut settings);
        assert_eq!(settings, json!({}));
        PlaybackArgs { duration: Some(90.0), from: Some(FlightTime::OfDay(60.0)), ..PlaybackArgs::default() }
            .record(&mut settings);
        assert_eq!(settings, json!({ "duration_s": 90.0, "from": { "seconds_of_day": 60.0 } }));
    }
}
