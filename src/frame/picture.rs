//! Pictures of 8 bits a channel.

/// An 8-bit RGB picture, `[height][width]`, row 0 at the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `r g b r g b …`, sRGB.
    pub rgb: Vec<u8>,
}
