//! The scan-plane engine: sixteen vertical planes in lockstep, from the eye outward.
//!
//! ```text
//! for each block of lines along the major axis, nearest first:
//!     its highest surface lies below the horizon of every plane → next block, or a leap over many
//!     for each line of the block, a stride apart:
//!         slope = (height of the line where each plane crosses it) / depth         one gather
//!         slope is above a plane's horizon →
//!             the surface from the last line to here is in sight; the horizon rises to slope
//! ```
//!
//! A *line* is a row of posts of one level, across the planes' *major axis* (x or y, whichever they run along):
//! all sixteen cross it at once, a few voxels apart, and interpolation is needed along it only. Over a
//! single-valued surface a ray with a higher elevation angle cannot end nearer, so each plane keeps
//! its *horizon*, the highest slope so far: what lies below is hidden (range coherence: Nack et al.,
//! US 5,317,689, 1994, claim 14; lines in lockstep and highest row reached: VoxelSpace, 1992).
//!
//! What is found is a [`Profile`]: the stretches of surface that are in sight, by the tangents of
//! elevation at their ends. A *row* of a picture is a span of tangents, so that projections with other rows
//! only cut the same profile elsewhere. On a straight stretch inverse depth is linear in the tangent:
//!
//! ```text
//! z = z₀ + s·(w − w₀),  t = z/w   →   1/w = (t − s) / (z₀ − s·w₀)
//! ```
//!
//! so ranges are exact for it, and silhouettes end where the surface does and not at a step.
//!
//! How far lines lie apart follows from the footprint of a pixel, see [`Strides`]; where the surface rises
//! over several rows from one to the next, lines between them are read. Where ground is displaced, samples between lines
//! are finer than its bumps, see [`DisplacedField`].

mod advance;
mod block_slopes;
mod blocks;
mod bound_pyramid;
mod bounds;
mod cell_way;
mod displaced_field;
mod displaced_march;
mod displaced_pages;
mod displaced_stretch;
mod edge;
mod footprint;
mod ground;
mod group;
mod leap;
mod lines;
mod march;
mod march_field;
mod pages;
mod panorama;
mod profile;
mod rims;
mod row_coordinate;
mod row_table;
mod shape;
mod spans;
mod start;
mod steep;
mod strides;
mod turned;
mod upright;

pub use bound_pyramid::BoundPyramid;
pub use bounds::highest_code;
pub use displaced_field::DisplacedField;
pub use displaced_pages::DisplacedPages;
pub use footprint::{FootprintGroup, PageFootprint};
pub use group::PlaneGroup;
pub use march::PlaneMarch;
pub use march_field::MarchField;
pub use pages::Pages;
pub use panorama::{Annulus, Between, Directions, Gaze, Panorama, Refusal};
pub use profile::{NO_SLOPE, Post, Profile, SampleLine, VisibleSegment};
pub use row_coordinate::RowCoordinate;
pub use row_table::RowTable;
pub use shape::{KeptPlanes, PlaneArray};
pub use spans::{FaceDirection, FacetLight, RowMiddle, SpanCoverage, SpanMarch, SpanRow, SpanScan};
pub use strides::{Outlook, Strides};
pub use turned::TurnedPages;
pub use upright::{LevelRow, Upright, UprightGaze};
