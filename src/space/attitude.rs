//! Attitude of an eye.

use glam::{DMat3, DVec3};

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

/// Axes of a view (x right, y up, z forward) that stands as the world (x east, y north, z up) stands before
/// an eye that looks north: east is right, north is forward.
const VIEW_FROM_NORTHBOUND: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Y);

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

    /// Whether the view is neither pitched nor rolled.
    pub fn is_level(&self) -> bool {
        self.pitch == 0.0 && self.roll == 0.0
    }

    /// Columns: right, up, forward of a view that is turned by this attitude against the axes of another view
    /// (yaw to its right, pitch to its top), in those axes.
    pub(super) fn view_from_turned(&self) -> DMat3 {
        VIEW_FROM_NORTHBOUND * self.world_from_view()
    }

    /// Attitude of a view that is turned by `offset` against the axes of a view of this attitude: of a channel
    /// that is fixed in an aircraft. Exact where one of the two is level or nothing.
    pub fn turned(&self, offset: Self) -> Self {
        if offset == Self::default() {
            *self
        } else if self.is_level() {
            Self { yaw: self.yaw + offset.yaw, ..offset }
        } else {
            Self::from_axes(self.world_from_view() * offset.view_from_turned())
        }
    }

    /// Columns: right, forward, up of a body, in world axes (orthonormal, right-handed).
    pub fn world_from_body(&self) -> DMat3 {
        let view = self.world_from_view();
        DMat3::from_cols(view.x_axis, view.z_axis, view.y_axis)
    }

    /// Inverse of [`Self::world_from_body`]; yaw 0…360.
    pub fn of_body(world_from_body: DMat3) -> Self {
        let DMat3 { x_axis: right, y_axis: forward, z_axis: up } = world_from_body;
        Self::from_axes(DMat3::from_cols(right, up, forward))
    }

    /// The attitude of a view with the orthonormal axes (right, up, forward) of `world_from_view`; yaw 0…360.
    fn from_axes(world_from_view: DMat3) -> Self {
        let forward = world_from_view.z_axis;
        let pitch = forward.z.atan2(forward.truncate().length());
        let yaw = forward.x.atan2(forward.y);
        // Against the yaw that was found, so that the two make up for each other where the view is vertical.
        let level_right = DVec3::new(yaw.cos(), -yaw.sin(), 0.0);
        let roll = world_from_view.y_axis.dot(level_right).atan2(world_from_view.x_axis.dot(level_right));
        Self { yaw: yaw.to_degrees().rem_euclid(360.0), pitch: pitch.to_degrees(), roll: roll.to_degrees() }
    }
}

/// Place of the eye, its attitude, and how wide it sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Eye in world space, metres.
    pub eye: DVec3,
    /// Attitude, degrees.
    pub attitude: Attitude,
    /// Horizontal field of view, degrees; of a planar screen 0 < hfov < 180.
    pub hfov: f64,
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

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
    fn a_channel_turns_with_its_aircraft() {
        let close = |found: DVec3, expected: DVec3| assert!((found - expected).length() < 1e-12, "{found}");
        let right = Attitude { yaw: 90.0, ..Attitude::default() };
        // Banked to the right by 30°, the view out of the right window points 30° down.
        let banked = Attitude { yaw: 0.0, pitch: 0.0, roll: 30.0 }.turned(right);
        assert!((banked.pitch + 30.0).abs() < 1e-12 && (banked.yaw - 90.0).abs() < 1e-12, "{banked:?}");
        // Climbing by 20°, it is level but rolled.
        let climbing = Attitude { yaw: 10.0, pitch: 20.0, roll: 0.0 }.turned(right).world_from_view();
        close(climbing.z_axis, Attitude { yaw: 100.0, ..Attitude::default() }.world_from_view().z_axis);
        close(climbing.x_axis, -Attitude { yaw: 10.0, pitch: 20.0, roll: 0.0 }.world_from_view().z_axis);
        let exact = Attitude { yaw: 350.1, ..Attitude::default() };
        assert_eq!(exact.turned(Attitude { yaw: -60.0, pitch: 7.7, roll: 0.3 }).pitch, 7.7);
        assert_eq!(right.turned(Attitude::default()), right);
    }

    proptest! {
        #[test]
        fn attitudes_and_axes_agree(
            yaw in -400.0..400.0_f64, pitch in prop_oneof![Just(90.0), Just(-90.0), -90.0..90.0_f64],
            roll in -200.0..200.0_f64, off_yaw in -180.0..180.0_f64, off_pitch in -90.0..90.0_f64,
        ) {
            let own = Attitude { yaw, pitch, roll };
            let offset = Attitude { yaw: off_yaw, pitch: off_pitch, roll: 12.0 };
            let axes = own.world_from_view() * offset.view_from_turned();
            let again = own.turned(offset).world_from_view();
            prop_assert!(axes.abs_diff_eq(again, 1e-14), "{axes} {again}");
            let body = own.world_from_body();
            prop_assert!(body.abs_diff_eq(Attitude::of_body(body).world_from_body(), 1e-14), "{body}");
        }
    }
}
