//! Ellipsoids, by the flat ellipse that has their image.
//!
//! ```text
//! in units of its axes the ellipsoid is a ball of radius 1 at distance d: rays touch it in a circle
//!     of radius √(1 − 1/d²), whose middle is 1/d² of the way from the centre to the eye
//! an affine map keeps touching: back in space the circle is an ellipse with the ellipsoid's outline
//! ```
//!
//! Bunker and Ferris recommend ellipsoids and did not build them (§5); the conversion is ours.

use glam::{DMat3, DVec3};

use crate::{Cull, FlatEllipse, ViewFrame};

/// An ellipsoid in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipsoid {
    /// Metres.
    pub centre: DVec3,
    /// Vectors from the centre to the ends of three conjugate half axes, metres; not in one plane.
    pub axes: [DVec3; 3],
}

impl Ellipsoid {
    /// The ellipsoid in the axes of an eye.
    pub fn seen(&self, frame: &ViewFrame) -> Self {
        Self { centre: frame.point(self.centre), axes: self.axes.map(|axis| frame.vector(axis)) }
    }

    /// Finds the flat ellipse in which rays from the eye touch it, in an eye's axes.
    ///
    /// # Errors
    /// Why it is left out: the eye is inside of it, or its outline is behind or beside the eye.
    pub fn outline(&self) -> Result<FlatEllipse, Cull> {
        let space_from_ball = DMat3::from_cols(self.axes[0], self.axes[1], self.axes[2]);
        let eye = space_from_ball.inverse() * -self.centre;
        let square = eye.length_squared();
        if square <= 1.0 {
            return Err(Cull::AroundEye);
        }

        let radius = (1.0 - 1.0 / square).sqrt();
        let (first, second) = (eye / square.sqrt()).any_orthonormal_pair();
        let outline = FlatEllipse {
            centre: self.centre + space_from_ball * (eye / square),
            axes: [first, second].map(|axis| space_from_ball * (axis * radius)),
        };
        match outline.cull() {
            Some(cull @ (Cull::Behind | Cull::CrossesViewPlane)) => Err(cull),
            _ => Ok(outline),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use glam::DVec2;

    use super::*;
    use crate::{Ball, ImageConic, ImagePoint, Raster};

    const RASTER: Raster = Raster { lines: 480.0, elements: 640.0, vertical_fov: 0.8, horizontal_fov: 1.1 };

    const BODIES: [Ellipsoid; 3] = [
        Ellipsoid {
            centre: DVec3::new(60.0, 7.0, -4.0),
            axes: [DVec3::new(15.0, 0.0, 0.0), DVec3::new(0.0, 12.0, 0.0), DVec3::new(0.0, 0.0, 14.0)],
        },
        Ellipsoid {
            centre: DVec3::new(90.0, -20.0, 12.0),
            axes: [DVec3::new(14.0, 5.0, 1.0), DVec3::new(-2.0, 6.0, 3.0), DVec3::new(1.0, -1.0, 4.0)],
        },
        Ellipsoid {
            centre: DVec3::new(40.0, 3.0, 2.0),
            axes: [DVec3::new(0.0, 9.0, 1.0), DVec3::new(7.0, 0.0, 2.0), DVec3::new(0.3, 0.2, 1.5)],
        },
    ];

    #[test]
    fn ellipsoids_of_equal_axes_are_spheres() {
        for (centre, radius) in
            [([60.0, 7.0, -4.0], 9.0), ([900.0, -300.0, 20.0], 30.0), ([5.0, 0.5, 0.0], 2.0)]
        {
            let centre = DVec3::from_array(centre);
            let turned = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.2, 2.0);
            let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| turned * axis * radius);
            let own = ImageConic::of(&Ellipsoid { centre, axes }.outline().unwrap(), &RASTER);
            let ball = ImageConic::of(&Ball { centre, radius }.disc().unwrap(), &RASTER);
            let [own, ball] = [own, ball].map(|conic| [conic.vertical_extrema(), conic.horizontal_extrema()]);
            for (own, ball) in own.into_iter().flatten().flatten().zip(ball.into_iter().flatten().flatten()) {
                let apart = (own.line - ball.line).hypot(own.element - ball.element);
                assert!(apart < 1e-6, "{own:?} {ball:?}");
            }
        }
    }

    #[test]
    fn outlines_are_silhouettes_of_fine_meshes() {
        for body in BODIES {
            let conic = ImageConic::of(&body.outline().unwrap(), &RASTER);
            let (centre, _) = conic.ellipse().unwrap();
            // Corners of a mesh, as a silhouette in 720 directions on the screen: the farthest in each.
            let corner = |step: i32, turn: i32| {
                let ((sin, cos), (east, north)) =
                    ((f64::from(step) * PI / 400.0).sin_cos(), (f64::from(turn) * TAU / 800.0).sin_cos());
                let on_ball = DVec3::new(sin * north, sin * east, cos);
                let [a, b, c] = body.axes;
                RASTER.project(body.centre + a * on_ball.x + b * on_ball.y + c * on_ball.z)
            };
            let corners: Vec<DVec2> =
                (0..=400).flat_map(|step| (0..800).map(move |turn| corner(step, turn))).collect();
            let [top, bottom] = conic.vertical_extrema().unwrap();
            let [left, right] = conic.horizontal_extrema().unwrap();
            let most =
                |of: &dyn Fn(DVec2) -> f64| corners.iter().map(|corner| of(*corner)).fold(f64::MIN, f64::max);
            for (mesh, outline) in [
                (-most(&|at| -at.x), top.line),
                (most(&|at| at.x), bottom.line),
                (-most(&|at| -at.y), left.element),
                (most(&|at| at.y), right.element),
            ] {
                assert!((mesh - outline).abs() < 0.1, "{body:?}: {mesh}, not {outline}");
            }

            // No corner lies outside, and some lie on the outline on each side of the centre.
            let mut sides = [0; 8];
            for at in corners {
                let offset = at - centre;
                let value = |share: f64| {
                    let at = centre + offset * share;
                    conic.value(ImagePoint { line: at.x, element: at.y })
                };
                let pixel = 1.0 / offset.length().max(1.0);
                assert!(value(1.0 - 0.1 * pixel) < 0.0, "{body:?}: {at} lies outside");
                if value(1.0 + 0.1 * pixel) > 0.0 {
                    sides[((offset.y.atan2(offset.x) / TAU + 1.0) * 8.0) as usize % 8] += 1;
                }
            }
            assert!(sides.iter().all(|&count| count > 0), "{sides:?}");
        }
    }

    #[test]
    fn ellipsoids_are_culled_for_one_reason_each() {
        let at = |x: f64| Ellipsoid {
            centre: DVec3::new(x, 1.0, 0.0),
            axes: [DVec3::X * 5.0, DVec3::Y * 2.0, DVec3::Z],
        };
        assert_eq!(at(1.0).outline(), Err(Cull::AroundEye));
        assert_eq!(at(-40.0).outline(), Err(Cull::Behind));
        let beside = Ellipsoid { centre: DVec3::new(0.5, 9.0, 0.0), ..at(0.0) };
        assert_eq!(beside.outline(), Err(Cull::CrossesViewPlane));
        assert!(at(40.0).outline().is_ok());
    }
}
