//! Positions on the map of what pixels show.
//!
//! ```text
//! pixel ──ray · range──▶ point of the world ──raised by what curvature lowered it──▶ point of the map − offset ──▶ f32
//! ```
//!
//! Floats hold projected coordinates to half a metre, so that positions count from a point near by: half a millimetre
//! up to 16 km from it, and twice that for each doubling.

use glam::DVec3;

use super::motion::raised;
use super::{Frame, MapPositions};
use crate::earth::Curvature;
use crate::objects::Body;
use crate::subimage::Farm;
use crate::voxel::Grid;

/// Unit of offsets, metres: whole kilometres are exact in floats, too.
const OFFSET_UNIT: f64 = 1000.0;

/// Data besides a frame that positions of its pixels need.
#[derive(Debug, Clone, Copy)]
pub struct PositionInputs<'s> {
    /// Point that positions are to count from, metres in the database's reference system.
    pub offset: DVec3,
    /// Curvature of the ground, by which it was lowered.
    pub curvature: Curvature,
    /// Bodies of the frame, in any order.
    pub bodies: &'s [Body],
    /// Rays of each pixel along a side, ≥ 1: ranges are those of the one below and right of the middle.
    pub antialias: u32,
}

/// Height that a body was lowered by.
struct Lowered {
    id: u32,
    drop: f64,
}

/// Returns the point that positions and poses over a grid count from: whole kilometres of its middle, cut towards 0, at the datum's height.
pub fn map_offset(grid: &Grid) -> DVec3 {
    let middle = 0.5 * (grid.origin + grid.far_corner());
    let kilometres = (middle / OFFSET_UNIT).trunc().extend(0.0);
    // A sum with 0 has no negative zero.
    kilometres * OFFSET_UNIT + DVec3::ZERO
}

/// Computes where on the map the points are that a frame's pixels show: as high as in the database, whatever curvature made of them.
pub fn map_positions(frame: &Frame, inputs: &PositionInputs<'_>, farm: &Farm) -> MapPositions {
    let lowered = lowered(frame, inputs);
    let width = frame.camera.width as usize;
    let side = inputs.antialias.max(1);
    let middle = (f64::from(side / 2) + 0.5) / f64::from(side);

    let mut points = vec![[f32::INFINITY; 3]; frame.range.len()];
    farm.rows(&mut points, width, |row, line| {
        for (column, told) in line.iter_mut().enumerate() {
            let pixel = row * width + column;
            let range = f64::from(frame.range[pixel]);
            let ray = frame.camera.ray(column as f64 + middle, row as f64 + middle);
            let Some(ray) = ray.filter(|_| range.is_finite()) else { continue };

            let point = ray.origin + ray.direction * range;
            let body = (frame.level[pixel] == Frame::BODY_LEVEL)
                .then(|| lowered.binary_search_by_key(&frame.id[pixel], |body| Frame::body_id(body.id)).ok())
                .flatten();
            let on_map = match body {
                Some(index) => point + DVec3::Z * lowered[index].drop,
                None => raised(point, &ray, inputs.curvature),
            };
            *told = (on_map - inputs.offset).to_array().map(|metres| metres as f32);
        }
    });

    MapPositions { offset: inputs.offset, points }
}

/// Lists how far each body was lowered as a whole, by id.
fn lowered(frame: &Frame, inputs: &PositionInputs<'_>) -> Vec<Lowered> {
    let eye = frame.camera.pose.eye;
    let drop = |body: &Body| inputs.curvature.drop_at((body.position - eye).truncate().length());
    let mut all: Vec<_> =
        inputs.bodies.iter().map(|body| Lowered { id: body.id, drop: drop(body) }).collect();
    all.sort_unstable_by_key(|body| body.id);
    all
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, Vec3};

    use super::*;
    use crate::objects::{Form, Shape};
    use crate::space::{Attitude, Camera, Pose};

    #[test]
    fn offsets_are_whole_kilometres_near_by() {
        let of = |origin: DVec2, side: u32| {
            map_offset(&Grid { nx: side, ny: side, spacing: 10.0, origin }).to_array()
        };
        assert_eq!(of(DVec2::new(500_123.0, 4_649_776.0), 400), [502_000.0, 4_651_000.0, 0.0]);
        assert_eq!(of(DVec2::ZERO, 160), [0.0; 3]);
        let [x, y, _] = of(DVec2::new(-1100.0, -3700.0), 40);
        assert!((x, y) == (0.0, -3000.0) && x.is_sign_positive());
    }

    /// A frame of 3 × 2 pixels with a range, but for the sky in the first.
    fn frame(pose: Pose, range: f32) -> Frame {
        let mut frame = Frame::sky(Camera::new(pose, 3, 2));
        frame.range[1..].fill(range);
        frame.level[1..].fill(0);
        frame
    }

    #[test]
    fn points_are_those_of_the_map_and_not_of_the_bent_world() {
        let eye = DVec3::new(500_123.25, 4_649_776.5, 900.0);
        let attitude = Attitude { yaw: 33.0, pitch: -3.0, roll: 12.0 };
        let mut frame = frame(Pose { eye, attitude, hfov: 40.0 }, 20_000.0);
        (frame.level[5], frame.id[5]) = (Frame::BODY_LEVEL, Frame::body_id(7));
        let mast = Body {
            id: 7,
            form: Form::Shape(Shape::Ellipsoid { radii: DVec3::ONE }),
            position: eye + DVec3::new(3000.0, 4000.0, 0.0),
            attitude: Attitude::default(),
            albedo: Vec3::ONE,
            priority: 0,
        };

        let offset = DVec3::new(500_000.0, 4_649_000.0, 0.0);
        let curvature = Curvature::standard();
        for antialias in [1, 4] {
            let inputs = PositionInputs { offset, curvature, bodies: std::slice::from_ref(&mast), antialias };
            let MapPositions { points, .. } = map_positions(&frame, &inputs, &Farm::new(2).unwrap());
            assert_eq!(points[0], [f32::INFINITY; 3], "the sky");
            let middle = if antialias == 1 { 0.5 } else { 0.625 };
            for (pixel, drop) in [(1, None), (4, None), (5, Some(curvature.drop_at(5000.0)))] {
                let (column, row) = ((pixel % 3) as f64 + middle, (pixel / 3) as f64 + middle);
                let way = frame.camera.direction(column, row) * 20_000.0;
                let drop = drop.unwrap_or_else(|| curvature.drop_at(way.truncate().length()));
                let exact = eye + way + DVec3::Z * drop - offset;
                let found = DVec3::from_array(points[pixel].map(f64::from));
                assert!(found.distance(exact) < 3e-3, "{pixel}: {found} {exact}");
            }
        }
    }
}
