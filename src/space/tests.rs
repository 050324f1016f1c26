//! Rays of every screen against closed forms that are derived otherwise.

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec2, DVec3};
use proptest::prelude::*;

use super::*;

const EYE: DVec3 = DVec3::new(5.0e5, 4.0e6, 300.0);

fn pose(yaw: f64, pitch: f64, roll: f64) -> Pose {
    Pose { eye: EYE, attitude: Attitude { yaw, pitch, roll }, hfov: 71.0 }
}

fn level(screen: Screen, width: u32, height: u32) -> Camera {
    Camera::with_screen(pose(0.0, 0.0, 0.0), screen, width, height)
}

/// Azimuth clockwise from north and elevation, degrees.
fn angles(direction: DVec3) -> (f64, f64) {
    (direction.x.atan2(direction.y).to_degrees(), direction.z.asin().to_degrees())
}

/// A table with the directions of another camera's pixels.
fn table_of(camera: &Camera) -> Arc<RayTable> {
    Arc::new(RayTable::of_screen(camera.screen(), camera.width, camera.height).unwrap())
}

fn screens() -> Vec<Screen> {
    let fisheye = Camera::with_screen(pose(0.0, 0.0, 0.0), Screen::Fisheye { fov: 200.0 }, 64, 48);
    vec![
        Screen::Planar { hfov: 71.0 },
        Screen::Cylindrical { hfov: 250.0 },
        Screen::Equirectangular { hfov: 360.0, vfov: 180.0 },
        Screen::Fisheye { fov: 190.0 },
        Screen::Table(table_of(&fisheye)),
        Screen::Orthographic { width: 900.0 },
    ]
}

#[test]
fn a_planar_screen_is_the_pinhole_to_the_bit() {
    let camera = Camera::new(pose(33.0, -12.0, 41.0), 640, 360);
    let focal = 320.0 / (0.5 * 71_f64.to_radians()).tan();
    let pinhole = DVec3::new(12.5 - 320.0, 180.0 - 300.25, focal);
    let expected = (camera.pose.attitude.world_from_view() * pinhole).normalize();
    assert_eq!(camera.ray(12.5, 300.25), Some(Ray { origin: EYE, direction: expected }));
    assert_eq!(camera.pixel_angle(), 1.0 / focal);
    assert_eq!(camera.footprint().at(700.0), 700.0 * (1.0 / focal));
}

#[test]
fn equirectangular_rows_and_columns_are_angles() {
    let camera = level(Screen::Equirectangular { hfov: 360.0, vfov: 180.0 }, 720, 360);
    for (column, row) in [(0.5, 0.5), (360.0, 180.0), (719.5, 359.5), (123.4, 77.7), (540.0, 270.0)] {
        let (azimuth, elevation) = angles(camera.ray(column, row).unwrap().direction);
        assert!((azimuth - (column - 360.0) / 2.0).abs() < 1e-9, "{column}: {azimuth}");
        assert!((elevation - (180.0 - row) / 2.0).abs() < 1e-9, "{row}: {elevation}");
    }
    assert!((camera.ray(5.0, 0.0).unwrap().direction - DVec3::Z).length() < 1e-15);
    assert_eq!(camera.ray(5.0, -0.1), None, "beyond the zenith");
    assert!((camera.pixel_angle() - 0.5_f64.to_radians()).abs() < 1e-15);
    let part = level(Screen::Equirectangular { hfov: 90.0, vfov: 30.0 }, 180, 30);
    let (azimuth, elevation) = angles(part.ray(180.0, 30.0).unwrap().direction);
    assert!((azimuth - 45.0).abs() < 1e-9 && (elevation + 15.0).abs() < 1e-9);
    assert!((part.pixel_angle() - 1_f64.to_radians()).abs() < 1e-15, "the wider side counts");
}

#[test]
fn a_cylinder_has_even_azimuths_and_square_pixels() {
    let camera = level(Screen::Cylindrical { hfov: 180.0 }, 360, 200);
    for (column, row) in [(0.0, 3.0), (180.0, 100.0), (360.0, 199.5), (77.7, 150.0)] {
        let (azimuth, elevation) = angles(camera.ray(column, row).unwrap().direction);
        assert!((azimuth - (column - 180.0) / 2.0).abs() < 1e-9);
        let slope = (100.0 - row) * 0.5_f64.to_radians();
        assert!((elevation - slope.atan().to_degrees()).abs() < 1e-9);
    }
}

#[test]
fn the_radius_of_a_fisheye_is_the_angle_from_its_axis() {
    let camera = Camera::with_screen(pose(0.0, 90.0, 0.0), Screen::Fisheye { fov: 180.0 }, 300, 200);
    assert!((camera.ray(150.0, 100.0).unwrap().direction - DVec3::Z).length() < 1e-12);
    for (dx, dy) in [(30.0, 0.0), (0.0, -50.0), (-60.0, 80.0), (12.0, 13.0)] {
        let direction = camera.ray(150.0 + dx, 100.0 - dy).unwrap().direction;
        let from_zenith = direction.z.acos().to_degrees();
        assert!((from_zenith - f64::hypot(dx, dy) * 0.9).abs() < 1e-9);
        // Pitched up from north by 90°, the top of the picture is south and its right east.
        assert!(direction.truncate().normalize().dot(DVec2::new(dx, -dy).normalize()) > 1.0 - 1e-12);
    }
    assert!(camera.ray(250.0, 100.0).is_some(), "the rim");
    assert_eq!(camera.ray(250.1, 100.0), None);
    assert_eq!(camera.ray(0.5, 0.5), None, "a corner");
}

#[test]
fn orthographic_rays_are_parallel_and_north_is_up() {
    let camera = Camera::with_screen(pose(0.0, -90.0, 0.0), Screen::Orthographic { width: 800.0 }, 400, 300);
    for (column, row, east, north) in [(200.0, 150.0, 0.0, 0.0), (400.0, 0.0, 400.0, 300.0)] {
        let ray = camera.ray(column, row).unwrap();
        assert_eq!(ray.direction, DVec3::NEG_Z, "exactly down");
        assert!((ray.origin - EYE - DVec3::new(east, north, 0.0)).length() < 1e-9, "{ray:?}");
    }
    assert_eq!(camera.footprint(), Footprint::Width(2.0));
    assert_eq!(camera.pixel_angle(), 0.0);
}

#[test]
fn a_table_gives_its_entries_and_what_lies_between() {
    let planar = Camera::new(pose(33.0, -12.0, 41.0), 64, 48);
    let table = Camera::with_screen(planar.pose, Screen::Table(table_of(&planar)), 64, 48);
    // Entries are rounded to f32; between them the chord of a pixel stands for the plane.
    for (column, row, tolerance) in
        [(0.5, 0.5, 1e-7), (33.5, 20.5, 1e-7), (63.9, 47.9, 1e-3), (9.0, 2.2, 1e-4)]
    {
        let (found, expected) = (table.ray(column, row).unwrap(), planar.ray(column, row).unwrap());
        assert!((found.direction - expected.direction).length() < tolerance, "{column} {row}");
        assert_eq!(found.origin, EYE);
    }
    assert!((table.pixel_angle() / planar.pixel_angle() - 1.0).abs() < 0.02);
    let stretched = Camera::with_screen(planar.pose, Screen::Table(table_of(&planar)), 32, 24);
    let (found, expected) = (stretched.ray(10.25, 7.25).unwrap(), planar.ray(20.5, 14.5).unwrap());
    assert!((found.direction - expected.direction).length() < 1e-7);
    assert!((stretched.pixel_angle() / table.pixel_angle() - 2.0).abs() < 1e-9);
}

#[test]
fn entries_that_are_no_direction_have_no_ray() {
    let none = [[0.0; 3], [f32::NAN, 0.0, 1.0], [f32::INFINITY, 0.0, 0.0]];
    for (at, entry) in none.into_iter().enumerate() {
        let mut directions = vec![[0.0, 0.0, 1e-30], [0.0, 0.1, 1e30], [0.1, 0.0, 1.0]];
        directions[at] = entry;
        let table = Arc::new(RayTable::new(3, 1, directions).unwrap());
        let camera = level(Screen::Table(table), 3, 1);
        let seen: Vec<bool> =
            (0..3).map(|column| camera.ray(f64::from(column) + 0.5, 0.5).is_some()).collect();
        assert_eq!(seen, [at != 0, at != 1, at != 2]);
    }
    assert!(RayTable::new(3, 1, none.to_vec()).unwrap_err().to_string().contains("no pixel"));
    assert!(RayTable::new(2, 2, none.to_vec()).is_err());
    assert!(RayTable::of_screen(&Screen::Orthographic { width: 5.0 }, 4, 4).is_err());
    assert!(RayTable::new(0, 0, Vec::new()).is_err());
    assert!(RayTable::new(u32::MAX, u32::MAX, Vec::new()).is_err());
    let lone = RayTable::new(1, 1, vec![[0.0, 0.0, 2.0]]).unwrap();
    assert_eq!(lone.pixel_angle(), 1.0);
}

#[test]
fn screens_that_make_no_picture_are_refused() {
    for screen in screens() {
        assert!(screen.check().is_ok(), "{screen}");
    }
    for (screen, flag) in [
        (Screen::Planar { hfov: 180.0 }, "--hfov"),
        (Screen::Cylindrical { hfov: 360.5 }, "--hfov"),
        (Screen::Equirectangular { hfov: 360.0, vfov: 181.0 }, "--vfov"),
        (Screen::Fisheye { fov: f64::NAN }, "--hfov"),
        (Screen::Orthographic { width: 0.0 }, "--ground-width"),
    ] {
        assert!(screen.check().unwrap_err().to_string().contains(flag), "{screen}");
    }
}

/// The shared edge of neighbours is seen by both, along its whole length, whatever the aircraft does.
#[test]
fn abutting_channels_share_the_rays_of_their_edge() {
    let own = pose(33.0, -12.0, 41.0);
    let side_by_side = [
        (Screen::Planar { hfov: 60.0 }, 60.0, vec![-60.0, 0.0, 60.0]),
        (Screen::Cylindrical { hfov: 90.0 }, 90.0, vec![-135.0, -45.0, 45.0, 135.0, 225.0]),
        (Screen::Equirectangular { hfov: 120.0, vfov: 90.0 }, 120.0, vec![-120.0, 0.0, 120.0, 240.0]),
    ];

    for (screen, step, yaws) in side_by_side {
        for pair in yaws.windows(2) {
            assert_eq!(pair[1] - pair[0], step);
            let [left, right] = [pair[0], pair[1]].map(|yaw| {
                let channel = Attitude { yaw, ..Attitude::default() };
                Camera::with_channel(own, channel, screen.clone(), 333, 217)
            });
            for row in 0..=217 {
                let [one, other] =
                    [left.ray(333.0, row.into()), right.ray(0.0, row.into())].map(Option::unwrap);
                assert!((one.direction - other.direction).length() < 1e-12, "{screen} {pair:?} {row}");
                assert_eq!(one.origin, other.origin);
            }
        }
    }

    // One above the other, too.
    let [upper, lower] = [22.5, -22.5].map(|pitch| {
        let channel = Attitude { pitch, ..Attitude::default() };
        Camera::with_channel(own, channel, Screen::Planar { hfov: 45.0 }, 100, 100)
    });

    for column in 0..=100 {
        let [one, other] =
            [upper.ray(column.into(), 100.0), lower.ray(column.into(), 0.0)].map(Option::unwrap);
        assert!((one.direction - other.direction).length() < 1e-12);
    }
}

#[test]
fn cylindrical_quarters_are_the_whole_to_the_bit() {
    for (own, width) in [(pose(0.0, 0.0, 0.0), 37), (pose(77.7, -12.0, 41.0), 480)] {
        for whole in
            [Screen::Cylindrical { hfov: 360.0 }, Screen::Equirectangular { hfov: 360.0, vfov: 120.0 }]
        {
            let quarter = match whole {
                Screen::Equirectangular { vfov, .. } => Screen::Equirectangular { hfov: 90.0, vfov },
                _ => Screen::Cylindrical { hfov: 90.0 },
            };
            let all = Camera::with_screen(own, whole, 4 * width, 90);

            for (index, yaw) in [-135.0, -45.0, 45.0, 135.0].into_iter().enumerate() {
                let channel = Attitude { yaw, ..Attitude::default() };
                let part = Camera::with_channel(own, channel, quarter.clone(), width, 90);
                assert_eq!(part.footprint(), all.footprint());
                for column in 0..width {
                    let at = f64::from(column) + 0.5;
                    let there = at + f64::from(width) * index as f64;
                    assert_eq!(part.ray(at, 20.5), all.ray(there, 20.5), "{yaw} {column}");
                }
            }
        }
    }
}

#[test]
fn a_turned_channel_looks_where_its_attitude_says() {
    let own = pose(33.0, -12.0, 41.0);
    for channel in
        [Attitude { yaw: 50.0, pitch: 0.0, roll: 0.0 }, Attitude { yaw: -70.0, pitch: 20.0, roll: 5.0 }]
    {
        for screen in screens() {
            let one = Camera::with_channel(own, channel, screen.clone(), 96, 64);
            let composed = Pose { attitude: own.attitude.turned(channel), ..own };
            let other = Camera::with_screen(composed, screen, 96, 64);
            for (column, row) in [(48.0, 32.0), (30.5, 40.5), (60.0, 10.0)] {
                let (one, other) = (one.ray(column, row).unwrap(), other.ray(column, row).unwrap());
                assert!((one.direction - other.direction).length() < 1e-12);
                assert!((one.origin - other.origin).length() < 1e-8);
            }
            assert_eq!(one.pose.attitude, composed.attitude);
        }
    }
}

proptest! {
    #[test]
    fn rays_are_unit_and_neighbours_are_near(
        yaw in 0.0..360.0_f64, pitch in -90.0..90.0_f64, roll in -180.0..180.0_f64,
        width in 16_u32..200, height in 16_u32..200, column in 0.0..1.0_f64, row in 0.0..1.0_f64,
    ) {
        for screen in screens() {
            let camera = Camera::with_screen(pose(yaw, pitch, roll), screen, width, height);
            let at = |dx: f64, dy: f64| {
                let position = DVec2::new(column * f64::from(width - 1) + dx, row * f64::from(height - 1) + dy);
                camera.ray(position.x, position.y)
            };
            let here = at(0.0, 0.0);

            for neighbour in [at(1.0, 0.0), at(0.0, 1.0)] {
                let (Some(one), Some(other)) = (here, neighbour) else { continue };
                prop_assert!((one.direction.length() - 1.0).abs() < 1e-12);
                let angle = one.direction.cross(other.direction).length().atan2(one.direction.dot(other.direction));
                // Tables are interpolated, which is uneven; those of this test are stretched besides.
                let most = if matches!(camera.screen(), Screen::Table(_)) { 3.0 } else { 1.0 + 1e-6 };
                prop_assert!(angle <= most * camera.pixel_angle() + 1e-12, "{} {angle}", camera.screen());
                if let Footprint::Width(metres) = camera.footprint() {
                    prop_assert!(((one.origin - other.origin).length() - metres).abs() < 1e-8);
                } else {
                    prop_assert_eq!(one.origin, EYE);
                }
            }
        }
    }

    #[test]
    fn screen_from_world_inverts_ray(
        yaw in 0.0..360.0_f64, pitch in -90.0..90.0_f64, roll in -180.0..180.0_f64, turn in -180.0..180.0_f64,
        column in 0.001..0.999_f64, row in 0.001..0.999_f64,
    ) {
        for screen in screens() {
            let channel = Attitude { yaw: turn, ..Attitude::default() };
            let camera = Camera::with_channel(pose(yaw, pitch, roll), channel, screen, 160, 90);
            let position = DVec2::new(column * 160.0, row * 90.0);
            let Some(ray) = camera.ray(position.x, position.y) else { continue };
            let found = camera.screen_from_world(ray.origin + ray.direction * 1234.0);
            if matches!(camera.screen(), Screen::Table(_)) {
                prop_assert_eq!(found, None);
            } else {
                prop_assert!((found.unwrap() - position).length() < 1e-5, "{} {found:?} {position}", camera.screen());
            }
        }
    }

    /// The axes, derived otherwise than in the library: banked, raised and turned one after the other.
    #[test]
    fn axes_are_bank_then_pitch_then_yaw(yaw in 0.0..360.0_f64, pitch in -90.0..90.0_f64, roll in -180.0..180.0_f64) {
        let turn = DQuat::from_rotation_z(-yaw.to_radians())
            * DQuat::from_rotation_x(pitch.to_radians())
            * DQuat::from_rotation_y(roll.to_radians());
        let expected = DMat3::from_quat(turn) * DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Y);
        let found = Attitude { yaw, pitch, roll }.world_from_view();
        prop_assert!(found.abs_diff_eq(expected, 1e-12));
    }
}
