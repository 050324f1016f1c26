//! The image stage: what planes and bodies saw, as pixels of a screen.
//!
//! ```text
//! Frame ──▶ linear light with range, normal, level, id
//!   └──finish──▶ exposure, tone, lens ──▶ Picture
//! ```
//!
//! [`stage`] fills rows of pixels from plane images. How frames become files is in [`crate::encode`].

mod channels;
#[doc(hidden)]
pub mod finish;
mod matte;
mod motion;
mod picture;
mod position;
#[doc(hidden)]
pub mod stage;

pub use channels::{Aov, Frame, MapPositions};
#[doc(hidden)]
pub use matte::{Matte, MatteCoverage};
#[doc(hidden)]
pub use motion::{MotionStep, motion};
pub use picture::Picture;
#[doc(hidden)]
pub use position::{PositionInputs, map_offset, map_positions};
