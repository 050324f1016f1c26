//! A shape in its place.

use glam::{DMat3, DVec3, Vec3};

use super::Shape;
use super::shape::Touch;
use crate::earth::Curvature;
use crate::space::Attitude;

use super::lens::Line;

/// A shape somewhere in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Number that pictures carry; of two at the same range the lower one is seen. No two have the same.
    pub id: u32,
    /// What it looks like from all sides.
    pub shape: Shape,
    /// The shape's origin, metres (x east, y north, z above the datum).
    pub position: DVec3,
    /// Where its forward axis points (yaw, pitch), and how its up axis leans (roll), degrees.
    pub attitude: Attitude,
    /// Linear Rec. 709 reflectance, 0…1.
    pub albedo: Vec3,
}

/// A body as an eye finds it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    pub id: u32,
    pub albedo: Vec3,
    pub shape: Shape,
    pub position: DVec3,
    pub body_from_world: DMat3,
    /// The eye, in its axes.
    eye: DVec3,
    /// Corners of the box around it, in its axes, metres.
    corners: [DVec3; 2],
    /// Of the sphere around that, in the world, metres.
    pub centre: DVec3,
    pub radius: f64,
    /// Its least extent, metres: two of the three sides of its box are longer.
    pub thickness: f64,
}

impl Placed {
    /// Where `eye` finds `body`, which the Earth's curvature lowers with the ground that it stands on.
    pub fn new(body: &Body, eye: DVec3, curvature: Curvature) -> Self {
        let distance = (body.position - eye).truncate().length();
        let position = body.position - DVec3::Z * curvature.drop_at(distance);
        let view = body.attitude.world_from_view();
        let world_from_body = DMat3::from_cols(view.x_axis, view.z_axis, view.y_axis);
        let corners = body.shape.corners();
        let size = corners[1] - corners[0];
        Self {
            id: body.id,
            albedo: body.albedo,
            shape: body.shape,
            position,
            body_from_world: world_from_body.transpose(),
            eye: world_from_body.transpose() * (eye - position),
            corners,
            centre: position + world_from_body * (0.5 * (corners[0] + corners[1])),
            radius: 0.5 * size.length(),
            thickness: size.min_element(),
        }
    }

    /// Where a ray meets it first; the normal is of unit length and in world axes.
    pub fn touch(&self, line: &Line) -> Option<Touch> {
        let touch = self.shape.touch(self.origin(line), self.body_from_world * line.direction)?;
        Some(Touch { normal: self.body_from_world.transpose() * touch.normal.normalize(), ..touch })
    }

    /// Corners of the box around it, in the world.
    pub fn box_corners(&self) -> impl Iterator<Item = DVec3> {
        let world_from_body = self.body_from_world.transpose();
        (0..8).map(move |corner| {
            let of = |axis: usize| self.corners[corner >> axis & 1][axis];
            self.position + world_from_body * DVec3::new(of(0), of(1), of(2))
        })
    }

    /// Where a ray starts, in the body's axes.
    fn origin(&self, line: &Line) -> DVec3 {
        match line.origin {
            None => self.eye,
            Some(origin) => self.body_from_world * (origin - self.position),
        }
    }

    /// Whether a ray may come nearer to it than `margin` metres, in front of its origin.
    pub fn is_near(&self, line: &Line, margin: f64) -> bool {
        let origin = self.origin(line);
        if let Some((grown, below)) = self.shape.grown(margin) {
            return grown.touch(origin + DVec3::Z * below, self.body_from_world * line.direction).is_some();
        }
        let inverse = (self.body_from_world * line.direction).recip();
        let low = (self.corners[0] - margin - origin) * inverse;
        let high = (self.corners[1] + margin - origin) * inverse;
        let (enter, leave) = (low.min(high).max_element(), low.max(high).min_element());
        enter <= leave && leave >= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tower(attitude: Attitude) -> Placed {
        let body = Body {
            id: 1,
            shape: Shape::Box { size: DVec3::new(2.0, 10.0, 4.0) },
            position: DVec3::new(100.0, 200.0, 50.0),
            attitude,
            albedo: Vec3::ONE,
        };
        Placed::new(&body, DVec3::ZERO, Curvature::FLAT)
    }

    fn touch(placed: &Placed, origin: [f64; 3], direction: DVec3) -> Option<Touch> {
        placed.touch(&Line { origin: Some(origin.into()), direction })
    }

    #[test]
    fn forward_is_where_its_yaw_points() {
        // Its long side, 10 m, lies from west to east.
        let placed = tower(Attitude { yaw: 90.0, ..Attitude::default() });
        let seen = touch(&placed, [100.0, 100.0, 51.0], DVec3::Y).unwrap();
        assert!((seen.range - 99.0).abs() < 1e-9 && (seen.normal - DVec3::NEG_Y).length() < 1e-9);
        assert!(touch(&placed, [104.9, 100.0, 51.0], DVec3::Y).is_some());
        assert!(touch(&placed, [105.1, 100.0, 51.0], DVec3::Y).is_none());
    }

    #[test]
    fn a_nose_that_is_pitched_up_is_higher() {
        let placed = tower(Attitude { pitch: 30.0, ..Attitude::default() });
        // Northward its upper side rises.
        let [front, back] =
            [2.0, -2.0].map(|y| touch(&placed, [100.0, 200.0 + y, 90.0], DVec3::NEG_Z).unwrap().range);
        assert!((back - front - 4.0 * 30.0_f64.to_radians().tan()).abs() < 1e-9, "{front} {back}");
    }

    #[test]
    fn near_rays_are_those_that_pass_within_the_margin() {
        let placed = tower(Attitude::default());
        let ray = |x: f64| Line { origin: Some(DVec3::new(x, 0.0, 52.0)), direction: DVec3::Y };
        assert!(placed.is_near(&ray(101.4), 0.5) && !placed.is_near(&ray(101.6), 0.5));
        let behind = Line { origin: Some(DVec3::new(100.0, 300.0, 52.0)), direction: DVec3::Y };
        assert!(!placed.is_near(&behind, 0.5));
    }

    #[test]
    fn far_bodies_are_lowered_with_their_ground() {
        let body = Body {
            id: 0,
            shape: Shape::Disc { radius: 1.0 },
            position: DVec3::new(30_000.0, 40_000.0, 100.0),
            attitude: Attitude::default(),
            albedo: Vec3::ONE,
        };
        let placed = Placed::new(&body, DVec3::ZERO, Curvature::standard());
        assert!((100.0 - placed.centre.z - Curvature::standard().drop_at(50_000.0)).abs() < 1e-9);
    }
}
