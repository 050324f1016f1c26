//! Lines and points: what is thinner than a pixel keeps its share of it, and what is to be so many pixels wide is.

use std::f64::consts::PI;

use glam::DVec3;

use super::exact::{compare, shares as exact_shares};
use super::{FARM, PLAIN, PLAIN_ORIGIN, black, frame, options, shares};
use crate::scene::View;
use hedgehop::frame::Frame;
use hedgehop::objects::{Body, Form};
use hedgehop::render::{Engine, Renderer};
use hedgehop::space::{Attitude, Camera, Screen};

const VIEW: View =
    View { eye: DVec3::new(500.0, 200.0, 60.0), ypr: [8.0, -9.0, 20.0], hfov: 40.0, size: [200, 160] };

/// A black line between two places, from the area's south-west corner.
fn line(from: DVec3, to: DVec3, width: f64, pixels: f64) -> Body {
    let offset = to - from;
    let pitch = offset.z.atan2(offset.truncate().length()).to_degrees();
    let attitude = Attitude { yaw: offset.x.atan2(offset.y).to_degrees(), pitch, roll: 0.0 };
    let form = Form::Line { length: offset.length(), width, pixels };
    Body { attitude, ..black(form, from.to_array()) }
}

/// Whether a ray passes by a line nearer than `radius`, between its ends.
fn meets_line(eye: DVec3, direction: DVec3, [from, to]: [DVec3; 2], radius: f64) -> bool {
    let along = (to - from).normalize();
    let across = direction.cross(along).normalize();
    let beside = direction.cross(across);
    let at = (eye - from).dot(beside) / along.dot(beside);
    (from - eye).dot(across).abs() < radius && at > 0.0 && at < (to - from).length()
}

#[test]
fn lines_keep_their_share_however_thin_they_are() {
    let ends = [DVec3::new(440.0, 380.0, 20.0), DVec3::new(600.0, 420.0, 75.0)];
    // A pixel is 0.75 m wide there.
    for width in [0.1, 0.3, 2.0] {
        let place = |part: i32| ends[0].lerp(ends[1], f64::from(part) / 24.0);
        let boxes: Vec<_> = (0..24).map(|part| [place(part) - width, place(part + 1) + width]).collect();
        let hits = |eye, direction| meets_line(eye, direction, ends, 0.5 * width);
        let exact = exact_shares(&VIEW, &boxes, hits);
        for engine in [Engine::Planes, Engine::Reference] {
            let seen = shares(engine, &PLAIN, &VIEW, &[line(ends[0], ends[1], width, 0.0)]);
            let (mean, apart) = compare(&VIEW, &seen, &exact);
            assert!(mean <= 1.0 / 128.0 && apart <= 0.1, "{width} m: {mean}, {apart} px");
        }
    }
}

#[test]
fn ranges_of_lines_are_exact() {
    let ends = [DVec3::new(440.0, 380.0, 20.0), DVec3::new(600.0, 420.0, 75.0)];
    let camera = VIEW.camera();
    let radius = 2.0;
    let frame = frame(Engine::Planes, &PLAIN, &camera, &[line(ends[0], ends[1], 2.0 * radius, 0.0)]);
    let along = (ends[1] - ends[0]).normalize();
    let mut count = 0;

    for pixel in (0..frame.id.len()).filter(|pixel| frame.id[*pixel] == Frame::body_id(1)) {
        let ray = camera.ray((pixel % 200) as f64 + 0.5, (pixel / 200) as f64 + 0.5).unwrap();
        let outside = |range: f64| {
            let point = ray.origin + ray.direction * range - PLAIN_ORIGIN.extend(0.0) - ends[0];
            point.cross(along).length() - radius
        };
        let range = f64::from(frame.range[pixel]);
        let at = ray.origin - PLAIN_ORIGIN.extend(0.0);
        if meets_line(at, ray.direction, ends, 0.95 * radius) {
            assert!(outside(range * (1.0 - 1e-4)) > 0.0 && outside(range * (1.0 + 1e-4)) < 0.0, "{pixel}");
            count += 1;
        }
    }

    assert!(count > 200, "{count}");
}

#[test]
fn lines_are_as_many_pixels_wide_as_they_are_to_be() {
    // From 15 m before the eye to 700 m away, past it.
    let ends = [DVec3::new(497.0, 215.0, 58.0), DVec3::new(560.0, 900.0, 20.0)];
    let camera = VIEW.camera();
    let [from, to] = ends.map(|end| camera.screen_from_world(end + PLAIN_ORIGIN.extend(0.0)).unwrap());

    for pixels in [0.5, 1.0, 3.0] {
        let seen = shares(Engine::Planes, &PLAIN, &VIEW, &[line(ends[0], ends[1], 0.004, pixels)]);
        let rows = seen.chunks(200).map(|row| row.iter().sum::<f64>());

        // What a row or a column holds of it, whichever it crosses.
        let across = (to - from).abs();
        let slant = (to - from).length() / across.max_element();
        let wide: Vec<_> = if across.y > across.x {
            rows.collect()
        } else {
            (0..200).map(|column| seen.iter().skip(column).step_by(200).sum()).collect()
        };
        let inside: Vec<_> = wide.into_iter().filter(|wide| *wide > 0.0).collect();
        assert!(inside.len() > 30, "{}", inside.len());

        for wide in &inside[4..inside.len() - 4] {
            // Towards the corners of a screen pixels see less than in its middle.
            let ratio = wide / (pixels * slant);
            assert!((0.85..1.38).contains(&ratio), "{wide} instead of {} pixels", pixels * slant);
        }
    }
}

#[test]
fn points_are_as_many_pixels_wide_as_they_are_to_be() {
    let view = View { eye: DVec3::new(500.0, 20.0, 60.0), ypr: [0.0; 3], hfov: 40.0, size: [200, 160] };
    let focal = 100.0 / 20.0_f64.to_radians().tan();
    for (distance, pixels) in
        [(30.0, 3.0), (200.0, 3.0), (900.0, 0.6), (900.0, 8.0), (12.0, 1.0), (900.0, 0.0)]
    {
        let point =
            |east: f64| black(Form::Point { width: 0.3, pixels }, [500.0 + east, 20.0 + distance, 60.1]);
        for east in [0.0, 0.1] {
            let seen: f64 = shares(Engine::Planes, &PLAIN, &view, &[point(east)]).iter().sum();
            let wide = pixels.max(0.3 / distance * focal);
            let area = 0.25 * PI * wide * wide;
            assert!((seen / area - 1.0).abs() < 0.02, "{distance} m: {seen} instead of {area} pixels");
        }
    }
}

#[test]
fn lines_are_seen_on_other_screens() {
    let camera = VIEW.camera();
    let wide = Camera::with_screen(camera.pose, Screen::Cylindrical { hfov: 80.0 }, 320, 160);
    let ends = [DVec3::new(440.0, 380.0, 20.0), DVec3::new(600.0, 420.0, 75.0)];
    let render = |bodies: &[Body]| {
        let renderer = Renderer::new(&*PLAIN, &options(Engine::Planes));
        renderer.frame_with(&wide, bodies, &FARM).unwrap().frame.colour
    };
    let (with, without) = (render(&[line(ends[0], ends[1], 0.01, 1.0)]), render(&[]));
    let seen: f64 = with.iter().zip(&without).map(|(seen, all)| 1.0 - f64::from(seen[1] / all[1])).sum();
    let directions = ends.map(|end| (end - VIEW.eye).normalize());
    let length = directions[0].angle_between(directions[1]) * 320.0 / 80.0_f64.to_radians();
    assert!((seen / length - 1.0).abs() < 0.15, "{seen} instead of {length} pixels");
}
