//! Product that is asked of a frame.

/// Product that is asked of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Product {
    /// 8-bit colour: the fastest.
    Picture,
    /// Linear colour, range, normals, levels, ids.
    Frame,
}
