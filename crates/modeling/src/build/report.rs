//! Outcome of a build.

use hedgehop::voxel::{ContentHash, Grid};

/// Report of a build.
#[derive(Debug, Clone)]
pub struct BuildReport {
    /// Grid that was built.
    pub grid: Grid,
    /// Identity of the result.
    pub content_hash: ContentHash,
    /// Bytes of the file.
    pub bytes: u64,
    /// Voxels that were made from the sources: all of level 1, and coarser ones outside of corridors.
    pub voxels: u64,
    /// Share of void voxels, 0…1.
    pub void_share: f64,
    /// Pages that were written.
    pub pages: u64,
    /// Pages of these that a build before made.
    pub reused: u64,
    /// Wall time, seconds.
    pub seconds: f64,
}
