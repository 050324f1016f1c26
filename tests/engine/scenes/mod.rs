//! Scene files, and what they cast.

mod night;
mod parts;
mod picture;
mod whole;
