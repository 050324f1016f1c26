//! Between which heights the surface lies, told from bounds.

use crate::simd::Each;
use crate::voxel::{BoundsView, PAGE_SIDE, PageId, PageSource, RADIX};
use hedgehop_base::error::Result;

/// Looks bounds up.
pub(super) struct CoarseSurface<'a> {
    source: &'a dyn PageSource,
    level_count: u8,
    /// Pages whose bounds were looked at last, by level, and which of four neighbours it is.
    known: Vec<[Option<KnownHeights<'a>>; 4]>,
}

/// A page and its bounds, if it is there.
type KnownHeights<'a> = (PageId, Option<BoundsView<'a>>);

impl<'a> CoarseSurface<'a> {
    pub fn new(source: &'a dyn PageSource) -> Self {
        let level_count = source.header().level_count;
        Self { source, level_count, known: vec![[None; 4]; usize::from(level_count)] }
    }

    /// Least lower and greatest upper bound of voxels of `level`, first and last along each axis; of the coarser ones where their page is
    /// absent. `None` where not all are known.
    ///
    /// # Errors
    /// A page with bounds that is damaged.
    pub fn range(&mut self, level: u8, [x, y]: [[u32; 2]; 2]) -> Result<Option<[u16; 2]>> {
        // No surface in some voxel: the lowest is lower than any.
        let mut range = [u16::MAX, u16::MIN];
        for py in y[0] / PAGE_SIDE..=y[1] / PAGE_SIDE {
            for px in x[0] / PAGE_SIDE..=x[1] / PAGE_SIDE {
                let part = [part_on_page(x, px), part_on_page(y, py)];
                let found = match self.page(PageId { level, px, py })? {
                    Some(view) => range_on_page(&view, part),
                    None if level + 1 < self.level_count => {
                        self.range(level + 1, part.each(|range| range.each(|at| at / RADIX)))?
                    }
                    None => None,
                };
                let Some([low, high]) = found else { return Ok(None) };
                range = [range[0].min(low), range[1].max(high)];
            }
        }
        Ok(Some(range))
    }

    /// The page that all of these voxels lie on, if it is one, and there.
    ///
    /// # Errors
    /// As [`Self::range`].
    pub fn page_of(&mut self, level: u8, voxels: [[u32; 2]; 2]) -> Result<Option<BoundsView<'a>>> {
        let [[px, last_px], [py, last_py]] = voxels.each(|range| range.each(|at| at / PAGE_SIDE));
        if px == last_px && py == last_py { self.page(PageId { level, px, py }) } else { Ok(None) }
    }

    fn page(&mut self, id: PageId) -> Result<Option<BoundsView<'a>>> {
        let slot = &mut self.known[usize::from(id.level)][(id.px % 2 + 2 * (id.py % 2)) as usize];
        if let Some((known, view)) = slot
            && *known == id
        {
            return Ok(*view);
        }
        let view = self.source.bounds(id)?;
        *slot = Some((id, view));
        Ok(view)
    }
}

/// Returns the part of a range of voxels, first and last, that lies on a page.
fn part_on_page([first, last]: [u32; 2], page: u32) -> [u32; 2] {
    [first.max(page * PAGE_SIDE), last.min(page * PAGE_SIDE + PAGE_SIDE - 1)]
}

/// Least lower and greatest upper bound of voxels of the level, first and last along each axis, that all lie on a page; `None` where there
/// are none.
pub(super) fn range_on_page(view: &BoundsView<'_>, voxels: [[u32; 2]; 2]) -> Option<[u16; 2]> {
    let [x, y] = voxels.each(|range| range.each(|at| at % PAGE_SIDE));
    let mut range = [u16::MAX, u16::MIN];
    for row in y[0]..=y[1] {
        let row = (row * view.width + x[0]) as usize..=(row * view.width + x[1]) as usize;
        for (low, high) in view.low.get(row.clone())?.iter().zip(view.high.get(row)?) {
            range = [range[0].min(*low), range[1].max(*high)];
        }
    }
    Some(range)
}
