//! Sunlight: where the sun stands, and what ground it reaches.
//!
//! ```text
//! sun ──▶ course: along which posts its rays run, and how fast they fall
//!          └▶ legs: rows of posts towards the sun, the farther the coarser ──sweep──▶ share of the sun that each post sees
//! ```
//!
//! The patent marches from every voxel towards the sun and darkens what is blocked (Hughes 1994, shadows). A sweep finds the same for a page at
//! once: row by row away from the sun it carries the height up to which all lies in shadow, which every row may lift and every step
//! lowers. It carries two of them, of the sun's upper and its lower rim, and what lies between the two sees a part of the sun: shadows are as soft
//! as they are wide of their edge. The way to a far edge leads over coarser levels, whose voxels are no larger than the half-shadow is wide there.

mod brightness;
mod course;
mod daylight;
mod film;
mod observatory;
mod rows;
mod sample;
mod setting;
mod shade;
mod stars;
mod sun;
mod sweep;
#[cfg(test)]
mod tests;
#[doc(hidden)]
pub mod written;

#[doc(hidden)]
pub use brightness::{Brightness, illuminance};
#[doc(hidden)]
pub use course::SUN_SEMIDIAMETER;
#[doc(hidden)]
pub use daylight::Daylight;
pub use film::{FilmSun, RunningSky};
#[doc(hidden)]
pub use observatory::Observatory;
#[doc(hidden)]
pub use sample::ShadeSampler;
pub use setting::SunSetting;
#[doc(hidden)]
pub use shade::{SHADE_APRON, Shade, ShadePage, Shades};
#[doc(hidden)]
pub use stars::{Firmament, Star, starlight_through, stars};
#[doc(hidden)]
pub use sun::{Night, seen_through};
pub use sun::{Sky, Sun};
