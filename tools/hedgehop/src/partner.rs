//! Frame whose pose a frame's motion is told against.

use hedgehop::space::Camera;

/// The frame next to another, which tells its motion: the one behind, or before the last.
#[derive(Debug)]
pub struct Partner {
    pub number: u64,
    pub camera: Camera,
}
