//! Parts of a page's posts.

use crate::voxel::PAGE_SIDE;

/// A rectangle of a page's posts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PostPart {
    /// The first post, eastward and northward.
    pub first: [u32; 2],
    /// Posts, eastward and northward, ≥ 1; what lies beyond the page is none.
    pub size: [u32; 2],
}

impl PostPart {
    /// The whole of any page.
    pub const ALL: Self = Self { first: [0; 2], size: [PAGE_SIDE; 2] };

    /// `count` columns (`major` 0) or rows (`major` 1).
    pub fn lines(major: u8, first: u32, count: u32) -> Self {
        let mut part = Self::ALL;
        part.first[usize::from(major)] = first;
        part.size[usize::from(major)] = count;
        part
    }

    /// Clips the part to a page of `width` × `height` posts.
    #[must_use]
    pub(super) fn within(self, width: u32, height: u32) -> Self {
        let mut part = self;
        for (axis, side) in [width, height].into_iter().enumerate() {
            part.first[axis] = part.first[axis].min(side - 1);
            part.size[axis] = part.size[axis].min(side - part.first[axis]);
        }
        part
    }
}

/// Posts around the page: the apron of images of lines, a texel of four posts.
pub const RING: usize = 4;

/// Posts around it that are lit: those of the ring, and what voids in it take their light from.
pub const LIT: usize = RING + 1;
