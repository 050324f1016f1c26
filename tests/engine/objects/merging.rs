//! What bodies must not depend on: their order, the cut into tasks, how many screens there are.

use std::collections::BTreeSet;

use glam::{DVec3, Vec3};

use super::meshes::{cuboid, globe, model};
use super::{FARM, PLAIN, black, options};
use crate::scene::{Terrain, View};
use hedgehop::frame::Frame;
use hedgehop::objects::{Body, Form, Shape};
use hedgehop::render::{Engine, Renderer};
use hedgehop::space::{Attitude, Camera, Pose, Screen};
use hedgehop::subimage::{Farm, TaskSize};

/// Bodies of all shapes, and models, in each other's way, some of them in the ground.
fn crowd() -> Vec<Body> {
    let cube = model(cuboid(DVec3::new(9.0, 14.0, 7.0)));
    let ball = model(globe(8.0, 24));
    (0..60)
        .map(|id| {
            let part = |step: f64| (f64::from(id) * step).fract();
            let place = [440.0 + 160.0 * part(0.618), 330.0 + 150.0 * part(0.414), 30.0 * part(0.732)];
            let form: Form = match id % 7 {
                0 => Shape::Ellipsoid { radii: DVec3::new(6.0, 14.0, 4.0) }.into(),
                1 => Shape::Box { size: DVec3::new(10.0, 5.0, 12.0) }.into(),
                2 => Shape::Cylinder { radius: 4.0, height: 20.0 }.into(),
                3 => Shape::Cone { radius: 8.0, height: 16.0 }.into(),
                4 => Shape::disc(11.0).into(),
                5 => cube.clone().into(),
                _ => ball.clone().into(),
            };

            let attitude =
                Attitude { yaw: 360.0 * part(0.27), pitch: 30.0 * part(0.51), roll: 40.0 * part(0.77) };
            let albedo = Vec3::new(part(0.3) as f32, part(0.7) as f32, part(0.9) as f32);

            Body { id, attitude, albedo, ..black(form, place) }
        })
        .collect()
}

/// Everything of a frame, as bits.
fn bits(frame: &Frame) -> Vec<u32> {
    let triples = frame.colour.iter().chain(&frame.normal).flatten().map(|value| value.to_bits());
    let rest = frame.range.iter().map(|range| range.to_bits()).chain(frame.id.iter().copied());
    triples.chain(rest).chain(frame.level.iter().map(|level| u32::from(*level))).collect()
}

fn camera() -> Camera {
    let eye = DVec3::new(500.0, 200.0, 60.0);
    View { eye, ypr: [5.0, -12.0, 15.0], hfov: 60.0, size: [251, 173] }.camera()
}

#[test]
fn order_workers_and_tasks_change_nothing() {
    let bodies = crowd();
    let renderer = Renderer::new(&*PLAIN, &options(Engine::Planes));
    let camera = camera();
    let first = renderer.frame_with(&camera, &bodies, &FARM).unwrap().frame;
    let visible = first.id.iter().zip(&first.level).filter(|(_, level)| **level == Frame::BODY_LEVEL);
    let seen: BTreeSet<_> = visible.map(|(id, _)| id).collect();
    assert!(seen.len() > 40, "{} bodies are seen", seen.len());
    let (picture, _) = renderer.picture_with(&camera, &bodies, &FARM).unwrap();
    let mut turned = bodies.clone();

    for turn in 1..6 {
        turned.rotate_left(7 * turn);
        turned.swap(0, turn * 9);
        let farm = Farm::new(turn).unwrap();
        let rows = [1, 5, 18, 31, 64][turn - 1];
        let farm = farm.with_task_size(TaskSize { lines: 16 * turn as u32, rows });
        let frame = renderer.frame_with(&camera, &turned, &farm).unwrap().frame;
        assert!(bits(&frame) == bits(&first), "turn {turn}");
        assert!(renderer.picture_with(&camera, &turned, &farm).unwrap().0 == picture, "turn {turn}");
    }
}

#[test]
fn pictures_hold_the_light_of_frames() {
    let renderer = Renderer::new(&*PLAIN, &options(Engine::Planes));
    let camera = camera();
    let frame = renderer.frame_with(&camera, &crowd(), &FARM).unwrap().frame;
    let (picture, _) = renderer.picture_with(&camera, &crowd(), &FARM).unwrap();
    let rgb = hedgehop::colour::srgb8_picture(&frame.colour);
    let most = rgb.iter().zip(&picture.rgb).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
    // Ground was rounded to 8 bits before it was covered.
    assert!(most <= 3, "{most} steps");
}

#[test]
fn without_bodies_in_sight_nothing_changes() {
    let renderer = Renderer::new(&*PLAIN, &options(Engine::Planes));
    let camera = camera();
    let behind = [black(Shape::Cone { radius: 5.0, height: 9.0 }, [500.0, 100.0, 0.0])];
    // Behind a hill of its own: under the ground.
    let hidden = [black(Shape::Cylinder { radius: 30.0, height: 20.0 }, [500.0, 400.0, -25.0])];
    let plain = renderer.frame(&camera, &FARM).unwrap().frame;
    for bodies in [behind, hidden] {
        let frame = renderer.frame_with(&camera, &bodies, &FARM).unwrap().frame;
        assert!(bits(&frame) == bits(&plain));
        assert!(
            renderer.picture_with(&camera, &bodies, &FARM).unwrap().0
                == renderer.picture(&camera, &FARM).unwrap().0
        );
    }
}

#[test]
fn screens_that_abut_show_one_picture() {
    let renderer = Renderer::new(&*PLAIN, &options(Engine::Planes));
    let attitude = Attitude { yaw: 5.0, ..Attitude::default() };
    let pose = Pose { eye: camera().pose.eye, attitude, hfov: 60.0 };
    let screen = |hfov| Screen::Cylindrical { hfov };
    let wide = Camera::with_screen(pose, screen(80.0), 320, 120);
    let all = renderer.frame_with(&wide, &crowd(), &FARM).unwrap().frame;

    for (side, first) in [(-20.0, 0), (20.0, 160)] {
        let channel = Attitude { yaw: side, ..Attitude::default() };
        let half = Camera::with_channel(pose, channel, screen(40.0), 160, 120);
        let frame = renderer.frame_with(&half, &crowd(), &FARM).unwrap().frame;
        let bodies = frame.level.iter().filter(|level| **level == Frame::BODY_LEVEL).count();
        assert!(bodies > 500, "{bodies} pixels of bodies");

        for pixel in 0..frame.id.len() {
            let other = pixel / 160 * 320 + first + pixel % 160;
            if [frame.level[pixel], all.level[other]].contains(&Frame::BODY_LEVEL) {
                assert_eq!(
                    frame.id[pixel],
                    all.id[other],
                    "pixel {pixel} {other} {:?} {:?} {:?}",
                    frame.range[pixel],
                    all.range[other],
                    frame.camera.ray(0.5, 0.5)
                );
                assert!((frame.range[pixel] / all.range[other] - 1.0).abs() < 1e-5, "pixel {pixel}");
            }
        }
    }
}

#[test]
fn hills_hide_what_is_behind_them() {
    let ridge = |place: glam::DVec2| 80.0 * (1.0 - (place.y - 350.0).abs() / 60.0).max(0.0);
    let world = Terrain::new([500, 500], 2.0, ridge, |_| [120; 3]).in_memory();
    let view = View { eye: DVec3::new(500.0, 100.0, 40.0), ypr: [0.0; 3], hfov: 60.0, size: [160, 120] };
    let tower = |height: f64| [black(Shape::Cylinder { radius: 10.0, height }, [500.0, 450.0, 0.0])];
    for engine in [Engine::Planes, Engine::Reference] {
        let top = |height: f64| super::shares(engine, &world, &view, &tower(height)).iter().sum::<f64>();
        // The sight line over the crest, 80 m at 250 m, is 96 m high 100 m behind it.
        assert!(top(94.0) < 0.5, "{engine:?}: {}", top(94.0));
        let seen = top(120.0);
        let focal = 80.0 / 30.0_f64.to_radians().tan();
        let expected = focal * focal * 20.0 * 24.0 / (340.0 * 340.0);
        assert!((seen / expected - 1.0).abs() < 0.1, "{engine:?}: {seen} pixels instead of {expected}");
    }
}
