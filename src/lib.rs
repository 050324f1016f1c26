//! Hedgehop: a CPU image generator for low flight over real terrain.
//!
//! Elevation rasters and imagery become a database of voxels in levels of side 1, 4, 16, 64, …; a flight path becomes
//! poses; each pose becomes a frame of colour, range, normal, level and id per pixel. This crate is all of that
//! without terminal, arguments or printing; the program `hedgehop` is made from it.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # use hedgehop::voxel::{Arrays, Grid, Metadata, write_arrays};
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("area.hop");
//! # let grid = Grid { nx: 64, ny: 64, spacing: 10.0, origin: glam::DVec2::ZERO };
//! # let heights: Vec<f64> = (0..64 * 64).map(|i| 30.0 * f64::from(i % 64 / 8 % 2)).collect();
//! # let arrays = Arrays { grid, heights: &heights, colours: &[[90, 140, 60]; 64 * 64], attributes: None };
//! # write_arrays(&path, &arrays, &Metadata::default(), false)?;
//! use hedgehop::render::{RenderOptions, render_frame};
//! use hedgehop::space::{Attitude, Camera, Pose};
//!
//! let area = hedgehop::memory::PageFile::open(&path)?;
//! let farm = hedgehop::subimage::Farm::new(2)?;
//! let attitude = Attitude { yaw: 45.0, pitch: -10.0, roll: 0.0 };
//! let pose = Pose { eye: glam::dvec3(100.0, 100.0, 80.0), attitude, hfov: 60.0 };
//! let camera = Camera::new(pose, 160, 90);
//! let frame = render_frame(&area, &camera, &RenderOptions::default(), &farm)?.frame;
//! let rgb: Vec<u8> = hedgehop::colour::srgb8_picture(&frame.colour);
//! # assert_eq!(rgb.len(), 160 * 90 * 3);
//! # assert!(frame.range[0].is_infinite() && frame.range[89 * 160 + 80].is_finite());
//! # Ok(())
//! # }
//! ```
//!
//! The folder `examples/` goes on from here. Vectors are those of [`glam`] 0.34.
//!
//! # Layers
//!
//! Lowest first. A module imports only from those above it in this list, and a test holds them to it.
//!
//! | module | is |
//! |---|---|
//! | [`error`] | few kinds of error, each with path, place and remedy |
//! | [`progress`] | how long work reports, and how it is stopped |
//! | [`space`] | world, view and screen; poses and cameras |
//! | [`colour`] | 8-bit sRGB to linear light and back |
//! | [`earth`] | curvature and refraction: how much lower far ground appears |
//! | [`simd`] | sixteen lanes in lockstep, on whatever instructions the machine has |
//! | [`geo`] | coordinate reference systems, vertical datums |
//! | [`voxel`] | the database: grid, levels, pages, reader, writer; its page describes every byte |
//! | [`sunlight`] | where the sun stands, and what ground it reaches |
//! | [`flight`] | path files, interpolation, attitude: a pose for any time |
//! | [`memory`] | database files, mapped: pages on demand |
//! | [`raymarch`] | where a ray meets the surface, and what a pixel sees there |
//! | [`subimage`] | a frame as tasks, and the farm of workers |
//! | [`query`] | questions about the ground: profiles, lines of sight |
//! | [`objects`] | bodies that are not the surface, seen by ray |
//! | [`scene`] | scene files: what is where, when, under which light |
//! | [`sensor`] | from what is seen to radiance |
//! | [`mod@frame`] | haze and sky; PNG, EXR, y4m, video; what made each frame |
//! | [`render`] | one frame |
//! | [`modeling`] | rasters → database; beside the others, on `error` … `voxel` alone |
//! | [`recipe`] | recipe files: what a database is built from |
//!
//! Marchers and renderers take any [`voxel::PageSource`]: a mapped file ([`memory::PageFile`]), a database in memory
//! ([`voxel::MemPages`]), or one of your own.

pub mod colour;
pub mod earth;
pub mod error;
pub mod flight;
pub mod frame;
pub mod geo;
pub mod memory;
pub mod modeling;
pub mod objects;
pub mod progress;
pub mod query;
pub mod raymarch;
pub mod recipe;
pub mod render;
pub mod scene;
pub mod sensor;
pub mod simd;
pub mod space;
pub mod subimage;
pub mod sunlight;
pub mod voxel;

mod document;
mod model;
mod picture;

pub use error::{Error, Result};

#[cfg(test)]
#[path = "../tests/common/realdata.rs"]
mod realdata;
