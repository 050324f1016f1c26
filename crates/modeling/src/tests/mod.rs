//! Builds from rasters in memory with known answers, and from real files.

mod baked_codes;
mod contours;
mod copies;
mod corridors;
mod disk_space;
mod empty;
mod land_cover;
mod mosaics;
mod objects;
mod patches;
mod pictures;
mod real;
mod refusals;
mod shapes;
mod support;
mod synthetic;
mod voids;
