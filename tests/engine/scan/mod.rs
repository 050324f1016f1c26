//! Scan planes without a picture.

mod edges;
mod profiles;
