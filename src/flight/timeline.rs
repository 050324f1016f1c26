//! Time of a film: moments of a flight that its frames show.

use super::rate::FrameRate;
use super::raw::{CLOCK, DAY};
use hedgehop_base::error::{Error, Result};

/// A moment of a flight, as people name it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FlightTime {
    /// Seconds after the first fix.
    Seconds(f64),
    /// Seconds after midnight, UTC: the first such moment of the part of the flight that is asked about.
    OfDay(f64),
    /// Departure: the flight stands, or hardly moves, before it.
    Departure,
    /// Arrival: the flight stands, or hardly moves, after it.
    Arrival,
}

/// Pace at which a film passes over a flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pace {
    /// Seconds of flight in a second of the film, above 0.
    Speed(f64),
    /// Seconds that the whole film lasts, above 0.
    Duration(f64),
}

/// Part of a flight that is shown, and at what pace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Playback {
    /// Pace of the film.
    pub pace: Pace,
    /// Moment that it begins at; `None`: the first fix.
    pub from: Option<FlightTime>,
    /// Moment that it ends at, a time of day after its beginning; `None`: the last fix.
    pub to: Option<FlightTime>,
}

impl Default for Playback {
    /// All of a flight, as fast as it was flown.
    fn default() -> Self {
        Self { pace: Pace::Speed(1.0), from: None, to: None }
    }
}

/// Length of a flight, and when it began.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlightSpan {
    /// Time from the first fix to the last, seconds.
    pub duration: f64,
    /// Departure, seconds after the first fix.
    pub departure: f64,
    /// Arrival, seconds after the first fix.
    pub arrival: f64,
    /// Seconds after midnight, UTC, of the first fix, if the file tells the time.
    pub time_of_day: Option<f64>,
}

/// Frames of a film, each with its moment of the flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timeline {
    fps: FrameRate,
    /// Seconds of flight in a second of the film.
    speed: f64,
    /// Moment of the first frame, seconds after the first fix.
    from: f64,
    frame_count: u64,
}

impl Timeline {
    /// Lays frames over the part of a flight that a film shows. At a given speed the last frame is not later than that part's
    /// end; over a given duration there are as many as last so long.
    ///
    /// # Errors
    /// [`Error::Configuration`], if a moment lies outside the flight, its end before its beginning, or the file tells no time of day.
    pub fn new(fps: FrameRate, flight: FlightSpan, playback: &Playback) -> Result<Self> {
        let from = playback.from.map_or(Ok(0.0), |time| flight.seconds_of("--from", time, 0.0))?;
        let to = playback.to.map_or(Ok(flight.duration), |time| flight.seconds_of("--to", time, from))?;
        let length = to - from;
        if length < 0.0 {
            return Err(Error::Configuration(format!(
                "--to is {to:.1} s after the first fix, which is before --from, {from:.1} s after it"
            )));
        }

        match playback.pace {
            Pace::Speed(speed) => {
                let frame_count = frames_within(length / speed, fps.per_second());
                Ok(Self { fps, speed, from, frame_count })
            }
            Pace::Duration(seconds) => {
                if length == 0.0 {
                    return Err(Error::Configuration(
                        "--duration needs a flight that lasts; a single moment is one frame".into(),
                    ));
                }
                // A float converts saturating.
                let frame_count = ((seconds * fps.per_second()).round() as u64).max(1);
                Ok(Self { fps, speed: length / seconds, from, frame_count })
            }
        }
    }

    /// Lays out frames that show no flight: one after the other from the first moment on.
    pub fn of_views(fps: FrameRate, frame_count: u64) -> Self {
        Self { fps, speed: 1.0, from: 0.0, frame_count }
    }

    /// Number of frames, at least 1.
    pub fn frame_count(&self) -> u64 {
        self.frame_count
    }

    /// Moment of frame `number` (1 is the first), seconds after the first fix.
    pub fn seconds_at(&self, number: u64) -> f64 {
        self.from + self.speed * self.fps.seconds_at(number)
    }

    /// Moment of frame `number` in the film, seconds after its first frame.
    pub fn film_seconds_at(&self, number: u64) -> f64 {
        self.fps.seconds_at(number)
    }

    /// Moment of the film that shows a moment of the flight, seconds after the first frame; below 0: none does.
    pub fn film_seconds_of(&self, seconds: f64) -> f64 {
        (seconds - self.from) / self.speed
    }

    /// Moment of the flight at which the film ends, seconds after the first fix: an interval after its last frame.
    pub fn end(&self) -> f64 {
        self.from + self.speed * self.film_duration()
    }

    /// Length of the film, seconds, to the end of its last frame.
    pub fn film_duration(&self) -> f64 {
        self.frame_count as f64 / self.fps.per_second()
    }

    /// Seconds of flight in a second of the film.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Seconds of flight from one frame to the next.
    pub fn interval(&self) -> f64 {
        self.speed / self.fps.per_second()
    }
}

impl FlightSpan {
    /// Returns a moment as seconds after the first fix; `flag` names it. A time of day is the first one not before `earliest`, seconds.
    ///
    /// # Errors
    /// [`Error::Configuration`], if it lies outside the flight, or the file tells no time of day.
    pub fn seconds_of(&self, flag: &str, time: FlightTime, earliest: f64) -> Result<f64> {
        let seconds = match (time, self.time_of_day) {
            (FlightTime::Seconds(seconds), _) => seconds,
            (FlightTime::Departure, _) => self.departure,
            (FlightTime::Arrival, _) => self.arrival,
            (FlightTime::OfDay(of_day), Some(first)) => {
                earliest + (of_day - first - earliest).rem_euclid(DAY)
            }
            (FlightTime::OfDay(_), None) => {
                return Err(Error::Configuration(format!(
                    "{flag} is a time of day, and the path file tells none; give seconds after the first fix"
                )));
            }
        };

        if (0.0..=self.duration + CLOCK).contains(&seconds) {
            return Ok(seconds.min(self.duration));
        }
        let clock = self.time_of_day.map(|first| {
            // Whole seconds that lie within it.
            let [begin, end] = [first.ceil(), (first + self.duration).floor()];
            format!(
                ", from {} to {} UTC; 14:05+02:00 is one of another clock",
                time_of_day(begin),
                time_of_day(end)
            )
        });
        Err(Error::Configuration(format!(
            "{flag} lies outside the flight, which lasts {:.1} s{}",
            self.duration,
            clock.unwrap_or_default()
        )))
    }
}

/// Frames at a rate, above 0, that are not later than so many seconds after the first, up to the microsecond that clocks are
/// good to. At least 1.
pub(super) fn frames_within(seconds: f64, fps: f64) -> u64 {
    // A float converts saturating, NaN to 0.
    (((seconds + CLOCK) * fps) as u64).saturating_add(1)
}

/// Seconds after a midnight as `HH:MM:SS`.
fn time_of_day(seconds: f64) -> String {
    let seconds = seconds.rem_euclid(DAY) as u32;
    format!("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two hours from 22:59:30 UTC on.
    const FLIGHT: FlightSpan =
        FlightSpan { duration: 7200.0, departure: 600.0, arrival: 7000.0, time_of_day: Some(82_770.0) };

    fn film(fps: &str, playback: Playback) -> Result<Timeline> {
        Timeline::new(fps.parse().unwrap(), FLIGHT, &playback)
    }

    #[test]
    fn by_default_a_film_lasts_as_long_as_the_flight() {
        let rate: FrameRate = "29.97".parse().unwrap();
        let whole = film("29.97", Playback::default()).unwrap();
        assert_eq!(whole.frame_count(), frames_within(7200.0, rate.per_second()));
        for number in [1, 2, 1000, whole.frame_count()] {
            assert_eq!(whole.seconds_at(number), rate.seconds_at(number));
        }
        assert_eq!(whole.interval(), 1.0 / rate.per_second());
    }

    #[test]
    fn films_pass_as_fast_as_they_are_told() {
        let quick = film("30", Playback { pace: Pace::Speed(30.0), ..Playback::default() }).unwrap();
        assert_eq!((quick.frame_count(), quick.seconds_at(2), quick.seconds_at(7201)), (7201, 1.0, 7200.0));
        let slow = film("25", Playback { pace: Pace::Speed(0.5), ..Playback::default() }).unwrap();
        assert_eq!((slow.frame_count(), slow.seconds_at(26)), (360_001, 0.5));
    }

    #[test]
    fn films_last_as_long_as_they_are_told() {
        let film = film("60", Playback { pace: Pace::Duration(90.0), ..Playback::default() }).unwrap();
        assert_eq!((film.frame_count(), film.interval(), film.seconds_at(1)), (5400, 80.0 / 60.0, 0.0));
        assert!((film.seconds_at(5401) - 7200.0).abs() < 1e-9);
    }

    #[test]
    fn parts_are_named_by_seconds_and_by_the_clock() {
        let part = |from, to| film("1", Playback { from: Some(from), to: Some(to), ..Playback::default() });
        let seconds = part(FlightTime::Seconds(60.0), FlightTime::Seconds(120.0)).unwrap();
        assert_eq!((seconds.seconds_at(1), seconds.frame_count()), (60.0, 61));

        let moving = part(FlightTime::Departure, FlightTime::Arrival).unwrap();
        assert_eq!((moving.seconds_at(1), moving.frame_count()), (600.0, 6401));

        // 23:00:30, and half past midnight of the day after.
        let clock = part(FlightTime::OfDay(82_830.0), FlightTime::OfDay(1800.0)).unwrap();
        assert_eq!((clock.seconds_at(1), clock.frame_count()), (60.0, 5371));
    }

    #[test]
    fn times_of_day_are_found_after_fractions_of_seconds_and_midnights() {
        // Two days from 12:00:00.4 on.
        let flight = FlightSpan { duration: 172_800.0, time_of_day: Some(43_200.4), ..FLIGHT };
        let part = |from: f64, to: f64| {
            let [from, to] = [from, to].map(|hours| Some(FlightTime::OfDay(3600.0 * hours)));
            let playback = Playback { pace: Pace::Speed(3600.0), from, to };
            Timeline::new("1".parse().unwrap(), flight, &playback).unwrap()
        };
        let night = part(23.0, 11.0);
        assert!((night.seconds_at(1) - 39_599.6).abs() < 1e-6 && night.frame_count() == 13);
        let told =
            FlightSpan { duration: 5.0, ..flight }.seconds_of("--from", FlightTime::OfDay(43_200.0), 0.0);
        assert!(told.unwrap_err().to_string().contains("from 12:00:01 to 12:00:05 UTC"));
    }

    #[test]
    fn what_is_not_flown_is_refused() {
        let refused =
            |from, to| film("1", Playback { from, to, ..Playback::default() }).unwrap_err().to_string();
        let beyond = refused(Some(FlightTime::Seconds(7201.0)), None);
        assert!(beyond.contains("--from") && beyond.contains("from 22:59:30 to 00:59:30 UTC"), "{beyond}");
        assert!(refused(None, Some(FlightTime::OfDay(12.0 * 3600.0))).contains("--to lies outside"));
        let back = refused(Some(FlightTime::Seconds(9.0)), Some(FlightTime::Seconds(5.0)));
        assert!(back.contains("before --from"), "{back}");

        let flight = FlightSpan { duration: 9.0, time_of_day: None, ..FLIGHT };
        let playback = Playback { from: Some(FlightTime::OfDay(0.0)), ..Playback::default() };
        let said = Timeline::new("1".parse().unwrap(), flight, &playback).unwrap_err().to_string();
        assert!(said.contains("tells none"), "{said}");
        let still = FlightSpan { duration: 0.0, time_of_day: None, ..FLIGHT };
        let playback = Playback { pace: Pace::Duration(9.0), ..Playback::default() };
        assert!(Timeline::new("1".parse().unwrap(), still, &playback).is_err());
    }
}
