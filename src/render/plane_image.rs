//! Light and depths that scan planes saw, and their parts for tasks.

use std::ops::Range;

use crate::frame::stage::Cell;
use crate::simd::Sixteen;

/// Picture of the scan planes before it is resampled to a screen: light; distances and how they go on, as of [`Depths`](crate::frame::stage::Depths).
#[derive(Debug, Default)]
pub struct PlaneImage {
    pub cells: Vec<Cell>,
    pub inverse: Vec<Sixteen>,
    pub tilts: [Vec<Sixteen>; 2],
}

/// Distances in a part of it.
#[derive(Default)]
pub struct DepthsMut<'f> {
    pub inverse: &'f mut [Sixteen],
    pub tilts: [&'f mut [Sixteen]; 2],
}

impl<'f> DepthsMut<'f> {
    /// Takes those of up to `count` rows away from the beginning.
    pub fn first_part(&mut self, count: usize) -> Self {
        let Self { inverse, tilts } = self;
        Self {
            inverse: first_part(inverse, count),
            tilts: tilts.each_mut().map(|tilts| first_part(tilts, count)),
        }
    }

    /// Takes the depths of some rows, if anybody asks for them.
    pub fn of(&mut self, rows: Range<usize>) -> DepthsMut<'_> {
        DepthsMut {
            inverse: self.inverse.get_mut(rows.clone()).unwrap_or_default(),
            tilts: self.tilts.each_mut().map(|tilts| tilts.get_mut(rows.clone()).unwrap_or_default()),
        }
    }
}

/// Takes up to `count` elements away from the beginning of a slice.
pub fn first_part<'s, T>(slice: &mut &'s mut [T], count: usize) -> &'s mut [T] {
    let all = std::mem::take(slice);
    let (first, rest) = all.split_at_mut(count.min(all.len()));
    *slice = rest;
    first
}
