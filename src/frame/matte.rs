//! Mattes: shares that bodies and ground have of each pixel.

/// Shares that bodies and ground have of each pixel of a frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Matte {
    /// Names of bodies by their ids; a body without one is called `object` and its id. Bodies of one name are one thing.
    pub names: Vec<String>,
    /// Shares in pixels that bodies are in, and along the skyline; by pixel, and of each the most first. Other pixels show ground alone, or sky, as the
    /// frame's `level` says.
    pub covers: Vec<MatteCoverage>,
}

/// Share of one thing in a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatteCoverage {
    /// Column, plus row times the picture's width.
    pub pixel: u32,
    /// Number of the body; [`Self::GROUND`] of the ground.
    pub id: u32,
    /// Share of the pixel, 0…1, more than 0.
    pub share: f32,
}

impl MatteCoverage {
    /// Number of the ground, which no body has.
    pub const GROUND: u32 = u32::MAX;
}
