//! The part of a flight between its departure and its arrival: recordings begin and end with minutes on the ground.

use glam::DVec3;

use super::spline::Spline;

/// Distance from the first fix, or the last one, that only what has left it comes to, metres.
const AWAY: f64 = 25.0;
/// Distance from it within which a flight has not left yet, metres; less than receivers of what stands drift in minutes.
const AT_REST: f64 = 10.0;

/// Returns departure and arrival, seconds after the first fix; of a flight that stays where it is, its beginning and end.
///
/// Departure is the last fix within 10 m of the first one before the flight is 25 m from it; arrival is the same from the end.
pub(super) fn moving(path: &Spline) -> [f64; 2] {
    let times = path.times();
    let places: Vec<DVec3> = times.iter().map(|time| path.position(*time)).collect();
    let last = times.len() - 1;
    let departure = left(places.iter());
    let arrival = left(places.iter().rev()).map(|steps| last - steps);
    match (departure, arrival) {
        (Some(departure), Some(arrival)) if departure < arrival => [times[departure], times[arrival]],
        _ => [times[0], times[last]],
    }
}

/// Returns how many steps from the first place the last one is at which it is not left yet; `None`: it never is.
fn left<'p>(mut places: impl Iterator<Item = &'p DVec3>) -> Option<usize> {
    let first = *places.next()?;
    let mut rest = 0;
    for (place, step) in places.zip(1..) {
        let distance = place.distance(first);
        if distance > AWAY {
            return Some(rest);
        }
        if distance <= AT_REST {
            rest = step;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moving_along(place: impl Fn(f64) -> DVec3) -> [f64; 2] {
        let times: Vec<f64> = (0..=600).map(f64::from).collect();
        let places = times.iter().map(|time| place(*time)).collect();
        moving(&Spline::through(times, places))
    }

    #[test]
    fn minutes_on_the_ground_are_no_part_of_it() {
        // Parked for 100 s with a drift of 6 m, at 5 m/s for 400 s, and parked.
        let drift = |time: f64| DVec3::new(3.0 * (time / 20.0).sin(), 3.0 * (time / 31.0).cos(), 0.0);
        let flown = |time: f64| DVec3::new(5e5, 4e6 + 5.0 * (time - 100.0).clamp(0.0, 400.0), 200.0);
        let [departure, arrival] = moving_along(|time| flown(time) + drift(time));
        assert!((100.0..=103.0).contains(&departure), "{departure}");
        assert!((497.0..=500.0).contains(&arrival), "{arrival}");
    }

    #[test]
    fn a_balloon_departs_upwards_and_rounds_end_where_they_begin() {
        let up = moving_along(|time| DVec3::Z * 2.0 * (time - 50.0).clamp(0.0, 300.0));
        assert_eq!(up, [55.0, 345.0]);
        let round =
            moving_along(|time| 500.0 * DVec3::new((time / 95.4929).sin(), (time / 95.4929).cos(), 0.0));
        assert_eq!(round, [1.0, 599.0]);
    }

    #[test]
    fn what_stays_is_shown_whole() {
        assert_eq!(moving_along(|time| DVec3::new(9.0 * (time / 9.0).sin(), 0.0, 5.0)), [0.0, 600.0]);
        assert_eq!(moving(&Spline::through(vec![0.0], vec![DVec3::ONE])), [0.0, 0.0]);
        // From one place to another in a single step.
        let jump = moving(&Spline::through(vec![0.0, 60.0], vec![DVec3::ZERO, 900.0 * DVec3::X]));
        assert_eq!(jump, [0.0, 60.0]);
    }
}
