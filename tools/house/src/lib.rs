//! Measures of this repository's own sources, for the figures of a review and for the tests that hold the layers.
//!
//! ```text
//! Cargo packages ──sources──▶ files by module ──imports──▶ arrows from file to file ──circles──▶ loops
//!                                             ──prose────▶ doc comments, paragraphs, parameters
//!                                             ──names────▶ types of one name, public names
//! ```
//! Code for tests only counts apart. Arrows are those of imports and paths, also inside macros; calls of methods draw
//! none, and neither does handing a name on (`pub use`).

pub mod circles;
pub mod imports;
pub mod names;
pub mod prose;
pub mod sources;
