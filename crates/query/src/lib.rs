//! Questions about the ground: what lies along a line, what is seen from where, and what maps of it show.
//!
//! ```text
//! places ──▶ samples along straight lines of the database's system ──▶ ground below each
//! two points ──▶ the ray between them, over a curved Earth ──▶ where ground or what stands on it hides one from the other, and how near it comes
//! a box ──▶ the posts of a level in it ──▶ pixels of a map, light on them, contour lines
//! an area ──▶ its finest voxels ──▶ spikes, seams, voids and other faults of terrain
//! ```
//!
//! Line of sight is that of the reference marcher on the finest level (design of the data base analysis system, Hughes 1994): what a picture from near by would show, with air below
//! bridges and crowns, however far apart the points are.

mod classes;
mod clearance;
mod continuity;
mod contours;
mod hillshade;
mod map;
mod posts;
mod profile;
mod sight;
mod slabs;
#[cfg(test)]
mod testing;

pub use classes::{ClassTally, LevelTally, ObjectTally, Tally, attributes_at, tally};
pub use continuity::{ContinuityLimits, ContinuityReport, Fault, Finding, continuity};
pub use contours::{Contour, contour_range, contours, fitting_interval};
pub use hillshade::Hillshade;
pub use map::{GroundMap, MapExtent};
pub use posts::{PostReader, Posts, Sheet};
pub use profile::{Ground, Sample, profile};
pub use sight::{Matter, Sight, footing, sight};
