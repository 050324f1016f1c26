//! Radial distortion of a lens, after Conrady (1919, *Decentred Lens-Systems*) and Brown (1966, *Decentering Distortion of Lenses*), of its two first
//! radial terms:
//!
//! ```text
//! seen = undistorted · (1 + k₁r² + k₂r⁴)      r: distance of the undistorted point from the axis, in focal lengths
//! ```
//!
//! It maps where a point is on an ideal plane to where it is seen. Rays need the other way, which has no closed form: the root of a
//! polynomial that rises up to where the lens would fold the picture.

use glam::DVec2;

/// Radius of a picture that sees all before the eye but 0.6°, focal lengths: no lens with this distortion sees more.
const WIDEST: f64 = 100.0;

/// Steps towards a root: half of them halve the interval at worst.
const STEPS: usize = 80;

/// Relative error of a root.
const CLOSE: f64 = 1.0e-14;

/// Maps a point of the ideal plane to where it is seen, focal lengths; `None` from where on the lens folds.
pub(super) fn seen([k1, k2]: [f64; 2], undistorted: DVec2) -> Option<DVec2> {
    let square = undistorted.length_squared();
    (square <= fold([k1, k2]).powi(2)).then(|| undistorted * (1.0 + square * (k1 + square * k2)))
}

/// Maps a place of the picture to its point of the ideal plane, focal lengths; `None` where there is none.
pub(super) fn undistorted([k1, k2]: [f64; 2], seen: DVec2) -> Option<DVec2> {
    let radius = seen.length();
    if radius == 0.0 {
        return Some(seen);
    }

    let off = |r: f64| r * (1.0 + r * r * (k1 + r * r * k2)) - radius;
    let (mut low, mut high) = (0.0, fold([k1, k2]));
    if off(high) < 0.0 || radius.is_nan() {
        return None;
    }

    let mut r = radius.min(0.5 * (low + high));
    for _ in 0..STEPS {
        let wrong = off(r);
        if wrong > 0.0 {
            high = r
        } else {
            low = r
        }
        let slope = 1.0 + r * r * (3.0 * k1 + 5.0 * r * r * k2);
        let next = r - wrong / slope;
        // Newton's step, or half of the interval where that leaves it.
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        if (next - r).abs() <= CLOSE * r {
            return Some(seen * (next / radius));
        }
        r = next;
    }

    Some(seen * (r / radius))
}

/// Radius of the ideal plane up to which what is seen moves outward, focal lengths: the least root of 1 + 3k₁r² + 5k₂r⁴.
fn fold([k1, k2]: [f64; 2]) -> f64 {
    let (a, b) = (5.0 * k2, 3.0 * k1);
    let root = b * b - 4.0 * a;
    if root < 0.0 {
        return WIDEST;
    }
    // In a form that has no difference of near numbers, and none of the roots is lost where k₂ is 0.
    let sum = -0.5 * (b + root.sqrt().copysign(b));
    let roots = [sum / a, 1.0 / sum];
    let least = roots.into_iter().filter(|square| *square > 0.0).fold(f64::INFINITY, f64::min);
    least.sqrt().min(WIDEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_that_is_seen_somewhere_is_found_there() {
        for k in [[0.0, 0.0], [-0.25, 0.0], [-0.3, 0.08], [0.2, -0.02], [0.4, 0.3], [-0.1, -0.05]] {
            for step in 1..400 {
                let angle = f64::from(step) * 0.7;
                let point = DVec2::from_angle(angle) * f64::from(step) * 0.0027;
                let Some(at) = seen(k, point) else { continue };
                let back = undistorted(k, at).unwrap();
                // Close to the fold the root is a double one.
                let margin =
                    1.0 + point.length_squared() * (3.0 * k[0] + 5.0 * k[1] * point.length_squared());
                assert!((back - point).length() < 1e-12 / margin.max(1e-3), "{k:?} {point} {back}");
            }
        }
        assert_eq!(undistorted([0.3, 0.1], DVec2::ZERO), Some(DVec2::ZERO));
    }

    #[test]
    fn a_lens_shows_nothing_beyond_its_fold() {
        // 1 − 3·0.25·r² = 0 at r = 1.1547, which is seen at 0.7698.
        let k = [-0.25, 0.0];
        assert!((fold(k) - (4.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert!(seen(k, DVec2::new(1.15, 0.0)).is_some() && seen(k, DVec2::new(1.16, 0.0)).is_none());
        assert!(undistorted(k, DVec2::new(0.0, 0.7697)).is_some());
        assert!(undistorted(k, DVec2::new(0.0, 0.77)).is_none());
        assert!(undistorted(k, DVec2::new(f64::NAN, 0.0)).is_none());
        for k in [[0.0, 0.0], [0.3, 0.0], [0.3, 0.1], [-0.3, 0.3]] {
            assert_eq!(fold(k), WIDEST, "{k:?}");
        }
        // k₁ = 0: r⁴ = 1/(5·0.2).
        assert!((fold([0.0, -0.2]) - 1.0).abs() < 1e-12);
    }
}
