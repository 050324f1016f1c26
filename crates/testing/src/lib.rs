//! Helpers that tests of several crates share: real data, numbers that look random, and damaged copies of files.

mod damage;
mod random;
mod realdata;

pub use damage::{Count, Damage};
pub use random::Random;
pub use realdata::realdata;
