//! What bodies a camera sees, square by square of its pixels.

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::Body;
use super::body::Placed;
use crate::earth::Curvature;
use crate::space::{Camera, Footprint, Ray};

/// Pixels across and along a square: few enough that a small body concerns few, enough that finding its bodies costs little.
pub const SQUARE: usize = 32;

/// Pixels from one ray to the next of those that tell how a square lies.
const STRIDE: usize = 8;

/// Angle of a cone, radians, from which on it is taken for all directions.
const WIDE: f64 = 1.2;

/// Bodies before a camera.
#[derive(Debug)]
pub struct View<'c> {
    pub(super) camera: &'c Camera,
    /// By id.
    bodies: Vec<Placed>,
}

/// Where a ray meets a body.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    /// The body's number.
    pub id: u32,
    /// Metres.
    pub range: f64,
    /// Of unit length, world axes, towards where the ray comes from.
    pub normal: Vec3,
    /// The body's linear Rec. 709 reflectance.
    pub albedo: Vec3,
}

/// A square of pixels with bodies in it.
#[derive(Debug)]
pub struct Square<'v> {
    pub(super) camera: &'v Camera,
    /// Those that may be in it, by id.
    pub(super) bodies: Vec<&'v Placed>,
    /// Columns and rows of the screen.
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
    /// What the pixels' corners see, row by row.
    pub(super) corners: Vec<Option<Hit>>,
}

/// Rays of a square: they start within `width` metres of the origin, and go up to `angle` radians from the axis.
struct Cone {
    origin: DVec3,
    axis: DVec3,
    angle: f64,
    width: f64,
}

impl<'c> View<'c> {
    /// `bodies` before `camera`.
    pub fn new(camera: &'c Camera, bodies: &[Body], curvature: Curvature) -> Self {
        let mut bodies: Vec<_> =
            bodies.iter().map(|body| Placed::new(body, camera.pose.eye, curvature)).collect();
        bodies.sort_unstable_by_key(|body| body.id);
        Self { camera, bodies }
    }

    /// Whether there are none at all.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// The square that begins at a pixel of the screen; `None`: no body is in it.
    pub fn square(&self, column: usize, row: usize) -> Option<Square<'_>> {
        let until = |first: usize, size: u32| first..(first + SQUARE).min(size as usize);
        let (columns, rows) = (until(column, self.camera.width), until(row, self.camera.height));
        let cone = Cone::of(self.camera, &columns, &rows)?;
        let bodies: Vec<_> = self.bodies.iter().filter(|body| cone.meets(body)).collect();
        if bodies.is_empty() {
            return None;
        }
        let mut square = Square { camera: self.camera, bodies, columns, rows, corners: Vec::new() };
        square.see_corners();
        Some(square)
    }
}

impl Square<'_> {
    /// Its pixels' columns of the screen.
    pub fn columns(&self) -> Range<usize> {
        self.columns.clone()
    }

    /// Its pixels' rows of the screen.
    pub fn rows(&self) -> Range<usize> {
        self.rows.clone()
    }

    fn see_corners(&mut self) {
        let positions = (self.rows.start..=self.rows.end)
            .flat_map(|row| (self.columns.start..=self.columns.end).map(move |column| (column, row)));
        self.corners = positions
            .map(|(column, row)| {
                let ray = self.camera.ray(column as f64, row as f64)?;
                nearest(&self.bodies, &ray)
            })
            .collect();
    }
}

/// The nearest hit among bodies, by id where ranges are equal.
pub(super) fn nearest(bodies: &[&Placed], ray: &Ray) -> Option<Hit> {
    let mut nearest: Option<Hit> = None;
    for body in bodies {
        if let Some(touch) = body.touch(ray)
            && nearest.is_none_or(|hit| touch.range < hit.range)
        {
            nearest = Some(Hit {
                id: body.id,
                range: touch.range,
                normal: touch.normal.as_vec3(),
                albedo: body.albedo,
            });
        }
    }
    nearest
}

impl Cone {
    /// That of a square's rays; `None` where none of them has one.
    fn of(camera: &Camera, columns: &Range<usize>, rows: &Range<usize>) -> Option<Self> {
        let ends = |range: &Range<usize>| {
            (range.start..range.end)
                .step_by(STRIDE)
                .chain([range.end])
                .map(|at| at as f64)
                .collect::<Vec<_>>()
        };
        let (columns, rows) = (ends(columns), ends(rows));
        let positions = rows.iter().flat_map(|row| columns.iter().map(move |column| (*column, *row)));
        let rays: Vec<_> = positions.filter_map(|(column, row)| camera.ray(column, row)).collect();
        let first = rays.first()?;
        let sum: DVec3 = rays.iter().map(|ray| ray.direction).sum();
        let axis = sum.try_normalize().unwrap_or(first.direction);
        let origin = rays.iter().map(|ray| ray.origin).sum::<DVec3>() / rays.len() as f64;
        let most = |value: &dyn Fn(&Ray) -> f64| rays.iter().map(value).fold(0.0, f64::max);
        // Between those that were asked there are others, up to a stride away.
        let (angle, width) = match camera.footprint() {
            Footprint::Angle(angle) => (STRIDE as f64 * angle, 0.0),
            Footprint::Width(width) => (0.0, STRIDE as f64 * width),
        };
        Some(Self {
            origin,
            axis,
            angle: most(&|ray| ray.direction.dot(axis).clamp(-1.0, 1.0).acos()) + angle,
            width: most(&|ray| (ray.origin - origin).length()) + width,
        })
    }

    /// Whether the sphere around a body may reach into it.
    fn meets(&self, body: &Placed) -> bool {
        if self.angle >= WIDE {
            return true;
        }
        let offset = body.centre - self.origin;
        let along = offset.dot(self.axis);
        let across = (offset - self.axis * along).length();
        let (sin, cos) = self.angle.sin_cos();
        // Its distance from the cone's side; behind the tip, no more than that.
        across * cos - along * sin <= body.radius + self.width
    }
}
