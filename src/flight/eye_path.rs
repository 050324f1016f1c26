//! Paths of eyes that follow a flight.
//!
//! ```text
//! m(t) = mean of the flight's places about t, over STEADY seconds of the film
//! p(t) = m(t), or between it and the flight, where that strays too far from m       (what the eye follows)
//! chase:  a rod of the rope's length is towed by m:  e ← m − rope · d,  d = (m − e) / |m − e|
//!         eye = p − back · d + side · right(d) + up
//! orbit:  eye = centre + radius · (sin β, cos β) + up,   β = β₀ + 360° · film seconds / period
//! ```
//!
//! Means are over the film's time, not the flight's: thirty times as fast, a glider that circles does not shake the
//! picture: it circles in it, within IN_VIEW of the middle. An eye draws back up to DRAWN_BACK times its distance for that,
//! and goes along with what is strayed beyond, turning no more than before. It runs straight behind, cuts wide turns a little,
//! and only swings in turns that are tighter than the rope (the tractrix of Huygens 1692).

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::aim::Subject;
use super::shot::{Chase, Orbit};
use super::spline::Spline;
use super::trajectory::Trajectory;

/// Time between two places of a path, seconds of the film, and least seconds of flight.
const STEP: f64 = 0.1;
const LEAST_STEP: f64 = 0.02;
/// Most places of a path.
const MOST_PLACES: f64 = 200_000.0;
/// Standard deviation of the mean over the flight's places, seconds of the film.
const STEADY: f64 = 0.5;
/// Shortest rope: metres, and seconds of the film at the flight's mean speed.
const ROPE: f64 = 5.0;
const LAG: f64 = 1.0;

/// Farthest that the flight is from the middle of the picture, in distances of the eye: 11°, clear of what is written at the borders.
const IN_VIEW: f64 = 0.2;
/// Distances from which an eye sees at most what strays from the middle.
const DRAWN_BACK: f64 = 2.0;

/// Angle between a rope and the way of what tows it from which on it is pushed, that before half a turn over which it ceases to turn, and the
/// least share of its turning there; radians.
const PUSHED: f64 = 2.0 * PI / 3.0;
const LAST: f64 = PI / 18.0;
const BIAS: f64 = 0.1;

/// Part of a flight that a shot shows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch {
    /// Beginning and end, seconds after the flight's first fix.
    pub begin: f64,
    pub end: f64,
    /// Seconds of flight in a second of the film, above 0.
    pub pace: f64,
}

/// A flight without what shakes it, at even times.
#[derive(Debug, Clone)]
pub(super) struct Steadied {
    /// Seconds after the flight's first fix, increasing; at least one.
    pub times: Vec<f64>,
    /// Places, metres.
    places: Vec<DVec3>,
    /// Places of the flight itself, metres.
    flown: Vec<DVec3>,
    /// Farthest that the flight strays from these about each time, metres; it changes gently.
    strays: Vec<f64>,
}

/// Way of an eye that follows, at the times of what it follows.
#[derive(Debug, Clone)]
pub(super) struct FollowingWay {
    /// Places of the eye, metres.
    pub eyes: Vec<DVec3>,
    /// Places in the middle of its picture, metres.
    pub middles: Vec<DVec3>,
    /// Level directions in which the rope leads, of length 1.
    pub ways: Vec<DVec2>,
}

/// Middle of a picture in which the flight stays.
#[derive(Debug, Clone, Copy)]
struct Middle {
    /// Place, metres.
    place: DVec3,
    /// Factor of the eye's distance, at least 1.
    farther: f64,
}

impl Steadied {
    /// Takes means of a flight's places over part of it.
    pub fn of(flight: &Trajectory, stretch: Stretch) -> Self {
        let length = stretch.end - stretch.begin;
        let wanted = length / (STEP * stretch.pace).max(LEAST_STEP);
        // A float converts saturating; an interval that is too short for a double to divide is one place.
        let count = if length < LEAST_STEP { 0 } else { wanted.ceil().clamp(1.0, MOST_PLACES) as i64 };
        let step = if count > 0 { length / count as f64 } else { 0.0 };
        let moment = |index: i64| stretch.begin + step * index as f64;

        // Three standard deviations to either side; beyond its ends the flight is turned about them, which neither circles nor runs away.
        let sigma = if step > 0.0 { STEADY * stretch.pace / step } else { 0.0 };
        let reach = (3.0 * sigma).ceil() as i64;
        let weights: Vec<f64> =
            (-reach..=reach).map(|index| (-0.5 * (index as f64 / sigma.max(1e-9)).powi(2)).exp()).collect();
        let sum: f64 = weights.iter().sum();
        let raw: Vec<DVec3> =
            (-reach..=count + reach).map(|index| continued(flight, moment(index))).collect();

        let mean = |window: &[DVec3]| {
            // About the first place, so that large coordinates lose nothing.
            let offsets = window.iter().zip(&weights).map(|(place, weight)| (*place - window[0]) * *weight);
            window[0] + offsets.sum::<DVec3>() / sum
        };
        let places: Vec<DVec3> = raw.windows(weights.len()).map(mean).collect();

        // The mean of a maximum over the same window is nowhere below what is strayed.
        let flown = raw[reach as usize..][..places.len()].to_vec();
        let strayed: Vec<f64> =
            flown.iter().zip(&places).map(|(flown, mean)| flown.distance(*mean)).collect();
        let farthest = over(&strayed, reach as usize, |window| window.iter().copied().fold(0.0, f64::max));
        let strays =
            over(&farthest, reach as usize, |window| window.iter().sum::<f64>() / window.len() as f64);
        Self { times: (0..=count).map(moment).collect(), places, flown, strays }
    }

    /// Returns the way of an eye that is towed; `heading` is the flight's at its beginning, degrees.
    pub fn chased(&self, chase: Chase, heading: f64, pace: f64) -> FollowingWay {
        let rope = self.rope(pace).max(chase.back.abs());
        let length = DVec3::new(chase.back, chase.side, chase.up).length();
        let ways = self.towed(heading, rope);
        let eye = |(middle, along): (Middle, &DVec2)| {
            let right = DVec2::new(along.y, -along.x);
            let offset = (chase.side * right - chase.back * *along).extend(chase.up);
            (middle.place + middle.farther * offset, middle.place)
        };
        let (eyes, middles) = self.middles(length).zip(&ways).map(eye).unzip();
        FollowingWay { eyes, middles, ways }
    }

    /// Returns what an eye at a distance, metres, follows at each time.
    fn middles(&self, distance: f64) -> impl Iterator<Item = Middle> {
        let middle = move |((mean, flown), strays): ((&DVec3, &DVec3), &f64)| {
            let farther = (strays / (IN_VIEW * distance)).clamp(1.0, DRAWN_BACK);
            let share = (IN_VIEW * farther * distance / strays.max(f64::MIN_POSITIVE)).min(1.0);
            Middle { place: flown.lerp(*mean, share), farther }
        };
        self.places.iter().zip(&self.flown).zip(&self.strays).map(middle)
    }

    /// Returns the level directions, of length 1, in which a rope leads to the places; `heading` is the flight's at its beginning, degrees.
    pub fn ways(&self, heading: f64, pace: f64) -> Vec<DVec2> {
        self.towed(heading, self.rope(pace))
    }

    /// Returns the level directions to where the flight will be a time later, seconds of flight, at least 0; the shorter that way is, the more
    /// they are those of [`Self::ways`]. `heading` is the flight's at its beginning, degrees.
    pub fn ways_ahead(&self, lead: f64, heading: f64, pace: f64) -> Vec<DVec2> {
        let path = Spline::through(self.times.clone(), self.places.clone());
        let rope = self.rope(pace);
        let ways = self.ways(heading, pace).into_iter().zip(&self.times).zip(&self.places);
        ways.map(|((way, time), place)| {
            // A spline stays where it ends.
            (way + (path.position(time + lead) - *place).truncate() / rope).normalize_or(way)
        })
        .collect()
    }

    /// Returns the level directions of a rope of a length, metres.
    fn towed(&self, heading: f64, rope: f64) -> Vec<DVec2> {
        let (sin, cos) = heading.to_radians().sin_cos();
        let mut before = self.places[0].truncate();
        let mut towed = before - rope * DVec2::new(sin, cos);
        let along = |place: &DVec3| {
            let place = place.truncate();
            let along = turned((place - towed).normalize_or(DVec2::Y), place - before, rope);
            before = place;
            towed = place - rope * along;
            along
        };
        self.places.iter().map(along).collect()
    }

    fn rope(&self, pace: f64) -> f64 {
        ROPE.max(LAG * pace * self.mean_speed())
    }

    /// Returns the way of an eye on a circle around `centre`, or around the flight; `heading` is the flight's at the beginning,
    /// where the eye is behind it, degrees.
    pub fn orbited(
        &self,
        orbit: Orbit,
        centre: Option<&dyn Subject>,
        heading: f64,
        pace: f64,
    ) -> FollowingWay {
        let around = |(time, middle): (&f64, Middle)| {
            let Middle { place, farther } = match centre {
                Some(centre) => Middle { place: centre.place_at(*time), farther: 1.0 },
                None => middle,
            };
            let turns = (time - self.times[0]) / pace / orbit.period;
            let (sin, cos) = (heading + 180.0 + 360.0 * turns.fract()).to_radians().sin_cos();
            (place + farther * DVec3::new(orbit.radius * sin, orbit.radius * cos, orbit.up), place)
        };
        let distance = orbit.radius.hypot(orbit.up);
        let (eyes, middles) = self.times.iter().zip(self.middles(distance)).map(around).unzip();
        FollowingWay { eyes, middles, ways: self.ways(heading, pace) }
    }

    /// Mean speed over ground, metres a second.
    fn mean_speed(&self) -> f64 {
        let way: f64 = self.places.windows(2).map(|pair| (pair[1] - pair[0]).truncate().length()).sum();
        let length = self.times[self.times.len() - 1] - self.times[0];
        if length > 0.0 { way / length } else { 0.0 }
    }
}

/// Turns the direction of a rope that is pushed back, on a way of metres, as fast as one that is pulled by a sharp angle: on its own it would stay
/// as it is for long, with what flies coming straight at the eye.
fn turned(along: DVec2, way: DVec2, rope: f64) -> DVec2 {
    let angle = along.angle_to(way);
    let pushed = angle.abs() - PUSHED;
    if way == DVec2::ZERO || pushed <= 0.0 {
        return along;
    }

    // All of it from PUSHED on, and evenly less over the last degrees before half a turn; exactly there it goes right.
    let share = ((PI - angle.abs()) / LAST).clamp(BIAS, 1.0);
    let missing = share * PUSHED.sin() - angle.abs().sin();
    let turn = missing.max(0.0) * way.length() / rope * if angle > 0.0 { 1.0 } else { -1.0 };
    DVec2::from_angle(turn).rotate(along)
}

/// Returns the place of a flight at any time, seconds; before its beginning and behind its end half a turn about these.
fn continued(flight: &Trajectory, seconds: f64) -> DVec3 {
    let end = seconds.clamp(0.0, flight.duration());
    let place = flight.position_at(end);
    let mirrored = flight.position_at(2.0 * end - seconds);
    if seconds == end { place } else { 2.0 * place - mirrored }
}

/// Values of a function of all values within `reach` places of each.
fn over(values: &[f64], reach: usize, of: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    let window = |index: usize| &values[index.saturating_sub(reach)..values.len().min(index + reach + 1)];
    (0..values.len()).map(|index| of(window(index))).collect()
}
