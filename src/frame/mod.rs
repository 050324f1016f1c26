//! The image stage: pictures and how they are written.
//!
//! ```text
//! Frame ────────▶ 8-bit sRGB ─┬─▶ png   one file per frame, text chunks say what made it
//!   │                         ├─▶ y4m   one stream of frames, BT.709, limited range
//!   │                         └─▶ video an installed ffmpeg, from the finished frames
//!   └───────────────────────────▶ exr   linear colour, Z, range, normals, level, id
//! ```
//!
//! [`pattern`] names the files, [`frames`] says which of them are wanted, [`check`] whether one that
//! exists is whole, [`read_ray_table`] reads screens from EXR, [`sidecar`] writes what made them beside them, [`atomic`] sees to it that no half
//! file is ever seen under its final name. `docs/output.md` describes all of it to users.

use std::path::Path;

use crate::space::Camera;
use crate::voxel::{Attributes, Material};
use hedgehop_base::colour::srgb8_picture;
use hedgehop_base::error::{Error, Result};

mod atmosphere;
pub mod atomic;
pub mod check;
pub mod clouds;
mod exr;
pub mod finish;
mod fog;
pub mod frames;
pub mod geotiff;
mod glow;
pub mod hud;
mod info;
mod matte;
mod motion;
pub mod pattern;
mod picture;
mod png;
mod precipitation;
pub mod rate;
mod ray_table;
pub mod sidecar;
pub mod stage;
#[cfg(test)]
mod testing;
pub mod video;
pub mod y4m;

pub use atmosphere::{Atmosphere, Veil};
pub use frames::FrameSet;
pub use info::FrameInfo;
pub use matte::{Matte, MatteCoverage};
pub use motion::{MotionStep, motion};
pub use pattern::{FramePattern, Target};
pub use picture::Picture;
pub use precipitation::PrecipitationStage;
pub use rate::FrameRate;
pub use ray_table::{read_ray_table, write_ray_table};

/// One rendered frame. All planes are `[height][width]`, row 0 at the top of the screen.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Camera that looked.
    pub camera: Camera,
    /// Linear Rec. 709 radiance, display-referred: 1 is display white.
    pub colour: Vec<[f32; 3]>,
    /// Distance along the ray, metres; infinite where the sky is seen, and where the screen has no picture
    /// ([`Camera::ray`] is `None`): there the colour is black.
    pub range: Vec<f32>,
    /// Unit surface normal in world space (x east, y north, z up); zero for the sky.
    pub normal: Vec<[f32; 3]>,
    /// Level index of the surface that was seen; [`Frame::SKY_LEVEL`] for the sky, [`Frame::BODY_LEVEL`] for bodies.
    pub level: Vec<u8>,
    /// `source << 16 | material << 8 | flags` of the voxel; [`Frame::SKY_ID`] for the sky, [`Frame::body_id`] for bodies.
    pub id: Vec<u32>,
    /// Further channels that were asked for.
    pub aov: Aov,
}

/// Further values of a frame's pixels, which EXR files hold if they are there. The field calls them arbitrary output variables.
#[derive(Debug, Clone, Default)]
pub struct Aov {
    /// Share that bodies and ground have of each pixel.
    pub matte: Option<Matte>,
    /// Motion vectors: pixels to the right and up until the next frame, `[height][width]`; see [`motion()`].
    pub motion: Option<Vec<[f32; 2]>>,
    /// Colours that tell materials apart: [`Material::mark`] of each pixel's `id`.
    pub material: bool,
}

impl Frame {
    /// Level of pixels that see the sky.
    pub const SKY_LEVEL: u8 = 255;
    /// Level of pixels that see a body.
    pub const BODY_LEVEL: u8 = 254;
    /// Id of pixels that see the sky.
    pub const SKY_ID: u32 = u32::MAX;

    /// A frame in which every pixel sees the sky, its colour still black.
    pub fn sky(camera: Camera) -> Self {
        let pixels = camera.width as usize * camera.height as usize;
        Self {
            camera,
            colour: vec![[0.0; 3]; pixels],
            range: vec![f32::INFINITY; pixels],
            normal: vec![[0.0; 3]; pixels],
            level: vec![Self::SKY_LEVEL; pixels],
            id: vec![Self::SKY_ID; pixels],
            aov: Aov::default(),
        }
    }

    /// Id of pixels that see the body of a number below 2³¹ − 1: no voxel has so high a one.
    pub fn body_id(number: u32) -> u32 {
        1 << 31 | number
    }

    /// The material that an [`Self::id`] tells; `None`: of the sky, or of a body.
    pub fn material_of(id: u32) -> Option<Material> {
        (id >> 31 == 0).then(|| Material::of_code((id >> 8) as u8))
    }

    /// Packs a voxel's attributes as they stand in [`Self::id`].
    pub fn pixel_id(attributes: Attributes) -> u32 {
        u32::from(attributes.source) << 16 | u32::from(attributes.material) << 8 | u32::from(attributes.flags)
    }

    /// Whether every plane has one value per pixel of the camera; `path` is where it was to go.
    fn check_planes(&self, path: &Path) -> Result<()> {
        let (width, height) = (self.camera.width as usize, self.camera.height as usize);
        let pixels = width.checked_mul(height).filter(|&pixels| pixels > 0);
        let planes =
            [self.colour.len(), self.range.len(), self.normal.len(), self.level.len(), self.id.len()];
        if planes.iter().any(|&plane| Some(plane) != pixels) {
            let what = format!(
                "planes of {planes:?} values (colour, range, normal, level, id) do not make a picture of \
                 {width}×{height}; --size must be at least 1×1"
            );
            return Err(Error::invalid(path, what));
        }
        if self.aov.motion.as_ref().is_some_and(|motion| motion.len() != self.id.len()) {
            return Err(Error::invalid(path, "motion of other pixels than those of the picture"));
        }
        Ok(())
    }
}

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

    fn from_bytes(bytes: &[u8]) -> Self {
        Self { bytes: bytes.len() as u64, blake3: blake3::hash(bytes).to_hex().to_string() }
    }
}

/// The bytes of the file that [`write_frame`] would write; the extension of `path` decides the encoder.
pub fn encode_frame(path: &Path, frame: &Frame, info: &FrameInfo) -> Result<Vec<u8>> {
    frame.check_planes(path)?;
    match Target::of(path)? {
        Target::Png => png::encode(path, &srgb8_picture(&frame.colour), &frame.camera, info),
        Target::Exr => exr::encode(path, frame, info),
        Target::Y4m => Err(Error::Configuration(format!(
            "{}: y4m holds a stream of frames, not one; use png or exr for single frames",
            path.display()
        ))),
    }
}

/// Writes `frame` to `path`, PNG or EXR by extension. The file appears whole or not at all, and the
/// same frame always gives the same bytes.
pub fn write_frame(path: &Path, frame: &Frame, info: &FrameInfo) -> Result<Written> {
    let bytes = encode_frame(path, frame, info)?;
    atomic::write_bytes(path, &bytes)?;
    Ok(Written::from_bytes(&bytes))
}

/// The bytes of a PNG of a picture of what `camera` saw.
pub fn encode_picture(path: &Path, picture: &Picture, camera: &Camera, info: &FrameInfo) -> Result<Vec<u8>> {
    if Target::of(path)? != Target::Png {
        let what = "only PNG is made from 8-bit pictures; render a frame for other formats";
        return Err(Error::Configuration(format!("{}: {what}", path.display())));
    }
    png::encode(path, &picture.rgb, camera, info)
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
        Target::Png => png::decode(&bytes, None).map(|(picture, _)| picture).map_err(|what| again(&what)),
        Target::Exr => {
            let decoded = exr::decode(&bytes, None).map_err(|what| again(&what))?;
            let colour = decoded.colour().ok_or_else(|| again(&"it has no channels R, G and B"))?;
            let rgb = srgb8_picture(&colour);
            Ok(Picture { width: decoded.width, height: decoded.height, rgb })
        }
        Target::Y4m => Err(Error::unsupported(path, "y4m is not read back", "render frames/####.png")),
    }
}
