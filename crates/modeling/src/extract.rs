//! A part of a database as a database of its own.
//!
//! ```text
//! grow the box to whole pages: so level index 0 keeps its pages, with other numbers
//! each of these pages: as it is, but at the cut its apron repeats its own edge, as FORMAT.md says of the edge of an area
//! each coarser page: made anew from the finer ones, since what lies beyond the cut no longer counts
//!     what is absent there: as the coarser page of the whole has it
//! ```
//!
//! Where finer pages are absent (outside of corridors) the box grows to whole pages of the coarsest level with absent pages, so that a page is stored in the part
//! where it is stored in the whole.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec2;

use super::counts::PageCounts;
use super::disk_space;
use super::options::OutputFile;
use super::workers::in_order;
use hedgehop::voxel::{
    APRON, Attributes, BARE, ContentHash, EncodedPage, Grid, Metadata, PAGE_SIDE, PageBuffer, PageId,
    PageReadback, PageSource, PageWriter, RADIX, RELIEF_APRON, Relief, SpanTable, StandIn, VoxelBlock,
    sparse_page,
};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

/// Share of a page's side that the box may reach into one that it only touches.
const SAME: f64 = 1e-9;

/// A part of a database's grid that is made of whole pages.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtractPart {
    /// Voxels of level 1 before it, eastward and northward.
    pub first: [u32; 2],
    /// Grid of the part.
    pub grid: Grid,
}

impl ExtractPart {
    /// The pages that a box (west, south, east, north; metres) touches; `pages` are all pages of the database.
    ///
    /// # Errors
    /// [`Error::Configuration`]: the box lies beside the area, or has too few levels for what is stored in it.
    pub fn around(grid: &Grid, pages: &[PageId], [west, south, east, north]: [f64; 4]) -> Result<Self> {
        let (near, far) = (grid.origin, grid.far_corner());
        if !(west < far.x && south < far.y && east > near.x && north > near.y && west < east && south < north)
        {
            return Err(Error::Configuration(format!(
                "the box {west},{south},{east},{north} lies outside the area, which is {},{},{},{} in metres of its reference system",
                near.x, near.y, far.x, far.y
            )));
        }

        let sparse = coarsest_sparse(grid, pages);
        let block = PAGE_SIDE.saturating_mul(Grid::side_units(sparse.unwrap_or(0)));
        let cut = |low: f64, high: f64, limit: u32| {
            let block = f64::from(block);
            // A float converts saturating.
            let first = ((low / grid.spacing / block + SAME).floor().max(0.0) * block) as u32;
            let end = ((high / grid.spacing / block - SAME).ceil() * block).min(f64::from(limit)) as u32;
            (first, end.max(first.saturating_add(1)).min(limit))
        };

        let (first_x, end_x) = cut(west - near.x, east - near.x, grid.nx);
        let (first_y, end_y) = cut(south - near.y, north - near.y, grid.ny);
        let origin = near + DVec2::new(f64::from(first_x), f64::from(first_y)) * grid.spacing;
        let own = Grid { nx: end_x - first_x, ny: end_y - first_y, origin, ..*grid };
        if sparse.is_some_and(|sparse| sparse + 1 >= own.level_count()) {
            let what = "the part is smaller than the voxels that the database has outside of its corridors; take a larger box";
            return Err(Error::Configuration(what.into()));
        }

        Ok(Self { first: [first_x, first_y], grid: own })
    }

    /// The page of the whole that a page of the part was, if pages of its level are the same.
    fn of_whole(&self, id: PageId) -> PageId {
        let units = PAGE_SIDE * Grid::side_units(id.level);
        PageId { px: id.px + self.first[0] / units, py: id.py + self.first[1] / units, ..id }
    }
}

/// The coarsest level of which a page is absent.
fn coarsest_sparse(grid: &Grid, pages: &[PageId]) -> Option<u8> {
    (0..grid.level_count()).rev().find(|level| {
        let (columns, rows) = grid.page_dims(*level);
        let stored = pages.iter().filter(|id| id.level == *level).count() as u64;
        stored < u64::from(columns) * u64::from(rows)
    })
}

/// Writes a part of the database that `source` gives out as `output`; `pages` are all of its pages. Returns identity and bytes.
///
/// # Errors
/// [`Error::Configuration`]: `output` exists and may not be replaced; a page that is damaged; what the disk refuses; an interruption.
pub fn extract(
    source: &dyn PageSource,
    pages: &[PageId],
    part: &ExtractPart,
    output: OutputFile<'_>,
    threads: usize,
    observer: &dyn Observer,
) -> Result<(ContentHash, u64)> {
    let header = source.header();
    let mut writer = PageWriter::create(output.path, part.grid, header.heights, output.overwrite)?
        .with_objects(Arc::clone(&header.objects));
    let knife = Knife { source, part, finer: writer.readback() };
    let ids = knife.ids(pages);
    let count = |level: u8| ids.iter().filter(|id| id.level == level).count() as u64;
    let objects = header.objects.to_bytes().len() as u64;
    writer.expect(disk_space::most_bytes(&part.grid, count, count(BARE)) + objects);
    let mut counts = PageCounts::default();
    observer.begin("pages", ids.len() as u64, "pages");

    // Coarser pages are made from finer ones that have been written.
    for ids in ids.chunk_by(|a, b| a.level == b.level) {
        in_order(
            ids.len() as u64,
            threads,
            observer,
            || (),
            |(), task| {
                let page = knife.page(ids[task as usize])?;
                Ok((
                    PageCounts::of_stored(&page, ids[task as usize], &header.objects),
                    page.encode(ids[task as usize]),
                ))
            },
            |_, (own, page): (PageCounts, EncodedPage)| {
                writer.append(&page)?;
                counts.add(&own);
                observer.advance(1);
                Ok(())
            },
        )?;
    }

    observer.end();
    source.intact()?;
    let mut metadata: Metadata = counts.metadata(&header.metadata);
    let note = "a part of a larger database";
    if metadata.notes.iter().all(|told| told != note) {
        metadata.notes.push(note.into());
    }

    writer.finish(&metadata, counts.height_range(header.heights))
}

/// Cuts pages out.
struct Knife<'s> {
    source: &'s dyn PageSource,
    part: &'s ExtractPart,
    /// Pages that have been written.
    finer: PageReadback,
}

impl Knife<'_> {
    /// Pages of the part that are to be stored, finer levels first, bare ground last.
    fn ids(&self, pages: &[PageId]) -> Vec<PageId> {
        let grid = &self.part.grid;
        let sparse = coarsest_sparse(&self.source.header().grid, pages);
        let of_level = |level: u8| {
            let (columns, rows) = grid.page_dims(level);
            (0..rows).flat_map(move |py| (0..columns).map(move |px| PageId { level, px, py }))
        };
        let is_stored = |id: &PageId| {
            sparse.is_none_or(|sparse| id.level > sparse) || self.source.has(self.part.of_whole(*id))
        };
        let mut ids: Vec<PageId> = (0..grid.level_count()).flat_map(of_level).filter(is_stored).collect();
        if self.source.header().has_spans {
            let bare = of_level(0).map(PageId::bare);
            ids.extend(bare.filter(|id| self.source.has(self.part.of_whole(*id))));
        }
        ids
    }

    fn page(&self, id: PageId) -> Result<PageBuffer> {
        if id.level > 0 && !id.is_bare() {
            let grid = &self.part.grid;
            return sparse_page(&self.finer, &mut Whole(self), grid, self.source.header().heights, id);
        }
        let whole = self.part.of_whole(id);
        let view = self.source.page(whole)?.ok_or_else(|| absent(whole))?;
        let mut page = view.to_buffer();
        let places = self.places(id, Size { width: page.width, height: page.height });
        page.heights = places.iter().map(|place| view.heights[*place]).collect();
        page.colours = places.iter().map(|place| view.colours[*place]).collect();
        page.spans = self.source.spans(whole)?.map_or_else(SpanTable::default, |spans| spans.to_table());
        Ok(page)
    }

    /// Maps each sample of a page with its apron to one of the page: beyond the cut, to that at the edge of the part.
    fn places(&self, id: PageId, size: Size) -> Vec<usize> {
        let (nx, ny) = self.part.grid.dims(id.level);
        let clamped = |page: u32, size: u32, limit: u32| -> Vec<usize> {
            let first = page * PAGE_SIDE;
            let sample = |at: u32| (first + at).clamp(APRON, limit - 1 + APRON) - first;
            (0..size + 2 * APRON).map(|at| sample(at) as usize).collect()
        };
        let (columns, rows) = (clamped(id.px, size.width, nx), clamped(id.py, size.height, ny));
        let stride = (size.width + 2 * APRON) as usize;
        rows.iter().flat_map(|row| columns.iter().map(move |column| row * stride + column)).collect()
    }
}

fn absent(id: PageId) -> Error {
    Error::Configuration(format!("{id} is not stored; take the pages of the database's directory"))
}

/// Stands in for finer pages that are absent: the coarse page itself, as the whole has it.
struct Whole<'k, 's>(&'k Knife<'s>);

impl StandIn for Whole<'_, '_> {
    fn finer(&mut self, _: PageId, _: Range<u32>, _: Range<u32>) -> Result<Option<VoxelBlock>> {
        Ok(None)
    }

    fn page(&mut self, id: PageId) -> Result<PageBuffer> {
        let part = self.0.part;
        let Size { width, height } = part.grid.page_size(id).ok_or_else(|| absent(id))?;
        let side = Grid::side_units(id.level);
        let first = [id.px, id.py].map(|page| page * PAGE_SIDE);
        let offset = part.first.map(|units| units / side);
        let dims = part.grid.dims(id.level);

        let mut page = PageBuffer {
            width,
            height,
            heights: Vec::new(),
            low: Vec::new(),
            high: Vec::new(),
            colours: Vec::new(),
            relief: Vec::new(),
            attributes: Vec::new(),
            spans: SpanTable::default(),
        };

        // Voxels of the part with an apron, those beyond the cut being that at its edge.
        let around = |first: u32, size: u32, apron: u32, limit: u32| {
            (0..size + 2 * apron).map(move |at| (first + at).clamp(apron, limit - 1 + apron) - apron)
        };

        for y in around(first[1], height, APRON, dims.1) {
            for x in around(first[0], width, APRON, dims.0) {
                let (code, colour, ..) = self.voxel(id.level, [x + offset[0], y + offset[1]])?;
                page.heights.push(code);
                page.colours.push(colour);
            }
        }

        for y in around(first[1], height, RELIEF_APRON, dims.1) {
            for x in around(first[0], width, RELIEF_APRON, dims.0) {
                page.relief.push(self.voxel(id.level, [x + offset[0], y + offset[1]])?.2);
            }
        }

        for y in around(first[1], height, 0, dims.1) {
            for x in around(first[0], width, 0, dims.0) {
                page.attributes.push(self.voxel(id.level, [x + offset[0], y + offset[1]])?.3);
            }
        }

        Ok(page)
    }
}

impl Whole<'_, '_> {
    /// A coarse voxel of the whole: height, colour, relief and attributes; nothing where its page is absent.
    fn voxel(&self, level: u8, [x, y]: [u32; 2]) -> Result<(u16, [u8; 3], Relief, Attributes)> {
        let id = PageId { level, px: x / PAGE_SIDE, py: y / PAGE_SIDE };
        let Some(view) = self.0.source.page(id)? else { return Ok(Default::default()) };
        let (x, y) = (x % PAGE_SIDE, y % PAGE_SIDE);
        let sample = view.sample(x, y);
        let stride = view.width + 2 * RELIEF_APRON;
        let relief = view.relief.get(((y + RELIEF_APRON) * stride + x + RELIEF_APRON) as usize);
        Ok((
            view.heights[sample],
            view.colours[sample],
            relief.copied().unwrap_or_default(),
            view.attributes_at(x, y),
        ))
    }
}

// Blocks of pages hold whole voxels of the level above: what stands in for absent pages is aligned.
const _: () = assert!(PAGE_SIDE.is_multiple_of(RADIX));

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop::voxel::{build_in_memory, verify};
    use hedgehop_base::progress::Silent;

    #[test]
    fn a_part_says_what_was_built_of_it_alone() {
        let grid = Grid { nx: 900, ny: 700, spacing: 2.0, origin: DVec2::new(100.0, 200.0) };
        let height = |x: u32, y: u32| 50.0 + 20.0 * (f64::from(x) * 0.05).sin() + 0.1 * f64::from(y * x % 97);
        let colour = |x: u32, y: u32| [(x % 251) as u8, (y % 241) as u8, 90];
        let voxels = |x: Range<u32>, y: Range<u32>| y.flat_map(move |y| x.clone().map(move |x| (x, y)));
        let all = |x: Range<u32>, y: Range<u32>| -> (Vec<f64>, Vec<[u8; 3]>) {
            voxels(x, y).map(|(x, y)| (height(x, y), colour(x, y))).unzip()
        };
        let (heights, colours) = all(0..900, 0..700);
        let whole = build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap();
        let pages: Vec<PageId> = whole.directory().ids().collect();
        let folder = tempfile::tempdir().unwrap();

        for (bounds, first, size) in [
            ([700.0, 800.0, 1100.0, 1100.0], [256, 256], [256, 256]),
            ([100.0, 200.0, 500.0, 600.0], [0, 0], [256, 256]),
            ([1200.0, 900.0, 9e9, 9e9], [512, 256], [388, 444]),
        ] {
            let part = ExtractPart::around(&grid, &pages, bounds).unwrap();
            assert_eq!((part.first, [part.grid.nx, part.grid.ny]), (first, size), "{bounds:?}");
            let path = folder.path().join("part.hop");
            let output = OutputFile { path: &path, overwrite: true };
            extract(&whole, &pages, &part, output, 2, &Silent).unwrap();
            let bytes = std::fs::read(&path).unwrap();
            let found = hedgehop::voxel::MemPages::from_bytes("part", &bytes).unwrap();
            let report = verify(&found, &Silent).unwrap();
            assert!(report.is_sound(), "{:?}", report.problems);

            // Heights are coded as those of the whole; so compare what is seen.
            let [x, y] = [0, 1].map(|axis| first[axis]..first[axis] + size[axis]);
            let (heights, colours) = all(x, y);
            let own = build_in_memory(part.grid, &heights, &colours, None, &Metadata::default()).unwrap();

            for id in own.directory().ids() {
                let (a, b) = (found.page(id).unwrap().unwrap(), own.page(id).unwrap().unwrap());
                assert_eq!(a.colours, b.colours, "{id}");
                let codes = (found.header().heights, own.header().heights);
                for (a, b) in a.heights.iter().zip(b.heights) {
                    let (a, b) = (codes.0.decode(*a).unwrap(), codes.1.decode(*b).unwrap());
                    assert!((a - b).abs() < 0.005, "{id}: {a} {b}");
                }
            }
        }

        assert!(ExtractPart::around(&grid, &pages, [5000.0, 0.0, 6000.0, 900.0]).is_err());
    }
}
