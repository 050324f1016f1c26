//! Pages over which finer ones are absent: what they hold, and what their bounds bound.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use super::super::assembly::{Assembly, MemoryStorage};
use super::*;
use hedgehop_base::Size;
use hedgehop_base::error::Result;
use hedgehop_base::progress::Silent;

/// What sources say at a level: heights that have nothing to do with those of other levels.
#[derive(Clone, Copy)]
struct Sources {
    grid: Grid,
    seed: u64,
    /// Whether they know more than a level's own voxels.
    are_fine: bool,
}

impl Sources {
    fn at(&self, level: u8, x: u32, y: u32) -> (u16, [u8; 3], Attributes) {
        let place = u64::from(level) << 40 | u64::from(y) << 20 | u64::from(x);
        let mut noise = Noise((self.seed ^ place.wrapping_mul(0x9E37_79B9_7F4A_7C15)) | 1);
        (0..4).for_each(|_| _ = noise.next());
        let is_void = noise.next().is_multiple_of(40);
        let height = if is_void { HeightCode::EMPTY } else { 1000 + (noise.next() >> 20) as u16 % 60_000 };
        let colour = std::array::from_fn(|_| noise.next() as u8);
        (height, colour, Attributes { source: (noise.next() >> 9) as u16 & 1, ..Attributes::default() })
    }

    fn block(&self, level: u8, x: Range<u32>, y: Range<u32>) -> VoxelBlock {
        let voxels = y.clone().flat_map(|y| x.clone().map(move |x| (x, y)));
        let samples: Vec<_> = voxels.map(|(x, y)| self.at(level, x, y)).collect();
        VoxelBlock {
            heights: samples.iter().map(|sample| sample.0).collect(),
            colours: samples.iter().map(|sample| sample.1).collect(),
            attributes: samples.iter().map(|sample| sample.2).collect(),
            x,
            y,
        }
    }

    fn page(&self, id: PageId) -> PageBuffer {
        let Size { width, height } = self.grid.page_size(id).unwrap();
        let (nx, ny) = self.grid.dims(id.level);
        let around = |page: u32, size: u32, limit: u32| -> Vec<u32> {
            (0..size + 2 * APRON)
                .map(|k| (page * PAGE_SIDE + k).saturating_sub(APRON).min(limit - 1))
                .collect()
        };
        let (columns, rows) = (around(id.px, width, nx), around(id.py, height, ny));
        let samples = rows.iter().flat_map(|&y| columns.iter().map(move |&x| self.at(id.level, x, y)));
        let (heights, colours) = samples.map(|sample| (sample.0, sample.1)).unzip();
        let own = |page: u32, size: u32| page * PAGE_SIDE..page * PAGE_SIDE + size;

        PageBuffer {
            width,
            height,
            heights,
            low: Vec::new(),
            high: Vec::new(),
            colours,
            relief: Vec::new(),
            attributes: self.block(id.level, own(id.px, width), own(id.py, height)).attributes,
            spans: SpanTable::default(),
        }
    }
}

impl StandIn for Sources {
    fn finer(&mut self, id: PageId, x: Range<u32>, y: Range<u32>) -> Result<Option<VoxelBlock>> {
        Ok(self.are_fine.then(|| self.block(id.level, x, y)))
    }

    fn page(&mut self, id: PageId) -> Result<PageBuffer> {
        Ok(Self::page(self, id))
    }
}

/// A database of the pages that `is_stored` names; a page is, if a finer one under it is.
fn sparse(sources: Sources, is_stored: impl Fn(PageId) -> bool) -> MemPages {
    let (name, storage) = (Path::new("sparse"), Arc::new(MemoryStorage::default()));
    let code = HeightCode { scale: 0.1, offset: 0.0 };
    let mut assembly = Assembly::new(name, storage.clone(), sources.grid, code).unwrap();
    let finer = assembly.readback();
    for id in Directory::empty(&sources.grid).unwrap().ids().filter(|id| is_stored(*id)) {
        let page = match id.level {
            0 => Sources::page(&sources, id),
            _ => sparse_page(&finer, &mut sources.clone(), &sources.grid, code, id).unwrap(),
        };
        assembly.append(&page.encode(id)).unwrap();
    }
    let metadata = Metadata { empty_share: 0.01, ..Metadata::default() };
    assembly.seal(&metadata, &SharedObjects::default(), HeightRange { low: 0.0, high: 6553.5 }).unwrap();
    MemPages::new(name, storage.take()).unwrap()
}

/// Pages of level 1 in a diagonal strip, of level 4 in a wider one, and all of the coarser levels.
fn in_strip(id: PageId) -> bool {
    let side = u64::from(Grid::side_units(id.level)) * 256;
    let [x, y] = [id.px, id.py].map(|page| u64::from(page) * side);
    let reach = [300, 1400, u64::MAX, u64::MAX][usize::from(id.level.min(3))];
    x.abs_diff(y) <= reach
}

fn area() -> Grid {
    Grid { nx: 5000, ny: 4100, spacing: 2.0, origin: DVec2::ZERO }
}

#[test]
fn sparse_databases_are_sound() {
    for are_fine in [false, true] {
        let pages = sparse(Sources { grid: area(), seed: 5, are_fine }, in_strip);
        let report = verify(&pages, &Silent).unwrap();
        assert!(report.problems.is_empty(), "{:?}", report.problems[0]);
        assert!(report.absent > report.pages, "{} absent, {} stored", report.absent, report.pages);
    }
}

#[test]
fn what_is_not_stored_comes_from_the_sources() {
    let sources = Sources { grid: area(), seed: 6, are_fine: false };
    let pages = sparse(sources, in_strip);
    let mut direct = [0, 0];
    for id in pages.directory().present().map(|(id, _)| id).filter(|id| id.level == 1) {
        let view = pages.page(id).unwrap().unwrap();
        for (x, y) in (0..view.height).flat_map(|y| (0..view.width).map(move |x| (x, y))) {
            let (column, row) = (id.px * PAGE_SIDE + x, id.py * PAGE_SIDE + y);
            let finer = PageId { level: 0, px: column / 64, py: row / 64 };
            let (height, colour, attributes) = sources.at(1, column, row);
            let is_direct = view.heights[view.sample(x, y)] == height;
            assert!(is_direct || in_strip(finer), "{id} ({x}, {y})");
            direct[usize::from(in_strip(finer))] += u32::from(is_direct);
            if !in_strip(finer) {
                assert_eq!((view.colours[view.sample(x, y)], view.attributes_at(x, y)), (colour, attributes));
                assert_eq!(view.relief[((y + 5) * (view.width + 10) + x + 5) as usize], Relief::default());
            }
        }
    }

    assert!(direct[0] > 100_000 && direct[1] * 50 < direct[0], "{direct:?}");
}

#[test]
fn what_sources_know_below_a_voxel_shows_in_its_slopes() {
    let sources = Sources { grid: area(), seed: 7, are_fine: true };
    let pages = sparse(sources, in_strip);
    let id = PageId { level: 2, px: 1, py: 0 };
    let view = pages.page(id).unwrap().unwrap();
    assert!(!in_strip(PageId { level: 1, px: 4, py: 0 }));
    let posts = sources.block(1, 1024..1028, 0..4).heights;
    let there: Vec<u32> = posts.into_iter().filter(|code| *code != 0).map(u32::from).collect();
    let mean = (there.iter().sum::<u32>() + there.len() as u32 / 2) / there.len() as u32;
    assert_eq!(u32::from(view.heights[view.sample(0, 0)]), mean);
    assert_ne!(view.relief[(5 * (view.width + 10) + 5) as usize], Relief::default());
}

/// Every surface that can be seen at a place: that of each level there, and of a page beside it up to half a voxel on.
#[test]
fn bounds_hold_for_whatever_is_seen() {
    let grid = area();
    let sources = Sources { grid, seed: 8, are_fine: false };
    let pages = sparse(sources, in_strip);
    let mut noise = Noise(99);
    let (mut outside, mut borders) = (0, 0);

    for _ in 0..400_000 {
        let [x, y] = [grid.nx, grid.ny].map(|side| noise.unit() * f64::from(side));
        for seen in 0..3_u8 {
            let side = f64::from(Grid::side_units(seen));
            // The cell's south-west post, which says whose page it is.
            let [i, j] = [x, y].map(|at| (at / side - 0.5).floor());
            let [u, v] = [x / side - 0.5 - i, y / side - 0.5 - j];
            let id = PageId { level: seen, px: i.max(0.0) as u32 / 256, py: j.max(0.0) as u32 / 256 };
            let Some(view) = pages.page(id).unwrap() else { continue };
            let local = |at: f64, page: u32| (at + f64::from(APRON) - f64::from(page * 256)) as u32;
            let (column, row) = (local(i, id.px), local(j, id.py));
            let post = |x: u32, y: u32| view.heights[((row + y) * (view.width + 12) + column + x) as usize];
            let posts = [post(0, 0), post(1, 0), post(0, 1), post(1, 1)];
            if posts.contains(&HeightCode::EMPTY) {
                continue;
            }

            let [sw, se, nw, ne] = posts.map(f64::from);
            let code = (sw + (se - sw) * u) * (1.0 - v) + (nw + (ne - nw) * u) * v;

            // The level's own bounds hold where nothing finer is stored: they are what it is skipped by there.
            let voxel_at = |level: u8| {
                let side = f64::from(Grid::side_units(level));
                ((x / side) as u32, (y / side) as u32)
            };
            let (own_x, own_y) = voxel_at(seen);
            let finer = PageId { level: seen.wrapping_sub(1), px: own_x / 64, py: own_y / 64 };
            let is_finest = seen == 0 || !in_strip(finer);
            let first = if seen > 0 && is_finest { seen } else { seen + 1 };

            for level in first..4 {
                let (i, j) = voxel_at(level);
                let id = PageId { level, px: i / 256, py: j / 256 };
                if pages.page(id).unwrap().is_none() {
                    continue;
                }

                let (_, low, high) = voxel(&pages, level, i, j);
                outside += u32::from(level == seen);
                borders += u32::from(
                    level > seen && !in_strip(PageId { level: 0, px: x as u32 / 256, py: y as u32 / 256 }),
                );
                assert!(
                    f64::from(low) <= code + 1e-6 && code <= f64::from(high) + 1e-6,
                    "({x}, {y}): {code} of level index {seen} leaves {low}..{high} of {level}"
                );
            }
        }
    }

    assert!(outside > 100_000 && borders > 100_000, "{outside} {borders}");
}
