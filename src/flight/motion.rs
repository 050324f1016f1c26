//! Attitude from the smoothed motion, for what the file does not give.
//!
//! ```text
//! v̄(t) = Σ w(u) v(t+u),  ā(t) = Σ w(u) u v(t+u) / Σ w(u) u²,  s̄(t) = Σ w(u) |v(t+u)|     u = −3σ … 3σ, w Gaussian
//! heading = direction of v̄, horizontally
//! pitch   = atan(climb / ground speed), within ±45°
//! bank    = atan(s̄·ω / g), within ±60°, with the turn rate ω = (ā across v̄) / |v̄|
//! ```
//!
//! The bank is that of a coordinated turn (no side force; e.g. Etkin 1972, section 10.4). v is the derivative of the
//! spline, ā the derivative of v̄. σ is two fix intervals, at least half a second and at most three: it takes away what a
//! receiver errs and what the spline bends at fixes. Smoothing shortens v̄ and ā in a turn, both by exp(−ω²σ²/2); ω does
//! not suffer, and s̄ is not shortened, so that a steady turn has its full bank. Beyond the ends v is continued as
//! v(end+s) = 2 v(end) − v(end−s).
//!
//! At a standstill there is no direction: heading is held, from the stretch of motion that is nearest in time, and halfway
//! between two of them it turns from one to the other. Pitch and bank fade out with speed.

use glam::{DVec2, DVec3};

use super::angles::short_way;
use super::spline::Spline;

/// Standard gravity, m/s².
const GRAVITY: f64 = 9.806_65;
/// Slower than this, in m/s, is a standstill; or than a tenth of the top speed, where that is less.
const STANDSTILL: f64 = 0.5;
const SIGMA_RANGE: (f64, f64) = (0.5, 3.0);
const PITCH_LIMIT: f64 = 45.0;
const BANK_LIMIT: f64 = 60.0;
/// Most that s̄ may exceed |v̄|: it does without limit where the flight turns back on the spot.
const SHORTENING_LIMIT: f64 = 1.5;
/// Seconds that a held heading takes to turn into the next one.
const TURN: f64 = 4.0;
/// Points of the window on each side of its centre, four per σ.
const HALF_WINDOW: i32 = 12;
const POINTS_PER_SIGMA: f64 = 4.0;

/// A time without motion, and the headings (radians) at its ends.
#[derive(Debug, Clone, Copy)]
struct Hold {
    start: f64,
    end: f64,
    from: f64,
    to: f64,
}

/// Speed over ground at a time.
#[derive(Debug, Clone, Copy)]
struct SpeedSample {
    /// Seconds.
    time: f64,
    /// Metres per second.
    speed: f64,
}

/// The smoothed motion along a spline.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    sigma: f64,
    /// m/s
    standstill: f64,
    holds: Vec<Hold>,
    /// The path moves horizontally at some time.
    pub moves: bool,
}

/// Velocity around a time.
#[derive(Debug, Clone, Copy)]
struct Smoothed {
    /// m/s
    velocity: DVec3,
    /// m/s²
    acceleration: DVec3,
    /// Mean of the horizontal speed, m/s: not less than that of the mean velocity.
    mean_speed: f64,
}

impl Smoothed {
    fn ground_speed(&self) -> f64 {
        self.velocity.truncate().length()
    }

    /// Clockwise from north, radians.
    fn direction(&self) -> f64 {
        self.velocity.x.atan2(self.velocity.y)
    }
}

/// Angles derived from motion, degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Derived {
    pub heading: f64,
    pub pitch: f64,
    pub bank: f64,
}

impl Motion {
    /// `times` are those of the fixes, `interval` their median interval, seconds.
    pub fn along(spline: &Spline, times: &[f64], interval: f64) -> Self {
        let sigma = (2.0 * interval).clamp(SIGMA_RANGE.0, SIGMA_RANGE.1);
        let mut motion = Self { sigma, standstill: 0.0, holds: Vec::new(), moves: false };
        let speeds: Vec<SpeedSample> = scan_times(times, sigma)
            .map(|time| SpeedSample { time, speed: motion.smoothed(spline, time).ground_speed() })
            .collect();
        let top = speeds.iter().fold(0.0_f64, |top, sample| top.max(sample.speed));
        motion.moves = top > 0.0;
        motion.standstill = STANDSTILL.min(0.1 * top);
        motion.holds = motion.find_holds(spline, &speeds);
        motion
    }

    /// σ of the window, seconds.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    pub fn at(&self, spline: &Spline, seconds: f64) -> Derived {
        let motion = self.smoothed(spline, seconds);
        let speed = motion.ground_speed();
        let heading = self.held(seconds).unwrap_or_else(|| motion.direction()).to_degrees().rem_euclid(360.0);
        if speed == 0.0 {
            return Derived { heading, pitch: 0.0, bank: 0.0 };
        }
        let fade = (speed / self.standstill).min(1.0);
        let right = DVec2::new(motion.velocity.y, -motion.velocity.x) / speed;
        let across =
            motion.acceleration.truncate().dot(right) * (motion.mean_speed / speed).min(SHORTENING_LIMIT);
        let climb = motion.velocity.z.atan2(speed).to_degrees();
        let bank = across.atan2(GRAVITY).to_degrees();
        Derived {
            heading,
            pitch: fade * climb.clamp(-PITCH_LIMIT, PITCH_LIMIT),
            bank: fade * bank.clamp(-BANK_LIMIT, BANK_LIMIT),
        }
    }

    fn smoothed(&self, spline: &Spline, seconds: f64) -> Smoothed {
        let (mut weights, mut square) = (0.0, 0.0);
        let mut sums = Smoothed { velocity: DVec3::ZERO, acceleration: DVec3::ZERO, mean_speed: 0.0 };
        for point in -HALF_WINDOW..=HALF_WINDOW {
            let u = f64::from(point) / POINTS_PER_SIGMA;
            let weight = (-0.5 * u * u).exp();
            let here = continued_velocity(spline, seconds + u * self.sigma);
            weights += weight;
            square += weight * u * u;
            sums.velocity += weight * here;
            sums.acceleration += weight * u * here;
            sums.mean_speed += weight * here.truncate().length();
        }
        Smoothed {
            velocity: sums.velocity / weights,
            acceleration: sums.acceleration / (square * self.sigma),
            mean_speed: sums.mean_speed / weights,
        }
    }

    fn find_holds(&self, spline: &Spline, speeds: &[SpeedSample]) -> Vec<Hold> {
        let mut holds = Vec::new();
        let heading = |time: f64| self.smoothed(spline, time).direction();
        let moving = |speed: f64| speed > 0.0 && speed >= self.standstill;
        let mut before: Option<f64> = None; // last time in motion
        let mut still = false;

        for &SpeedSample { time, speed } in speeds {
            if !moving(speed) {
                still = true;
                continue;
            }

            if still {
                let to = heading(time);
                let from = before.map_or(to, heading);
                let start = before.unwrap_or(f64::NEG_INFINITY);
                holds.push(Hold { start, end: time, from, to });
                still = false;
            }

            before = Some(time);
        }

        if let (true, Some(last)) = (still, before) {
            let held = heading(last);
            holds.push(Hold { start: last, end: f64::INFINITY, from: held, to: held });
        }

        holds
    }

    /// Heading in radians if `seconds` lies in a standstill.
    fn held(&self, seconds: f64) -> Option<f64> {
        let index = self.holds.partition_point(|hold| hold.end <= seconds);
        let hold = self.holds.get(index).filter(|hold| hold.start < seconds)?;
        let turn = short_way((hold.to - hold.from).to_degrees()).to_radians();
        if turn == 0.0 {
            return Some(hold.from); // also the holds without end
        }
        let middle = 0.5 * (hold.start + hold.end);
        let u = ((seconds - middle) / TURN.min(hold.end - hold.start) + 0.5).clamp(0.0, 1.0);
        Some(hold.from + turn * u * u * (3.0 - 2.0 * u))
    }
}

fn continued_velocity(spline: &Spline, seconds: f64) -> DVec3 {
    let inside = seconds.clamp(0.0, spline.duration());
    if inside == seconds {
        return spline.velocity(seconds);
    }
    2.0 * spline.velocity(inside) - spline.velocity(2.0 * inside - seconds)
}

/// The fixes, and times between them at most half a σ apart (coarser in long gaps).
fn scan_times(times: &[f64], sigma: f64) -> impl Iterator<Item = f64> {
    const MOST_PER_GAP: f64 = 32.0;
    let between = times.windows(2).flat_map(move |pair| {
        let (start, step) = (pair[0], pair[1] - pair[0]);
        let parts = (2.0 * step / sigma).ceil().clamp(1.0, MOST_PER_GAP) as u32;
        (0..parts).map(move |part| start + step * f64::from(part) / f64::from(parts))
    });
    between.chain(times.last().copied())
}
