//! Light that segments send to sixteen planes.

use crate::simd::Sixteen;

/// Channels of light.
pub const COLOURS: usize = 3;

/// Places of the relative deviations below the voxel, over the ground and over walls, behind the channels of light.
pub const GROUND: usize = COLOURS;
pub const WALL: usize = COLOURS + 1;

/// Light of a segment: linear light by channel, and in [`GROUND`] and [`WALL`] its relative deviations below the voxel.
pub type PlaneLight = [Sixteen; COLOURS + 2];

/// Detail below the voxel of a chunk of segments.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ChunkDetail {
    /// None.
    None,
    /// Over the ground.
    Ground,
    /// Over the ground and over walls.
    Walls,
}
