//! Databases of point clouds, against the scenes that these were made of.

mod damaged;
mod drone;
mod scene;
mod standing;
