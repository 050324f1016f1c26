//! Quadrilateral on flat ground, clipped to the screen.
//!
//! ```text
//! beyond a side of the screen: right v − u·tan β, left −v − u·tan β, bottom w − u·tan α, top −w − u·tan α   > 0
//! r = |f₁|/(|f₁| + |f₂|)        P = P₁ + r·(P₂ − P₁)        where an edge crosses a side
//! ```
//!
//! Source: study of cyclic codes for surface texture (AFHRL on ACTES); α and β are half the fields of view.

use super::pixel_share::HalfPlane;
use super::view::GroundView;

/// Convex quadrilateral on the ground, feet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundQuad {
    /// Corners, x and y, in order around it.
    pub corners: [[f64; 2]; 4],
}

impl GroundQuad {
    /// A rectangle between two places along x, and two along y.
    pub fn rectangle(x: [f64; 2], y: [f64; 2]) -> Self {
        Self { corners: [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]] }
    }

    /// Sides of what the screen shows of it, each with it within; `None`: nothing.
    pub fn sides(&self, view: &GroundView) -> Option<Vec<HalfPlane>> {
        let [down, right] = view.half_tangents();
        let beyond = [[-right, 1.0, 0.0], [-right, -1.0, 0.0], [-down, 0.0, 1.0], [-down, 0.0, -1.0]];
        let mut outline = self.corners.map(|corner| view.seen(corner)).to_vec();
        for side in beyond {
            outline = clipped(&outline, |point| side.iter().zip(point).map(|(side, part)| side * part).sum());
        }

        let points: Vec<_> = outline.iter().map(|&point| view.projected(point)).collect();
        let next = points.iter().cycle().skip(1);
        let sides: Vec<_> =
            points.iter().zip(next).map(|(&from, &to)| HalfPlane::right_of(from, to)).collect();

        // Whichever way it goes around on the screen.
        let middle = points.get(2).copied()?;
        let turn: f64 = sides.iter().map(|half| half.at(middle)).sum();
        (turn != 0.0).then(|| {
            let inward = |half: HalfPlane| if turn > 0.0 { half } else { half.opposite() };
            sides.into_iter().map(inward).collect()
        })
    }
}

/// Part of a convex polygon where a linear function is not above zero.
fn clipped(polygon: &[[f64; 3]], beyond: impl Fn([f64; 3]) -> f64) -> Vec<[f64; 3]> {
    let mut part = Vec::with_capacity(polygon.len() + 1);
    for (number, &from) in polygon.iter().enumerate() {
        let to = polygon[(number + 1) % polygon.len()];
        let (a, b) = (beyond(from), beyond(to));
        if a <= 0.0 {
            part.push(from);
        }
        if a * b < 0.0 {
            let share = a.abs() / (a.abs() + b.abs());
            part.push(std::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis])));
        }
    }
    part
}

#[cfg(test)]
mod tests {
    use super::super::eye::{Eye, EyeAttitude};
    use super::super::pixel_share::pixel_share;
    use super::super::view::Screen;
    use super::*;
    use crate::projection::Projection;

    #[test]
    fn pixels_show_the_quadrilateral_whose_ground_lies_in_it() {
        let screen = Screen { projection: Projection { pixels: 64, fov_deg: 45.0 }, lines: 48 };
        let quad = GroundQuad::rectangle([100.0, 6000.0], [-300.0, 500.0]);
        for (altitude, heading_deg, pitch_deg, roll_deg) in [
            (800.0, 0.0, -8.0, 0.0),
            (300.0, 25.0, -15.0, 40.0),
            (500.0, -120.0, -60.0, 0.0),
            (90.0, 3.0, 2.0, -160.0),
        ] {
            let attitude = EyeAttitude { heading_deg, pitch_deg, roll_deg };
            // Over it, so that part of it lies behind the eye.
            let view = GroundView::new(Eye { place: [900.0, 20.0], altitude, attitude }, screen);
            let sides = quad.sides(&view).unwrap();
            let mut mixed = 0;
            for number in 0..screen.size() {
                let at = screen.pixel(number);
                let share = pixel_share(at, &sides);
                let holds = view
                    .ground(at)
                    .is_some_and(|[x, y]| (100.0..6000.0).contains(&x) && (-300.0..500.0).contains(&y));
                if !(1e-9..=1.0 - 1e-9).contains(&share) {
                    assert_eq!(share > 0.5, holds, "{attitude:?}, pixel {number}");
                } else {
                    mixed += 1;
                }
            }
            assert!(mixed > 20 && mixed < 400, "{mixed}");
        }
    }

    #[test]
    fn what_lies_behind_or_beside_has_no_sides() {
        let screen = Screen { projection: Projection { pixels: 64, fov_deg: 45.0 }, lines: 48 };
        let attitude = EyeAttitude { pitch_deg: -5.0, ..EyeAttitude::default() };
        let view = GroundView::new(Eye { place: [0.0, 0.0], altitude: 500.0, attitude }, screen);
        assert_eq!(GroundQuad::rectangle([-900.0, -200.0], [-300.0, 500.0]).sides(&view), None);
        assert_eq!(GroundQuad::rectangle([1000.0, 2000.0], [5000.0, 7000.0]).sides(&view), None);
    }
}
