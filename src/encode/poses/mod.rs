//! Poses of frames in formats of computer vision, beside `poses.csv`.
//!
//! | format | files | axes of the camera | a pose |
//! |---|---|---|---|
//! | `transforms` | `transforms.json` | x right, y up, z back (OpenGL's) | matrix, world from camera |
//! | `colmap` | `sparse/0/cameras.txt`, `images.txt`, `points3D.txt` | x right, y down, z forward (OpenCV's) | quaternion and translation, camera from world |
//! | `tum` | `poses.tum` | as of `colmap` | translation and quaternion, world from camera |
//!
//! The world is the map: x east, y north, z up, metres of the database's reference system, less an offset of whole
//! kilometres, since readers hold floats. Pixel centres lie at half-integers in all of them.

mod colmap;
mod list;
mod posed_frame;
#[cfg(test)]
mod tests;
mod transforms;
mod tum;

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::encode::atomic;
use crate::encode::ours::check_ours;
use hedgehop_base::error::{Error, Result};
use list::OURS;

pub use list::PoseList;
pub use posed_frame::PosedFrame;

/// Format of poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PoseFormat {
    /// `transforms.json` of nerfstudio and instant-ngp.
    Transforms,
    /// Text model of COLMAP.
    Colmap,
    /// Trajectory of the TUM RGB-D benchmark.
    Tum,
}

impl PoseFormat {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Transforms, Self::Colmap, Self::Tum];

    /// Returns the name that users call it by.
    pub fn name(self) -> &'static str {
        match self {
            Self::Transforms => "transforms",
            Self::Colmap => "colmap",
            Self::Tum => "tum",
        }
    }

    /// Returns the paths of its files, relative to the folder of the frames.
    pub fn files(self) -> &'static [&'static str] {
        match self {
            Self::Transforms => &[transforms::FILE],
            Self::Colmap => &[colmap::CAMERAS, colmap::IMAGES, colmap::POINTS],
            Self::Tum => &[tum::FILE],
        }
    }

    /// Whether it tells what a camera is like, which it can of planar screens, with a lens or without.
    pub fn describes_cameras(self) -> bool {
        self != Self::Tum
    }

    /// Refuses a folder that holds such files of somebody else, which would be replaced.
    pub fn check_folder(self, folder: &Path) -> Result<()> {
        let is_ours = |text: &str| match self {
            Self::Transforms => transforms::is_ours(text),
            Self::Colmap | Self::Tum => text.starts_with(OURS),
        };
        self.files().iter().try_for_each(|name| check_ours(&folder.join(name), &is_ours))
    }

    /// Writes its files into `folder`, each as a whole.
    ///
    /// # Errors
    /// [`Error::Configuration`] for a screen or a name that it cannot hold.
    pub fn write(self, folder: &Path, list: &PoseList<'_>) -> Result<()> {
        let files = match self {
            Self::Transforms => vec![transforms::file(list)?],
            Self::Colmap => colmap::files(list)?,
            Self::Tum => vec![tum::file(list)],
        };
        files.iter().try_for_each(|file| atomic::write_bytes(&folder.join(file.name), &file.bytes))
    }

    /// Removes its files from `folder`, whose frames they do not tell any more.
    pub fn remove(self, folder: &Path) -> Result<()> {
        for name in self.files() {
            let path = folder.join(name);
            match std::fs::remove_file(&path) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                    return Err(Error::io(&path, "remove it", error));
                }
                _ => {}
            }
        }
        Ok(())
    }
}
