//! Poses of a sequence, and what all files of them share.

use glam::DVec3;

use super::posed_frame::PosedFrame;

/// Beginning of text files of ours.
pub(super) const OURS: &str = "# hedgehop: ";

/// Poses of a sequence.
#[derive(Debug, Clone)]
pub struct PoseList<'a> {
    /// Frames, rising.
    pub frames: Vec<PosedFrame<'a>>,
    /// Point that positions count from, metres in the database's reference system.
    pub offset: DVec3,
    /// Coordinate reference system.
    pub crs: &'a str,
    /// Datum that heights count from.
    pub vertical_datum: &'a str,
}

/// A file of poses.
pub(super) struct PoseFile {
    /// Path, relative to the folder of the frames.
    pub name: &'static str,
    pub bytes: Vec<u8>,
}

impl PoseList<'_> {
    /// Says in a line what the world's axes are.
    pub fn world(&self) -> String {
        let [x, y, z] = self.offset.to_array();
        let line = format!(
            "world: x east, y north, z up, metres of {}, heights from {}, less offset_m {x} {y} {z}",
            self.crs, self.vertical_datum
        );
        line.replace(char::is_control, " ")
    }
}

/// Numbers as text, with blanks between, in digits that read back to the same f64; no zero is negative.
pub(super) fn numbers(values: impl IntoIterator<Item = f64>) -> String {
    let texts: Vec<_> = values.into_iter().map(|value| (value + 0.0).to_string()).collect();
    texts.join(" ")
}
