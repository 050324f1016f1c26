//! Trajectory of the TUM RGB-D benchmark (Sturm et al. 2012): `timestamp tx ty tz qx qy qz qw`, the world from the camera.

use std::fmt::Write;

use super::list::{OURS, PoseFile, PoseList, numbers};
use super::posed_frame::quaternion;

/// Name of the file.
pub(super) const FILE: &str = "poses.tum";

/// Returns the file of some poses.
pub(super) fn file(list: &PoseList<'_>) -> PoseFile {
    let axes = "camera: x right, y down, z forward";
    let mut text = format!("{OURS}trajectory; {}; {axes}\n# timestamp tx ty tz qx qy qz qw\n", list.world());
    for frame in &list.frames {
        let place = (frame.eye - list.offset).to_array();
        let turn = quaternion(frame.world_from_cv());
        let turn = [turn.x, turn.y, turn.z, turn.w];
        let _ = writeln!(text, "{}", numbers([frame.seconds].into_iter().chain(place).chain(turn)));
    }
    PoseFile { name: FILE, bytes: text.into_bytes() }
}
