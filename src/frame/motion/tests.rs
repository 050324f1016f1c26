use glam::Vec3;

use super::*;
use crate::objects::Shape;
use crate::space::{Attitude, Pose};

const SIZE: [u32; 2] = [65, 37];

fn camera(eye: [f64; 3], yaw: f64) -> Camera {
    let attitude = Attitude { yaw, ..Attitude::default() };
    Camera::new(Pose { eye: eye.into(), attitude, hfov: 60.0 }, SIZE[0], SIZE[1])
}

/// A frame of which `range` tells how far each ray goes.
fn frame(camera: &Camera, range: impl Fn(Ray) -> f64) -> Frame {
    let mut frame = Frame::sky(camera.clone());
    let pixels = (0..SIZE[1]).flat_map(|row| (0..SIZE[0]).map(move |column| (column, row)));
    frame.range = pixels
        .map(|(column, row)| {
            camera.ray(f64::from(column) + 0.5, f64::from(row) + 0.5).map_or(f64::INFINITY, &range) as f32
        })
        .collect();
    frame
}

fn step<'s>(camera: &'s Camera, bodies: [&'s [Body]; 2]) -> MotionStep<'s> {
    MotionStep { camera, bodies, curvature: Curvature::FLAT, is_backward: false }
}

/// Vectors, each with its pixel's place from the picture's centre, right and up.
fn vectors(frame: &Frame, step: &MotionStep<'_>) -> Vec<([f64; 2], [f64; 2])> {
    let vectors = motion(frame, step, &Farm::new(2).unwrap()).unwrap();
    let width = SIZE[0] as usize;
    let place = |pixel: usize| {
        let [column, row] = [pixel % width, pixel / width].map(|place| place as f64 + 0.5);
        [column - 0.5 * f64::from(SIZE[0]), 0.5 * f64::from(SIZE[1]) - row]
    };
    vectors.iter().enumerate().map(|(pixel, vector)| (place(pixel), vector.map(f64::from))).collect()
}

#[track_caller]
fn close(own: [f64; 2], exact: [f64; 2]) {
    // Ranges are floats.
    let near = |own: f64, exact: f64| (own - exact).abs() < 1e-3 + 1e-5 * exact.abs();
    assert!(near(own[0], exact[0]) && near(own[1], exact[1]), "{own:?} {exact:?}");
}

/// x' = f tan(α − δ), y' = y cos α / cos(α − δ), for the sky as for anything else.
#[test]
fn a_turn_moves_everything_by_its_angle() {
    let (now, then) = (camera([0.0, 0.0, 100.0], 20.0), camera([0.0, 0.0, 100.0], 23.0));
    let (turn, focal) = (3.0_f64.to_radians(), now.focal_px());
    for range in [7.0, 12_000.0, f64::INFINITY] {
        for ([x, y], vector) in vectors(&frame(&now, |_| range), &step(&then, [&[], &[]])) {
            let from = (x / focal).atan();
            let to = from - turn;
            close(vector, [focal * to.tan() - x, y * from.cos() / to.cos() - y]);
        }
    }
}

/// Forward over a plain by d, at depth Z: x' = x Z / (Z − d); what is passed has no position.
#[test]
fn a_plain_flows_away_from_the_point_flown_to() {
    let (height, advance) = (40.0, 25.0);
    let (now, then) = (camera([0.0, 0.0, height], 0.0), camera([0.0, advance, height], 0.0));
    let plain = |ray: Ray| if ray.direction.z < 0.0 { height / -ray.direction.z } else { f64::INFINITY };
    let found = vectors(&frame(&now, plain), &step(&then, [&[], &[]]));
    let mut passed = 0;

    for ([x, y], vector) in &found {
        let depth = now.focal_px() * height / -y;
        if *y > -1e-9 {
            close(*vector, [0.0; 2]);
        } else if depth > advance + 1.0 {
            let share = advance / (depth - advance);
            close(*vector, [x * share, y * share]);
        } else {
            passed += usize::from(depth < advance);
        }
    }

    // Flown backwards in time, it is the same step.
    let back = MotionStep { is_backward: true, ..step(&now, [&[], &[]]) };
    for ([x, y], vector) in vectors(&frame(&then, plain), &back) {
        let depth = now.focal_px() * height / -y;
        if y < -1e-9 {
            let share = advance / (depth + advance);
            close(vector, [x * share, y * share]);
        }
    }

    assert_eq!(passed, 0, "at this height nothing in sight is passed");
}

#[test]
fn what_is_passed_stays_put() {
    let (now, then) = (camera([0.0, 0.0, 40.0], 0.0), camera([0.0, 500.0, 40.0], 0.0));
    let found = vectors(&frame(&now, |_| 300.0), &step(&then, [&[], &[]]));
    assert!(found.iter().all(|(_, vector)| *vector == [0.0; 2]));
    // What is nearly reached flies beyond all bounds.
    let (now, then) = (camera([0.0; 3], 0.0), camera([0.0, 299.999_999_9, 0.0], 0.0));
    let wall = |ray: Ray| 300.0 / ray.direction.y;
    let found = vectors(&frame(&now, wall), &step(&then, [&[], &[]]));
    assert!(found.iter().flat_map(|(_, vector)| vector).all(|pixels| pixels.abs() <= 65_504.0));
}

fn body(id: u32, position: [f64; 3], yaw: f64) -> Body {
    Body {
        id,
        form: Shape::disc(1.0).into(),
        position: position.into(),
        attitude: Attitude { yaw, ..Attitude::default() },
        albedo: Vec3::ONE,
        priority: 0,
    }
}

/// A wall across the view at a depth of 100 m that all pixels see.
fn wall_of(camera: &Camera, id: u32) -> Frame {
    let mut wall = frame(camera, |ray| 100.0 / ray.direction.y);
    wall.level.fill(Frame::BODY_LEVEL);
    wall.id.fill(Frame::body_id(id));
    wall
}

#[test]
fn bodies_take_their_pixels_with_them() {
    let eye = camera([0.0; 3], 0.0);
    let per_metre = eye.focal_px() / 100.0;
    // In any order; of another body nothing is asked.
    let now = [body(3, [0.0, 100.0, 0.0], 30.0), body(1, [0.0; 3], 0.0)];
    let then = [body(1, [9.0; 3], 50.0), body(3, [2.0, 100.0, -1.0], 30.0)];
    for (_, vector) in vectors(&wall_of(&eye, 3), &step(&eye, [&now, &then])) {
        close(vector, [2.0 * per_metre, -per_metre]);
    }
    // A quarter turn about its own place takes what is on its right to its front.
    let [now, then] = [[body(3, [0.0, 100.0, 0.0], 0.0)], [body(3, [0.0, 100.0, 0.0], -90.0)]];
    for ([x, y], vector) in vectors(&wall_of(&eye, 3), &step(&eye, [&now, &then])) {
        let depth = 100.0 + x / per_metre;
        close(vector, [-x, y * 100.0 / depth - y]);
    }
    // One that is not there any more stays.
    for (_, vector) in vectors(&wall_of(&eye, 3), &step(&eye, [&now, &[]])) {
        close(vector, [0.0; 2]);
    }
}

#[test]
fn curvature_lowers_a_point_by_its_distance_from_either_eye() {
    let curvature = Curvature::standard();
    let (now, then) = (camera([0.0, 0.0, 100.0], 0.0), camera([0.0, 20_000.0, 100.0], 0.0));
    // Ground of the database 60 km north, at the height of the eye: 242 m low from here, 107 m low from there.
    let ground = 60_000.0;
    let far = |ray: Ray| ground / ray.direction.y;
    let curved = MotionStep { curvature, ..step(&then, [&[], &[]]) };
    for ([x, y], vector) in vectors(&frame(&now, far), &curved) {
        let across = x / now.focal_px() * ground;
        let [here, there] = [ground, ground - 20_000.0].map(|ahead| curvature.drop_at(ahead.hypot(across)));
        let up = y / now.focal_px() * ground + here - there;
        let scale = now.focal_px() / (ground - 20_000.0);
        close(vector, [across * scale - x, up * scale - y]);
    }
}

#[test]
fn around_the_eye_the_shorter_way_counts() {
    let pose =
        |yaw: f64| Pose { attitude: Attitude { yaw, ..Attitude::default() }, ..camera([0.0; 3], 0.0).pose };
    let round = |yaw| {
        Camera::with_screen(pose(yaw), Screen::Equirectangular { hfov: 360.0, vfov: 180.0 }, SIZE[0], SIZE[1])
    };
    let found = vectors(&frame(&round(0.0), |_| 50.0), &step(&round(10.0), [&[], &[]]));
    for (_, vector) in found {
        close(vector, [-10.0 / 360.0 * f64::from(SIZE[0]), 0.0]);
    }
}

#[test]
fn a_map_moves_as_a_whole_and_its_sky_does_not() {
    let map = |x: f64| {
        let attitude = Attitude { pitch: -90.0, ..Attitude::default() };
        let pose = Pose { eye: DVec3::new(x, 0.0, 500.0), attitude, hfov: 60.0 };
        Camera::with_screen(pose, Screen::Orthographic { width: 130.0 }, SIZE[0], SIZE[1])
    };
    for (range, u) in [(450.0, -1.5), (f64::INFINITY, 0.0)] {
        for (_, vector) in vectors(&frame(&map(0.0), |_| range), &step(&map(3.0), [&[], &[]])) {
            close(vector, [u, 0.0]);
        }
    }
}
