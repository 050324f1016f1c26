//! A shape or a model in its place.

use std::sync::Arc;

use glam::{DMat3, DVec3, Vec3};

use super::lens::Line;
use super::mesh::{Mesh, MeshHit};
use super::model::Model;
use super::shape::{Shape, Touch};
use crate::earth::Curvature;
use crate::space::{Attitude, Footprint};

/// Appearance of a body from all sides.
#[derive(Debug, Clone)]
pub enum Form {
    /// Something with a closed form.
    Shape(Shape),
    /// Triangles.
    Model(Arc<Model>),
    /// A thin round rod from the origin forward.
    Line {
        /// Metres, > 0.
        length: f64,
        /// Metres, > 0.
        width: f64,
        /// Least width on the screen, pixels, ≥ 0.
        pixels: f64,
    },
    /// A small ball around the origin.
    Point {
        /// Metres, > 0.
        width: f64,
        /// Least width on the screen, pixels, ≥ 0.
        pixels: f64,
    },
}

/// The axes of a line as a cylinder: that stands upright, a line goes forward. Columns: x, y, z of the cylinder.
const FORWARD: DMat3 = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y);

/// Most parts of a line that grow wider with their distance.
const MOST_PARTS: f64 = 40.0;

/// Least ratio of the distances of such a part's end and beginning.
const PART: f64 = 1.2;

/// A shape or a model somewhere in the world.
#[derive(Debug, Clone)]
pub struct Body {
    /// Number that pictures carry; of two of one priority at the same range the lower one is seen. No two have the same.
    pub id: u32,
    /// Appearance from all sides.
    pub form: Form,
    /// The form's origin, metres (x east, y north, z above the datum).
    pub position: DVec3,
    /// Direction of the forward axis (yaw, pitch), and lean of the up axis (roll), degrees.
    pub attitude: Attitude,
    /// Linear Rec. 709 reflectance, 0…1; of a model that of what has no colour of its own.
    pub albedo: Vec3,
    /// Rank among bodies at the same range but for 1/16384 of it: the highest one is seen.
    pub priority: i32,
}

/// Appearance of a form to one eye.
#[derive(Debug, Clone)]
pub(super) enum SeenForm {
    Shape(Shape),
    Mesh(Arc<Mesh>),
}

/// A body as an eye finds it.
#[derive(Debug, Clone)]
pub(super) struct PlacedBody {
    pub id: u32,
    pub priority: i32,
    pub albedo: Vec3,
    pub sight: SeenForm,
    pub position: DVec3,
    pub body_from_world: DMat3,
    /// The eye, in its axes.
    eye: DVec3,
    /// Corners of the box around it, in its axes, metres.
    corners: [DVec3; 2],
    /// Centre of the sphere around it, in the world, metres.
    pub centre: DVec3,
    pub radius: f64,
    /// Whether the body is one of several parts of a line, which go on at its ends.
    pub is_part: bool,
    /// Least extent, metres: two of the three sides of its box are longer.
    pub thickness: f64,
}

impl From<Shape> for Form {
    fn from(shape: Shape) -> Self {
        Self::Shape(shape)
    }
}

impl From<Arc<Model>> for Form {
    fn from(model: Arc<Model>) -> Self {
        Self::Model(model)
    }
}

impl Form {
    /// Least and greatest corner of the box around it, metres: x right, y forward, z up.
    pub fn corners(&self) -> [DVec3; 2] {
        match self {
            Self::Shape(shape) => shape.corners(),
            Self::Model(model) => model.corners(),
            Self::Line { length, width, .. } => {
                let half = DVec3::new(0.5 * width, 0.0, 0.5 * width);
                [-half, half.with_y(*length)]
            }
            Self::Point { width, .. } => [DVec3::splat(-0.5 * width), DVec3::splat(0.5 * width)],
        }
    }

    /// Returns the closed form, and the axes of that in the form's own; `None`: it has none.
    pub(super) fn shape(&self) -> Option<(Shape, DMat3)> {
        match *self {
            Self::Shape(shape) => Some((shape, DMat3::IDENTITY)),
            Self::Model(_) => None,
            Self::Line { length, width, .. } => {
                Some((Shape::Cylinder { radius: 0.5 * width, height: length }, FORWARD))
            }
            Self::Point { width, .. } => {
                Some((Shape::Ellipsoid { radii: DVec3::splat(0.5 * width) }, DMat3::IDENTITY))
            }
        }
    }

    /// Whether it holds up light on the way from a point of its own axes, metres, along `direction` up to `end` times that.
    pub(super) fn blocks(&self, origin: DVec3, direction: DVec3, end: f64) -> bool {
        if let Self::Model(model) = self {
            return model.levels()[0].mesh.blocks(origin, direction, end);
        }
        self.shape().is_some_and(|(shape, axes)| {
            let touch = shape.touch(axes.transpose() * origin, axes.transpose() * direction);
            touch.is_some_and(|touch| touch.range <= end)
        })
    }
}

impl Body {
    /// Middle (metres in the world) and radius (metres) of the sphere around the box around it.
    pub fn sphere(&self) -> (DVec3, f64) {
        let [low, high] = self.form.corners();
        let middle = self.position + self.world_from_body() * (0.5 * (low + high));
        (middle, 0.5 * (high - low).length())
    }

    /// Columns: its axes (right, forward, up) in the world.
    pub fn world_from_body(&self) -> DMat3 {
        self.attitude.world_from_body()
    }

    /// Whether it holds up light on the way from `origin` (metres in the world) along `direction` (of unit length), up to `end` metres: whether it casts
    /// a shadow on `origin`. Nothing bends here.
    pub fn blocks(&self, origin: DVec3, direction: DVec3, end: f64) -> bool {
        let body_from_world = self.world_from_body().transpose();
        self.form.blocks(body_from_world * (origin - self.position), body_from_world * direction, end)
    }
}

impl PlacedBody {
    /// Places `body` as `eye` sees it, lowered by the Earth's curvature with the ground that it stands on: in one part, or a line in several.
    pub fn parts(body: &Body, eye: DVec3, footprint: Footprint, curvature: Curvature) -> Vec<Self> {
        let distance = (body.position - eye).truncate().length();
        let position = body.position - DVec3::Z * curvature.drop_at(distance);
        let world_from_body = body.world_from_body();
        let place = |sight, corners, position, axes| {
            Self::new(body, eye, sight, corners, position, world_from_body * axes)
        };
        let plain = |shape: Shape| (SeenForm::Shape(shape), shape.corners());

        match &body.form {
            Form::Shape(shape) => {
                let (sight, corners) = plain(*shape);
                vec![place(sight, corners, position, DMat3::IDENTITY)]
            }
            Form::Model(model) => {
                let corners @ [low, high] = body.form.corners();
                let distance = (position + world_from_body * (0.5 * (low + high)) - eye).length();
                let mesh = model.at(model.size() / footprint.at(distance));
                let seen =
                    mesh.map(|mesh| place(SeenForm::Mesh(mesh.clone()), corners, position, DMat3::IDENTITY));
                seen.into_iter().collect()
            }
            Form::Point { width, pixels } => {
                let width = width.max(pixels * footprint.at((position - eye).length()));
                let (sight, corners) = plain(Shape::Ellipsoid { radii: DVec3::splat(0.5 * width) });
                vec![place(sight, corners, position, DMat3::IDENTITY)]
            }
            Form::Line { length, width, pixels } => {
                let forward = world_from_body.y_axis;
                let ends = line_parts(eye - position, forward, [*length, *width, *pixels], footprint);
                let part = |(from, to): (&f64, &f64)| {
                    let distance = (position + forward * (0.5 * (from + to)) - eye).length();
                    let radius = 0.5 * width.max(pixels * footprint.at(distance));
                    let (sight, corners) = plain(Shape::Cylinder { radius, height: to - from });
                    place(sight, corners, position + forward * *from, FORWARD)
                };
                let parts = ends.iter().zip(&ends[1..]).map(part);
                parts.map(|part| Self { is_part: ends.len() > 2, ..part }).collect()
            }
        }
    }

    /// `body` as it is seen, with corners of the box around that, where its origin is and which axes it has.
    fn new(
        body: &Body,
        eye: DVec3,
        sight: SeenForm,
        corners: [DVec3; 2],
        position: DVec3,
        world_from_body: DMat3,
    ) -> Self {
        let size = corners[1] - corners[0];
        Self {
            id: body.id,
            priority: body.priority,
            albedo: body.albedo,
            sight,
            position,
            body_from_world: world_from_body.transpose(),
            eye: world_from_body.transpose() * (eye - position),
            corners,
            centre: position + world_from_body * (0.5 * (corners[0] + corners[1])),
            radius: 0.5 * size.length(),
            thickness: size.min_element(),
            is_part: false,
        }
    }

    /// Finds where a ray meets the body first, and its colour there, over `footprint` of it; the normal is of unit length and in world axes.
    pub fn touch(&self, line: &Line, footprint: Footprint) -> Option<(Touch, Vec3)> {
        let (origin, direction) = (self.origin(line), self.body_from_world * line.direction);
        let (range, normal, albedo) = match &self.sight {
            SeenForm::Shape(shape) => {
                let touch = shape.touch(origin, direction)?;
                (touch.range, touch.normal, self.albedo)
            }
            SeenForm::Mesh(mesh) => {
                let metres = footprint.at((self.middle() - origin).length()) as f32;
                let MeshHit { range, triangle, weights, is_behind } =
                    mesh.touch(origin, direction, metres)?;
                let triangle = mesh.triangle_at(triangle);
                let normal = mesh.normal(triangle, weights, is_behind).as_dvec3();
                (range, normal, mesh.colour(triangle, weights, metres, self.albedo))
            }
        };
        let normal = self.body_from_world.transpose() * normal.normalize();
        Some((Touch { range, normal }, albedo))
    }

    /// Returns the axes (right, forward, up) in the world.
    pub fn axes(&self) -> [Vec3; 3] {
        let world_from_body = self.body_from_world.transpose();
        [world_from_body.x_axis, world_from_body.y_axis, world_from_body.z_axis].map(DVec3::as_vec3)
    }

    /// The eye, in its axes, metres.
    pub fn eye(&self) -> DVec3 {
        self.eye
    }

    /// The middle of the box around it, in its axes, metres.
    pub fn middle(&self) -> DVec3 {
        0.5 * (self.corners[0] + self.corners[1])
    }

    /// Corners of the box around it, in the world.
    pub fn box_corners(&self) -> impl Iterator<Item = DVec3> {
        let world_from_body = self.body_from_world.transpose();
        (0..8).map(move |corner| {
            let of = |axis: usize| self.corners[corner >> axis & 1][axis];
            self.position + world_from_body * DVec3::new(of(0), of(1), of(2))
        })
    }

    /// Returns the ray's start in the body's axes.
    fn origin(&self, line: &Line) -> DVec3 {
        match line.origin {
            None => self.eye,
            Some(origin) => self.body_from_world * (origin - self.position),
        }
    }

    /// Whether a ray may come nearer to it than `margin` metres, in front of its origin.
    pub fn is_near(&self, line: &Line, margin: f64) -> bool {
        let origin = self.origin(line);
        if let SeenForm::Shape(shape) = &self.sight
            && let Some((grown, below)) = shape.grown(margin)
        {
            return grown.touch(origin + DVec3::Z * below, self.body_from_world * line.direction).is_some();
        }
        let inverse = (self.body_from_world * line.direction).recip();
        let low = (self.corners[0] - margin - origin) * inverse;
        let high = (self.corners[1] + margin - origin) * inverse;
        let (enter, leave) = (low.min(high).max_element(), low.max(high).min_element());
        enter <= leave && leave >= 0.0
    }
}

/// Divides a line from the origin along `forward`, so long and wide (metres) and at least so many pixels wide, into parts: its beginning, where its parts meet, and its end. Each has one
/// width, in steps of a fifth or so with the distance from `eye`.
fn line_parts(eye: DVec3, forward: DVec3, line: [f64; 3], footprint: Footprint) -> Vec<f64> {
    let [length, width, pixels] = line;
    let nearest = eye.dot(forward);
    let aside = (eye - forward * nearest).length();
    let distance = |at: f64| aside.hypot(at - nearest);
    let farthest = distance(0.0).max(distance(length));

    // Up to there it is wide enough.
    let first = width / (pixels * footprint.at(1.0)).max(f64::MIN_POSITIVE);
    let first = first.max(distance(nearest.clamp(0.0, length)));
    let mut ends = vec![0.0, length];

    if let Footprint::Angle(_) = footprint
        && first < farthest
    {
        let step = PART.max((farthest / first).powf(1.0 / MOST_PARTS));
        let mut at = first * step.sqrt();
        while at < farthest {
            let beside = (at * at - aside * aside).max(0.0).sqrt();
            ends.extend(
                [nearest - beside, nearest + beside].into_iter().filter(|end| *end > 0.0 && *end < length),
            );
            at *= step;
        }
        ends.sort_unstable_by(f64::total_cmp);
        ends.dedup();
    }

    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tower(attitude: Attitude) -> PlacedBody {
        let body = Body {
            id: 1,
            form: Shape::Box { size: DVec3::new(2.0, 10.0, 4.0) }.into(),
            position: DVec3::new(100.0, 200.0, 50.0),
            attitude,
            albedo: Vec3::ONE,
            priority: 0,
        };
        PlacedBody::parts(&body, DVec3::ZERO, Footprint::Angle(1.0e-3), Curvature::FLAT).remove(0)
    }

    fn touch(placed: &PlacedBody, origin: [f64; 3], direction: DVec3) -> Option<Touch> {
        let line = Line { origin: Some(origin.into()), direction };
        placed.touch(&line, Footprint::Angle(1.0e-3)).map(|(touch, _)| touch)
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
            form: Shape::disc(1.0).into(),
            position: DVec3::new(30_000.0, 40_000.0, 100.0),
            attitude: Attitude::default(),
            albedo: Vec3::ONE,
            priority: 0,
        };
        let placed =
            PlacedBody::parts(&body, DVec3::ZERO, Footprint::Angle(1.0e-3), Curvature::standard()).remove(0);
        assert!((100.0 - placed.centre.z - Curvature::standard().drop_at(50_000.0)).abs() < 1e-9);
    }
}
