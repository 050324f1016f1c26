//! Titling: text and figures over finished pictures.
//!
//! ```text
//! scene, flags ──▶ Titling ─┐
//! path, relief, fonts ──────┴─ Titles::new ──▶ what is the same in all pictures
//!                                  └── draw(picture, camera, readings) ──▶ figures, then cards, over the picture's codes
//! ```
//!
//! The film's style ([`film`]) is for an audience: readouts, compass, map, profile, and cards of text. The pilot's style ([`hud`]) has a horizon and a tape. A picture is a
//! function of its camera and readings alone, so that it is the same whichever frames are drawn with it.

pub mod dot_font;
pub mod film;
mod fonts;
pub mod hud;
mod layer;
mod readings;
pub mod relief;
mod text;
mod titles;
mod track_point;

pub use fonts::{Fonts, quoted};
pub use readings::Readings;
pub use titles::{FilmLength, TimedCaption, TitleInputs, Titles};
pub use track_point::TrackPoint;
