//! The image stage: what planes and bodies saw, as pixels of a screen.
//!
//! ```text
//! Frame ──▶ linear light with range, normal, level, id
//!   └──finish──▶ exposure, tone, lens ──▶ Picture ──hud──▶ symbols over it
//! ```
//!
//! [`stage`] fills rows of pixels from plane images. How frames become files is in [`crate::encode`].

mod channels;
pub mod finish;
pub mod hud;
mod matte;
mod motion;
mod picture;
pub mod stage;

pub use channels::{Aov, Frame};
pub use matte::{Matte, MatteCoverage};
pub use motion::{MotionStep, motion};
pub use picture::Picture;
