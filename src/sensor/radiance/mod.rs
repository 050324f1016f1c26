//! Radiance by the page: what a voxel sends to any eye, computed once and not once a pixel.
//!
//! ```text
//! page touched for the first time:  radiance = colour × light on the post's normal, for every post
//! seen along planes for the first time:  its lines, filtered by stride and footprint
//! line that planes cross:           linear between its texels
//! ```
//!
//! The surfaces are Lambert's, so what they send does not depend on where the eye is, and a pixel
//! needs no normal. It also filters better: the average of what voxels send is what a far pixel sees, while
//! the light on an average normal is not. (The patent stores light and shadow with the voxels' colour, in
//! the database; here they follow the sun that is asked for.)
//!
//! Texels are three times 10 bits of the root of radiance: fine in the dark, and up to
//! 2.25 times display white.

#[cfg(test)]
mod beside_tests;
mod cache;
#[cfg(test)]
mod cache_tests;
mod facing;
mod lines;
mod page;
mod part;
mod posts;
mod sample;
#[cfg(test)]
mod seam_tests;
#[cfg(test)]
mod tests;
mod texels;
mod window;

pub use cache::{Radiance, RadiancePages};
pub use facing::Facing;
pub use lines::{LineFilter, LineImage};
pub use page::RadiancePage;
pub use sample::{Crossings, ImageLine, LineSampler, PlanesAbove, TexelPlace};
pub use texels::Deviations;
