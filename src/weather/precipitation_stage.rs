//! Rain and snow close to the eye: drops and flakes as streaks.
//!
//! ```text
//! each of some thousand points, strewn over a cube about the eye that repeats without end:
//!     falls, goes with the wind, and comes in on one side of the cube as it leaves it on the other
//!     streak: from where it was, as the eye saw it, to where it is after a part of a frame's time
//!     each pixel of the streak: some of the sky's light before what is behind, if that is farther away
//! ```
//!
//! Points stand in the world, not on the screen: they come towards an eye that flies, the faster the nearer they are. What falls farther away
//! than the cube is haze (see `Precipitation::visibility`).

use glam::{DVec3, Vec2, Vec3};

use crate::pixels::Pixels;
use crate::space::{Camera, Screen};
use crate::weather::{Precipitation, PrecipitationKind};

/// Half a side of the cube, metres.
const HALF: f64 = 12.0;

/// Range under which nothing is drawn, metres: it would be on the lens.
const NEAREST: f64 = 0.6;

/// Time over which a streak is drawn, seconds: a sixtieth, as eyes and cameras hold it.
const TIME: f64 = 1.0 / 60.0;

/// Longest streak, pixels for each of the screen's rows.
const LONGEST: f32 = 0.5;

/// Streaks that are too faint to be seen, as a share of the pixel's light.
const UNSEEN: f32 = 0.004;

/// Nature of drops and flakes.
struct Nature {
    /// Points in the cube, for 1 mm/h, and the power by which there are more of them if more falls.
    count: f64,
    power: f64,
    /// Speed of falling, metres per second, and how much that differs.
    speed: [f64; 2],
    /// Width of one, metres.
    width: f64,
    /// Share of a pixel's light that they take where they cover it.
    share: f32,
    most: usize,
}

const RAIN: Nature =
    Nature { count: 5000.0, power: 0.5, speed: [7.0, 2.0], width: 0.0025, share: 0.45, most: 60_000 };
const SNOW: Nature =
    Nature { count: 6000.0, power: 0.7, speed: [1.1, 0.5], width: 0.007, share: 0.85, most: 40_000 };

/// A point as the screen shows it.
#[derive(Debug, Clone, Copy)]
struct Streak {
    from: Vec2,
    to: Vec2,
    /// Half its width, pixels, and the share of light that it takes.
    half: f32,
    share: f32,
    range: f32,
}

/// Precipitation before a screen.
#[derive(Debug)]
pub struct PrecipitationStage {
    streaks: Vec<Streak>,
    /// Light that it sends, linear Rec. 709.
    light: Vec3,
    width: usize,
}

impl PrecipitationStage {
    /// Makes `falls` fall before `camera`, which moves at `velocity` metres per second (x east, y north, z up), so many `seconds` into a flight, and sends `light`. `None` on
    /// orthographic screens, which have no eye.
    pub fn new(
        falls: &Precipitation,
        camera: &Camera,
        velocity: DVec3,
        seconds: f64,
        light: Vec3,
    ) -> Option<Self> {
        if let Screen::Orthographic { .. } = camera.screen() {
            return None;
        }
        let nature = match falls.kind {
            PrecipitationKind::Rain => RAIN,
            PrecipitationKind::Snow => SNOW,
        };
        let count = (nature.count * falls.rate.powf(nature.power)) as usize;
        let streak = |number: usize| nature.streak(falls, camera, velocity, seconds, number as u64);
        let streaks = (0..count.min(nature.most)).filter_map(streak).collect();
        Some(Self { streaks, light, width: camera.width as usize })
    }

    /// Adds it to pixels whose first row is the screen's row `first`; `range` of the same pixels is metres.
    pub fn add(&self, first: usize, mut pixels: Pixels<'_>, range: &[f32]) {
        let rows = range.len() / self.width;
        for streak in &self.streaks {
            streak.cover([first, first + rows], self.width, |column, row, share| {
                let pixel = (row - first) * self.width + column;
                if range[pixel] > streak.range {
                    let light = pixels.light(pixel);
                    pixels.put(pixel, light.lerp(self.light, share));
                }
            });
        }
    }
}

impl Nature {
    fn streak(
        &self,
        falls: &Precipitation,
        camera: &Camera,
        velocity: DVec3,
        seconds: f64,
        number: u64,
    ) -> Option<Streak> {
        let random = |part: u64| hedgehop_base::chance::unit(8 * number + part);
        let speed = self.speed[0] + self.speed[1] * (2.0 * random(3) - 1.0);
        let moves = DVec3::new(falls.wind[0], falls.wind[1], -speed);
        let side = 2.0 * HALF;
        let start = DVec3::new(random(0), random(1), random(2)) * side;
        let eye = camera.pose.eye;
        let place = (start + moves * seconds - eye).rem_euclid(DVec3::splat(side)) - HALF;
        let range = place.length();
        if !(NEAREST..=HALF).contains(&range) {
            return None;
        }

        let before = place - (moves - velocity) * TIME;
        let [to, from] = [place, before].map(|at| camera.screen_from_world(eye + at));
        let (to, from) = (to?.as_vec2(), from?.as_vec2());
        let longest = LONGEST * camera.height as f32;
        if !(to - from).is_finite() || (to - from).length() > longest {
            return None;
        }

        let width = (self.width / (range * camera.pixel_angle())) as f32;
        // Thinner than a pixel, it covers a part of it; at the cube's sides it comes and goes unseen.
        let fades = (1.0 - (range / HALF).powi(2)) as f32;
        let share = self.share * width.min(1.0) * fades;

        (share > UNSEEN).then_some(Streak {
            from,
            to,
            half: 0.5 * width.max(1.0),
            share,
            range: range as f32,
        })
    }
}

impl Streak {
    /// Tells `put` the pixels of some rows that it covers, and how much of their light it takes.
    fn cover(&self, [first, end]: [usize; 2], width: usize, mut put: impl FnMut(usize, usize, f32)) {
        let reach = self.half + 0.5;
        let (along, low) = (self.to - self.from, self.from.y.min(self.to.y));
        let high = self.from.y.max(self.to.y);

        // Floats convert saturating.
        let top = ((low - reach).max(first as f32) as usize).max(first);
        let bottom = ((high + reach).ceil().max(0.0) as usize).min(end);
        for row in top..bottom {
            let middle = row as f32 + 0.5;
            // The part of the streak that comes near this row.
            let part = |at: f32| {
                if along.y.abs() < 1.0e-3 {
                    None
                } else {
                    Some(((at - self.from.y) / along.y).clamp(0.0, 1.0))
                }
            };

            let ends = match (part(middle - reach), part(middle + reach)) {
                (Some(a), Some(b)) => [self.from.x + along.x * a, self.from.x + along.x * b],
                _ => [self.from.x, self.to.x],
            };
            let left = (ends[0].min(ends[1]) - reach).max(0.0) as usize;
            let right = ((ends[0].max(ends[1]) + reach).ceil().max(0.0) as usize).min(width);

            for column in left..right {
                let off = Vec2::new(column as f32 + 0.5, middle) - self.from;
                let share = (off.dot(along) / along.length_squared().max(1.0e-6)).clamp(0.0, 1.0);
                let covers = (reach - (off - along * share).length()).clamp(0.0, 1.0);
                if covers > 0.0 {
                    put(column, row, self.share * covers);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{Attitude, Pose};

    fn camera(eye: DVec3) -> Camera {
        Camera::new(Pose { eye, attitude: Attitude::default(), hfov: 60.0 }, 320, 200)
    }

    const RAIN: Precipitation = Precipitation { kind: PrecipitationKind::Rain, rate: 10.0, wind: [0.0, 0.0] };

    fn fall(falls: &Precipitation, velocity: DVec3, seconds: f64) -> PrecipitationStage {
        let camera = camera(DVec3::new(500.0, 700.0, 90.0) + velocity * seconds);
        PrecipitationStage::new(falls, &camera, velocity, seconds, Vec3::ONE).unwrap()
    }

    #[test]
    fn streaks_of_an_eye_that_stands_are_upright_and_of_one_that_flies_point_to_where_it_goes() {
        let standing = fall(&RAIN, DVec3::ZERO, 3.0);
        assert!(standing.streaks.len() > 50, "{}", standing.streaks.len());
        for streak in &standing.streaks {
            let along = streak.to - streak.from;
            assert!(along.y > 0.0 && along.x.abs() < 0.6 * along.y, "{streak:?}");
        }
        // Northward, into the middle of the screen: all leave it.
        let flying = fall(&RAIN, DVec3::new(0.0, 200.0, 0.0), 3.0);
        let middle = Vec2::new(160.0, 100.0);
        let outward = |streak: &&Streak| (streak.to - middle).length() > (streak.from - middle).length();
        assert!(flying.streaks.iter().filter(outward).count() > flying.streaks.len() * 9 / 10);
    }

    #[test]
    fn points_go_on_from_frame_to_frame() {
        let snow = Precipitation { kind: PrecipitationKind::Snow, wind: [3.0, 0.0], ..RAIN };
        let [now, then] = [5.0, 5.0 + TIME].map(|seconds| fall(&snow, DVec3::ZERO, seconds));
        let goes_on =
            |streak: &&Streak| then.streaks.iter().any(|later| (later.from - streak.to).length() < 0.1);
        assert!(now.streaks.iter().filter(goes_on).count() > now.streaks.len() * 8 / 10);
    }

    #[test]
    fn a_streak_covers_as_much_as_its_area_and_only_what_is_asked_for() {
        for (from, to) in
            [([20.0, 30.0], [60.0, 35.0]), ([40.3, 10.2], [41.0, 90.7]), ([50.0, 50.0], [50.0, 50.0])]
        {
            let streak = Streak { from: from.into(), to: to.into(), half: 1.5, share: 1.0, range: 5.0 };
            let mut sum = 0.0;
            streak.cover([0, 100], 100, |_, _, share| sum += share);
            let expected = 3.0 * (streak.to - streak.from).length() + std::f32::consts::PI * 1.5 * 1.5;
            assert!((sum / expected - 1.0).abs() < 0.06, "{sum} {expected}");
            let mut halves = 0.0;
            for rows in [[0, 33], [33, 100]] {
                streak.cover(rows, 100, |_, row, share| {
                    assert!((rows[0]..rows[1]).contains(&row));
                    halves += share;
                });
            }
            assert!((halves - sum).abs() < 1e-3 * sum);
        }
    }

    #[test]
    fn heavier_falls_have_more_and_what_is_nearer_hides_them() {
        let heavy = Precipitation { rate: 60.0, ..RAIN };
        let [light, heavy] = [RAIN, heavy].map(|falls| fall(&falls, DVec3::ZERO, 1.0));
        assert!(heavy.streaks.len() > 2 * light.streaks.len());
        let see = |range: f32| {
            let mut colour = vec![[0.0; 3]; 320 * 200];
            light.add(0, Pixels::Linear(&mut colour), &vec![range; 320 * 200]);
            colour.into_iter().filter(|colour| colour[0] > 0.0).count()
        };
        assert!(see(f32::INFINITY) > 200 && see(0.5) == 0 && see(4.0) < see(f32::INFINITY));
    }
}
