//! An eye and its screen: the ray of every pixel.

use glam::{DMat3, DVec2, DVec3};

use super::screen::Mapping;
use super::{Attitude, Footprint, Pose, Screen};

/// A ray in world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Start of the ray, metres: the eye, but on an orthographic screen.
    pub origin: DVec3,
    /// Direction of unit length.
    pub direction: DVec3,
}

/// A screen before an eye.
#[derive(Debug, Clone)]
pub struct Camera {
    /// The pose of the view itself, the turn of its channel included. Its field of view is the screen's, where the screen
    /// has one.
    pub pose: Pose,
    /// Pixels per row, ≥ 1.
    pub width: u32,
    /// Rows, ≥ 1.
    pub height: u32,
    mapping: Mapping,
    world_from_view: DMat3,
    /// The axes that the mapping's directions are in: the view's, or, where the mapping turns by columns, those of the
    /// aircraft.
    world_from_mapping: DMat3,
}

impl Camera {
    /// A planar screen of `width` × `height` pixels at `pose`.
    pub fn new(pose: Pose, width: u32, height: u32) -> Self {
        Self::with_screen(pose, Screen::Planar { hfov: pose.hfov }, width, height)
    }

    /// `screen` of `width` × `height` pixels at `pose`; the screen's own field of view counts, not the pose's.
    pub fn with_screen(pose: Pose, screen: Screen, width: u32, height: u32) -> Self {
        Self::with_channel(pose, Attitude::default(), screen, width, height)
    }

    /// One of several screens around the eye of an aircraft at `pose`: `channel` is its attitude against the axes of the
    /// aircraft. Channels that abut share the rays of their common edge.
    pub fn with_channel(pose: Pose, channel: Attitude, screen: Screen, width: u32, height: u32) -> Self {
        let own = pose.attitude.world_from_view();
        let world_from_view =
            if channel == Attitude::default() { own } else { own * channel.view_from_turned() };
        let shifts = screen.turns_by_columns() && channel.is_level();
        Self {
            pose: Pose {
                eye: pose.eye,
                attitude: pose.attitude.turned(channel),
                hfov: screen.hfov().unwrap_or(pose.hfov),
            },
            width,
            height,
            mapping: Mapping::new(screen, width, height, if shifts { channel.yaw } else { 0.0 }),
            world_from_view,
            world_from_mapping: if shifts { own } else { world_from_view },
        }
    }

    /// The same screen at another pose of the view; it keeps its field of view.
    #[must_use]
    pub fn moved_to(&self, pose: Pose) -> Self {
        let world_from_view = pose.attitude.world_from_view();
        // Both are rotations; the screen turns with the view.
        let view_from_mapping = self.world_from_view.transpose() * self.world_from_mapping;
        Self {
            pose: Pose { hfov: self.pose.hfov, ..pose },
            world_from_view,
            world_from_mapping: world_from_view * view_from_mapping,
            ..self.clone()
        }
    }

    /// The same view with `times` as many pixels along each side, `u32::MAX` at most.
    #[must_use]
    pub fn enlarged(&self, times: u32) -> Self {
        let (width, height) = (self.width.saturating_mul(times), self.height.saturating_mul(times));
        Self { width, height, mapping: self.mapping.enlarged(times), ..self.clone() }
    }

    /// Returns the screen that the picture is projected on.
    pub fn screen(&self) -> &Screen {
        &self.mapping.screen
    }

    /// Planar screens: distance of the screen from the eye, pixels. Others: pixels per radian at the picture's centre;
    /// orthographic: pixels per metre.
    pub fn focal_px(&self) -> f64 {
        self.mapping.scale
    }

    /// Returns how wide a pixel is where its ray ends: what levels and filters go by.
    pub fn footprint(&self) -> Footprint {
        self.mapping.footprint()
    }

    /// Widest angle between neighbouring pixels, radians: on a planar screen that at its centre (the patent's A_PIX); 0 on
    /// an orthographic one, see [`Self::footprint`].
    pub fn pixel_angle(&self) -> f64 {
        match self.footprint() {
            Footprint::Angle(angle) => angle,
            Footprint::Width(_) => 0.0,
        }
    }

    /// Columns: right, up, forward in world axes.
    pub fn world_from_view(&self) -> DMat3 {
        self.world_from_view
    }

    /// Whether every column of the picture lies in a vertical plane through the eye, with elevation rising from row to row.
    pub fn has_vertical_columns(&self) -> bool {
        match self.screen() {
            Screen::Planar { .. } | Screen::Cylindrical { .. } | Screen::Equirectangular { .. } => {
                self.pose.attitude.is_level()
            }
            Screen::Lens { .. } | Screen::Fisheye { .. } | Screen::Table(_) | Screen::Orthographic { .. } => {
                false
            }
        }
    }

    /// The ray through screen position (`column`, `row`), in pixels; pixel centres lie at half-integers. `None` where the
    /// screen has no picture: outside a fisheye's circle, beyond the poles, where a table has no direction. Positions outside
    /// the frame continue the mapping.
    pub fn ray(&self, column: f64, row: f64) -> Option<Ray> {
        let (origin, direction) = self.mapping.ray(column, row)?;
        let direction = (self.world_from_mapping * direction).normalize();
        if let Screen::Orthographic { .. } = self.screen() {
            // The cosine of 90° is not quite 0 in floating point. Beside the area such rays would reach it far below
            // its surface, where parallel rays straight down never do.
            let vertical = direction.z.abs() == 1.0;
            let direction = if vertical { DVec3::Z * direction.z } else { direction };
            return Some(Ray { origin: self.pose.eye + self.world_from_mapping * origin, direction });
        }
        Some(Ray { origin: self.pose.eye, direction })
    }

    /// Directions of the rays through the pixels of a row, from their number after `column` on, on a planar screen; `None` on others.
    ///
    /// They are those of [`Self::ray`] to the bit, without what keeps several of them from being computed at once.
    pub fn planar_directions(&self, column: u32, row: u32) -> Option<impl Fn(u32) -> DVec3 + '_> {
        let first = self.mapped(f64::from(column) + 0.5, f64::from(row) + 0.5);
        let first = first.filter(|_| matches!(self.screen(), Screen::Planar { .. }))?;
        // From pixel to pixel they differ by 1 along the row, without rounding.
        Some(move |pixel| (self.world_from_mapping * (first + DVec3::X * f64::from(pixel))).normalize())
    }

    /// Direction of [`Self::ray`] in axes of which [`Self::world_from_mapping`] tells how they lie: it depends on the screen
    /// and its size alone, not on the pose. Of any length but 0.
    pub fn mapped(&self, column: f64, row: f64) -> Option<DVec3> {
        self.mapping.ray(column, row).map(|(_, direction)| direction)
    }

    /// Columns: the axes that [`Self::mapped`] directions are in, in world axes.
    pub fn world_from_mapping(&self) -> DMat3 {
        self.world_from_mapping
    }

    /// Whether [`Self::mapped`] is the same for both cameras.
    pub fn maps_like(&self, other: &Self) -> bool {
        self.mapping.is_like(&other.mapping)
    }

    /// Direction of [`Self::ray`]; the optical axis where there is no ray.
    pub fn direction(&self, column: f64, row: f64) -> DVec3 {
        self.ray(column, row).map_or(self.world_from_view.z_axis, |ray| ray.direction)
    }

    /// Cosine between the optical axis and the ray of unit `direction`: `Z = range · cos`.
    pub fn axis_cosine(&self, direction: DVec3) -> f64 {
        self.world_from_view.z_axis.dot(direction)
    }

    /// Screen position (column, row) in pixels of a world point, or `None` where no ray of the screen meets it (behind the
    /// eye on a planar one), and on a table, which has no inverse.
    pub fn screen_from_world(&self, point: DVec3) -> Option<DVec2> {
        self.mapping.position(self.world_from_mapping.transpose() * (point - self.pose.eye))
    }
}
