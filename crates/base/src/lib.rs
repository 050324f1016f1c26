//! The ground floor of hedgehop: errors, progress, documents that people write, and colour.

pub mod colour;
pub mod document;
pub mod error;
pub mod progress;

pub use error::{Error, Result};
