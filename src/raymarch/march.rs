//! The march of one ray.

use glam::{DVec2, DVec3};

use super::surface::{Patch, block_contact};
use super::walk::Lattice;
use super::{CellStep, CellWalk, GridRay, LevelBands, PageCursor, Surface};
use crate::error::Result;
use crate::voxel::{Grid, PageSource, RADIX};

/// Where a ray ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Range, metres, ≥ 0.
    pub range: f64,
    /// Level index of the surface.
    pub level: u8,
    /// Normal of the voxel's face, for [`Surface::Blocks`].
    pub face: Option<DVec3>,
}

/// Marches rays through one database for one eye and field of view.
pub struct Marcher<'a, S: PageSource> {
    cursor: PageCursor<'a, S>,
    grid: Grid,
    /// Level index and the ground distances between which it is seen, metres; nearest first.
    bands: Vec<(u8, f64, f64)>,
    surface: Surface,
    /// Voxels of level 1 eastward and northward.
    size: DVec2,
    /// Height that no surface reaches, metres above the datum.
    ceiling: f64,
    /// Index of the coarsest level.
    coarsest: u8,
}

/// One ray's search for the surface of one level.
struct Search<'r> {
    ray: &'r GridRay,
    level: u8,
}

impl<'a, S: PageSource> Marcher<'a, S> {
    /// A marcher over `source` that sees levels in `bands`; in place of those that `source` lacks it
    /// sees its coarsest.
    pub fn new(source: &'a S, bands: LevelBands, surface: Surface) -> Self {
        let header = source.header();
        let coarsest = header.level_count - 1;
        Self {
            cursor: PageCursor::new(source),
            grid: header.grid,
            bands: bands.iter().map(|(level, start, end)| (level.min(coarsest), start, end)).collect(),
            surface,
            size: DVec2::new(f64::from(header.grid.nx), f64::from(header.grid.ny)),
            // Codes are rounded, by half a step at most.
            ceiling: header.height_range.1 + header.heights.scale,
            coarsest,
        }
    }

    /// The grid that is marched through.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// The first contact at a ground distance of at least `from` metres (0 unless a neighbour's
    /// range is known to bound this one), or `None`: the sky.
    pub fn first_contact(&mut self, ray: &GridRay, from: f64) -> Result<Option<Contact>> {
        let Some((over_area, off_area)) = ray.clip(self.size, self.ceiling) else { return Ok(None) };
        // A vertical ray stays at ground distance 0, in the first band, for ever.
        let range_at = |ground: f64| if ground == 0.0 { 0.0 } else { ground / ray.ground_cosine };
        for index in 0..self.bands.len() {
            let (level, band_start, band_end) = self.bands[index];
            let start = range_at(band_start.max(from)).max(over_area);
            let end = range_at(band_end).min(off_area);
            if start.is_finite() && start <= end {
                let search = Search { ray, level };
                if let Some(contact) = self.search(&search, start, end)? {
                    return Ok(Some(contact));
                }
            }
        }
        Ok(None)
    }

    fn search(&mut self, search: &Search<'_>, start: f64, end: f64) -> Result<Option<Contact>> {
        if search.level == self.coarsest {
            return self.walk_surface(search, search.level, start, end);
        }
        let dims = self.cursor.dims(self.coarsest);
        self.descend(search, self.coarsest, [[0, 0], [dims[0] - 1, dims[1] - 1]], start, end)
    }

    /// Walks the voxels `first..=last` of `level`, which is coarser than the one that is searched,
    /// and goes into those that the ray does not clear.
    fn descend(
        &mut self,
        search: &Search<'_>,
        level: u8,
        [first, last]: [[i64; 2]; 2],
        start: f64,
        end: f64,
    ) -> Result<Option<Contact>> {
        let ray = search.ray;
        let lattice = Lattice { side: f64::from(Grid::side_units(level)), shift: 0.0 };
        for CellStep { cell, enter, leave } in CellWalk::new(ray, lattice, first, last, start, end) {
            let lowest = ray.height_at(enter).min(ray.height_at(leave));
            if lowest > self.cursor.upper_bound(level, cell)? {
                continue;
            }
            let contact = if level == search.level + 1 {
                self.walk_surface(search, search.level, enter, leave)?
            } else {
                let inside = self.finer_cells(level, cell);
                self.descend(search, level - 1, inside, enter, leave)?
            };
            if contact.is_some() {
                return Ok(contact);
            }
        }
        Ok(None)
    }

    /// First and last of the next finer voxels inside a voxel.
    fn finer_cells(&self, level: u8, cell: [i64; 2]) -> [[i64; 2]; 2] {
        let radix = i64::from(RADIX);
        let dims = self.cursor.dims(level - 1);
        let first = cell.map(|index| index * radix);
        [first, [0, 1].map(|axis| (first[axis] + radix - 1).min(dims[axis] - 1))]
    }

    /// Intersects the cells of `level`'s surface between two ranges.
    fn walk_surface(
        &mut self,
        search: &Search<'_>,
        level: u8,
        start: f64,
        end: f64,
    ) -> Result<Option<Contact>> {
        let dims = self.cursor.dims(level);
        let side = f64::from(Grid::side_units(level));
        let (shift, first) = match self.surface {
            Surface::Smooth => (0.5, [-1, -1]),
            Surface::Blocks => (0.0, [0, 0]),
        };
        let last = [dims[0] - 1, dims[1] - 1];
        for step in CellWalk::new(search.ray, Lattice { side, shift }, first, last, start, end) {
            let contact = self.cell_contact(search, level, &step, side)?;
            if contact.is_some() {
                return Ok(contact);
            }
        }
        Ok(None)
    }

    /// Where the ray first is on or under the surface within one cell. Where its page is absent, the next
    /// coarser level stands in.
    fn cell_contact(
        &mut self,
        search: &Search<'_>,
        level: u8,
        step: &CellStep,
        side: f64,
    ) -> Result<Option<Contact>> {
        let found = match self.surface {
            Surface::Smooth => self.cursor.corners(level, step.cell)?.map(|corners| {
                Patch::new(corners).first_contact(search.ray, step, side).map(|range| (range, None))
            }),
            Surface::Blocks => self.cursor.height(level, step.cell)?.map(|top| {
                block_contact(search.ray, step, top?, side).map(|(range, face)| (range, Some(face)))
            }),
        };
        match found {
            Some(contact) => Ok(contact.map(|(range, face)| Contact { range, level, face })),
            None if level < self.coarsest => self.walk_surface(search, level + 1, step.enter, step.leave),
            None => Ok(None),
        }
    }
}
