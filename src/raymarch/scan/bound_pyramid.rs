//! Bounds of the surface above the coarsest level's voxels: a look at one of them passes over many kilometres.

use crate::simd::Each;
use crate::voxel::{Grid, HeightCode, PAGE_SIDE, PageId, PageSource, RADIX};

/// Code of a square about which nothing is known.
const UNKNOWN: u16 = u16::MAX;

/// Upper bounds of an area's surface over squares, from the voxels of its coarsest level to one that holds all of it; by default of none.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct BoundPyramid {
    /// Side of the coarsest level's voxels, units.
    side: i64,
    /// Squares four times as wide from each step to the next.
    steps: Vec<BoundGrid>,
}

/// Upper bounds over squares of one size.
#[derive(Debug, Clone, PartialEq, Eq)]
struct BoundGrid {
    /// Squares eastward and northward.
    size: [usize; 2],
    /// Height codes, row by row northward: [`HeightCode::EMPTY`] where there is no surface.
    high: Vec<u16>,
}

impl BoundPyramid {
    /// Reads the bounds of the coarsest level, which is no more than a few pages. Of an absent or damaged one nothing is known.
    pub fn new(source: &dyn PageSource) -> Self {
        let header = source.header();
        let level = header.level_count - 1;
        let (nx, ny) = header.grid.dims(level);
        let size = [nx, ny].each(|squares| squares as usize);
        let mut base = BoundGrid { size, high: vec![UNKNOWN; size[0] * size[1]] };

        let (columns, rows) = header.grid.page_dims(level);
        for (px, py) in (0..rows).flat_map(|py| (0..columns).map(move |px| (px, py))) {
            let id = PageId { level, px, py };
            let Ok(Some(page)) = source.bounds(id) else { continue };
            let [west, south] = [px, py].each(|index| (index * PAGE_SIDE) as usize);
            for (row, high) in page.high.chunks_exact(page.width as usize).enumerate() {
                base.high[(south + row) * size[0] + west..][..high.len()].copy_from_slice(high);
            }
        }

        let mut steps = vec![base];
        while let Some(last) = steps.last()
            && last.high.len() > 1
        {
            let wider = last.wider();
            steps.push(wider);
        }
        Self { side: i64::from(Grid::side_units(level)), steps }
    }

    /// Sides of squares, units, and the number of the step that they make, rising.
    pub fn sides(&self) -> impl Iterator<Item = (usize, i64)> {
        (0..self.steps.len()).map(|step| (step, self.side << (RADIX.trailing_zeros() as usize * step)))
    }

    /// Greatest upper bound of a step's squares, as height code, at index `major` along an axis and `minor` across it (first and last), which
    /// are taken into the area; `None` where it is not known.
    #[inline]
    pub fn highest(&self, step: usize, axis: usize, major: i64, minor: [i64; 2]) -> Option<u16> {
        let BoundGrid { size, high } = &self.steps[step];
        let last = size.each(|squares| squares as i64 - 1);
        let major = major.clamp(0, last[axis]) as usize;
        let [first, end] = minor.each(|index| index.clamp(0, last[1 - axis]) as usize);
        let [along, across] = if axis == 0 { [1, size[0]] } else { [size[0], 1] };
        let squares = (first..=end).map(|minor| high[major * along + minor * across]);
        let highest = squares.fold(HeightCode::EMPTY, u16::max);
        (highest != UNKNOWN).then_some(highest)
    }
}

impl BoundGrid {
    /// Squares as wide as four.
    fn wider(&self) -> Self {
        let size = self.size.each(|squares| squares.div_ceil(RADIX as usize));
        let mut wider = Self { size, high: vec![HeightCode::EMPTY; size[0] * size[1]] };
        for (row, squares) in self.high.chunks_exact(self.size[0]).enumerate() {
            let target = row / RADIX as usize * size[0];
            for (column, &high) in squares.iter().enumerate() {
                let target = &mut wider.high[target + column / RADIX as usize];
                *target = high.max(*target);
            }
        }
        wider
    }
}
