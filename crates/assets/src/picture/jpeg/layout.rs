//! Frame of a JPEG, as SOF states it.

/// A component of a frame: brightness, or a colour.
pub struct Component {
    pub(super) id: u8,
    /// Blocks across and down a unit of a scan of several components.
    pub sampling: (usize, usize),
    /// Table of its quantisation.
    pub steps: usize,
    /// Blocks across and down that hold its samples.
    pub blocks: (usize, usize),
    /// Blocks from one row to the next.
    pub stride: usize,
    /// Coefficients of each block that are not zero, a bit each; only of progressive frames.
    pub nonzero: Vec<u64>,
    /// The lowest bit that came of each coefficient.
    pub(super) low: [u8; 64],
}

/// Frame as SOF states it.
pub struct Frame {
    pub is_progressive: bool,
    pub bits: u8,
    /// Units across and down of a scan of several components.
    pub units: (usize, usize),
    pub components: Vec<Component>,
}
