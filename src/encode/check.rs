//! Whether a frame that exists is whole, and can stay: `--skip-existing`.
//!
//! ```text
//! no file                                               → Missing
//! does not decode to its end, or a checksum is wrong    → Broken
//! another size, or entries of another frame, or none    → Different
//! else                                                  → Whole
//! ```
//!
//! A file that says nothing about itself (an optimiser stripped its text chunks, or another program wrote it) may
//! show anything; it is rendered again.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

use crate::encode::refusal::PictureRefusal;
use crate::encode::{FrameInfo, Target, exr, npy, png};
use crate::space::Camera;
use hedgehop_base::Size;

/// State of a frame's file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Existing {
    /// The frame, complete.
    Whole,
    /// No file.
    Missing,
    /// A file that is damaged, cut short or no picture; says how.
    Broken(String),
    /// A whole picture of something else; says what differs.
    Different(String),
}

/// Looks at the file that the frame of `camera` and `info` would go to.
pub fn existing(path: &Path, camera: &Camera, info: &FrameInfo) -> Existing {
    let bytes = match std::fs::metadata(path) {
        // A pipe would be waited for without end.
        Ok(found) if !found.is_file() => return Existing::Broken("it is no regular file".to_owned()),
        _ => std::fs::read(path),
    };
    let bytes = match bytes {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == ErrorKind::NotFound => return Existing::Missing,
        Err(error) => return Existing::Broken(format!("it cannot be read: {error}")),
    };

    match entries(path, &bytes, Some(Size { width: camera.width, height: camera.height })) {
        Ok(found) => match info.difference(camera, &found) {
            Some(what) => Existing::Different(what),
            None => Existing::Whole,
        },
        Err(PictureRefusal::Broken(what)) => Existing::Broken(what),
        Err(PictureRefusal::Size(Size { width, height })) => {
            let what = format!("it is {width}×{height} pixels, not {}×{}", camera.width, camera.height);
            Existing::Different(what)
        }
    }
}

/// Decodes a PNG, EXR or NPY to its end, with all its checksums, and returns its BLAKE3, hexadecimal.
///
/// # Errors
/// A clause that says how it is damaged, or why it cannot be read.
pub fn digest_of_whole(path: &Path) -> Result<String, String> {
    let bytes = std::fs::read(path).map_err(|error| format!("it cannot be read: {error}"))?;
    entries(path, &bytes, None).map_err(|refusal| refusal.to_string())?;
    Ok(blake3::hash(&bytes).to_hex().to_string())
}

/// Decodes a file as a whole and reads its entries about itself; of any size unless one is wanted.
fn entries(
    path: &Path,
    bytes: &[u8],
    wanted: Option<Size>,
) -> Result<BTreeMap<String, String>, PictureRefusal> {
    match Target::of(path) {
        Ok(Target::Png) => png::decode(bytes, wanted).map(|decoded| decoded.entries),
        Ok(Target::Exr) => exr::decode(bytes, wanted).map(|decoded| decoded.entries),
        Ok(Target::Npy) => npy::decode(bytes, wanted),
        Ok(Target::Y4m) => Err("y4m is not checked frame by frame".to_owned().into()),
        Err(error) => Err(error.to_string().into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::{testing, write_frame};

    /// A whole small frame in a folder of its own.
    fn written(name: &str) -> (tempfile::TempDir, std::path::PathBuf, Camera) {
        let (folder, path) = testing::place(name);
        let frame = testing::frame(9, 6);
        write_frame(&path, &frame, &testing::info()).unwrap();
        (folder, path, frame.camera)
    }

    fn is_broken(path: &Path, camera: &Camera) -> bool {
        matches!(existing(path, camera, &testing::info()), Existing::Broken(_))
    }

    #[test]
    fn the_frame_itself_is_whole() {
        for name in ["0042.png", "0042.exr", "0042.npy"] {
            let (_folder, path, camera) = written(name);
            assert_eq!(existing(&path, &camera, &testing::info()), Existing::Whole);
            assert_eq!(
                existing(&path.with_file_name("0043.png"), &camera, &testing::info()),
                Existing::Missing
            );
        }
    }

    #[test]
    fn no_prefix_is_whole() {
        for name in ["0042.png", "0042.exr", "0042.npy"] {
            let (_folder, path, camera) = written(name);
            let bytes = std::fs::read(&path).unwrap();
            for length in 0..bytes.len() {
                std::fs::write(&path, &bytes[..length]).unwrap();
                assert!(is_broken(&path, &camera), "{name}: {length} of {} bytes", bytes.len());
            }
        }
    }

    #[test]
    fn no_flipped_byte_goes_unseen() {
        for name in ["0042.png", "0042.npy"] {
            let (_folder, path, camera) = written(name);
            let whole = std::fs::read(&path).unwrap();
            for at in 0..whole.len() {
                let mut bytes = whole.clone();
                bytes[at] ^= 0x41;
                std::fs::write(&path, &bytes).unwrap();
                assert_ne!(existing(&path, &camera, &testing::info()), Existing::Whole, "{name}: byte {at}");
            }
        }
    }

    /// EXR has no checksum over attributes that are not ours; what the picture and its entries are is covered.
    #[test]
    fn flipped_bytes_of_an_exr_never_change_what_is_seen() {
        let (_folder, path, camera) = written("0042.exr");
        let whole = std::fs::read(&path).unwrap();
        let original = exr::decode(&whole, None).unwrap();
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x41;
            std::fs::write(&path, &bytes).unwrap();
            if existing(&path, &camera, &testing::info()) == Existing::Whole {
                let decoded = exr::decode(&bytes, None).unwrap();
                assert_eq!(decoded.colour(), original.colour(), "byte {at}");
                assert_eq!(decoded.entries, original.entries, "byte {at}");
            }
        }
    }

    #[test]
    fn zeroed_files_are_broken() {
        for name in ["0042.png", "0042.exr", "0042.npy"] {
            let (_folder, path, camera) = written(name);
            let length = std::fs::metadata(&path).unwrap().len() as usize;
            std::fs::write(&path, vec![0; length]).unwrap();
            assert!(is_broken(&path, &camera));
            std::fs::write(&path, []).unwrap();
            assert!(is_broken(&path, &camera));
        }
    }

    #[test]
    fn frames_of_something_else_are_different() {
        for name in ["0042.png", "0042.exr", "0042.npy"] {
            let (_folder, path, camera) = written(name);
            let different = |camera: &Camera, info: &FrameInfo| match existing(&path, camera, info) {
                Existing::Different(what) => what,
                other => panic!("{other:?}"),
            };
            let mut info = testing::info();
            info.settings_digest = "beef".to_owned();
            assert!(different(&camera, &info).contains("settings_digest"));
            let wider = Camera::new(camera.pose, 10, 6);
            assert_eq!(different(&wider, &testing::info()), "it is 9×6 pixels, not 10×6");
            let mut pose = camera.pose;
            pose.eye.x += 1e-9;
            let moved = Camera::new(pose, 9, 6);
            assert!(different(&moved, &testing::info()).starts_with("eye_m is 500123.456789 "));
        }
    }

    #[test]
    fn a_folder_in_the_way_is_broken_not_missing() {
        let (_folder, path) = testing::place("0042.png");
        std::fs::create_dir(&path).unwrap();
        assert!(is_broken(&path, &testing::frame(9, 6).camera));
    }
}
