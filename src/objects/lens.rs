//! Rays of a screen, many per pixel.

use glam::{DMat3, DVec2, DVec3};

use crate::space::{Camera, Ray, Screen};

/// A ray that need not be of unit length.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    /// Metres; `None`: the eye.
    pub origin: Option<DVec3>,
    /// Direction, of any length but 0.
    pub direction: DVec3,
}

/// Rays of a camera.
#[derive(Debug, Clone, Copy)]
pub struct Lens<'c> {
    pub(crate) camera: &'c Camera,
    /// Planar screens: direction of the upper left corner, and what a pixel to the right and a pixel down add to it.
    planar: Option<[DVec3; 3]>,
    /// Inverse of the rays: world directions to columns and rows, times how far they go.
    projection: Option<DMat3>,
}

impl<'c> Lens<'c> {
    /// Builds the rays of `camera`.
    pub fn new(camera: &'c Camera) -> Self {
        let at = |column: f64, row: f64| {
            camera.mapped(column, row).map(|direction| camera.world_from_mapping() * direction)
        };
        let planar = match (camera.screen(), at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)) {
            (Screen::Planar { .. }, Some(corner), Some(right), Some(down)) => {
                Some([corner, right - corner, down - corner])
            }
            _ => None,
        };
        let projection = planar.map(|[corner, right, down]| DMat3::from_cols(right, down, corner).inverse());
        Self { camera, planar, projection }
    }

    /// Planar screens: what takes directions of the world to columns and rows of the screen, times how far they go.
    pub(super) fn projection(&self) -> Option<DMat3> {
        self.projection
    }

    /// The ray through a position of the screen, as [`Camera::ray`], but faster on planar ones; `None` where there is none.
    pub fn ray_at(&self, position: DVec2) -> Option<Ray> {
        self.line(position).map(|line| self.ray(&line))
    }

    /// The ray through a position of the screen.
    pub(super) fn line(&self, position: DVec2) -> Option<Line> {
        if let Some([corner, right, down]) = self.planar {
            return Some(Line { origin: None, direction: corner + right * position.x + down * position.y });
        }
        let ray = self.camera.ray(position.x, position.y)?;
        let is_parallel = matches!(self.camera.screen(), Screen::Orthographic { .. });
        Some(Line { origin: is_parallel.then_some(ray.origin), direction: ray.direction })
    }

    /// Whether rays differ by multiples of what a pixel to the right and one down add to them, all over the screen.
    pub fn is_straight(&self) -> bool {
        self.planar.is_some() || matches!(self.camera.screen(), Screen::Orthographic { .. })
    }

    /// A ray of unit length.
    pub(super) fn ray(&self, line: &Line) -> Ray {
        Ray { origin: line.origin(self.camera), direction: line.direction.normalize() }
    }

    /// Least and greatest position of what lies between some points; `None` where that is not known.
    pub(crate) fn bounds(&self, points: impl Iterator<Item = DVec3>) -> Option<[DVec2; 2]> {
        self.planar?;
        let mut bounds = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        for point in points {
            // Behind the eye there is no position.
            let position = self.camera.screen_from_world(point)?;
            bounds = [bounds[0].min(position), bounds[1].max(position)];
        }
        Some(bounds)
    }
}

impl Line {
    /// Returns the start of the line.
    pub fn origin(&self, camera: &Camera) -> DVec3 {
        self.origin.unwrap_or(camera.pose.eye)
    }
}
