//! The ground floor of hedgehop: errors, progress, sizes, documents that people write, colour, and chance.

pub mod chance;
pub mod colour;
pub mod document;
pub mod error;
pub mod progress;
mod size;
mod whole_file;

pub use error::{Error, Result};
pub use size::Size;
pub use whole_file::read_whole_file;
