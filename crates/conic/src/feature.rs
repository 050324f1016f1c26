//! Elliptical and spherical features, and tests whether their images are ellipses.

use glam::DVec3;

use crate::ViewFrame;

/// Least |N·C| / (R·C·C) of an ellipse that is not seen end on (§2.4.3.4).
const END_ON: f64 = 1.0e-3;

/// A flat ellipse in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatEllipse {
    /// Metres.
    pub centre: DVec3,
    /// Vectors from the centre to the ends of two conjugate half axes, metres.
    pub axes: [DVec3; 2],
}

/// A sphere in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Metres.
    pub centre: DVec3,
    /// Metres, > 0.
    pub radius: f64,
}

/// Reason to leave a feature out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cull {
    /// The centre lies behind the eye.
    Behind,
    /// Part of it lies behind the eye: the image is a hyperbola, one branch of which is mirrored.
    CrossesViewPlane,
    /// Seen edge on, too thin to show.
    EndOn,
    /// The eye is inside of the sphere.
    AroundEye,
}

impl FlatEllipse {
    /// The ellipse in the axes of an eye.
    pub fn seen(&self, frame: &ViewFrame) -> Self {
        Self { centre: frame.point(self.centre), axes: self.axes.map(|axis| frame.vector(axis)) }
    }

    /// Returns the point at an angle around it, radians from the first axis towards the second.
    pub fn point(&self, angle: f64) -> DVec3 {
        self.centre + self.axes[0] * angle.cos() + self.axes[1] * angle.sin()
    }

    /// Says why an ellipse in an eye's axes is left out; `None`: its image is an ellipse.
    pub fn cull(&self) -> Option<Cull> {
        self.cull_by_place().or_else(|| self.is_end_on().then_some(Cull::EndOn))
    }

    /// Culls by the centre and by the plane through the eye across the boresight, which bound spheres too.
    fn cull_by_place(&self) -> Option<Cull> {
        let ahead = self.centre.x;
        if ahead <= 0.0 {
            return Some(Cull::Behind);
        }
        let reach = self.axes[0].x.powi(2) + self.axes[1].x.powi(2);
        (reach >= ahead * ahead).then_some(Cull::CrossesViewPlane)
    }

    fn is_end_on(&self) -> bool {
        let [first, second] = self.axes;
        let radius = (first.length() * second.length()).sqrt();
        let test = first.cross(second).dot(self.centre) / (radius * self.centre.length_squared());
        test.abs() < END_ON
    }
}

impl Ball {
    /// The sphere in the axes of an eye.
    pub fn seen(&self, frame: &ViewFrame) -> Self {
        Self { centre: frame.point(self.centre), ..*self }
    }

    /// Finds the disc about its centre that has the image of a sphere in an eye's axes: of radius R·D/√(D²−R²), across the way to the eye (§2.4.3.2).
    ///
    /// # Errors
    /// Why it is left out.
    pub fn disc(&self) -> Result<FlatEllipse, Cull> {
        let distance = self.centre.length();
        if distance <= self.radius {
            return Err(Cull::AroundEye);
        }
        let radius = self.radius * distance / ((distance - self.radius) * (distance + self.radius)).sqrt();

        let towards = self.centre / distance;
        let level = DVec3::new(-towards.y, towards.x, 0.0).try_normalize().unwrap_or(DVec3::Y);
        let disc = FlatEllipse { centre: self.centre, axes: [level * radius, level.cross(towards) * radius] };
        disc.cull_by_place().map_or(Ok(disc), Err)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_disc_of_a_sphere_touches_its_tangents() {
        for (centre, radius) in
            [([12.0, 3.0, -2.0], 4.0), ([900.0, -500.0, 20.0], 7.0), ([5.0, 0.0, 0.0], 0.1)]
        {
            let ball = Ball { centre: centre.into(), radius };
            let disc = ball.disc().unwrap();
            // As R / cos θ, with sin θ = R / D.
            let wanted = radius / (radius / ball.centre.length()).asin().cos();
            assert!((disc.axes[0].length() / wanted - 1.0).abs() < 1e-9);
            assert!((disc.axes[1].length() / wanted - 1.0).abs() < 1e-9);
            for step in 0..12 {
                let towards = disc.point(f64::from(step)).normalize();
                let missed = ball.centre.cross(towards).length();
                assert!((missed / radius - 1.0).abs() < 1e-9, "{missed} {radius}");
            }
        }
    }

    #[test]
    fn features_are_culled_for_one_reason_each() {
        let at = |x: f64, z: f64| FlatEllipse {
            centre: DVec3::new(x, 0.0, z),
            axes: [DVec3::X * 2.0, DVec3::Y * 2.0],
        };
        assert_eq!(at(-1.0, -5.0).cull(), Some(Cull::Behind));
        assert_eq!(at(1.9, -5.0).cull(), Some(Cull::CrossesViewPlane));
        assert_eq!(at(2.1, -5.0).cull(), None);
        // Where it is about a thousandth of its distance thick.
        assert_eq!(at(100.0, -4.9).cull(), Some(Cull::EndOn));
        assert_eq!(at(100.0, -5.1).cull(), None);
        assert_eq!(at(40.0, 0.0).cull(), Some(Cull::EndOn));
        let ball = |x: f64| Ball { centre: DVec3::new(x, 0.0, 0.1), radius: 3.0 };
        assert_eq!(ball(2.9).disc(), Err(Cull::AroundEye));
        assert_eq!(ball(-20.0).disc(), Err(Cull::Behind));
        assert!(ball(3.1).disc().is_ok());
        let beside = Ball { centre: DVec3::new(1.0, 5.0, 0.0), radius: 3.0 };
        assert_eq!(beside.disc(), Err(Cull::CrossesViewPlane));
    }
}
