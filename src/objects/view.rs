//! Bodies that a camera sees, square by square of its pixels.

use std::ops::Range;

use glam::{DVec2, DVec3, Vec3};

use super::Body;
use super::body::PlacedBody;
use super::lens::{Lens, Line};
use super::rank::{by_rank, limit};
use crate::earth::Curvature;
use crate::simd::LANES;
use crate::space::{Camera, Footprint, Ray};

/// Pixels across and along a square: few enough that a small body concerns few, enough that finding its bodies costs little.
pub const SQUARE: usize = 32;

/// Pixels from one ray to the next of those that tell how a square lies.
const STRIDE: usize = 8;

/// Angle of a cone, radians, from which on it is taken for all directions.
const WIDE: f64 = 1.2;

/// Bodies before a camera.
#[derive(Debug)]
pub struct BodyView<'c> {
    lens: Lens<'c>,
    /// Bodies by rank.
    bodies: Vec<ShownBody>,
}

/// A body, and which columns and rows of the screen it may be in.
#[derive(Debug, Clone)]
pub(super) struct ShownBody {
    pub placed: PlacedBody,
    pub columns: Range<usize>,
    pub rows: Range<usize>,
    /// Whether these are known to hold it, and not just all of the screen.
    pub is_bounded: bool,
}

/// Bodies about an eye, whether the screen shows them or not.
#[derive(Debug)]
pub struct Surroundings {
    placed: Vec<PlacedBody>,
    footprint: Footprint,
}

/// Hit of a ray on a body.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    /// The body's number.
    pub id: u32,
    /// Metres.
    pub range: f64,
    /// World axes, towards where the ray comes from; of unit length, but of several rays of a face their mean.
    pub normal: Vec3,
    /// The body's linear Rec. 709 reflectance.
    pub albedo: Vec3,
}

/// A square of pixels with bodies in it.
#[derive(Debug)]
pub struct Square<'v> {
    pub(super) lens: Lens<'v>,
    /// Bodies that may be in it, by rank.
    pub(super) bodies: Vec<&'v ShownBody>,
    /// Columns and rows of the screen.
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
}

/// Rays of a square: they start within `width` metres of the origin, and go up to `angle` radians from the axis.
struct RayCone {
    origin: DVec3,
    axis: DVec3,
    angle: f64,
    width: f64,
}

impl Surroundings {
    /// `bodies` about the eye of `camera`.
    pub fn new(camera: &Camera, bodies: &[Body], curvature: Curvature) -> Self {
        let (eye, footprint) = (camera.pose.eye, camera.footprint());
        let placed =
            bodies.iter().flat_map(|body| PlacedBody::parts(body, eye, footprint, curvature)).collect();
        Self { placed, footprint }
    }

    /// Returns the range of the nearest body along a ray from the eye, metres.
    pub fn range(&self, ray: &Ray) -> Option<f64> {
        let line = Line { origin: None, direction: ray.direction };
        nearest(self.placed.iter(), &line, self.footprint).map(|hit| hit.range)
    }
}

impl<'c> BodyView<'c> {
    /// `bodies` before `camera`.
    pub fn new(camera: &'c Camera, bodies: &[Body], curvature: Curvature) -> Self {
        let lens = Lens::new(camera);
        let footprint = camera.footprint();
        let eye = camera.pose.eye;
        let placed = bodies.iter().flat_map(|body| PlacedBody::parts(body, eye, footprint, curvature));
        let mut bodies: Vec<_> = placed.map(|placed| ShownBody::new(placed, &lens)).collect();
        bodies.retain(|body| !body.columns.is_empty() && !body.rows.is_empty());
        bodies.sort_by(|one, other| by_rank(&one.placed, &other.placed));
        Self { lens, bodies }
    }

    /// Whether nothing can be seen of any.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Tells in which parts of rows, [`LANES`] pixels wide, bodies may be, or beside which, `[rows][parts of a row]`; empty if there are no bodies.
    pub fn parts(&self) -> Vec<bool> {
        if self.is_empty() {
            return Vec::new();
        }
        let Camera { width, height, .. } = self.lens.camera;
        let (count, height) = ((*width as usize).div_ceil(LANES), *height as usize);
        let mut parts = vec![false; count * height];
        for ShownBody { columns, rows, .. } in &self.bodies {
            let across = columns.start.saturating_sub(1) / LANES..(columns.end / LANES + 1).min(count);
            for row in rows.start.saturating_sub(1)..(rows.end + 1).min(height) {
                parts[row * count + across.start..row * count + across.end].fill(true);
            }
        }
        parts
    }

    /// The squares that begin at a row of the screen, from the left, but for those that no body is in.
    pub fn squares(&self, row: usize) -> impl Iterator<Item = Square<'_>> {
        let until = |first: usize, size: u32| first..(first + SQUARE).min(size as usize);
        let (width, rows) = (self.lens.camera.width, until(row, self.lens.camera.height));
        let in_rows: Vec<_> = self.bodies.iter().filter(|body| meet(&body.rows, &rows)).collect();
        (0..width as usize).step_by(SQUARE).filter_map(move |column| {
            let (columns, rows) = (until(column, width), rows.clone());
            let mut bodies: Vec<_> =
                in_rows.iter().copied().filter(|body| meet(&body.columns, &columns)).collect();
            if bodies.iter().any(|body| !body.is_bounded) {
                let cone = RayCone::of(self.lens.camera, &columns, &rows)?;
                bodies.retain(|body| body.is_bounded || cone.meets(&body.placed));
            }
            (!bodies.is_empty()).then_some(Square { lens: self.lens, bodies, columns, rows })
        })
    }
}

impl ShownBody {
    fn new(placed: PlacedBody, lens: &Lens<'_>) -> Self {
        let size = [lens.camera.width, lens.camera.height].map(|size| size as usize);
        // A float converts saturating.
        let range = |from: f64, to: f64, size: usize| {
            from.floor() as usize..(to.floor() as usize).saturating_add(1).min(size)
        };
        let bounds = lens.bounds(placed.box_corners());
        let is_bounded = bounds.is_some();
        let bounds = bounds.unwrap_or([DVec2::ZERO, DVec2::MAX]);
        let is_beside = bounds[1].cmplt(DVec2::ZERO).any();
        let [columns, rows] = [0, 1].map(|axis| range(bounds[0][axis], bounds[1][axis], size[axis]));
        Self { placed, columns: if is_beside { 0..0 } else { columns }, rows, is_bounded }
    }
}

fn meet(a: &Range<usize>, b: &Range<usize>) -> bool {
    a.start < b.end && b.start < a.end
}

/// The nearest hit among bodies, which stand by rank: where ranges are equal that of the first.
pub(super) fn nearest<'p>(
    bodies: impl Iterator<Item = &'p PlacedBody>,
    line: &Line,
    footprint: Footprint,
) -> Option<Hit> {
    let mut nearest: Option<(Hit, i32)> = None;
    let metres = line.direction.length();
    for body in bodies {
        if let Some((touch, albedo)) = body.touch(line, footprint)
            && nearest.is_none_or(|(hit, priority)| {
                touch.range * metres < limit(hit.range, body.priority, priority)
            })
        {
            let (range, normal) = (touch.range * metres, touch.normal.as_vec3());
            nearest = Some((Hit { id: body.id, range, normal, albedo }, body.priority));
        }
    }
    nearest.map(|(hit, _)| hit)
}

impl RayCone {
    /// Builds the cone of a square's rays; `None` where none of them has one.
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
    fn meets(&self, body: &PlacedBody) -> bool {
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

#[cfg(test)]
#[path = "view_tests.rs"]
mod tests;
