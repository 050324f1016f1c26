//! Encoders: frames and pictures to files, and what made them beside.
//!
//! ```text
//! 8-bit sRGB ─┬─▶ png   one file per frame, text chunks say what made it
//!             ├─▶ y4m   one stream of frames, BT.709, limited range
//!             └─▶ video an installed ffmpeg, or Motion JPEG
//! Frame ───────┬─▶ exr   linear colour, Z, range, normals, level, id
//!              ├─▶ png   labels: materials and objects, as numbers
//!              └─▶ npy   depth alone, as NumPy's arrays
//! ```
//!
//! [`pattern`] names the files, [`frames`] says which of them are wanted, [`check`] whether one that
//! exists is whole, [`read_ray_table`] reads screens from EXR, [`sidecar`] writes what made them beside them, [`atomic`] sees to it that no half
//! file is ever seen under its final name. `docs/output.md` describes all of it to users.

#[doc(hidden)]
pub mod atomic;
#[doc(hidden)]
pub mod check;
mod cryptomatte;
mod depth;
mod exr;
#[doc(hidden)]
pub mod frames;
#[doc(hidden)]
pub mod geotiff;
mod info;
#[doc(hidden)]
pub mod labels;
mod npy;
mod ours;
#[doc(hidden)]
pub mod pattern;
mod png;
#[doc(hidden)]
pub mod poses;
mod ray_table;
mod refusal;
#[doc(hidden)]
pub mod sidecar;
#[cfg(test)]
mod testing;
#[doc(hidden)]
pub mod video;
mod write;
#[doc(hidden)]
pub mod y4m;

#[doc(hidden)]
pub use frames::FrameSet;
#[doc(hidden)]
pub use info::FrameInfo;
#[doc(hidden)]
pub use pattern::{FramePattern, Target};
pub use ray_table::{read_ray_table, write_ray_table};
#[doc(hidden)]
pub use write::{Written, encode_frame, encode_picture, read_regular};
pub use write::{read_picture, write_frame, write_frame_on, write_picture};
