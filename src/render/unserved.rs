//! Views that scan planes leave to the reference marcher.

use std::fmt;

use super::options::RenderOptions;
use crate::raymarch::Surface;

/// Why scan planes do not serve a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Unserved {
    /// Voxels themselves are to be seen, not the smooth surface.
    Blocks,
    /// The area repeats without end.
    Endless,
    /// Rays are parallel: no plane holds an eye.
    Orthographic,
    /// Pixels are narrower than single precision can tell.
    FinePixels,
    /// More pixels than a table of planes and rows has room for.
    ManyPixels,
    /// Rays of a table lie so far apart that planes for them would be far more than pixels.
    Strewn,
}

impl Unserved {
    /// Why planes serve no view with these options; `None`: it is up to the view.
    pub(super) fn of(options: &RenderOptions) -> Option<Self> {
        match (options.surface, options.tile_world) {
            (Surface::Blocks, _) => Some(Self::Blocks),
            (Surface::Smooth, true) => Some(Self::Endless),
            (Surface::Smooth, false) => None,
        }
    }
}

impl fmt::Display for Unserved {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Blocks => "they see no blocks",
            Self::Endless => "the area repeats",
            Self::Orthographic => "the screen is orthographic",
            Self::FinePixels => "pixels are narrower than 5 µrad",
            Self::ManyPixels => "there are too many pixels",
            Self::Strewn => "the table's rays are strewn",
        })
    }
}
