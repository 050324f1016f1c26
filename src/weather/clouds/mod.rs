//! A layer of clouds: semitransparent voxels between the eye and what was rendered.
//!
//! ```text
//! once:       densities of the voxels, and the light of the sun in each                              field
//! each band of the screen's rows:
//!     each point of a lattice, some pixels apart:  through the layer by steps, front to back         march
//!         light += what comes through · (1 − e^−depth) · light there, seen through the air before
//!         what comes through · e^−depth; both kept after every step
//!     each pixel:                                                                                    band
//!         ground: its light, less what clouds keep of the sun's
//!         nearer than the layer: as it is; behind it: the lattice's last step
//!         within it: the lattice's steps at as many metres into the layer
//! ```
//!
//! Semitransparent voxels that a ray goes through are the patent's third state (Hughes 1994). Clouds are smooth, so that a ray every few pixels
//! tells of those between; where they end at ground is told by each pixel's own range, so that ridges stay sharp. Light
//! is scattered once, and what is scattered often is a share of light that fades more slowly (Wrenninge, Kulla and Lundqvist 2013, *Oz: The
//! Great and Volumetric*). Nothing is random: voxels stand still in the wind, and steps depend on the ray alone.

mod band;
mod cover;
mod field;
mod march;
mod noise;
mod stage;
#[cfg(test)]
mod tests;

pub use band::CloudLattice;
pub use field::{CloudDensities, CloudField};
pub use stage::{AirOverGround, CloudStage};
