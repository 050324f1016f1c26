//! The part of a flight between its departure and its arrival: recordings begin and end with minutes at rest, or taxiing.

use glam::DVec3;

use super::spline::Spline;

/// Distance from the first fix, or the last one, that only what has left it comes to, metres.
const AWAY: f64 = 25.0;
/// Distance from it within which a flight has not left yet, metres; less than receivers of what stands drift in minutes.
const AT_REST: f64 = 10.0;

/// Share of a flight's speed below which it has not departed: an aeroplane taxies, a hiker stands.
const SLOW: f64 = 1.0 / 3.0;
/// Time over which speeds are taken, seconds, and most of them.
const STEP: f64 = 5.0;
const MOST_STEPS: f64 = 1.0e5;

/// Returns departure and arrival, seconds after the first fix; of a flight that stays where it is, its beginning and end.
///
/// Departure is the last fix within 10 m of the first one before the flight is 25 m from it. On the level it is later, five seconds before
/// it is first faster for ten seconds than a third of its speed, the upper quartile of all. Arrival is the same from the end.
pub(super) fn moving(path: &Spline) -> [f64; 2] {
    let times = path.times();
    let last = times.len() - 1;
    let places: Vec<DVec3> = times.iter().map(|time| path.position(*time)).collect();
    let departure = left(places.iter());
    let arrival = left(places.iter().rev()).map(|steps| last - steps);
    match (departure, arrival) {
        (Some(departure), Some(arrival)) if departure < arrival => {
            fast(path, [times[departure], times[arrival]])
        }
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

/// Narrows a part of a flight to what is not slow at its ends.
fn fast(path: &Spline, [from, to]: [f64; 2]) -> [f64; 2] {
    // A float converts saturating.
    let count = ((to - from) / STEP).clamp(2.0, MOST_STEPS) as usize;
    let step = (to - from) / count as f64;
    let moment = |index: usize| from + step * index as f64;
    let places: Vec<DVec3> = (0..=count).map(|index| path.position(moment(index))).collect();
    let speeds: Vec<f64> = places.windows(2).map(|pair| pair[1].distance(pair[0]) / step).collect();

    let mut sorted = speeds.clone();
    let (_, quartile, _) = sorted.select_nth_unstable_by(3 * count / 4, f64::total_cmp);
    let least = SLOW * *quartile;
    let is_fast = |index: &usize| speeds[*index].min(speeds[index + 1]) >= least;
    // A flight that climbs or sinks flies, however slow it is.
    let is_level = |index: &usize, end: usize| (places[*index].z - places[end].z).abs() <= AWAY;
    let pairs = 0..count - 1;
    let first = pairs.clone().find(|index| is_fast(index) || !is_level(index, 0));
    let last = pairs.rev().find(|index| is_fast(index) || !is_level(&(index + 2), count));
    match (first, last) {
        // The part begins a step before the first pair, and ends a step behind the last one.
        (Some(first), Some(last)) if first <= last => {
            [moment(first.saturating_sub(1)), moment((last + 3).min(count))]
        }
        _ => [from, to],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moving_along(place: impl Fn(f64) -> DVec3) -> [f64; 2] {
        let times: Vec<f64> = (0..=600).map(f64::from).collect();
        let places = times.iter().map(|time| place(*time)).collect();
        moving(&Spline::through(times, places))
    }

    /// Parked, with a drift of 6 m.
    fn drift(time: f64) -> DVec3 {
        DVec3::new(3.0 * (time / 20.0).sin(), 3.0 * (time / 31.0).cos(), 0.0)
    }

    #[test]
    fn minutes_on_the_ground_are_no_part_of_it() {
        // Parked for 100 s, at 5 m/s for 400 s, and parked.
        let flown = |time: f64| DVec3::new(5e5, 4e6 + 5.0 * (time - 100.0).clamp(0.0, 400.0), 200.0);
        let [departure, arrival] = moving_along(|time| flown(time) + drift(time));
        assert!((96.0..=103.0).contains(&departure), "{departure}");
        assert!((497.0..=504.0).contains(&arrival), "{arrival}");
    }

    #[test]
    fn neither_is_taxiing_or_waiting_at_the_runway() {
        // Parked, 150 s at 6 m/s, a wait of 50 s, 200 s at 50 m/s, and back at 6 m/s.
        let flown = |time: f64| {
            let taxied = 6.0 * (time - 50.0).clamp(0.0, 150.0);
            let back = 6.0 * (time - 450.0).clamp(0.0, 100.0);
            DVec3::new(5e5, 4e6 + taxied + 50.0 * (time - 250.0).clamp(0.0, 200.0) - back, 200.0)
        };
        let [departure, arrival] = moving_along(|time| flown(time) + drift(time));
        assert!((240.0..=251.0).contains(&departure), "{departure}");
        assert!((449.0..=460.0).contains(&arrival), "{arrival}");
    }

    #[test]
    fn a_slow_climb_is_flown() {
        // 50 s of rest, 100 s up at 3 m/s, and on at 40 m/s.
        let flown = |time: f64| {
            let up = 3.0 * (time - 50.0).clamp(0.0, 100.0);
            DVec3::new(40.0 * (time - 150.0).max(0.0), 0.0, up)
        };
        let [departure, arrival] = moving_along(flown);
        assert!((46.0..=62.0).contains(&departure) && arrival > 594.0, "{departure} {arrival}");
    }

    #[test]
    fn a_balloon_departs_upwards_and_rounds_end_where_they_begin() {
        let [departure, arrival] = moving_along(|time| DVec3::Z * 2.0 * (time - 50.0).clamp(0.0, 300.0));
        assert!(
            (46.0..=55.0).contains(&departure) && (345.0..=354.0).contains(&arrival),
            "{departure} {arrival}"
        );
        let round =
            moving_along(|time| 500.0 * DVec3::new((time / 95.4929).sin(), (time / 95.4929).cos(), 0.0));
        assert_eq!(round, [1.0, 599.0]);
    }

    #[test]
    fn what_stays_is_shown_whole() {
        assert_eq!(moving_along(|time| DVec3::new(9.0 * (time / 9.0).sin(), 0.0, 5.0)), [0.0, 600.0]);
        assert_eq!(moving(&Spline::through(vec![0.0], vec![DVec3::ONE])), [0.0, 0.0]);
        // From one place to another in a single step, and in several.
        let jump = |end: f64| moving(&Spline::through(vec![0.0, end], vec![DVec3::ZERO, 900.0 * DVec3::X]));
        assert_eq!((jump(1.0), jump(60.0)), ([0.0, 1.0], [0.0, 60.0]));
    }
}
