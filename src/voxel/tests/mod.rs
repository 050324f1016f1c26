//! Tests of the whole layer; those of one file are at its end.

mod damage;
pub(super) mod empty;
mod forgetting;
pub(super) mod patching;
mod placements;
mod sparse;
mod standing;
mod verifying;

use glam::DVec2;
use proptest::prelude::*;

use super::*;
use hedgehop_base::Size;

fn grid(nx: u32, ny: u32) -> Grid {
    Grid { nx, ny, spacing: 30.0, origin: DVec2::new(5.0e5, 4.0e6) }
}

/// Numbers that look random, from a seed (xorshift).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Random heights with holes, random colours and attributes.
struct Terrain {
    grid: Grid,
    heights: Vec<f64>,
    colours: Vec<[u8; 3]>,
    attributes: Vec<Attributes>,
}

impl Terrain {
    fn new(nx: u32, ny: u32, holes: f64, seed: u64) -> Self {
        let mut noise = Noise(seed | 1);
        let voxels = (nx * ny) as usize;
        let heights = (0..voxels)
            .map(|_| if noise.unit() < holes { f64::NAN } else { -50.0 + 900.0 * noise.unit() })
            .collect();
        let colours = (0..voxels).map(|_| std::array::from_fn(|_| noise.next() as u8)).collect();
        let attribute = |bits: u64| Attributes {
            source: (bits & 1) as u16,
            material: (bits >> 1 & 3) as u8,
            flags: (bits >> 3 & 3) as u8,
        };
        let attributes = (0..voxels).map(|_| attribute(noise.next() >> 9)).collect();
        Self { grid: grid(nx, ny), heights, colours, attributes }
    }

    fn pages(&self) -> MemPages {
        build_in_memory(self.grid, &self.heights, &self.colours, Some(&self.attributes), &Metadata::default())
            .unwrap()
    }

    fn arrays(&self) -> Arrays<'_> {
        Arrays {
            grid: self.grid,
            heights: &self.heights,
            colours: &self.colours,
            attributes: Some(&self.attributes),
        }
    }
}

/// The smooth surface of a level as codes, bilinear between posts, replicated at the edge; among posts without a
/// surface, of those of the four that have one; `None` where none has. `x`, `y` in voxels of the level.
struct LevelSurface {
    nx: usize,
    ny: usize,
    codes: Vec<u16>,
}

impl LevelSurface {
    fn of(pages: &MemPages, level: u8) -> Self {
        let grid = pages.header().grid;
        let (nx, ny) = grid.dims(level);
        let codes = (0..ny).flat_map(|y| (0..nx).map(move |x| (x, y)));
        let codes = codes.map(|(x, y)| voxel(pages, level, x, y).0).collect();
        Self { nx: nx as usize, ny: ny as usize, codes }
    }

    fn post(&self, x: f64, y: f64) -> f64 {
        let clamp = |v: f64, n: usize| v.clamp(0.0, (n - 1) as f64) as usize;
        f64::from(self.codes[clamp(y, self.ny) * self.nx + clamp(x, self.nx)])
    }

    fn at(&self, x: f64, y: f64) -> Option<f64> {
        let (x, y) = (x - 0.5, y - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(i, j)| {
            let weight = (if i == 0.0 { 1.0 - fx } else { fx }) * (if j == 0.0 { 1.0 - fy } else { fy });
            let code = self.post(x0 + i, y0 + j);
            (if code == 0.0 { 0.0 } else { weight }, code)
        });
        let total: f64 = corners.iter().map(|(weight, _)| weight).sum();
        let code = corners.iter().map(|(weight, code)| weight * code).sum::<f64>() / total;
        // Quotients may leave the interval of the posts by a rounding; codes are whole numbers.
        (total > 0.0).then(|| if (code - code.round()).abs() < 1.0e-6 { code.round() } else { code })
    }
}

/// Mean, low and high of a voxel of a level.
fn voxel(pages: &MemPages, level: u8, x: u32, y: u32) -> (u16, u16, u16) {
    let id = PageId { level, px: x / PAGE_SIDE, py: y / PAGE_SIDE };
    let view = pages.whole_page(id).unwrap().unwrap();
    let (x, y) = (x % PAGE_SIDE, y % PAGE_SIDE);
    let aproned = view.sample(x, y);
    let own = (y * view.width + x) as usize;
    let bound = |plane: &[u16]| plane.get(own).copied().unwrap_or(view.heights[aproned]);
    (view.heights[aproned], bound(view.low), bound(view.high))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn bounds_hold_for_all_finer_smooth_surfaces(
        nx in 1u32..90, ny in 1u32..90, holes in 0.0f64..0.5, seed: u64,
    ) {
        let pages = Terrain::new(nx, ny, holes, seed).pages();
        let levels: Vec<_> = (0..4).map(|level| LevelSurface::of(&pages, level)).collect();
        let mut noise = Noise(seed | 1);
        for _ in 0..2000 {
            // A position in units; half of them on the edges of voxels, where a neighbour matters most.
            let mut position = || {
                let p = noise.unit();
                if noise.next().is_multiple_of(2) { p } else { (p * 16.0).round() / 16.0 }
            };
            let (x, y) = (position() * f64::from(nx), position() * f64::from(ny));

            for (finer, surface) in levels.iter().enumerate() {
                let side = f64::from(Grid::side_units(finer as u8));
                let Some(code) = surface.at(x / side, y / side) else { continue };
                for level in finer as u8 + 1..4 {
                    let side = f64::from(Grid::side_units(level));
                    let (columns, rows) = pages.header().grid.dims(level);
                    let (i, j) = (((x / side) as u32).min(columns - 1), ((y / side) as u32).min(rows - 1));
                    let (_, low, high) = voxel(&pages, level, i, j);
                    prop_assert!(low != 0 && f64::from(low) <= code && code <= f64::from(high),
                        "({x}, {y}): {code} of level index {finer} leaves {low}..{high} of {level}");
                }
            }
        }
    }

    #[test]
    fn pages_tile_each_level(nx in 1u32..9000, ny in 1u32..9000) {
        let grid = grid(nx, ny);
        let directory = Directory::empty(&grid).unwrap();
        for level in 0..grid.level_count() {
            let (columns, rows) = grid.dims(level);
            let side = Grid::side_units(level);
            prop_assert!((columns - 1) * side < nx && nx <= columns * side);
            let sizes: Vec<_> = directory.ids().filter(|id| id.level == level)
                .map(|id| (id, grid.page_size(id).unwrap())).collect();
            let area: u64 = sizes.iter().map(|(_, size)| u64::from(size.width * size.height)).sum();
            prop_assert_eq!(area, u64::from(columns) * u64::from(rows));

            for (id, Size { width, height }) in sizes {
                prop_assert!((1..=PAGE_SIDE).contains(&width) && (1..=PAGE_SIDE).contains(&height));
                let east = id.px * PAGE_SIDE + width;
                prop_assert!(east == columns || width == PAGE_SIDE && east < columns);
            }

            prop_assert_eq!(grid.page_size(PageId { level, px: grid.page_dims(level).0, py: 0 }), None);
        }

        prop_assert_eq!(grid.page_size(PageId { level: grid.level_count(), px: 0, py: 0 }), None);
        prop_assert_eq!(grid.page_size(PageId { level: 255, px: u32::MAX, py: u32::MAX }), None);
    }

    #[test]
    fn height_codes_round_to_half_a_step(low in -1.0e4f64..1.0e4, span in 0.0f64..2.0e4, part in 0.0f64..=1.0) {
        let code = HeightCode::spanning(low, low + span);
        let height = low + span * part;
        let back = code.decode(code.encode(height)).unwrap();
        prop_assert!((back - height).abs() <= code.scale * 0.5 * (1.0 + 1.0e-9), "{height} became {back}");
        prop_assert_eq!(code.decode(code.encode(f64::NAN)), None);
        prop_assert!(code.encode(low - 1.0e6) == 1 && code.encode(f64::INFINITY) == u16::MAX);
    }
}

#[test]
fn ranges_of_codes_leave_out_what_has_no_surface() {
    let empty = HeightCode::EMPTY;
    assert_eq!(HeightCode::range(&[empty, 7, empty, 65535, 9]), Some((7, 65535)));
    assert_eq!((HeightCode::range(&[1]), HeightCode::range(&[empty; 3])), (Some((1, 1)), None));
    assert_eq!(HeightCode::joined(Some((3, 4)), Some((1, 2))), Some((1, 4)));
    assert_eq!(
        (HeightCode::joined(None, Some((1, 2))), HeightCode::joined(None, None)),
        (Some((1, 2)), None)
    );
}

#[test]
fn directory_numbers_pages_in_order() {
    let directory = Directory::empty(&grid(3000, 700)).unwrap();
    for (number, id) in directory.ids().enumerate() {
        assert_eq!(directory.index(id), Some(number));
    }
    assert_eq!(directory.ids().count(), directory.len());
}

#[test]
fn aprons_repeat_neighbours_and_edges() {
    let terrain = Terrain::new(700, 300, 0.1, 11);
    let pages = terrain.pages();
    for id in pages.directory().ids() {
        let view = pages.page(id).unwrap().unwrap();
        let (nx, ny) = terrain.grid.dims(id.level);
        for y in 0..view.height + 2 * APRON {
            for x in 0..view.width + 2 * APRON {
                let at = |page: u32, k: u32, n: u32| (page * PAGE_SIDE + k).saturating_sub(APRON).min(n - 1);
                let (mean, _, _) = voxel(&pages, id.level, at(id.px, x, nx), at(id.py, y, ny));
                assert_eq!(
                    view.heights[(y * (view.width + 2 * APRON) + x) as usize],
                    mean,
                    "{id} at ({x}, {y})"
                );
            }
        }
    }
}

#[test]
fn pages_lie_along_the_curve_whatever_their_order_in_a_band() {
    let sound = Terrain::new(600, 300, 0.0, 1).pages();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("area.hop");
    let header = sound.header();
    let mut writer = PageWriter::create(&path, header.grid, header.heights, false).unwrap();
    let ids: Vec<PageId> = sound.directory().ids().collect();

    for level in 0..header.level_count {
        let mut shelf = Shelf::new(&mut writer).unwrap();
        for id in ids.iter().rev().filter(|id| id.level == level) {
            shelf.take(&sound.whole_page(*id).unwrap().unwrap().to_buffer().encode(*id)).unwrap();
        }
        shelf.empty().unwrap();
    }

    writer.finish(&header.metadata, header.height_range).unwrap();
    let written = MemPages::from_bytes(&path, &std::fs::read(&path).unwrap()).unwrap();
    assert_eq!(written.header().content_hash, header.content_hash);
    let mut finest: Vec<_> = written.directory().present().filter(|(id, _)| id.level == 0).collect();
    finest.sort_by_key(|(_, entry)| entry.offset);
    let order: Vec<_> = finest.iter().map(|(id, _)| (id.px, id.py)).collect();
    assert_eq!(order, [(0, 0), (0, 1), (1, 1), (1, 0), (2, 0), (2, 1)]);
}

#[test]
fn means_are_of_voxels_with_a_surface() {
    let mut terrain = Terrain::new(8, 8, 0.0, 3);
    terrain.heights.fill(f64::NAN);
    terrain.colours.fill([255, 0, 0]);
    terrain.heights[0] = 100.0;
    terrain.heights[9] = 200.0;
    terrain.colours[0] = [10, 20, 30];
    terrain.colours[9] = [10, 20, 30];
    let pages = terrain.pages();
    let code = pages.header().heights;
    let view = pages.whole_page(PageId { level: 1, px: 0, py: 0 }).unwrap().unwrap();
    assert_eq!((view.width, view.height), (2, 2));
    assert!((code.decode(view.heights[view.sample(0, 0)]).unwrap() - 150.0).abs() <= code.scale);
    assert_eq!(view.colours[view.sample(0, 0)], [10, 20, 30]);
    assert_eq!(
        [view.heights[view.sample(1, 0)], view.low[1], view.high[3]],
        [0; 3],
        "nothing near has a surface"
    );
    assert_eq!((view.low[0], view.high[0]), (code.encode(100.0), code.encode(200.0)));
}

#[test]
fn attributes_are_majorities() {
    let mut terrain = Terrain::new(4, 4, 0.0, 5);
    for (k, attributes) in terrain.attributes.iter_mut().enumerate() {
        let flags = if k < 8 { Attributes::VOID } else { 0 } | if k < 7 { Attributes::NO_IMAGERY } else { 0 };
        *attributes = Attributes { source: u16::from(k < 7), material: [3, 2][k % 2], flags };
    }
    let pages = terrain.pages();
    let view = pages.page(PageId { level: 1, px: 0, py: 0 }).unwrap().unwrap();
    assert_eq!(view.attributes_at(0, 0), Attributes { source: 0, material: 2, flags: Attributes::VOID });
}

#[test]
fn a_file_holds_the_bytes_of_its_twin_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("area.hop");
    let terrain = Terrain::new(300, 40, 0.2, 7);
    let (hash, bytes) = write_arrays(&path, &terrain.arrays(), &Metadata::default(), false).unwrap();
    let pages = terrain.pages();
    assert_eq!(std::fs::read(&path).unwrap(), pages.bytes());
    assert_eq!((hash, bytes), (pages.header().content_hash, pages.bytes().len() as u64));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
}

#[test]
fn identity_does_not_depend_on_the_order_of_pages() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("area.hop");
    let pages = Terrain::new(600, 300, 0.0, 9).pages();
    let header = pages.header();
    let mut writer = PageWriter::create(&path, header.grid, header.heights, false).unwrap();
    let mut ids: Vec<_> = pages.directory().ids().collect();
    ids.reverse();

    for id in ids {
        let page = pages.whole_page(id).unwrap().unwrap().to_buffer();
        writer.append(&page.encode(id)).unwrap();
        assert_eq!(writer.readback().page(id).unwrap(), Some(page));
        assert!(
            writer.append(&pages.whole_page(id).unwrap().unwrap().to_buffer().encode(id)).is_err(),
            "twice"
        );
    }

    let (hash, _) = writer.finish(&Metadata::default(), header.height_range).unwrap();
    assert_eq!(hash, header.content_hash);
    assert_ne!(std::fs::read(&path).unwrap(), pages.bytes());
}

#[test]
fn a_writer_that_is_dropped_leaves_nothing_and_refuses_to_overwrite() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("area.hop");
    let terrain = Terrain::new(5, 5, 0.0, 1);
    drop(PageWriter::create(&path, terrain.grid, HeightCode::spanning(0.0, 1.0), false).unwrap());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    let late = PageWriter::create(&path, terrain.grid, HeightCode::spanning(0.0, 1.0), false).unwrap();
    let incomplete =
        late.finish(&Metadata::default(), HeightRange { low: 0.0, high: 1.0 }).unwrap_err().to_string();
    assert!(incomplete.contains("coarsest level must be complete"), "{incomplete}");
    write_arrays(&path, &terrain.arrays(), &Metadata::default(), false).unwrap();
    let refused =
        write_arrays(&path, &terrain.arrays(), &Metadata::default(), false).unwrap_err().to_string();
    assert!(refused.contains("area.hop") && refused.contains("--overwrite"), "{refused}");
    write_arrays(&path, &terrain.arrays(), &Metadata::default(), true).unwrap();
}
