//! Detail below the finest voxel: what imagery says of it, and what is made up in its spirit.
//!
//! ```text
//! posts of the finest level:
//!     colour     such that interpolation between posts gives each voxel back its own mean      mean_keeping
//!     amplitude  how rough the imagery is there, by its finest octave                          amplitude
//!     walls      calmed, and detail over their face instead of the ground                      walls
//! façades of spans:
//!     colour × mean of windows, doors, plinth and courses over the footprint, 1 from afar      facade
//! pixels nearer than a voxel's width:
//!     light × (1 + amplitude · mean of a repeating tile over the footprint)                    ground tile
//!     tiles   of the pattern that a database asks for, as the sun lights it                    synthesis
//!     height + reach of the material · mean of a tile of heights over the pixel, if asked for  displacement
//! ```
//!
//! Real pictures hold about as much contrast in each octave as in the one before (measured over five, from 0.1 m to 3 m a pixel),
//! so that the finest octave that a voxel's neighbours show foretells those that no voxel holds.

mod amplitude;
mod blocks;
mod displacement;
mod facade;
mod field;
mod ground_tile;
mod mean_keeping;
mod measure;
mod post_light;
mod posts;
mod synthesis;
#[cfg(test)]
mod tests;
mod walls;

pub use amplitude::MOST_DEVIATION;
pub use blocks::{DetailBlocks, DetailedColour, PostCell};
pub use displacement::{DisplacedRelief, Displacement, DisplacementView};
pub use facade::{AlongMeans, FacadePattern, WallFootprint};
pub use ground_tile::{FADING, GroundTile, RoughPattern};
pub use measure::DetailMeasure;
pub use post_light::PostLight;
pub use posts::{DETAIL_MARGIN, DETAIL_RING, DetailPosts, DetailSource};
pub use synthesis::{DetailTiles, SunAngles, Synthesis};
pub use walls::{LEAST_TOWARD, WALL_SCALE};
