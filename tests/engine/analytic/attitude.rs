//! Where things are on the screen: straight down, straight up, all around, and from where nobody should be.

use glam::{DVec2, DVec3};

use super::scene::{Terrain, View, clear_air};
use super::screen::is_of_one_surface;
use hedgehop::frame::Frame;

const RED: [u8; 3] = [200, 20, 20];
const GREEN: [u8; 3] = [20, 200, 20];
const BLUE: [u8; 3] = [20, 20, 200];
const WHITE: [u8; 3] = [200; 3];
const DARK: [u8; 3] = [60; 3];

/// Which of the colours above a pixel's hue is closest to, whatever light falls on it.
fn hue(colour: [f32; 3]) -> [u8; 3] {
    let [red, green, blue] = colour;
    let bright = red.max(green).max(blue);
    match (red > 0.5 * bright, green > 0.5 * bright, blue > 0.5 * bright) {
        (true, true, true) => WHITE,
        (true, ..) => RED,
        (_, true, _) => GREEN,
        _ => BLUE,
    }
}

#[test]
fn straight_down_north_is_up_east_is_right_and_range_is_height_times_secant() {
    let middle = DVec2::splat(1280.0);
    let quadrants = |post: DVec2| match (post.x > middle.x, post.y > middle.y) {
        (true, true) => RED,
        (false, true) => GREEN,
        (true, false) => BLUE,
        (false, false) => WHITE,
    };
    let world = Terrain::new([256; 2], 10.0, |_| 35.0, quadrants).in_memory();

    for (yaw, roll) in [(0.0, 0.0), (90.0, 0.0), (180.0, 0.0), (30.0, 0.0), (0.0, 90.0), (300.0, 45.0)] {
        for (size, hfov, height) in
            [([61, 61], 60.0, 800.0), ([80, 40], 90.0, 600.0), ([33, 64], 5.0, 4000.0)]
        {
            let view = View { eye: middle.extend(35.0 + height), ypr: [yaw, -90.0, roll], hfov, size };
            let frame = view.frame(&world, &clear_air());
            for (index, pixel) in view.pixels() {
                let screen = view.screen(pixel);
                let range = height * screen.length() / view.focal();
                let found = f64::from(frame.range[index]);
                assert!((found / range - 1.0).abs() < 1e-6, "{view:?} {pixel:?}: {found} for {range}");

                // At yaw 0 right is east and up is north. Yaw turns the nose, at the top, clockwise to
                // the east; looking down, a right bank then brings what lies to the left into view.
                let (sin, cos) = yaw.to_radians().sin_cos();
                let (sin_roll, cos_roll) = f64::to_radians(roll).sin_cos();
                let right = screen.x * cos_roll + screen.z * sin_roll;
                let up = screen.z * cos_roll - screen.x * sin_roll;
                let (east, north) = (right * cos + up * sin, up * cos - right * sin);
                let slack = 1.0 + 10.0 * view.focal() / height;
                if east.abs().min(north.abs()) > slack {
                    let expected = quadrants(middle + DVec2::new(east, north));
                    assert_eq!(hue(frame.colour[index]), expected, "{view:?} {pixel:?}");
                }
            }
        }
    }
}

#[test]
fn straight_up_there_is_nothing_but_sky() {
    let world = Terrain::new([64; 2], 10.0, |_| 35.0, |_| DARK).in_memory();
    for hfov in [5.0, 60.0, 140.0] {
        let view =
            View { eye: DVec3::new(320.0, 320.0, 36.0), ypr: [77.0, 90.0, 10.0], hfov, size: [40, 30] };
        let frame = view.frame(&world, &clear_air());
        for (index, pixel) in view.pixels() {
            assert!(frame.range[index].is_infinite());
            assert_eq!((frame.level[index], frame.id[index]), (Frame::SKY_LEVEL, Frame::SKY_ID));
            assert_eq!(frame.normal[index], [0.0; 3]);
            let [red, green, blue] = frame.colour[index];
            assert!(blue > green && green > red && red > 0.0, "{pixel:?} is {:?}", frame.colour[index]);
        }
    }
}

#[test]
fn an_eye_under_the_surface_sees_ground_at_no_distance_in_all_directions() {
    let hills = |post: DVec2| 200.0 + 40.0 * (post.x / 90.0).sin();
    let world = Terrain::new([200; 2], 10.0, hills, |_| DARK).in_memory();
    for pitch in [-90.0, -30.0, 0.0, 45.0, 90.0] {
        for depth in [0.5, 20.0, 500.0] {
            let place = DVec2::new(1033.0, 711.0);
            let eye = place.extend(hills(place) - depth);
            let view = View { eye, ypr: [10.0, pitch, 20.0], hfov: 70.0, size: [24, 18] };
            let frame = view.frame(&world, &clear_air());
            assert!(frame.range.iter().all(|&range| range == 0.0), "{view:?}");
            assert!(frame.colour.iter().flatten().all(|light| light.is_finite()), "{view:?}");
        }
    }
}

/// Posts of 30 m in the middle of each side, 400 m from the middle of a level field.
fn posts() -> Vec<(f64, [u8; 3], DVec2)> {
    [(0.0, RED), (90.0, GREEN), (180.0, BLUE), (270.0, WHITE)]
        .into_iter()
        .map(|(azimuth, colour): (f64, _)| {
            let (sin, cos) = azimuth.to_radians().sin_cos();
            (azimuth, colour, DVec2::splat(600.0) + DVec2::new(sin, cos) * 400.0)
        })
        .collect()
}

#[test]
fn posts_around_the_eye_stand_where_yaw_says() {
    let near = |post: DVec2| posts().into_iter().find(|(_, _, at)| (post - *at).abs().max_element() < 8.0);
    let height = |post| if near(post).is_some() { 60.0 } else { 0.0 };
    let colour = |post| near(post).map_or(DARK, |(_, colour, _)| colour);
    let world = Terrain::new([600; 2], 2.0, height, colour).in_memory();

    for (size, hfov) in [([160, 60], 60.0), ([240, 80], 110.0), ([90, 120], 40.0)] {
        for yaw in [0.0, 20.0, 45.0, 90.0, 135.0, 180.0, -90.0, 255.0, 340.0, 720.0] {
            for (pitch, roll) in [(0.0, 0.0), (3.0, 0.0), (0.0, 90.0), (-2.0, 180.0), (2.0, 20.0)] {
                let eye = DVec2::splat(600.0).extend(30.0);
                let view = View { eye, ypr: [yaw, pitch, roll], hfov, size };
                let frame = view.frame(&world, &clear_air());
                for (_, colour, at) in posts() {
                    // The upper half of a post stands before the sky, from the eye's height up.
                    let towards = (at - DVec2::splat(600.0)).normalize();
                    let hits: Vec<f64> = view
                        .pixels()
                        .filter(|&(index, pixel)| {
                            let seen = hue(frame.colour[index]) == colour && frame.range[index].is_finite();
                            seen && view.direction(pixel).z > 0.0 && is_of_one_surface(&frame, index)
                        })
                        .map(|(_, pixel)| {
                            let ground = view.direction(pixel).truncate();
                            // Positive to the right of the post's middle.
                            ground.y.mul_add(towards.x, -ground.x * towards.y).atan2(ground.dot(towards))
                        })
                        .collect();

                    let axis = view.axes().transpose() * towards.extend(0.02);
                    let place = DVec2::new(axis.x, axis.z) / axis.y * view.focal();
                    let inside = axis.y > 0.0
                        && (place.abs() + 15.0)
                            .cmple(DVec2::new(f64::from(size[0]), f64::from(size[1])) * 0.5)
                            .all();
                    assert!(!inside || !hits.is_empty(), "{view:?}: no {colour:?}");
                    assert!(axis.y > 0.0 || hits.is_empty(), "{view:?}: {colour:?} behind the eye");
                    let half_width = (10.0_f64 / 390.0).atan();
                    let pixel = 1.0 / view.focal();
                    assert!(
                        hits.iter().all(|angle| angle.abs() <= half_width + pixel),
                        "{view:?} {colour:?}"
                    );
                    if inside {
                        let mean = hits.iter().sum::<f64>() / hits.len() as f64;
                        assert!(mean.abs() <= pixel, "{view:?}: {colour:?} is off by {} px", mean / pixel);
                    }
                }
            }
        }
    }
}
