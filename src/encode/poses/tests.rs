//! Files of poses, read as their readers do.

use glam::{DMat3, DQuat, DVec2, DVec3};

use super::*;
use crate::space::{Attitude, Camera, Pose, Screen};
use hedgehop_base::Size;

const SIZE: Size = Size { width: 64, height: 48 };
const OFFSET: DVec3 = DVec3::new(500_000.0, 4_649_000.0, 0.0);

/// Views of every kind of attitude: level, banked, straight down, upside down.
fn cameras(screen: impl Fn(usize) -> Screen) -> Vec<Camera> {
    let attitudes = [
        [0.0, 0.0, 0.0],
        [33.0, -5.25, 20.0],
        [200.0, -90.0, 0.0],
        [359.0, 60.0, -170.0],
        [90.0, 90.0, 45.0],
    ];
    let camera = |(index, [yaw, pitch, roll]): (usize, [f64; 3])| {
        let eye = DVec3::new(500_123.456_789, 4_649_776.225 + 3.5 * index as f64, 312.75);
        let pose = Pose { eye, attitude: Attitude { yaw, pitch, roll }, hfov: 60.0 };
        Camera::with_screen(pose, screen(index), SIZE.width, SIZE.height)
    };
    attitudes.into_iter().enumerate().map(camera).collect()
}

fn planar(_: usize) -> Screen {
    Screen::Planar { hfov: 60.0 }
}

/// Writes the poses of cameras, and returns the text of one of the files.
fn written(cameras: &[Camera], format: PoseFormat, file: &str) -> Result<String> {
    let folder = tempfile::tempdir().unwrap();
    let screens: Vec<_> = cameras.iter().map(|camera| camera.screen().to_string()).collect();
    let names: Vec<_> = (1..=cameras.len()).map(|number| format!("{number:04}.png")).collect();
    let frame = |(index, camera): (usize, &Camera)| PosedFrame {
        number: index as u64 + 1,
        file: &names[index],
        seconds: 0.04 * index as f64,
        eye: camera.pose.eye,
        attitude: camera.pose.attitude,
        screen: &screens[index],
        size: SIZE,
    };
    let frames = cameras.iter().enumerate().map(frame).collect();
    let list = PoseList { frames, offset: OFFSET, crs: "EPSG:32633", vertical_datum: "mean sea level" };
    format.write(folder.path(), &list)?;
    format.check_folder(folder.path())?;
    Ok(std::fs::read_to_string(folder.path().join(file)).unwrap())
}

/// Numbers of each line that is no comment.
fn rows(text: &str) -> Vec<Vec<f64>> {
    let lines = text.lines().filter(|line| !line.starts_with('#') && !line.is_empty());
    lines.map(|line| line.split(' ').map_while(|value| value.parse().ok()).collect()).collect()
}

/// Points of the map in and out of sight of a camera, each with its place on the screen.
fn points(camera: &Camera) -> impl Iterator<Item = (DVec3, DVec2)> + '_ {
    let places = [[0.5, 0.5], [63.5, 0.5], [20.25, 47.5], [32.0, 24.0]].map(DVec2::from_array);
    places.into_iter().map(|place| {
        let ray = camera.ray(place.x, place.y).unwrap();
        (ray.origin + ray.direction * 700.0, place)
    })
}

/// Place of a point in OpenCV's axes of a camera, by OpenCV's model with k₁ and k₂.
fn projected(point: DVec3, focal: f64, k: [f64; 2]) -> DVec2 {
    let plane = point.truncate() / point.z;
    let r = plane.length_squared();
    plane * (1.0 + k[0] * r + k[1] * r * r) * focal + DVec2::new(32.0, 24.0)
}

#[test]
fn colmap_takes_points_of_the_map_to_their_pixels() {
    let cameras = cameras(planar);
    let parameters = rows(&written(&cameras, PoseFormat::Colmap, "sparse/0/cameras.txt").unwrap());
    let listed = written(&cameras, PoseFormat::Colmap, "sparse/0/images.txt").unwrap();
    assert!(listed.contains("less offset_m 500000 4649000 0\n"), "{listed}");
    assert!(listed.contains(" 1 0002.png\n\n"), "an image has two lines: {listed}");
    assert_eq!(parameters.len(), 1, "one camera for all");
    let text = written(&cameras, PoseFormat::Colmap, "sparse/0/cameras.txt").unwrap();
    let focal = 32.0 / 30.0_f64.to_radians().tan();
    assert!(text.ends_with(&format!("\n1 PINHOLE 64 48 {focal} {focal} 32 24\n")), "{text}");

    for (camera, row) in cameras.iter().zip(rows(&listed)) {
        let turn = DQuat::from_xyzw(row[2], row[3], row[4], row[1]);
        assert!(turn.is_normalized() && turn.w >= 0.0);
        let shift = DVec3::from_slice(&row[5..8]);
        for (point, place) in points(camera) {
            let found = projected(turn * (point - OFFSET) + shift, focal, [0.0; 2]);
            assert!(found.distance(place) < 1e-9, "{found} {place}");
        }
    }
}

#[test]
fn transforms_take_the_camera_to_the_map() {
    let cameras = cameras(planar);
    let text = written(&cameras, PoseFormat::Transforms, "transforms.json").unwrap();
    let read: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!((&read["w"], &read["cx"], &read["cy"]), (&64.into(), &32.0.into(), &24.0.into()));
    assert!(read.get("k1").is_none() && read.get("offset").is_none(), "{text}");
    assert_eq!(read["applied_transform"][1][3], -4_649_000.0);
    assert_eq!(read["hedgehop"]["offset_m"][0], 500_000.0);
    let focal = read["fl_x"].as_f64().unwrap();

    for (index, camera) in cameras.iter().enumerate() {
        let frame = &read["frames"][index];
        assert_eq!(frame["file_path"], format!("{:04}.png", index + 1));
        let rows: Vec<[f64; 4]> = serde_json::from_value(frame["transform_matrix"].clone()).unwrap();
        let column = |column: usize| DVec3::new(rows[0][column], rows[1][column], rows[2][column]);
        let world_from_camera = DMat3::from_cols(column(0), column(1), column(2));
        assert!((world_from_camera.determinant() - 1.0).abs() < 1e-12);
        for (point, place) in points(camera) {
            // OpenGL's axes: y up, z back.
            let seen = world_from_camera.transpose() * (point - OFFSET - column(3));
            let found = projected(seen * DVec3::new(1.0, -1.0, -1.0), focal, [0.0; 2]);
            assert!(found.distance(place) < 1e-9, "{found} {place}");
        }
    }
}

#[test]
fn trajectories_are_of_the_eye() {
    let cameras = cameras(|_| Screen::Fisheye { fov: 180.0 });
    let text = written(&cameras, PoseFormat::Tum, "poses.tum").unwrap();
    for (index, (camera, row)) in cameras.iter().zip(rows(&text)).enumerate() {
        assert_eq!(row[0], 0.04 * index as f64);
        assert_eq!(DVec3::from_slice(&row[1..4]), camera.pose.eye - OFFSET);
        let turn = DQuat::from_xyzw(row[4], row[5], row[6], row[7]);
        let axes = camera.world_from_view();
        assert!((turn * DVec3::Z).distance(axes.z_axis) < 1e-12, "z is forward");
        assert!((turn * DVec3::Y).distance(-axes.y_axis) < 1e-12, "y is down");
    }
}

#[test]
fn lenses_and_zooms_have_cameras_of_their_own() {
    let k = [-0.2, 0.05];
    let cameras = cameras(|index| Screen::Lens { hfov: if index == 3 { 40.0 } else { 60.0 }, k });
    let models = written(&cameras, PoseFormat::Colmap, "sparse/0/cameras.txt").unwrap();
    assert_eq!(models.matches(" RADIAL 64 48 ").count(), 2, "{models}");
    let images = written(&cameras, PoseFormat::Colmap, "sparse/0/images.txt").unwrap();
    let text = written(&cameras, PoseFormat::Transforms, "transforms.json").unwrap();
    let read: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert!(read.get("fl_x").is_none(), "each frame has its own");

    for (index, (camera, row)) in cameras.iter().zip(rows(&images)).enumerate() {
        assert_eq!(row[8], if index == 3 { 2.0 } else { 1.0 });
        let frame = &read["frames"][index];
        assert_eq!((&frame["k1"], &frame["k2"], &frame["p1"]), (&(-0.2).into(), &0.05.into(), &0.0.into()));
        let focal = frame["fl_y"].as_f64().unwrap();
        for (point, place) in points(camera) {
            let turn = DQuat::from_xyzw(row[2], row[3], row[4], row[1]);
            let seen = turn * (point - OFFSET) + DVec3::from_slice(&row[5..8]);
            let found = projected(seen, focal, k);
            assert!(found.distance(place) < 1e-9, "{found} {place}");
        }
    }
}

#[test]
fn screens_without_such_a_camera_are_refused() {
    let cameras = cameras(|_| Screen::Cylindrical { hfov: 90.0 });
    for (format, file) in
        [(PoseFormat::Colmap, "sparse/0/images.txt"), (PoseFormat::Transforms, "transforms.json")]
    {
        let message = written(&cameras, format, file).unwrap_err().to_string();
        assert!(message.contains("kind cylindrical") && message.contains("planar"), "{message}");
    }
}

#[test]
fn files_of_somebody_else_stay() {
    for (format, name, text) in [
        (PoseFormat::Transforms, "transforms.json", "{\"frames\": []}"),
        (PoseFormat::Colmap, "sparse/0/images.txt", "# Image list\n"),
        (PoseFormat::Tum, "poses.tum", "0 1 2 3 0 0 0 1\n"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        format.check_folder(folder.path()).unwrap();
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
        let message = format.check_folder(folder.path()).unwrap_err().to_string();
        assert!(message.contains("another folder to -o"), "{message}");
    }
}
