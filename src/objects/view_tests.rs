use glam::{DVec2, Vec3};

use super::*;
use crate::objects::{PixelGround, Shape};
use crate::simd::Isa;
use crate::space::{Attitude, Pose};

/// Bodies of all shapes about an eye, some of them across the plane beside it.
fn bodies(eye: DVec3) -> Vec<Body> {
    (0..48)
        .map(|id| {
            let part = |step: f64| (f64::from(id) * step).fract();
            let form: crate::objects::Form = match id % 4 {
                0 => Shape::Ellipse { radii: DVec2::new(2.0 + 9.0 * part(0.37), 4.0) }.into(),
                1 => Shape::disc(5.0).into(),
                2 => Shape::Ellipsoid { radii: DVec3::new(4.0, 1.0, 2.0) }.into(),
                _ => Shape::Ellipse { radii: DVec2::new(0.2, 7.0) }.into(),
            };
            let aside =
                DVec3::new(80.0 * part(0.618) - 40.0, 150.0 * part(0.414) - 6.0, 50.0 * part(0.732) - 25.0);
            Body {
                id,
                form,
                position: eye + aside,
                attitude: Attitude {
                    yaw: 360.0 * part(0.27),
                    pitch: 90.0 * part(0.51),
                    roll: 90.0 * part(0.77),
                },
                albedo: Vec3::ONE,
                priority: (id % 3) as i32,
            }
        })
        .collect()
}

/// Everything that is seen of bodies, as bits, by pixel.
fn look(view: &BodyView<'_>, height: u32) -> Vec<(usize, usize, [u32; 7])> {
    let mut seen = Vec::new();
    for row in (0..height as usize).step_by(SQUARE) {
        for square in view.squares(row) {
            square.look(
                Isa::best(),
                |_, _| PixelGround::default(),
                |hit, _| hit.normal * hit.range as f32,
                |row, column, light| {
                    let [x, y, z] = light.colour.to_array().map(f32::to_bits);
                    let range = light.hit.range.to_bits();
                    let numbers =
                        [x, y, z, light.share.to_bits(), light.hit.id, range as u32, (range >> 32) as u32];
                    seen.push((row, column, numbers));
                },
            );
        }
    }
    seen.sort_unstable();
    seen
}

#[test]
fn bounds_of_bodies_change_no_bit() {
    let eye = DVec3::new(500_000.0, 4_000_000.0, 60.0);
    let pose = Pose { eye, attitude: Attitude { yaw: 10.0, pitch: -5.0, roll: 25.0 }, hfov: 70.0 };
    let camera = Camera::new(pose, 203, 161);
    let bodies = bodies(eye);
    let view = BodyView::new(&camera, &bodies, Curvature::FLAT);
    assert!(
        view.bodies.iter().any(|body| body.is_bounded) && view.bodies.iter().any(|body| !body.is_bounded)
    );

    let placed =
        bodies.iter().flat_map(|body| PlacedBody::parts(body, eye, camera.footprint(), Curvature::FLAT));
    let everywhere =
        placed.map(|placed| ShownBody { placed, columns: 0..203, rows: 0..161, is_bounded: true });
    let mut all: Vec<ShownBody> = everywhere.collect();
    all.sort_by(|one, other| by_rank(&one.placed, &other.placed));
    let unbounded = BodyView { lens: Lens::new(&camera), bodies: all };

    let (bounded, unbounded) = (look(&view, 161), look(&unbounded, 161));
    assert!(bounded.len() > 3000, "{} pixels", bounded.len());
    assert!(bounded == unbounded);
}
