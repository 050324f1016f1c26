//! A once differentiable curve through fixes at uneven times.
//!
//! Cubic Hermite pieces; the tangents make the difference.
//!
//! - *Horizontally*: the derivative of the parabola through three neighbours (Catmull and Rom 1974, for uneven times),
//!   never longer than three times the slower of the two chords. That bound is Fritsch and Carlson's, applied to the
//!   vector's length so that it does not depend on where north is; it keeps the eye in place where two fixes are equal.
//! - *Vertically*: Fritsch and Butland 1984 (the weighted harmonic mean of the two slopes, 0 at an extremum). Between two
//!   fixes the height then stays between theirs: a spline that overshoots would dip into the hill that the flight has
//!   just cleared.
//!
//! A corner between coarse fixes is no sample of a curve: its tangent, which points to neither side, would make the path
//! swing out by a share of intervals that last long. There the path follows the chords but for [`ROUNDING`] before and
//! after the corner, which it swings out by 2/27 of the way flown in that time.

use glam::{DVec2, DVec3};

/// Cosine of the turn from which on a fix is a corner: 60°, of a circle of six fixes.
const CORNER: f64 = 0.5;
/// Intervals of coarse fixes, seconds, on both sides of a corner.
const COARSE: f64 = 10.0;
/// Seconds before and after a corner within which the path turns, less than half of [`COARSE`].
const ROUNDING: f64 = 3.0;

#[derive(Debug, Clone)]
pub(super) struct Spline {
    /// Times of the fixes, seconds, increasing.
    times: Vec<f64>,
    /// Times of the ends of pieces: those of the fixes, and some more where corners are rounded.
    knots: Vec<f64>,
    points: Vec<DVec3>,
    /// Metres per second.
    tangents: Vec<DVec3>,
}

/// Straight line from one fix to the next.
#[derive(Debug, Clone, Copy)]
struct Chord {
    /// Seconds between the two.
    step: f64,
    /// Metres per second.
    slope: DVec3,
}

/// End of a piece.
struct Knot {
    /// Seconds.
    time: f64,
    /// Metres.
    point: DVec3,
    /// Metres per second.
    tangent: DVec3,
}

impl Spline {
    /// `times` strictly increase and are as many as `points`; at least one.
    pub fn through(times: Vec<f64>, points: Vec<DVec3>) -> Self {
        let chord = |end: usize| {
            let step = times[end] - times[end - 1];
            Chord { step, slope: (points[end] - points[end - 1]) / step }
        };
        let chords: Vec<Chord> = (1..points.len()).map(chord).collect();
        let tangents = (0..points.len()).map(|index| tangent(index, &chords)).collect();
        let mut spline = Self { knots: times.clone(), times, points, tangents };
        if (1..chords.len()).any(|index| is_corner(chords[index - 1], chords[index])) {
            spline.round_corners(&chords);
        }
        spline
    }

    /// Leads the path along its chords to corners, which it turns round in a few seconds. Heights stay as they are.
    fn round_corners(&mut self, chords: &[Chord]) {
        let mut rounded =
            Self { knots: Vec::new(), points: Vec::new(), tangents: Vec::new(), ..self.clone() };
        let is_corner =
            |index: usize| (1..chords.len()).contains(&index) && is_corner(chords[index - 1], chords[index]);
        let beside = |index: usize, chord: Chord, seconds: f64| {
            let time = self.times[index] + seconds;
            let place = self.points[index].truncate() + seconds * chord.slope.truncate();
            let [height, climb] = [self.position(time).z, self.velocity(time).z];
            Knot { time, point: place.extend(height), tangent: chord.slope.truncate().extend(climb) }
        };

        for (index, time) in self.times.iter().copied().enumerate() {
            let mut knot = Knot { time, point: self.points[index], tangent: self.tangents[index] };
            if is_corner(index) {
                let (before, after) = (chords[index - 1], chords[index]);
                let [from, to] = [before.slope.truncate(), after.slope.truncate()];
                knot.tangent = bounded(0.5 * (from + to), from, to).extend(knot.tangent.z);
                rounded.push(beside(index, before, -ROUNDING));
                rounded.push(knot);
                rounded.push(beside(index, after, ROUNDING));
                continue;
            }

            // At an end there is no other neighbour than the corner, which tells nothing of the direction there.
            let only = match index {
                0 if is_corner(1) => chords.first(),
                _ if index == chords.len() && is_corner(index - 1) => chords.last(),
                _ => None,
            };
            knot.tangent = only.map_or(knot.tangent, |chord| chord.slope.truncate().extend(knot.tangent.z));
            rounded.push(knot);
        }

        *self = rounded;
    }

    fn push(&mut self, knot: Knot) {
        self.knots.push(knot.time);
        self.points.push(knot.point);
        self.tangents.push(knot.tangent);
    }

    /// Times of the fixes, seconds.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    pub fn duration(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// Metres; before the first and after the last fix the eye rests there.
    pub fn position(&self, seconds: f64) -> DVec3 {
        let Some((index, step, u)) = self.locate(seconds) else { return self.points[0] };
        let (a, b) = (self.points[index], self.points[index + 1]);
        let (m, n) = (self.tangents[index] * step, self.tangents[index + 1] * step);
        // Hermite in the form a + …, so that large coordinates lose nothing where a = b.
        let rise = b - a;
        a + u * (m + u * ((3.0 * rise - 2.0 * m - n) + u * (m + n - 2.0 * rise)))
    }

    /// Metres per second.
    pub fn velocity(&self, seconds: f64) -> DVec3 {
        let Some((index, step, u)) = self.locate(seconds) else { return DVec3::ZERO };
        let rise = self.points[index + 1] - self.points[index];
        let (m, n) = (self.tangents[index] * step, self.tangents[index + 1] * step);
        (m + u * (2.0 * (3.0 * rise - 2.0 * m - n) + u * 3.0 * (m + n - 2.0 * rise))) / step
    }

    /// Piece, its length in seconds and the place in it (0…1); `None` if there is only one fix.
    fn locate(&self, seconds: f64) -> Option<(usize, f64, f64)> {
        let last_piece = self.knots.len().checked_sub(2)?;
        let index = self.knots.partition_point(|&time| time <= seconds).saturating_sub(1).min(last_piece);
        let step = self.knots[index + 1] - self.knots[index];
        Some((index, step, ((seconds - self.knots[index]) / step).clamp(0.0, 1.0)))
    }
}

/// Returns whether the flight turns sharply at a fix between two chords that are coarse.
fn is_corner(before: Chord, after: Chord) -> bool {
    let [from, to] = [before.slope.truncate(), after.slope.truncate()];
    before.step.min(after.step) >= COARSE && from.dot(to) < CORNER * from.length() * to.length()
}

fn tangent(index: usize, chords: &[Chord]) -> DVec3 {
    match (index.checked_sub(1).map(|before| chords[before]), chords.get(index).copied()) {
        (None, None) => DVec3::ZERO,
        (None, Some(first)) => end_tangent(first, chords.get(1).copied()),
        (Some(last), None) => end_tangent(last, index.checked_sub(2).map(|inner| chords[inner])),
        (Some(before), Some(after)) => {
            let weight = before.step / (before.step + after.step);
            let parabola = before.slope.truncate().lerp(after.slope.truncate(), weight);
            bounded(parabola, before.slope.truncate(), after.slope.truncate())
                .extend(harmonic_slope(before, after))
        }
    }
}

/// At an end: the parabola through the three last fixes, or the chord if there are but two.
fn end_tangent(outer: Chord, inner: Option<Chord>) -> DVec3 {
    let Chord { step, slope: chord } = outer;
    let Some(inner) = inner else { return chord };
    let parabola = chord + (chord - inner.slope) * (step / (step + inner.step));
    let climb = if parabola.z * chord.z <= 0.0 { 0.0 } else { parabola.z.abs().min(3.0 * chord.z.abs()) };
    bounded(parabola.truncate(), chord.truncate(), chord.truncate()).extend(climb.copysign(chord.z))
}

fn bounded(tangent: DVec2, before: DVec2, after: DVec2) -> DVec2 {
    tangent.clamp_length_max(3.0 * before.length().min(after.length()))
}

/// Returns the weighted harmonic mean of the vertical slopes of two chords, 0 at an extremum.
fn harmonic_slope(before: Chord, after: Chord) -> f64 {
    let [slope_before, slope_after] = [before.slope.z, after.slope.z];
    if slope_before * slope_after <= 0.0 {
        return 0.0;
    }
    let weight_before = 2.0 * after.step + before.step;
    let weight_after = 2.0 * before.step + after.step;
    (weight_before + weight_after) / (weight_before / slope_before + weight_after / slope_after)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(fixes: &[(f64, DVec3)]) -> Spline {
        Spline::through(fixes.iter().map(|fix| fix.0).collect(), fixes.iter().map(|fix| fix.1).collect())
    }

    #[test]
    fn passes_through_fixes_and_is_straight_on_a_line() {
        let line = |t: f64| DVec3::new(5e5 + 40.0 * t, 4e6 - 30.0 * t, 100.0 + 2.0 * t);
        let times = [0.0, 1.0, 1.5, 4.0, 9.0];
        let spline = curve(&times.map(|t| (t, line(t))));
        for step in 0..=90 {
            let t = f64::from(step) / 10.0;
            assert!((spline.position(t) - line(t)).length() < 1e-6, "at {t}");
            assert!((spline.velocity(t) - DVec3::new(40.0, -30.0, 2.0)).length() < 1e-6, "at {t}");
        }
    }

    #[test]
    fn velocity_is_the_derivative_and_continuous() {
        let spline = curve(
            &[0.0, 1.0, 1.2, 3.0, 7.0, 8.0]
                .map(|t: f64| (t, DVec3::new(50.0 * t.sin(), 30.0 * t, 10.0 * (1.7 * t).cos()))),
        );
        let h = 1e-6;
        for step in 1..80 {
            let t = 0.1 * f64::from(step) + 0.013;
            if t + h >= spline.duration() {
                break;
            }
            let numeric = (spline.position(t + h) - spline.position(t - h)) / (2.0 * h);
            assert!((numeric - spline.velocity(t)).length() < 1e-4, "at {t}");
        }
        for knot in [1.0, 1.2, 3.0, 7.0] {
            assert!((spline.velocity(knot - 1e-9) - spline.velocity(knot + 1e-9)).length() < 1e-4);
        }
    }

    #[test]
    fn height_never_leaves_the_range_of_its_two_fixes() {
        let heights = [100.0, 100.0, 300.0, 300.0, 120.0, 125.0, 90.0];
        let fixes: Vec<_> = heights
            .iter()
            .enumerate()
            .map(|(i, &z)| (i as f64 * 2.0, DVec3::new(i as f64, 0.0, z)))
            .collect();
        let spline = curve(&fixes);
        for (pair, k) in heights.windows(2).zip(0..) {
            for step in 0..=20 {
                let z = spline.position(2.0 * f64::from(k) + 0.1 * f64::from(step)).z;
                assert!(
                    z >= pair[0].min(pair[1]) - 1e-9 && z <= pair[0].max(pair[1]) + 1e-9,
                    "{z} of {pair:?}"
                );
            }
        }
    }

    #[test]
    fn rests_where_two_fixes_are_equal() {
        let stop = DVec3::new(100.0, 0.0, 10.0);
        let spline = curve(&[
            (0.0, DVec3::new(0.0, 0.0, 10.0)),
            (1.0, DVec3::new(50.0, 10.0, 10.0)),
            (2.0, stop),
            (60.0, stop),
            (61.0, DVec3::new(150.0, 50.0, 10.0)),
        ]);
        for t in [2.0, 10.0, 59.9] {
            assert_eq!(spline.position(t), stop);
        }
    }

    /// Legs of 300 m each way in 30 s, with fixes along them or none.
    #[test]
    fn corners_of_coarse_fixes_are_not_swung_out_of() {
        for legs in [1, 2, 3] {
            for turn in [70.0_f64, 90.0, 135.0, 180.0] {
                let [sine, cosine] = [turn.to_radians().sin(), turn.to_radians().cos()];
                let place = |leg: i32| {
                    let way = 300.0 * f64::from(leg.abs());
                    if leg < 0 {
                        DVec3::new(-way, 0.0, 90.0)
                    } else {
                        DVec3::new(way * cosine, way * sine, 90.0)
                    }
                };
                let spline: Vec<(f64, DVec3)> =
                    (-legs..=legs).map(|leg| (30.0 * f64::from(leg + legs), place(leg))).collect();
                let spline = curve(&spline);
                for step in 0..=600 * legs {
                    let at = spline.position(0.1 * f64::from(step));
                    // How far right of the first leg, and of the line of the second.
                    let out = [-at.y, at.x * sine - at.y * cosine];
                    let most = if turn == 180.0 { 1e-9 } else { 2.3 };
                    assert!(
                        out.iter().all(|out| *out < most),
                        "{out:?} m at step {step} of {turn}°, {legs} legs"
                    );
                }
                let corner = 30.0 * f64::from(legs);
                assert_eq!(spline.position(corner), DVec3::new(0.0, 0.0, 90.0));
                assert_eq!(spline.times().len() as i32, 2 * legs + 1);
                let before = spline.velocity(corner - 5.0);
                assert!((before - DVec3::new(10.0, 0.0, 0.0)).length() < 1e-9, "{before}");
            }
        }
    }

    /// Circles and dense corners are curves, as before.
    #[test]
    fn turns_stay_curves() {
        let circle = |count: u32, interval: f64| {
            let at = |fix: u32| {
                let angle = std::f64::consts::TAU * f64::from(fix) / f64::from(count);
                (interval * f64::from(fix), DVec3::new(300.0 * angle.cos(), 300.0 * angle.sin(), 0.0))
            };
            curve(&(0..2 * count).map(at).collect::<Vec<_>>())
        };
        for (count, interval) in [(8, 15.0), (7, 30.0), (4, 5.0)] {
            let spline = circle(count, interval);
            assert_eq!(spline.knots.len(), spline.times.len());
        }
        assert!(circle(5, 10.0).knots.len() > 10);
    }

    #[test]
    fn a_single_fix_stands_still() {
        let spline = curve(&[(0.0, DVec3::ONE)]);
        assert_eq!(spline.position(5.0), DVec3::ONE);
        assert_eq!(spline.velocity(5.0), DVec3::ZERO);
    }
}
