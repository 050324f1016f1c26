//! Pictures and three-dimensional models, as other programs write them.

pub mod model;
pub mod picture;
