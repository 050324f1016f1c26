//! A small frame with every kind of pixel, for the tests of the encoders.

use std::path::PathBuf;

use glam::DVec3;

use crate::encode::FrameInfo;
use crate::frame::Frame;
use crate::space::{Attitude, Camera, Pose};

/// A banked view of a sloping plane under a sky: columns of colour, rows of range.
pub fn frame(width: u32, height: u32) -> Frame {
    let pose = Pose {
        eye: DVec3::new(500_123.456_789, 4_649_776.225, 312.75),
        attitude: Attitude { yaw: 33.0, pitch: -5.25, roll: 20.0 },
        hfov: 60.0,
    };

    let mut frame = Frame {
        camera: Camera::new(pose, width, height),
        colour: Vec::new(),
        range: Vec::new(),
        normal: Vec::new(),
        level: Vec::new(),
        id: Vec::new(),
        aov: crate::frame::Aov::default(),
    };

    for row in 0..height {
        for column in 0..width {
            let sky = row < height / 3;
            let (u, v) = (column as f32 / width as f32, row as f32 / height as f32);
            frame.colour.push([u * u, 0.25 + 0.5 * v, if sky { 1.5 } else { 0.125 * u }]);
            frame.range.push(if sky { f32::INFINITY } else { 1000.0 / (v + 0.01) + column as f32 });
            frame.normal.push(if sky { [0.0; 3] } else { [0.0, -0.6, 0.8] });
            frame.level.push(if sky { Frame::SKY_LEVEL } else { (row % 4) as u8 });
            frame.id.push(if sky { Frame::SKY_ID } else { (3 << 16) | (row << 8) | (column % 2) });
        }
    }

    frame
}

/// What made it.
pub fn info() -> FrameInfo {
    FrameInfo {
        frame: 42,
        seconds: 1.64,
        database_hash: "0123abcd".repeat(8),
        database_file: "Küste.hop".to_owned(),
        crs_name: "WGS 84 / UTM zone 33N (EPSG:32633)".to_owned(),
        vertical_datum: "mean sea level (EGM96)".to_owned(),
        settings_digest: "feed".repeat(16),
        writer: "hedgehop 0.1.0".to_owned(),
    }
}

/// A folder of this test's own, and a file name in it.
pub fn place(name: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    (folder, path)
}
