//! Positions of points of the world on a screen, also on tables, which have no inverse.

use glam::{DVec2, DVec3};

use crate::space::{Camera, Screen};

/// Pixels from one known position of a table to the next.
const STRIDE: usize = 8;

/// Steps of Newton's method from there to where a point is.
const STEPS: usize = 4;

/// Finds where a screen shows points of the world.
pub(super) struct Finder<'c> {
    camera: &'c Camera,
    /// Directions of every [`STRIDE`]th position of a table lens, which has no inverse.
    samples: Vec<(DVec3, DVec2)>,
}

impl<'c> Finder<'c> {
    /// Looks at the screen of `camera`.
    pub fn new(camera: &'c Camera) -> Self {
        let mut samples = Vec::new();
        if let Screen::Table(_) = camera.screen() {
            for row in (0..=camera.height as usize).step_by(STRIDE) {
                for column in (0..=camera.width as usize).step_by(STRIDE) {
                    let at = DVec2::new(column as f64, row as f64);
                    samples.extend(camera.ray(at.x, at.y).map(|ray| (ray.direction, at)));
                }
            }
        }
        Self { camera, samples }
    }

    /// Position of a world point, pixels; `None` where the screen does not show it.
    pub fn position(&self, point: DVec3) -> Option<DVec2> {
        let Screen::Table(_) = self.camera.screen() else { return self.camera.screen_from_world(point) };
        let towards = (point - self.camera.pose.eye).normalize();
        let nearest = self.samples.iter().max_by(|a, b| a.0.dot(towards).total_cmp(&b.0.dot(towards)));
        self.refined(towards, nearest?.1)
    }

    /// [`Self::position`] of a point that is seen near to a known position, if one is given.
    pub fn position_near(&self, point: DVec3, known: Option<DVec2>) -> Option<DVec2> {
        let refined = || self.refined((point - self.camera.pose.eye).normalize(), known?);
        match self.camera.screen() {
            Screen::Table(_) => refined().or_else(|| self.position(point)),
            _ => self.position(point),
        }
    }

    /// Position of a direction on a table, from one near to it.
    fn refined(&self, towards: DVec3, mut at: DVec2) -> Option<DVec2> {
        let ray = |at: DVec2| self.camera.ray(at.x, at.y).map(|ray| ray.direction);

        for _ in 0..STEPS {
            let here = ray(at)?;
            let across = ray(at + DVec2::new(0.5, 0.0))? - ray(at - DVec2::new(0.5, 0.0))?;
            let along = ray(at + DVec2::new(0.0, 0.5))? - ray(at - DVec2::new(0.0, 0.5))?;
            // Least squares in the plane of both.
            let (aa, ab, bb) = (across.length_squared(), across.dot(along), along.length_squared());
            let (a, b) = (across.dot(towards - here), along.dot(towards - here));
            let scale = aa * bb - ab * ab;
            let step = DVec2::new(a * bb - b * ab, b * aa - a * ab) / scale;
            let step = step.clamp(DVec2::splat(-(STRIDE as f64)), DVec2::splat(STRIDE as f64));
            if !step.is_finite() {
                return None;
            }
            at += step;
        }

        let off = ray(at)?.dot(towards);
        (off > self.camera.pixel_angle().cos()).then_some(at)
    }
}
