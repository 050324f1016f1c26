//! `transforms.json`, as nerfstudio and instant-ngp read it.
//!
//! A frame's `transform_matrix` is the world from the camera, whose axes are right, up and back. `applied_transform` is
//! nerfstudio's: what was done to the coordinates of the map. The key `offset` is not: instant-ngp moves its cube by it.

use serde::Serialize;

use super::list::{PoseFile, PoseList};
use super::posed_frame::Intrinsics;
use hedgehop_base::error::{Error, Result};

/// Name of the file.
pub(super) const FILE: &str = "transforms.json";

#[derive(Serialize)]
struct Transforms<'a> {
    camera_model: &'static str,
    /// Camera of all frames; each has its own where they differ.
    #[serde(flatten)]
    camera: Option<CameraEntry>,
    applied_transform: [[f64; 4]; 3],
    hedgehop: WorldEntry<'a>,
    frames: Vec<FrameEntry<'a>>,
}

#[derive(Serialize)]
struct CameraEntry {
    w: u32,
    h: u32,
    fl_x: f64,
    fl_y: f64,
    cx: f64,
    cy: f64,
    #[serde(flatten)]
    lens: Option<LensEntry>,
}

#[derive(Serialize)]
struct LensEntry {
    k1: f64,
    k2: f64,
    p1: f64,
    p2: f64,
}

/// Meaning of coordinates.
#[derive(Serialize)]
struct WorldEntry<'a> {
    offset_m: [f64; 3],
    crs: &'a str,
    vertical_datum: &'a str,
    world: String,
}

#[derive(Serialize)]
struct FrameEntry<'a> {
    file_path: &'a str,
    #[serde(flatten)]
    camera: Option<CameraEntry>,
    transform_matrix: [[f64; 4]; 4],
}

/// Whether a `transforms.json` is one of ours.
pub(super) fn is_ours(text: &str) -> bool {
    serde_json::from_str::<serde_json::Value>(text).is_ok_and(|found| found.get("hedgehop").is_some())
}

/// Returns the file of some poses.
pub(super) fn file(list: &PoseList<'_>) -> Result<PoseFile> {
    let cameras = list.frames.iter().map(|frame| frame.intrinsics()).collect::<Result<Vec<_>>>()?;
    let shared = cameras.first().filter(|first| cameras.iter().all(|camera| camera == *first));

    let frames = list.frames.iter().zip(&cameras).map(|(frame, camera)| {
        let axes = frame.world_from_gl();
        let place = frame.eye - list.offset;
        let columns = [axes.x_axis, axes.y_axis, axes.z_axis, place].map(|column| column.to_array());
        let row = |row: usize| columns.map(|column| column[row] + 0.0);
        FrameEntry {
            file_path: frame.file,
            camera: shared.is_none().then(|| CameraEntry::of(camera)),
            transform_matrix: [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]],
        }
    });

    let [x, y, z] = list.offset.to_array();
    let transforms = Transforms {
        camera_model: "OPENCV",
        camera: shared.map(CameraEntry::of),
        applied_transform: [[1.0, 0.0, 0.0, 0.0 - x], [0.0, 1.0, 0.0, 0.0 - y], [0.0, 0.0, 1.0, 0.0 - z]],
        hedgehop: WorldEntry {
            offset_m: [x, y, z],
            crs: list.crs,
            vertical_datum: list.vertical_datum,
            world: list.world(),
        },
        frames: frames.collect(),
    };

    let mut bytes = serde_json::to_vec_pretty(&transforms)
        .map_err(|error| Error::Configuration(format!("{FILE} cannot be written as JSON: {error}")))?;
    bytes.push(b'\n');
    Ok(PoseFile { name: FILE, bytes })
}

impl CameraEntry {
    fn of(camera: &Intrinsics) -> Self {
        let ([cx, cy], [k1, k2]) = (camera.middle(), camera.k);
        Self {
            w: camera.size.width,
            h: camera.size.height,
            fl_x: camera.focal,
            fl_y: camera.focal,
            cx,
            cy,
            lens: camera.is_distorted().then_some(LensEntry { k1, k2, p1: 0.0, p2: 0.0 }),
        }
    }
}
