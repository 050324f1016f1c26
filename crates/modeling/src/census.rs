//! Counts of the voxels of pages.

use super::corridor::Stored;
use super::materials::Classes;
use hedgehop::voxel::{
    APRON, Attributes, Grid, HeightCode, PAGE_SIDE, PageBuffer, PageId, RADIX, SharedObject, SharedObjects,
};

/// Counts over voxels, in voxels of level 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Census {
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

impl Census {
    /// Counts those voxels of a page that no stored page holds more finely.
    pub fn of_finest(page: &PageBuffer, id: PageId, stored: &Stored) -> Self {
        let mut census = Self::default();
        if id.level > stored.outside() {
            return census;
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
                census.made += 1;
                census.voxels += area;
                let is_void = flags & Attributes::VOID != 0;
                census.voids += if is_void { area } else { 0 };
                census.filled += if is_void && !is_empty { area } else { 0 };
                census.empty += if is_empty { area } else { 0 };
                census.bare += if !is_empty && flags & Attributes::NO_IMAGERY != 0 { area } else { 0 };
            }
        }

        census
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
