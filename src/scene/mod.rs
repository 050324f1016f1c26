//! Scenes: what a flight meets besides the ground, and under which light.
//!
//! ```text
//! scene.toml ──Scene::read──▶ Scene (as the file says) ──Scene::bind──▶ Cast ──bodies_at(seconds)──▶ bodies
//! ```
//!
//! `docs/scene.md` describes the file to users.

mod appearance;
mod camera;
mod cast;
mod contents;
mod file;
mod form;
mod joint;
mod light;
mod model;
mod object;
mod object_table;
mod onward;
mod own_flight;
mod part;
mod picture;
mod place;
mod plume;
mod slope;
mod sun;
mod titling;
mod track_file;
mod trail;
mod trail_cast;
mod weather_tables;

#[doc(hidden)]
pub use cast::{Cast, CastSubject, Scenery};
pub use contents::Scene;
#[doc(hidden)]
pub use contents::{Beyond, NightSky, Object, Part, SunLines};
#[doc(hidden)]
pub use light::{Flash, Lamp, LampLayout, Light, Rhythm};
#[doc(hidden)]
pub use own_flight::OwnFlight;
pub use picture::{Dither, Finish, Hud, Tone};
#[doc(hidden)]
pub use place::Anchor;
#[doc(hidden)]
pub use plume::{Plume, PlumeKind};
#[doc(hidden)]
pub use titling::{Caption, Cue, Figures, MOST_FONT_BYTES, OverlayStyle, Titling, Units};
#[doc(hidden)]
pub use trail::{Trail, TrailColour, TrailQuantity, TrailSource};
