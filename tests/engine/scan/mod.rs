//! Scan planes without a picture.

mod displaced;
mod edges;
mod profiles;
