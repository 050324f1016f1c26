//! Outlines of shapes on a planar screen: convex polygons.
//!
//! ```text
//! what of a shape's rim an eye sees      ellipse, corners, or arcs of rings between two lines that touch them
//! its points, on the screen              in order around the outline
//! ```
//!
//! Rings become polygons of the same area, the finer the larger they are on the screen.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::body::PlacedBody;
use super::lens::Lens;
use super::shape::Shape;

/// Points of a ring: some, and so many times the square root of its radius in pixels. A ring of 10 pixels then is a hundredth of a pixel off where it is
/// farthest off.
const POINTS: f64 = 8.0;
const POINTS_PER_ROOT: f64 = 16.0;

/// Points of a ring at most: outlines of 1,000 pixels are a tenth of a pixel off.
const MOST_POINTS: f64 = 400.0;

/// Part of the way to an outline's farthest point below which points lie on the eye's own plane.
const BESIDE: f64 = 1.0e-6;

/// Ring of points, of the area of its circle.
#[derive(Clone, Copy)]
struct OutlineRing {
    points: f64,
    /// Middle, and two half axes.
    middle: DVec3,
    axes: [DVec3; 2],
}

impl OutlineRing {
    fn level(radius: f64, height: f64, points: f64) -> Self {
        Self { points, middle: DVec3::Z * height, axes: [DVec3::X * radius, DVec3::Y * radius] }
    }

    /// Adds the arc from one angle to another, radians, both ends included.
    fn arc(&self, from: f64, to: f64, points: &mut Vec<DVec3>) {
        let steps = (self.points * (to - from).abs() / TAU).ceil().max(1.0);
        let step = (to - from) / steps;
        let wide = if step == 0.0 { 1.0 } else { (step / step.sin()).sqrt() };
        let [(mut sin, mut cos), (turn_sin, turn_cos)] = [from.sin_cos(), step.sin_cos()];
        for _ in 0..=steps as usize {
            points.push(self.middle + wide * (self.axes[0] * cos + self.axes[1] * sin));
            (sin, cos) = (sin * turn_cos + cos * turn_sin, cos * turn_cos - sin * turn_sin);
        }
    }

    fn all(&self, points: &mut Vec<DVec3>) {
        self.arc(0.0, TAU, points);
        points.pop();
    }

    /// The arc up to `half` radians either way from `towards`, or the rest of the ring, from the same end to the same end.
    fn side(&self, towards: f64, half: f64, is_near: bool, points: &mut Vec<DVec3>) {
        let from = towards - half;
        self.arc(from, if is_near { towards + half } else { towards + half - TAU }, points);
    }
}

/// Points on the rim that `eye` (in the shape's axes, metres) sees, so that what lies between them on the screen is what it sees of the shape; in order around it, but
/// for boxes. `radius` of the shape in pixels. None: the eye is inside.
fn rim(shape: &Shape, eye: DVec3, radius: f64, points: &mut Vec<DVec3>) {
    let count = (POINTS + POINTS_PER_ROOT * radius.sqrt()).min(MOST_POINTS).ceil();
    let (distance, towards) = (eye.truncate().length(), eye.y.atan2(eye.x));

    match *shape {
        Shape::Ellipsoid { radii } => {
            let eye = eye / radii;
            let square = eye.length_squared();
            if square > 1.0 {
                let (right, up) = (eye / square.sqrt()).any_orthonormal_pair();
                let half = (1.0 - 1.0 / square).sqrt();
                let axes = [right, up].map(|axis| axis * half * radii);
                OutlineRing { points: count, middle: eye / square * radii, axes }.all(points);
            }
        }

        Shape::Ellipse { radii } => {
            let axes = [DVec3::X * radii.x, DVec3::Y * radii.y];
            OutlineRing { points: count, middle: DVec3::ZERO, axes }.all(points);
        }
        Shape::Box { size } => {
            let corner = |index: usize| {
                let side = |axis: usize| if index >> axis & 1 == 1 { 0.5 } else { -0.5 };
                DVec3::new(side(0), side(1), side(2) + 0.5) * size
            };
            points.extend((0..8).map(corner));
        }

        // An end that is seen whole, or else near half of one end and the far half of the other.
        Shape::Cylinder { radius, height } => {
            let [lower, upper] = [0.0, height].map(|height| OutlineRing::level(radius, height, count));
            if distance <= radius {
                (if eye.z > 0.0 { upper } else { lower }).all(points);
            } else {
                let half = (radius / distance).acos();
                lower.side(towards, half, eye.z > 0.0, points);
                let turn = points.len();
                upper.side(towards, half, eye.z <= height, points);
                points[turn..].reverse();
            }
        }

        // The base as far as the flank does not hide it, and the tip where the flank is seen from a side.
        Shape::Cone { radius, height } => {
            let base = OutlineRing::level(radius, 0.0, count);
            let cosine = radius * (height - eye.z) / (height * distance);
            if cosine.abs() < 1.0 {
                base.side(towards, cosine.acos(), eye.z > 0.0, points);
                points.push(DVec3::Z * height);
            } else {
                base.all(points);
            }
        }
    }
}

/// Ends of the two lines in which an eye sees a cylinder end at its sides; none if it sees none of these.
fn sides(radius: f64, height: f64, eye: DVec3, points: &mut Vec<DVec3>) {
    let half = (radius / eye.truncate().length()).acos();
    if half.is_nan() {
        return;
    }
    let towards = eye.y.atan2(eye.x);
    let at = |angle: f64, height: f64| (radius * DVec2::from_angle(angle)).extend(height);
    let ends = [(-half, 0.0), (half, 0.0), (half, height), (-half, height)];
    points.extend(ends.map(|(angle, height)| at(towards + angle, height)));
}

/// The convex polygon around some points, in order around it.
fn hull(points: &mut Vec<DVec2>) {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut around: Vec<DVec2> = Vec::with_capacity(2 * points.len());
    let mut half = |ordered: &mut dyn Iterator<Item = &DVec2>| {
        let first = around.len();
        for point in ordered {
            while let [.., before, last] = &around[first..]
                && (*last - *before).perp_dot(*point - *before) <= 0.0
            {
                around.pop();
            }
            around.push(*point);
        }
        around.pop();
    };
    half(&mut points.iter());
    half(&mut points.iter().rev());
    *points = around;
}

/// Memory for outlines, one at a time.
#[derive(Debug, Default)]
pub(super) struct Outline {
    rim: Vec<DVec3>,
    /// Columns and rows of the screen, in order around it.
    pub points: Vec<DVec2>,
}

impl Outline {
    /// Finds the outline of a `shape` in the place of `body`; false: part of it is beside or behind the eye, or the screen is not planar.
    pub fn find(&mut self, lens: &Lens<'_>, body: &PlacedBody, shape: &Shape) -> bool {
        let Some(screen_from_world) = lens.projection() else { return false };
        let (eye, offset) = (lens.camera.pose.eye, body.position - lens.camera.pose.eye);
        let pixels = body.radius / lens.camera.footprint().at((body.centre - eye).length());
        self.rim.clear();
        self.points.clear();

        match *shape {
            Shape::Cylinder { radius, height } if body.is_part => {
                sides(radius, height, body.eye(), &mut self.rim);
            }
            _ => rim(shape, body.eye(), pixels, &mut self.rim),
        }

        let screen_from_body = screen_from_world * body.body_from_world.transpose();
        let start = screen_from_world * offset;
        for point in &self.rim {
            let place = screen_from_body * *point + start;
            if place.z <= BESIDE * place.truncate().length() {
                return false;
            }
            self.points.push(place.truncate() / place.z);
        }

        if matches!(shape, Shape::Box { .. }) {
            hull(&mut self.points);
        }

        self.points.len() > 2
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::earth::Curvature;
    use crate::objects::Body;
    use crate::objects::view::nearest;
    use crate::space::{Attitude, Camera, Pose};

    const SHAPES: [Shape; 7] = [
        Shape::Ellipsoid { radii: DVec3::splat(4.0) },
        Shape::Ellipsoid { radii: DVec3::new(9.0, 3.0, 5.0) },
        Shape::Box { size: DVec3::new(8.0, 3.0, 12.0) },
        Shape::Cylinder { radius: 4.0, height: 12.0 },
        Shape::Cone { radius: 5.0, height: 14.0 },
        Shape::disc(8.0),
        Shape::Ellipse { radii: DVec2::new(9.0, 2.5) },
    ];

    /// How far a place lies inside of a convex polygon, pixels; negative outside.
    fn depth(points: &[DVec2], place: DVec2) -> f64 {
        let next = points.iter().cycle().skip(1);
        let turn: f64 = points.iter().zip(next.clone()).map(|(a, b)| a.perp_dot(*b)).sum();
        let edges = points.iter().zip(next).filter(|(a, b)| a != b);
        let depths = edges.map(|(a, b)| turn.signum() * (*b - *a).normalize().perp_dot(place - *a));
        depths.fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn rays_meet_a_shape_where_they_pass_through_its_outline() {
        let mut outline = Outline::default();
        let mut all = 0;
        for (turn, shape) in (0..60).flat_map(|turn| SHAPES.map(|shape| (turn, shape))) {
            let part = |step: f64| (f64::from(turn) * step).fract();
            // From all sides, straight above and below among them.
            let tilt = [-90.0, 90.0, 180.0 * part(0.618) - 90.0, 20.0 * part(0.37)][turn as usize % 4];
            let view = Attitude { yaw: 360.0 * part(0.414), pitch: tilt, roll: 50.0 * part(0.77) };
            let ahead = view.world_from_view().z_axis;
            let eye = DVec3::new(500_000.0, 4_000_000.0, 300.0);
            let aside = DVec3::new(3.0 * part(0.11), 2.0 * part(0.23), 0.0);
            let attitude =
                Attitude { yaw: 90.0 * part(0.3), pitch: [0.0, 30.0][turn as usize % 2], roll: 0.0 };
            let distance = [20.0, 90.0, 3000.0][turn as usize % 3];
            let position = eye + ahead * distance + aside;
            let camera = Camera::new(Pose { eye, attitude: view, hfov: 60.0 }, 200, 160);
            let body = Body { id: 0, form: shape.into(), position, attitude, albedo: Vec3::ONE, priority: 0 };
            let placed = PlacedBody::parts(&body, eye, camera.footprint(), Curvature::FLAT).remove(0);
            let lens = Lens::new(&camera);
            assert!(outline.find(&lens, &placed, &shape), "{turn}, {shape:?}");
            let points = &outline.points;
            let (low, high) =
                points.iter().fold((points[0], points[0]), |(low, high), at| (low.min(*at), high.max(*at)));
            let mut met = 0;

            for step in 0..300 {
                let at = |by: f64| 1.4 * (f64::from(step) * by).fract() - 0.2;
                let place = low + (high - low) * DVec2::new(at(0.618), at(0.755));
                let depth = depth(points, place);
                if depth.abs() > 0.05 {
                    let line = lens.line(place).unwrap();
                    let hit = nearest(std::iter::once(&placed), &line, camera.footprint());
                    assert_eq!(hit.is_some(), depth > 0.0, "{turn}, {shape:?} at {place}: {depth}");
                    met += i32::from(hit.is_some());
                }
            }

            all += met;
        }

        assert!(all > 10_000, "{all}");
    }

    #[test]
    fn what_reaches_behind_the_eye_has_none() {
        let camera =
            Camera::new(Pose { eye: DVec3::ZERO, attitude: Attitude::default(), hfov: 60.0 }, 200, 160);
        let mut outline = Outline::default();
        for (shape, position) in [
            (SHAPES[0], DVec3::ZERO),
            (SHAPES[2], DVec3::new(0.0, 1.0, -2.0)),
            (SHAPES[5], DVec3::new(0.0, 2.0, -1.0)),
        ] {
            let body = Body {
                id: 0,
                form: shape.into(),
                position,
                attitude: Attitude::default(),
                albedo: Vec3::ONE,
                priority: 0,
            };
            let placed = PlacedBody::parts(&body, DVec3::ZERO, camera.footprint(), Curvature::FLAT).remove(0);
            assert!(!outline.find(&Lens::new(&camera), &placed, &shape), "{shape:?}");
        }
    }
}
