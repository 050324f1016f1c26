//! Screens other than the plane: where the horizon lies on each, and that parts make up the whole.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::judge::Judge;
use super::scene::{Terrain, View, clear_air};
use super::screen;
use hedgehop::frame::Frame;
use hedgehop::space::{Attitude, Camera, Pose, RayTable, Screen};
use hedgehop::voxel::MemPages;

const GROUND: f64 = 120.0;

fn render(world: &MemPages, camera: &Camera) -> Frame {
    screen::render(world, camera, &clear_air())
}

/// A pose at metres from the area's south-west corner.
fn pose(eye: DVec3, [yaw, pitch, roll]: [f64; 3]) -> Pose {
    View { eye, ypr: [yaw, pitch, roll], hfov: 60.0, size: [1, 1] }.camera().pose
}

/// A plane whose edge lies a millionth of a degree under the horizon, and an eye over its middle.
fn endless() -> (MemPages, DVec3) {
    let world = Terrain::new([256; 2], 1.0e7, |_| GROUND, |_| [128; 3]).in_memory();
    (world, DVec3::new(1.3e9, 1.25e9, GROUND + 30.0))
}

/// Hills of many colours.
fn hills() -> MemPages {
    let height = |post: DVec2| 150.0 + 60.0 * (post.x / 130.0).sin() + 40.0 * (post.y / 70.0).cos();
    let colour = |post: DVec2| [(post.x / 3.0) as u8, (post.y / 7.0) as u8, ((post.x + post.y) / 5.0) as u8];
    Terrain::new([600, 520], 8.0, height, colour).in_memory()
}

/// Every pixel of which `above` says more than 0 sees the sky, of which it says less the ground; what is within half a
/// pixel of the border may be either, and there must be a border.
fn assert_horizon(frame: &Frame, above: impl Fn(f64, f64) -> f64) {
    let (width, height) = (frame.camera.width as usize, frame.camera.height as usize);
    let mut seen = [0, 0];
    for (index, range) in frame.range.iter().enumerate() {
        let (column, row) = ((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
        let distance = above(column, row);
        let sky = range.is_infinite();
        seen[usize::from(sky)] += 1;
        assert!(
            distance.abs() <= 0.5 || sky == (distance > 0.0),
            "{}: {column} {row}: {distance}",
            frame.camera.screen()
        );
    }
    assert!(seen.iter().all(|&count| count > width * height / 20), "{seen:?}");
}

#[test]
fn the_horizon_of_a_cylinder_is_a_cosine() {
    let (world, eye) = endless();
    for (hfov, pitch) in [(360.0, 0.0), (360.0, 20.0), (180.0, -33.0), (75.0, 8.0)] {
        let (width, height) = (300_u32, 200_u32);
        let screen = Screen::Cylindrical { hfov };
        let camera = Camera::with_screen(pose(eye, [33.0, pitch, 0.0]), screen, width, height);
        let radius = f64::from(width) / f64::to_radians(hfov);
        // The eye is turned up by `pitch`, so that the horizon ahead sinks by its tangent.
        assert_horizon(&render(&world, &camera), |column, row| {
            let azimuth = (column - 0.5 * f64::from(width)) / radius;
            let horizon = 0.5 * f64::from(height) + radius * f64::to_radians(pitch).tan() * azimuth.cos();
            horizon - row
        });
    }
}

#[test]
fn the_horizon_of_an_equirectangular_picture_is_the_great_circle() {
    let (world, eye) = endless();
    for (hfov, vfov, pitch) in [(360.0, 180.0, 0.0), (360.0, 180.0, 40.0), (120.0, 60.0, -12.0)] {
        let size = [360.0, 180.0];
        let screen = Screen::Equirectangular { hfov, vfov };
        let camera = Camera::with_screen(pose(eye, [200.0, pitch, 0.0]), screen, 360, 180);
        assert_horizon(&render(&world, &camera), |column, row| {
            let azimuth = ((column / size[0] - 0.5) * hfov).to_radians();
            let elevation = (-f64::to_radians(pitch).tan() * azimuth.cos()).atan().to_degrees();
            (0.5 - elevation / vfov) * size[1] - row
        });
    }
}

#[test]
fn the_horizon_of_a_dome_is_a_circle_and_outside_is_nothing() {
    let (world, eye) = endless();
    let screen = Screen::Fisheye { fov: 220.0 };
    let camera = Camera::with_screen(pose(eye, [77.0, 90.0, 0.0]), screen, 300, 220);
    let frame = render(&world, &camera);
    let radius = |column: f64, row: f64| f64::hypot(column - 150.0, row - 110.0);
    // A pixel is a degree. Beyond the rim nothing is seen, which reads like the sky: infinite range.
    assert_horizon(&frame, |column, row| match radius(column, row) {
        beyond if beyond > 110.0 => 1.0,
        angle => 90.0 - angle,
    });
    for (index, colour) in frame.colour.iter().enumerate() {
        let radius = radius((index % 300) as f64 + 0.5, (index / 300) as f64 + 0.5);
        let black = *colour == [0.0; 3];
        assert_eq!(black, radius > 110.0, "{index}");
        assert!(radius <= 110.0 || frame.id[index] == Frame::SKY_ID && frame.normal[index] == [0.0; 3]);
    }
}

#[test]
fn ranges_on_every_screen_are_those_of_the_plane() {
    let world = Terrain::new([512; 2], 50.0, |_| GROUND, |_| [128; 3]).in_memory();
    let eye = DVec3::new(12_800.0, 12_000.0, GROUND + 400.0);
    for screen in [
        Screen::Cylindrical { hfov: 300.0 },
        Screen::Equirectangular { hfov: 360.0, vfov: 180.0 },
        Screen::Fisheye { fov: 180.0 },
    ] {
        let camera = Camera::with_screen(pose(eye, [10.0, -25.0, 7.0]), screen, 120, 90);
        let frame = render(&world, &camera);
        let (mut grounds, mut judge) = (0, Judge::default());
        for (index, &range) in frame.range.iter().enumerate().filter(|(_, range)| range.is_finite()) {
            let ray = camera.ray((index % 120) as f64 + 0.5, (index / 120) as f64 + 0.5).unwrap();
            let exact = 400.0 / -ray.direction.z;
            judge.range(f64::from(range), exact, 1e-6, camera.screen());
            grounds += 1;
        }
        judge.decide();
        assert!(grounds > 3000, "{grounds}");
    }
}

#[test]
fn a_map_shows_heights_as_range_and_north_at_the_top() {
    let red_in_the_north_east = |post: DVec2| {
        if post.x > 500.0 && post.y > 500.0 { [255, 0, 0] } else { [0, 0, 255] }
    };
    let ramp = |post: DVec2| 0.1 * post.x;
    let world = Terrain::new([200; 2], 5.0, ramp, red_in_the_north_east).in_memory();
    let eye = DVec3::new(500.0, 500.0, 900.0);
    let screen = Screen::Orthographic { width: 1100.0 };
    let camera = Camera::with_screen(pose(eye, [0.0, -90.0, 0.0]), screen.clone(), 110, 130);
    let frame = render(&world, &camera);

    for (index, &range) in frame.range.iter().enumerate() {
        let (column, row) = ((index % 110) as f64 + 0.5, (index / 110) as f64 + 0.5);
        let (east, north) = (500.0 + 10.0 * (column - 55.0), 500.0 + 10.0 * (65.0 - row));
        let inside = |at: f64| (0.0..1000.0).contains(&at);
        assert_eq!(range.is_finite(), inside(east) && inside(north), "{column} {row}");

        if range.is_finite() && (10.0..990.0).contains(&east) {
            assert!((f64::from(range) - (900.0 - 0.1 * east)).abs() < 0.01, "{east}: {range}");
            // Pixels are 10 m wide, posts 5 m apart: a pixel may blend one on either side.
            if (east - 500.0).abs() > 15.0 && (north - 500.0).abs() > 15.0 {
                let red = frame.colour[index][0] > frame.colour[index][2];
                assert_eq!(red, east > 500.0 && north > 500.0, "{east} {north}");
            }
        }
    }

    // From the side: parallel rays at 30° to the ground meet it twice as far as they start above it.
    let flat = Terrain::new([200; 2], 5.0, |_| 0.0, |_| [99; 3]).in_memory();
    let eye = DVec3::new(500.0, 100.0, 300.0);
    let camera = Camera::with_screen(pose(eye, [0.0, -30.0, 0.0]), screen, 110, 30);
    let frame = render(&flat, &camera);

    for (index, &range) in frame.range.iter().enumerate() {
        let (right, up) = (10.0 * ((index % 110) as f64 - 54.5), 10.0 * (14.5 - (index / 110) as f64));
        assert_eq!(range.is_finite(), right.abs() < 500.0, "{right} {up}");
        let start = 300.0 + up * 30_f64.to_radians().cos();
        assert!(
            range.is_infinite() || (f64::from(range) - 2.0 * start).abs() < 0.01,
            "{right} {up}: {range}"
        );
    }
}

#[test]
fn a_table_of_a_plane_shows_the_picture_of_the_plane() {
    let world = hills();
    let own = pose(DVec3::new(1800.0, 1300.0, 420.0), [130.0, -15.0, 25.0]);
    let planar = render(&world, &Camera::new(own, 160, 120));
    let table = RayTable::of_screen(&Screen::Planar { hfov: 60.0 }, 160, 120).unwrap();
    let mapped = render(&world, &Camera::with_screen(own, Screen::Table(Arc::new(table)), 160, 120));
    let (mut seen, mut differ) = (0, 0);
    let of_one_surface =
        |&index: &usize| [&planar, &mapped].into_iter().all(|frame| screen::is_of_one_surface(frame, index));

    for index in (0..planar.range.len()).filter(of_one_surface) {
        seen += 1;
        let (one, other) = (planar.range[index], mapped.range[index]);
        let near = (one - other).abs() <= 1e-3 * one || one == other;
        let colours = planar.colour[index].iter().zip(mapped.colour[index]);
        let same = colours.map(|(one, other)| (one - other).abs()).fold(0.0, f32::max) < 0.02;
        differ += usize::from(!(near && same));
    }

    // Its pixels are found to be 1 % narrower, so that levels begin a little farther, and silhouettes may flip.
    assert!(differ <= seen / 200, "{differ} pixels of {seen} differ");
    assert!(seen > planar.range.len() * 4 / 5, "{seen}");
}

/// All planes as bits, of the columns `from..to`.
fn bits(frame: &Frame, from: usize, to: usize) -> Vec<u32> {
    let width = frame.camera.width as usize;
    let pixels = (0..frame.range.len()).filter(|index| (from..to).contains(&(index % width)));
    pixels
        .flat_map(|index| {
            let floats =
                frame.colour[index].into_iter().chain(frame.normal[index]).chain([frame.range[index]]);
            let codes = [u32::from(frame.level[index]), frame.id[index]];
            floats.map(f32::to_bits).chain(codes).collect::<Vec<_>>()
        })
        .collect()
}

#[test]
fn quarters_side_by_side_are_the_whole_bit_by_bit() {
    let world = hills();
    for ypr in [[77.7, 0.0, 0.0], [12.0, -8.0, 31.0]] {
        let own = pose(DVec3::new(1800.0, 1300.0, 420.0), ypr);
        for (whole, quarter) in [
            (Screen::Cylindrical { hfov: 360.0 }, Screen::Cylindrical { hfov: 90.0 }),
            (
                Screen::Equirectangular { hfov: 360.0, vfov: 100.0 },
                Screen::Equirectangular { hfov: 90.0, vfov: 100.0 },
            ),
        ] {
            let all = render(&world, &Camera::with_screen(own, whole, 4 * 37, 50));
            for (index, yaw) in [-135.0, -45.0, 45.0, 135.0].into_iter().enumerate() {
                let channel = Attitude { yaw, ..Attitude::default() };
                let part = render(&world, &Camera::with_channel(own, channel, quarter.clone(), 37, 50));
                assert!(bits(&part, 0, 37) == bits(&all, 37 * index, 37 * (index + 1)), "{ypr:?} {yaw}");
            }
        }
    }
}

#[test]
fn range_coherence_changes_nothing_on_upright_screens() {
    let world = hills();
    for screen in [Screen::Cylindrical { hfov: 200.0 }, Screen::Equirectangular { hfov: 360.0, vfov: 180.0 }]
    {
        // The least pitch that there is turns no ray, but forbids coherence.
        let [coherent, alone] = [0.0, f64::from_bits(1)].map(|pitch| {
            let own = pose(DVec3::new(1800.0, 1300.0, 420.0), [50.0, pitch, 0.0]);
            let camera = Camera::with_screen(own, screen.clone(), 90, 120);
            assert_eq!(camera.has_vertical_columns(), pitch == 0.0);
            render(&world, &camera)
        });
        for (one, other) in coherent.range.iter().zip(&alone.range) {
            assert!(one == other || (one - other).abs() <= 1e-6 * one, "{one} {other}");
        }
    }
}
