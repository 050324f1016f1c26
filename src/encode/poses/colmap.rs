//! Text model of COLMAP (its documentation, *Output Format*): cameras, images, and no points.
//!
//! ```text
//! cameras.txt    CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]        PINHOLE: fx fy cx cy; RADIAL: f cx cy k1 k2
//! images.txt     IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, and an empty line for its points
//! ```
//!
//! Rotation and translation take points of the world to the camera: `R · p + t`. An image's id is its frame's number.

use std::fmt::Write;

use super::list::{OURS, PoseFile, PoseList, numbers};
use super::posed_frame::{Intrinsics, quaternion};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

pub(super) const CAMERAS: &str = "sparse/0/cameras.txt";
pub(super) const IMAGES: &str = "sparse/0/images.txt";
pub(super) const POINTS: &str = "sparse/0/points3D.txt";

/// Greatest id of an image.
const MOST_IMAGES: u64 = i32::MAX as u64;

/// Returns the files of some poses.
pub(super) fn files(list: &PoseList<'_>) -> Result<Vec<PoseFile>> {
    let world = list.world();
    let mut cameras: Vec<Intrinsics> = Vec::new();
    let mut images =
        format!("{OURS}images; {world}\n# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n");

    for frame in &list.frames {
        if frame.number > MOST_IMAGES || frame.file.contains(char::is_whitespace) {
            return Err(Error::Configuration(format!(
                "{}: COLMAP reads names without blanks, and numbers up to {MOST_IMAGES}; name frames otherwise (-o), or leave colmap out",
                frame.file
            )));
        }

        let camera = frame.intrinsics()?;
        let known = cameras.iter().position(|other| *other == camera);
        let index = known.unwrap_or_else(|| {
            cameras.push(camera);
            cameras.len() - 1
        });

        let camera_from_world = frame.world_from_cv().transpose();
        let turn = quaternion(camera_from_world);
        let shift = -(camera_from_world * (frame.eye - list.offset));
        let pose = numbers([turn.w, turn.x, turn.y, turn.z].into_iter().chain(shift.to_array()));
        // The second line is for points, of which there are none.
        let _ = writeln!(images, "{} {pose} {} {}\n", frame.number, index + 1, frame.file);
    }

    let mut rows = format!("{OURS}cameras\n# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n");
    for (index, camera) in cameras.iter().enumerate() {
        let Size { width, height } = camera.size;
        let ([cx, cy], [k1, k2], focal) = (camera.middle(), camera.k, camera.focal);
        let (model, parameters) = if camera.is_distorted() {
            ("RADIAL", numbers([focal, cx, cy, k1, k2]))
        } else {
            ("PINHOLE", numbers([focal, focal, cx, cy]))
        };
        let _ = writeln!(rows, "{} {model} {width} {height} {parameters}", index + 1);
    }

    let points = format!("{OURS}no points; {world}\n");
    let file = |name, text: String| PoseFile { name, bytes: text.into_bytes() };
    Ok(vec![file(CAMERAS, rows), file(IMAGES, images), file(POINTS, points)])
}
