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
//! # The map
//!
//! | module | is |
//! |---|---|
//! | [`voxel`] | the database: grid, levels, pages, reader, writer; its page describes every byte |
//! | [`flight`] | path files, interpolation, attitude: a pose for any time |
//! | [`space`], [`earth`] | poses, cameras and screens; how much lower far ground appears |
//! | [`memory`] | database files, mapped: pages on demand, and ahead of need |
//! | [`raymarch`] | where a ray meets the surface, and what a pixel sees there |
//! | [`subimage`] | a frame as tasks, and the farm of workers |
//! | [`scene`], [`objects`] | scene files, and the bodies in them, seen by ray |
//! | [`sunlight`] | where the sun stands, and what ground it reaches |
//! | [`weather`] | haze, fog, clouds, plumes, precipitation |
//! | [`mod@frame`] | the image stage: plane images to pixels; finish |
//! | [`encode`] | PNG, EXR, y4m, video; what made each frame |
//! | [`render`] | one frame |
//! | [`error`], [`progress`], [`colour`], [`geo`] | what other crates stand on, too |
//!
//! Items that these pages do not show serve the other crates of the workspace, and may change at any time.
//!
//! Databases are made by the crate `hedgehop-modeling`, and asked by `hedgehop-query`. ARCHITECTURE.md in the repository
//! has the layers of all of them.
//!
//! Marchers and renderers take any [`voxel::PageSource`]: a mapped file ([`memory::PageFile`]), a database in memory
//! ([`voxel::MemPages`]), or one of your own.

#[doc(hidden)]
pub mod cache;
#[doc(hidden)]
pub mod detail;
pub mod earth;
pub mod encode;
pub mod flight;
pub mod frame;
pub mod memory;
pub mod objects;
#[doc(hidden)]
pub mod pixels;
pub mod raymarch;
pub mod render;
pub mod scene;
#[doc(hidden)]
pub mod sensor;
pub mod simd;
pub mod space;
pub mod subimage;
pub mod sunlight;
pub mod voxel;
pub mod weather;

pub use hedgehop_base::{Error, Result, Size, colour, error, progress};
pub use hedgehop_geo as geo;
