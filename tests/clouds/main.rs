//! Databases of point clouds, against the scenes that these were made of.

#[path = "../common/realdata.rs"]
mod realdata;

mod damaged;
mod drone;
mod scene;
mod standing;
