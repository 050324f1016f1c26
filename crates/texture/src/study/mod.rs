//! Pictures as the study of cyclic codes makes them: sky, flat ground, terrain with texture, and a runway on it.
//!
//! ```text
//! Settings ──▶ Eye by frame ──▶ GroundView: place of a screen point on the ground, ground on the screen
//!                                  ├──▶ GroundQuad ──clip, project──▶ sides on the screen ──▶ shares of pixels
//!                                  └──▶ Footprint ──exact mean of the code──▶ shade
//! ```
//!
//! A reference to judge and to time by, not what hedgehop renders with.

mod eye;
mod ground_quad;
mod pixel_share;
mod run;
mod scene;
mod settings;
mod view;

pub use eye::{Eye, EyeAttitude};
pub use ground_quad::GroundQuad;
pub use pixel_share::{HalfPlane, ScreenPoint};
pub use run::Run;
pub use scene::{GreyPicture, Runway, StudyScene, TexturedTerrain};
pub use settings::{AircraftSettings, DatabaseSettings, DisplaySettings, Settings, SimulatorSettings};
pub use view::{GroundView, Screen};
