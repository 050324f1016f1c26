//! Distance of a place from a line, without creases.
//!
//! The distance to a bent line has a crease on the inside of each bend, where two legs are equally near. Here it is
//!
//! ```text
//! D = (3/4 · ∫ ds / |place − s|⁵) ^ −¼      over the line's length s
//! ```
//! which is the distance itself beside a straight line that goes on for ever, 0 on any line, and smooth everywhere else: legs are rounded into each other, and
//! ends into noses. The integral over a leg has a closed form of square roots. (Convolution surfaces after McCormack and Sherstyuk, "Creating and
//! rendering convolution surfaces", 1998, with a kernel whose level curves are undone again.)

use glam::DVec2;

/// Distance of a place from a line of at least two points, in their unit.
pub(super) fn distance(line: &[DVec2], at: DVec2) -> f64 {
    let sum: f64 = line.windows(2).map(|leg| along([leg[0], leg[1]], at)).sum();
    (4.0 / 3.0 / sum).sqrt().sqrt()
}

/// Returns the factor by which a place can seem nearer than its nearest leg, at most.
pub(super) fn widening(line: &[DVec2]) -> f64 {
    (line.len() as f64).sqrt().sqrt()
}

/// ∫ ds / |at − s|⁵ over a leg; infinite on it.
fn along([from, to]: [DVec2; 2], at: DVec2) -> f64 {
    /// Beside the leg's own line, in the square of the way along it, below which differences would cancel.
    const BESIDE: f64 = 1.0e-3;

    let length = (to - from).length();
    let way = (to - from) / length;
    let (low, high) = ((from - at).dot(way), (to - at).dot(way));
    let aside = (at - from).perp_dot(way);
    let aside2 = aside * aside;
    let nearest = if low <= 0.0 && high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
    if aside2 < BESIDE * nearest * nearest {
        // Ahead of the leg or behind it: the first terms of the series in the way aside.
        let (near, far) = (nearest, low.abs().max(high.abs()));
        let power = |u: f64, aside2: f64| {
            let u2 = u * u;
            (0.25 - aside2 / u2 * (5.0 / 12.0 - aside2 / u2 * (35.0 / 64.0))) / (u2 * u2)
        };
        return power(near, aside2) - power(far, aside2);
    }

    let part = |u: f64| {
        let ray2 = aside2 + u * u;
        let ray = ray2.sqrt();
        u / (3.0 * aside2 * ray) * (1.0 / ray2 + 2.0 / aside2)
    };
    // On the line itself the quotient is no number.
    let sum = part(high) - part(low);

    if sum.is_nan() { f64::INFINITY } else { sum }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEND: [DVec2; 3] = [DVec2::new(-400.0, 0.0), DVec2::new(0.0, 0.0), DVec2::new(100.0, 400.0)];

    #[test]
    fn beside_a_straight_line_it_is_the_distance() {
        let line = [DVec2::new(-5000.0, 20.0), DVec2::new(0.0, 20.0), DVec2::new(5000.0, 20.0)];
        for away in [1e-3, 0.5, 30.0, 200.0] {
            let found = distance(&line, DVec2::new(3.0, 20.0 - away));
            assert!((found / away - 1.0).abs() < 1e-5, "{away}: {found}");
        }
        for on in [DVec2::new(17.0, 20.0), line[0], line[1], line[2]] {
            assert_eq!(distance(&line, on), 0.0);
        }
    }

    #[test]
    fn ahead_of_an_end_it_goes_on_smoothly() {
        // Exactly on the leg's own line: (16/3)^¼ times the way.
        let line = [DVec2::ZERO, DVec2::new(1e6, 0.0)];
        let ahead = distance(&line, DVec2::new(-10.0, 0.0));
        assert!((ahead / 10.0 - (16.0_f64 / 3.0).sqrt().sqrt()).abs() < 1e-9, "{ahead}");
        // Both forms agree where they meet.
        let at = |aside: f64| distance(&line, DVec2::new(-10.0, aside));
        let edge = 10.0 * 1e-3_f64.sqrt();
        assert!((at(edge * (1.0 - 1e-9)) - at(edge * (1.0 + 1e-9))).abs() < 1e-6);
    }

    #[test]
    fn bends_have_no_crease() {
        // Across the inside of the bend the slope changes little from step to step; of the plain distance it jumps by a half.
        let place = |step: i32| DVec2::new(-60.0, 80.0) + DVec2::new(0.62, 0.78) * f64::from(step);
        let near = |step: i32| distance(&BEND, place(step));
        let bend = |step: i32| (near(step + 1) - 2.0 * near(step) + near(step - 1)).abs();
        assert!((-60..60).all(|step| bend(step) < 0.03), "{:?}", (-60..60).map(bend).fold(0.0, f64::max));
        let least = |at: DVec2| {
            BEND.windows(2)
                .map(|leg| {
                    let way = leg[1] - leg[0];
                    let share = ((at - leg[0]).dot(way) / way.length_squared()).clamp(0.0, 1.0);
                    at.distance(leg[0] + way * share)
                })
                .fold(f64::INFINITY, f64::min)
        };
        for step in -60..60 {
            assert!(near(step) * widening(&BEND) >= least(place(step)) * (1.0 - 1e-9));
        }
    }
}
