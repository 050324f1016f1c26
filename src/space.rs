//! Spaces, units and axes.
//!
//! *World*: metres in the database's coordinate reference system, x east, y north (grid north),
//! z up from the database's vertical datum. *View*: x right, y up, z forward. *Screen*: pixels,
//! column 0 at the left, row 0 at the top; the centre of pixel (c, r) is at (c + ½, r + ½).
//! Transforms are named `a_from_b`.

use glam::{DMat3, DVec2, DVec3};

/// Attitude of the eye, in degrees.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Attitude {
    /// Clockwise from grid north, degrees, any value.
    pub yaw: f64,
    /// Nose up positive, degrees, −90…90.
    pub pitch: f64,
    /// Right wing down positive, degrees, any value.
    pub roll: f64,
}

impl Attitude {
    /// Columns: right, up, forward of the view, in world axes (orthonormal).
    pub fn world_from_view(&self) -> DMat3 {
        let (sin_yaw, cos_yaw) = self.yaw.to_radians().sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch.to_radians().sin_cos();
        let (sin_roll, cos_roll) = self.roll.to_radians().sin_cos();
        let forward = DVec3::new(sin_yaw * cos_pitch, cos_yaw * cos_pitch, sin_pitch);
        let level_right = DVec3::new(cos_yaw, -sin_yaw, 0.0);
        let level_up = level_right.cross(forward);
        let right = level_right * cos_roll - level_up * sin_roll;
        let up = level_up * cos_roll + level_right * sin_roll;
        DMat3::from_cols(right, up, forward)
    }
}

/// Where the eye is, how it is turned and how wide it sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Eye in world space, metres.
    pub eye: DVec3,
    /// Attitude, degrees.
    pub attitude: Attitude,
    /// Horizontal field of view, degrees, 0 < hfov < 180.
    pub hfov: f64,
}

/// A planar screen before an eye: square pixels, pinhole.
#[derive(Debug, Clone, Copy)]
pub struct Camera {
    /// The pose that it was made from.
    pub pose: Pose,
    /// Pixels per row, ≥ 1.
    pub width: u32,
    /// Rows, ≥ 1.
    pub height: u32,
    world_from_view: DMat3,
    focal: f64,
}

impl Camera {
    /// A screen of `width` × `height` pixels at `pose`.
    pub fn new(pose: Pose, width: u32, height: u32) -> Self {
        let focal = 0.5 * f64::from(width) / (0.5 * pose.hfov.to_radians()).tan();
        Self { pose, width, height, world_from_view: pose.attitude.world_from_view(), focal }
    }

    /// Distance of the screen from the eye, pixels.
    pub fn focal_px(&self) -> f64 {
        self.focal
    }

    /// Angle that one pixel subtends at the screen's centre, radians (the patent's A_PIX).
    pub fn pixel_angle(&self) -> f64 {
        1.0 / self.focal
    }

    /// Columns: right, up, forward in world axes.
    pub fn world_from_view(&self) -> DMat3 {
        self.world_from_view
    }

    /// Unit direction in world space through screen position (`column`, `row`), in pixels;
    /// pixel centres lie at half-integers.
    pub fn direction(&self, column: f64, row: f64) -> DVec3 {
        let view =
            DVec3::new(column - 0.5 * f64::from(self.width), 0.5 * f64::from(self.height) - row, self.focal);
        (self.world_from_view * view).normalize()
    }

    /// Cosine between the optical axis and the ray of unit `direction`: `Z = range · cos`.
    pub fn axis_cosine(&self, direction: DVec3) -> f64 {
        self.world_from_view.z_axis.dot(direction)
    }

    /// Screen position (column, row) in pixels of a world point, or `None` behind the eye.
    pub fn screen_from_world(&self, point: DVec3) -> Option<DVec2> {
        let view = self.world_from_view.transpose() * (point - self.pose.eye);
        (view.z > 0.0).then(|| {
            DVec2::new(
                0.5 * f64::from(self.width) + view.x / view.z * self.focal,
                0.5 * f64::from(self.height) - view.y / view.z * self.focal,
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn yaw_is_clockwise_from_north() {
        let east = Attitude { yaw: 90.0, ..Attitude::default() }.world_from_view();
        assert!((east.z_axis - DVec3::X).length() < 1e-12);
        assert!((east.x_axis + DVec3::Y).length() < 1e-12, "south is to the right");
    }

    #[test]
    fn pitch_is_up_and_roll_is_right_wing_down() {
        let up = Attitude { pitch: 90.0, ..Attitude::default() }.world_from_view();
        assert!((up.z_axis - DVec3::Z).length() < 1e-12);
        let banked = Attitude { roll: 90.0, ..Attitude::default() }.world_from_view();
        assert!((banked.x_axis + DVec3::Z).length() < 1e-12, "the right wing points down");
    }

    #[test]
    fn screen_from_world_inverts_direction() {
        let pose = Pose {
            eye: DVec3::new(5.0e5, 4.0e6, 300.0),
            attitude: Attitude { yaw: 33.0, pitch: -12.0, roll: 41.0 },
            hfov: 71.0,
        };
        let camera = Camera::new(pose, 640, 360);
        let point = pose.eye + camera.direction(12.5, 300.25) * 1234.0;
        let screen = camera.screen_from_world(point).unwrap();
        assert!((screen - DVec2::new(12.5, 300.25)).length() < 1e-6);
    }
}
