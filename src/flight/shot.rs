//! Shots of a film: which camera sees which part of a flight.

use std::ops::RangeInclusive;

use super::track::Track;

/// Part of a film that one camera sees.
#[derive(Debug, Clone, Default)]
pub struct Shot {
    /// Moment that it begins at, seconds after the flight's first fix; it ends where the next one begins.
    pub from: f64,
    /// Place of the eye.
    pub mount: Mount,
    /// Direction of the view; `None`: that of the mount.
    pub look: Option<Look>,
    /// Field of view, if it is the shot's own.
    pub zoom: Option<Zoom>,
}

/// Place of the eye in a shot.
#[derive(Debug, Clone, Default)]
pub enum Mount {
    /// Aboard what flies, looking along its nose.
    #[default]
    Aboard,
    /// Behind what flies, looking at it.
    Chase(Chase),
    /// On a circle around what the shot looks at, or else around what flies.
    Orbit(Orbit),
    /// On a path of its own, or in one place, looking as its keys say.
    Keys(Keys),
}

/// Offset of an eye that follows, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chase {
    /// Distance behind, along the ground; negative is before it.
    pub back: f64,
    /// Height above it.
    pub up: f64,
    /// Distance to the right.
    pub side: f64,
}

/// Circle of an eye around something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orbit {
    /// Radius, metres, above 0.
    pub radius: f64,
    /// Height above what it goes around, metres.
    pub up: f64,
    /// Seconds of the film that a turn takes: clockwise from above, or if negative the other way; not 0.
    pub period: f64,
}

/// Farthest that an eye is from what it follows, metres.
const FARTHEST: f64 = 1.0e6;

/// Seconds of the film that an orbit takes, unless it is told.
const TURN: f64 = 60.0;

/// Shortest and longest turn, seconds of the film.
const TURNS: RangeInclusive<f64> = 1.0..=1.0e7;

impl Chase {
    /// Reads `[back, up]` or `[back, up, side]`, metres; `None`: they say no place, or that of what flies.
    pub fn of(offsets: &[f64]) -> Option<Self> {
        let chase = match *offsets {
            [back, up] => Self { back, up, side: 0.0 },
            [back, up, side] => Self { back, up, side },
            _ => return None,
        };
        let is_near = offsets.iter().all(|offset| offset.abs() <= FARTHEST);
        (is_near && offsets.iter().any(|offset| *offset != 0.0)).then_some(chase)
    }
}

impl Orbit {
    /// Reads a radius and a height, metres, and the seconds of the film that a turn takes; `None`: they say no circle.
    pub fn of([radius, up]: [f64; 2], period: Option<f64>) -> Option<Self> {
        let period = period.unwrap_or(TURN);
        let is_circle = radius > 0.0 && radius <= FARTHEST && up.abs() <= FARTHEST;
        (is_circle && TURNS.contains(&period.abs())).then_some(Self { radius, up, period })
    }
}

/// Poses of an eye over time.
#[derive(Debug, Clone)]
pub struct Keys {
    /// Moment of the first key, seconds after the flight's first fix.
    pub start: f64,
    /// Keys as fixes, the first one at 0 s; all have yaw, pitch and roll.
    pub track: Track,
    /// Way from one key to the next.
    pub ease: Ease,
}

/// Way from one value to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ease {
    /// Evenly.
    #[default]
    None,
    /// Smoothly, from rest to rest.
    InOut,
}

impl Ease {
    /// Returns the share of the way at a share of the time, 0 to 1.
    pub(super) fn at(self, share: f64) -> f64 {
        match self {
            Self::None => share,
            Self::InOut => share * share * (3.0 - 2.0 * share),
        }
    }
}

/// Horizontal field of view over a shot, degrees, 0 < hfov < 180.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zoom {
    /// Field of view at its beginning.
    pub from: f64,
    /// Field of view at its end.
    pub to: f64,
    /// Way from one to the other.
    pub ease: Ease,
}

impl Zoom {
    /// Returns the field of view at a share of the shot, 0 to 1: things grow at an even rate.
    pub(super) fn at(self, share: f64) -> f64 {
        if self.from == self.to {
            return self.from;
        }
        let [from, to] = [self.from, self.to].map(|hfov| (0.5 * hfov).to_radians().tan().ln());
        let scale = (from + (to - from) * self.ease.at(share.clamp(0.0, 1.0))).exp();
        2.0 * scale.atan().to_degrees()
    }
}

/// Direction of the view in a shot.
#[derive(Debug, Clone)]
pub enum Look {
    /// Along the nose of what flies, or as keys say.
    Nose,
    /// Along the nose, but no higher than keeps the ground in sight; in quick films where the flight goes, level and steady.
    Lowered,
    /// The same heading, at a pitch of the view's own, degrees.
    Pitch(f64),
    /// Straight down, with the top of the picture where the nose points.
    Down,
    /// At the place of the flight so many seconds of the film later, ≥ 0, with a level horizon, but no higher than keeps the ground in sight.
    Ahead(f64),
    /// At a place: a track of one fix.
    Place(Track),
    /// At a place that moves: fixes from the shot's beginning on; it stays where the last one is.
    Moving(Track),
    /// At an object of the scene, by its name.
    Object(String),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zoom_doubles_sizes_in_equal_times() {
        let zoom = Zoom { from: 90.0, to: 2.0 * 0.25_f64.atan().to_degrees(), ease: Ease::None };
        let half = zoom.at(0.5);
        assert!((half - 2.0 * 0.5_f64.atan().to_degrees()).abs() < 1e-9, "{half}");
        assert!((zoom.at(-1.0) - 90.0).abs() < 1e-9 && (zoom.at(2.0) - zoom.to).abs() < 1e-9);
        assert_eq!(Zoom { from: 50.0, to: 50.0, ease: Ease::InOut }.at(0.3), 50.0);
    }

    #[test]
    fn eased_ways_begin_and_end_at_rest() {
        let speed = |share: f64| (Ease::InOut.at(share + 1e-6) - Ease::InOut.at(share)) / 1e-6;
        assert!(speed(0.0).abs() < 1e-5 && speed(1.0 - 1e-6).abs() < 1e-5 && (speed(0.5) - 1.5).abs() < 1e-5);
        assert_eq!((Ease::InOut.at(0.0), Ease::InOut.at(1.0), Ease::None.at(0.3)), (0.0, 1.0, 0.3));
    }
}
