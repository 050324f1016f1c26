//! Counts of the voxels of pages.

use super::corridor::Stored;
use super::materials::Classes;
use hedgehop::voxel::{
    APRON, Attributes, Grid, HeightCode, HeightRange, Metadata, PAGE_SIDE, PageBuffer, PageId, RADIX,
    SharedObject, SharedObjects,
};

/// Counts over voxels, in voxels of level 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct PageCounts {
    pub voxels: u64,
    /// Voxels of their own levels.
    pub made: u64,
    /// Voxels whose source had no data.
    pub voids: u64,
    /// Voxels of those that have a surface all the same.
    pub filled: u64,
    /// Voxels without a surface.
    pub empty: u64,
    /// Voxels that have a surface, but no colour from imagery.
    pub bare: u64,
    /// Least and greatest height code of those with a surface.
    pub codes: Option<(u16, u16)>,
    /// Materials of voxels and spans.
    pub classes: Classes,
}

impl PageCounts {
    /// Counts those voxels of a page that no stored page holds more finely.
    pub fn of_finest(page: &PageBuffer, id: PageId, stored: &Stored) -> Self {
        let mut counts = Self::default();
        if id.level > stored.outside() {
            return counts;
        }

        let area = u64::from(Grid::side_units(id.level)).pow(2);
        for y in 0..page.height {
            for x in 0..page.width {
                let finer = [(id.px, x), (id.py, y)]
                    .map(|(page, voxel)| (page * PAGE_SIDE + voxel) * RADIX / PAGE_SIDE);
                if stored.has(PageId { level: id.level - 1, px: finer[0], py: finer[1] }) {
                    continue;
                }

                let Attributes { flags, .. } = page.attributes[(y * page.width + x) as usize];
                let sample = (y + APRON) * (page.width + 2 * APRON) + x + APRON;
                let is_empty = page.heights[sample as usize] == HeightCode::EMPTY;
                counts.made += 1;
                counts.voxels += area;
                let is_void = flags & Attributes::VOID != 0;
                counts.voids += if is_void { area } else { 0 };
                counts.filled += if is_void && !is_empty { area } else { 0 };
                counts.empty += if is_empty { area } else { 0 };
                counts.bare += if !is_empty && flags & Attributes::NO_IMAGERY != 0 { area } else { 0 };
            }
        }

        counts
    }

    /// The range of codes in a page, its apron included, and its materials.
    pub fn with_codes_of(mut self, page: &PageBuffer) -> Self {
        self.codes = HeightCode::range(&page.heights);
        let alike = page.attributes.chunk_by(|a, b| a.material == b.material);
        alike.for_each(|attributes| self.classes.add(attributes[0].material));
        self
    }

    /// The same with those of bare ground, and of what stands on it.
    pub fn with_codes_of_bare(mut self, bare: Option<&PageBuffer>, objects: &SharedObjects) -> Self {
        if let Some(bare) = bare {
            let ground = Self::default().with_codes_of(bare);
            let mut spans = Self { codes: bare.spans.codes(objects), ..Self::default() };
            bare.spans.spans().iter().for_each(|span| spans.classes.add(span.material));
            let placed = bare.spans.placements().iter().filter_map(|placement| objects.get(*placement));
            placed.flat_map(SharedObject::materials).for_each(|material| spans.classes.add(material));
            self.add(&ground);
            self.add(&spans);
        }
        self
    }

    /// Counts the surface of a page of level 1 that another database stores, and the codes of any of its pages, which places some of `objects`.
    pub fn of_stored(page: &PageBuffer, id: PageId, objects: &SharedObjects) -> Self {
        let ends = page.spans.codes(objects).map(<[u16; 2]>::from);
        let codes = [&page.heights, &page.low, &page.high].into_iter().flatten().chain(ends.iter().flatten());
        let mut counts = Self { codes: HeightCode::range(codes), ..Self::default() };
        if id.level == 0 {
            let stride = (page.width + 2 * APRON) as usize;
            let rows = page.heights.chunks_exact(stride).skip(APRON as usize).take(page.height as usize);
            let own = rows.flat_map(|row| &row[APRON as usize..stride - APRON as usize]);
            let is_void = |attributes: &&Attributes| attributes.flags & Attributes::VOID != 0;
            counts.voxels = u64::from(page.width) * u64::from(page.height);
            counts.voids = page.attributes.iter().filter(is_void).count() as u64;
            counts.empty = own.filter(|code| **code == HeightCode::EMPTY).count() as u64;
        }
        counts
    }

    /// Returns the lowest and the highest surface, metres.
    pub fn height_range(&self, heights: HeightCode) -> HeightRange {
        let height = |code| heights.decode(code).unwrap_or(0.0);
        self.codes.map(|(low, high)| HeightRange { low: height(low), high: height(high) }).unwrap_or_default()
    }

    /// Completes the metadata of a database with the shares of the part that was counted.
    pub fn metadata(&self, whole: &Metadata) -> Metadata {
        let share = |count: u64| if self.voxels > 0 { count as f64 / self.voxels as f64 } else { 0.0 };
        Metadata { void_share: share(self.voids), empty_share: share(self.empty), ..whole.clone() }
    }

    /// Adds the counts of others.
    pub fn add(&mut self, other: &Self) {
        self.voxels += other.voxels;
        self.made += other.made;
        self.voids += other.voids;
        self.filled += other.filled;
        self.empty += other.empty;
        self.bare += other.bare;
        self.classes.join(&other.classes);
        self.codes = HeightCode::joined(self.codes, other.codes);
    }
}
