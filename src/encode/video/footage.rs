//! Pictures of a film: what they are like, and how many are to come.

use hedgehop_base::Size;

/// Pictures that a film is made of.
#[derive(Debug, Clone, Copy)]
pub struct Footage {
    /// Size of each, pixels.
    pub size: Size,
    /// Number of pictures.
    pub frame_count: u64,
}
