//! Point clouds: LAS and LAZ files as a source of elevation and of what stands on it.
//!
//! ```text
//! head      counts and sizes against the file's length, the reference system                                   head, open
//! look      every point: where they lie, and how many are of what                                               look
//! bins      every point, by tile of the database's grid, in a file without a name                              read, bin
//! posts     ground of each voxel from its points and those around                                              posts
//! surface   gaps between posts, from the posts about them                                                      surface
//! columns   solids over each voxel: roofs and decks, runs of leaves, wires                                     hard, wall, runs, wires
//! ```
//! From posts comes a raster, which takes part in the mosaic of elevation as others do, from their colours another, and the solids
//! join those of features. Each stage goes tile by tile through the files of the one before, so that memory does not grow with the cloud; what a voxel gets
//! depends on points and posts about it, never on tiles or threads.

mod bin;
mod class;
mod columns;
mod fit;
mod hard;
mod head;
mod look;
mod open;
mod posts;
mod prepare;
mod raster;
mod read;
mod runs;
mod scene;
mod solids;
mod store;
mod stored;
mod surface;
mod wall;
mod window;
mod wires;

pub(super) use open::{Cloud, open};
pub(super) use prepare::prepare;
pub(super) use solids::{CloudSolids, drape};
