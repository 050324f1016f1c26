//! Counts of the contents of a database's pages, made while they are written.

use hedgehop::voxel::{APRON, Attributes, HeightCode, Metadata, PageBuffer, PageId, SharedObjects};

/// Counts of the contents of pages.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tally {
    /// Lowest and highest code; `None`: there is none.
    codes: Option<(u16, u16)>,
    /// Voxels of level 1, those without data, and those without a surface.
    voxels: [u64; 3],
}

impl Tally {
    /// Counts a page that places some of `objects`.
    pub fn of(page: &PageBuffer, id: PageId, objects: &SharedObjects) -> Self {
        let ends = page.spans.codes(objects).map(<[u16; 2]>::from);
        let codes = [&page.heights, &page.low, &page.high].into_iter().flatten().chain(ends.iter().flatten());
        let codes = HeightCode::range(codes);
        let mut voxels = [0; 3];
        if id.level == 0 {
            let stride = (page.width + 2 * APRON) as usize;
            let rows = page.heights.chunks_exact(stride).skip(APRON as usize).take(page.height as usize);
            let own = rows.flat_map(|row| &row[APRON as usize..stride - APRON as usize]);
            let is_void = |attributes: &&Attributes| attributes.flags & Attributes::VOID != 0;
            voxels = [
                u64::from(page.width) * u64::from(page.height),
                page.attributes.iter().filter(is_void).count() as u64,
                own.filter(|code| **code == HeightCode::EMPTY).count() as u64,
            ];
        }
        Self { codes, voxels }
    }

    /// Counts another.
    pub fn add(&mut self, other: &Self) {
        self.codes = HeightCode::joined(self.codes, other.codes);
        self.voxels.iter_mut().zip(other.voxels).for_each(|(own, other)| *own += other);
    }

    /// Lowest and highest surface, metres.
    pub fn height_range(&self, heights: HeightCode) -> (f64, f64) {
        let height = |code| heights.decode(code).unwrap_or(0.0);
        self.codes.map_or((0.0, 0.0), |(low, high)| (height(low), height(high)))
    }

    /// Completes what is said of another database with the shares of the part, as far as it is stored at its finest.
    pub fn metadata(&self, whole: &Metadata) -> Metadata {
        let share = |count: u64| if self.voxels[0] > 0 { count as f64 / self.voxels[0] as f64 } else { 0.0 };
        let (void_share, empty_share) = (share(self.voxels[1]), share(self.voxels[2]));
        Metadata { void_share, empty_share, ..whole.clone() }
    }
}
