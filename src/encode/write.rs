//! Frames and pictures to files, and back.

use std::path::Path;

use super::info::FrameInfo;
use super::pattern::Target;
use super::png::{DecodedPng, PngPixels};
use super::{atomic, exr, npy, png};
use crate::frame::{Frame, Picture};
use crate::space::Camera;
use crate::subimage::Farm;
use hedgehop_base::colour::srgb8_picture;
use hedgehop_base::error::{Error, Result};

/// Files that [`write_frame`] put on the disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// Length of the file, bytes.
    pub bytes: u64,
    /// BLAKE3 of the file, 64 lower-case hexadecimal digits.
    pub blake3: String,
}

impl Written {
    /// Measures a file that is there already.
    pub fn of(path: &Path) -> Result<Self> {
        let bytes = read_regular(path, "read it")?;
        Ok(Self::from_bytes(&bytes))
    }

    pub(super) fn from_bytes(bytes: &[u8]) -> Self {
        Self { bytes: bytes.len() as u64, blake3: blake3::hash(bytes).to_hex().to_string() }
    }
}

/// The bytes of the file that [`write_frame`] would write; the extension of `path` decides the encoder.
pub fn encode_frame(path: &Path, frame: &Frame, info: &FrameInfo) -> Result<Vec<u8>> {
    encode_frame_on(&Farm::new(1)?, path, frame, info)
}

/// The bytes of the file that [`write_frame_on`] would write.
fn encode_frame_on(farm: &Farm, path: &Path, frame: &Frame, info: &FrameInfo) -> Result<Vec<u8>> {
    frame.check_lengths(path)?;
    match Target::of(path)? {
        Target::Png => png::encode(path, PngPixels::Rgb(&srgb8_picture(&frame.colour)), &frame.camera, info),
        Target::Exr => exr::encode(path, frame, info, farm),
        Target::Npy => npy::encode(path, frame, info, farm),
        Target::Y4m => Err(Error::Configuration(format!(
            "{}: y4m holds a stream of frames, not one; use png, exr or npy for single frames",
            path.display()
        ))),
    }
}

/// Writes `frame` to `path`, PNG, EXR or NPY (depth) by extension. The file appears whole or not at all, and the
/// same frame always gives the same bytes.
pub fn write_frame(path: &Path, frame: &Frame, info: &FrameInfo) -> Result<Written> {
    write_frame_on(&Farm::new(1)?, path, frame, info)
}

/// Writes a frame as [`write_frame`] does, with the help of a farm's workers. The bytes are the same for any
/// number of them.
pub fn write_frame_on(farm: &Farm, path: &Path, frame: &Frame, info: &FrameInfo) -> Result<Written> {
    let bytes = encode_frame_on(farm, path, frame, info)?;
    atomic::write_bytes(path, &bytes)?;
    Ok(Written::from_bytes(&bytes))
}

/// The bytes of a PNG of a picture of what `camera` saw.
pub fn encode_picture(path: &Path, picture: &Picture, camera: &Camera, info: &FrameInfo) -> Result<Vec<u8>> {
    if Target::of(path)? != Target::Png {
        let what = "only PNG is made from 8-bit pictures; render a frame for other formats";
        return Err(Error::Configuration(format!("{}: {what}", path.display())));
    }
    png::encode(path, PngPixels::Rgb(&picture.rgb), camera, info)
}

/// Writes a picture of what `camera` saw to `path` as PNG. The file appears whole or not at all, and the same
/// picture always gives the same bytes.
pub fn write_picture(path: &Path, picture: &Picture, camera: &Camera, info: &FrameInfo) -> Result<Written> {
    let bytes = encode_picture(path, picture, camera, info)?;
    atomic::write_bytes(path, &bytes)?;
    Ok(Written::from_bytes(&bytes))
}

/// All bytes of a regular file: a pipe would be waited for without end. `action` says what fails if it cannot be read.
///
/// # Errors
/// [`Error::Io`] if it cannot be read; [`Error::Invalid`] if it is no regular file.
pub fn read_regular(path: &Path, action: &'static str) -> Result<Vec<u8>> {
    let failed = |source| Error::io(path, action, source);
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(Error::invalid(path, "is no regular file; name one that is"));
    }
    std::fs::read(path).map_err(failed)
}

/// Reads a finished frame back as an 8-bit picture; EXR goes through the same [`hedgehop_base::colour`] as PNG.
pub fn read_picture(path: &Path) -> Result<Picture> {
    let target = Target::of(path)?;
    let bytes = read_regular(path, "read it")?;
    let again = |what: &dyn std::fmt::Display| {
        Error::invalid(path, format!("no whole frame: {what}; render it again with --skip-existing"))
    };
    match target {
        Target::Png => {
            let DecodedPng { size, rgb, .. } = png::decode(&bytes, None).map_err(|what| again(&what))?;
            let what = "its pixels are labels, not colours";
            let rgb = rgb.ok_or_else(|| Error::unsupported(path, what, "render it without --labels"))?;
            Ok(Picture { width: size.width, height: size.height, rgb })
        }
        Target::Exr => {
            let decoded = exr::decode(&bytes, None).map_err(|what| again(&what))?;
            let colour = decoded.colour().ok_or_else(|| again(&"it has no channels R, G and B"))?;
            let rgb = srgb8_picture(&colour);
            Ok(Picture { width: decoded.width, height: decoded.height, rgb })
        }
        Target::Npy => Err(Error::unsupported(path, "depth is no picture", "render frames/####.png")),
        Target::Y4m => Err(Error::unsupported(path, "y4m is not read back", "render frames/####.png")),
    }
}
