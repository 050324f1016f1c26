//! Composition of the ground of a database: areas by material, and what stands on it.
//!
//! ```text
//! for each stored page, each of its voxels that no stored page holds more finely: its area counts for its material and its source
//! for each page of bare ground: its spans count for their materials, and its placements for their objects, each on the block of its middle voxel
//! ```

use std::collections::BTreeMap;
use std::ops::Range;

use glam::DVec2;

use hedgehop::voxel::{
    Attributes, BLOCK_SIDE, BlockSpans, Grid, HeightCode, PAGE_SIDE, PageId, PageSource, Placement, RADIX,
    SharedObject, SharedObjects, SpanTable,
};
use hedgehop_base::Size;
use hedgehop_base::error::Result;

/// Areas and numbers by class.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tally {
    /// Areas by the number of the material of the highest surface; 0: not known.
    pub materials: BTreeMap<u8, ClassTally>,
    /// Area by elevation source, m².
    pub sources: BTreeMap<u16, f64>,
    /// Areas by level, finest first.
    pub levels: Vec<LevelTally>,
    /// Area with a surface, m².
    pub area: f64,
    /// Area without any, m².
    pub empty: f64,
    /// Least and greatest height of the surface's voxels, metres above the datum; `None`: there is none.
    pub heights: Option<[f64; 2]>,
    /// Spans that stand on the ground.
    pub spans: u64,
    /// Objects that the database stores once and places, by number.
    pub objects: Vec<ObjectTally>,
}

/// Count of an object that is stored once.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ObjectTally {
    /// Voxels of level 1 eastward and northward, before it is turned.
    pub voxels: [u16; 2],
    /// Number of placements with their middle voxel in the area asked for. Each placement counts once, however many blocks and pages it reaches.
    pub placed: u64,
    /// Bytes that it takes in the file, without its placements.
    pub bytes: u64,
}

/// Count of a material.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ClassTally {
    /// Area of the surface seen from above, m².
    pub area: f64,
    /// Spans, which stand on the ground.
    pub spans: u64,
}

/// Count of a level.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LevelTally {
    /// Pages that were looked at: those that meet the area asked for.
    pub pages: u64,
    /// Area that no finer level holds, m².
    pub area: f64,
}

/// Counts over a database, or over the voxels of it whose centres lie within west, south, east, north (metres of its system).
///
/// # Errors
/// A page that is damaged.
pub fn tally(source: &dyn PageSource, bbox: Option<[f64; 4]>) -> Result<Tally> {
    let header = source.header();
    let grid = &header.grid;
    let object =
        |object: &SharedObject| ObjectTally { voxels: object.voxels(), placed: 0, bytes: object.bytes() };
    let objects = header.objects.all().iter().map(object).collect();
    let mut tally = Tally { objects, ..Tally::default() };

    for level in 0..header.level_count {
        tally.levels.push(LevelTally::default());
        let side = grid.side(level);
        let [columns, rows] = voxels_within(grid, level, bbox);
        let pages = |voxels: &Range<u32>| voxels.start / PAGE_SIDE..voxels.end.div_ceil(PAGE_SIDE);

        for (px, py) in pages(&rows).flat_map(|py| pages(&columns).map(move |px| (px, py))) {
            let id = PageId { level, px, py };
            if columns.is_empty() || rows.is_empty() || !source.has(id) {
                continue;
            }
            tally.levels[usize::from(level)].pages += 1;
            add_page(source, id, (&columns, &rows), side * side, &mut tally)?;
            if level == 0 {
                add_spans(source, id.bare(), (&columns, &rows), &mut tally)?;
            }
        }
    }

    Ok(tally)
}

type Voxels<'r> = (&'r Range<u32>, &'r Range<u32>);

/// Columns and rows of a level whose centres lie in an area.
fn voxels_within(grid: &Grid, level: u8, bbox: Option<[f64; 4]>) -> [Range<u32>; 2] {
    let (nx, ny) = grid.dims(level);
    let Some([west, south, east, north]) = bbox else { return [0..nx, 0..ny] };
    let range = |low: f64, high: f64, origin: f64, count: u32| {
        let place =
            |at: f64| ((at - origin) / grid.side(level) - 0.5).ceil().clamp(0.0, f64::from(count)) as u32;
        place(low)..place(high)
    };
    [range(west, east, grid.origin.x, nx), range(south, north, grid.origin.y, ny)]
}

/// The part of a page that a range of voxels of its level covers.
fn part(voxels: &Range<u32>, page: u32, size: u32) -> Range<u32> {
    let first = page * PAGE_SIDE;
    let place = |voxel: u32| voxel.saturating_sub(first).min(size);
    place(voxels.start)..place(voxels.end)
}

fn add_page(
    source: &dyn PageSource,
    id: PageId,
    (columns, rows): Voxels<'_>,
    area: f64,
    tally: &mut Tally,
) -> Result<()> {
    // Voxels along the side of what a finer page covers.
    const QUARTER: u32 = PAGE_SIDE / RADIX;

    let Some(page) = source.page(id)? else { return Ok(()) };
    let (columns, rows) = (part(columns, id.px, page.width), part(rows, id.py, page.height));
    let mut counts: BTreeMap<(u8, u16), u64> = BTreeMap::new();
    let mut empty = 0_u64;
    let mut last: Option<((u8, u16), u64)> = None;
    let mut codes: Option<[u16; 2]> = None;

    for y in rows {
        let has_finer: [bool; RADIX as usize] = std::array::from_fn(|quarter| {
            let (px, py) = (id.px * RADIX + quarter as u32, id.py * RADIX + y / QUARTER);
            id.level > 0 && source.has(PageId { level: id.level - 1, px, py })
        });

        for x in columns.clone().filter(|x| !has_finer[(x / QUARTER) as usize]) {
            let code = page.heights[page.sample(x, y)];
            if code == HeightCode::EMPTY {
                empty += 1;
                continue;
            }

            let [least, greatest] = codes.unwrap_or([code; 2]);
            codes = Some([least.min(code), greatest.max(code)]);
            let Attributes { material, source, .. } = page.attributes_at(x, y);
            let class = (material, source);

            // Neighbours are alike as a rule.
            match &mut last {
                Some((known, count)) if *known == class => *count += 1,
                _ => {
                    let before = last.replace((class, 1));
                    before.into_iter().for_each(|(class, count)| *counts.entry(class).or_default() += count);
                }
            }
        }
    }

    last.into_iter().for_each(|(class, count)| *counts.entry(class).or_default() += count);
    for ((material, source), count) in counts {
        let area = count as f64 * area;
        tally.materials.entry(material).or_default().area += area;
        *tally.sources.entry(source).or_default() += area;
        tally.area += area;
        tally.levels[usize::from(id.level)].area += area;
    }

    let code = source.header().heights;
    if let Some([low, high]) =
        codes.map(|codes| codes.map(|height| code.offset + code.scale * f64::from(height)))
    {
        let [least, greatest] = tally.heights.unwrap_or([low, high]);
        tally.heights = Some([least.min(low), greatest.max(high)]);
    }

    tally.empty += empty as f64 * area;
    Ok(())
}

fn add_spans(
    source: &dyn PageSource,
    bare: PageId,
    (columns, rows): Voxels<'_>,
    tally: &mut Tally,
) -> Result<()> {
    if !source.has(bare) {
        return Ok(());
    }

    let Some(spans) = source.spans(bare)? else { return Ok(()) };
    let Size { width, height } = source.header().grid.page_size(bare.surface()).unwrap_or_default();
    let (columns, rows) = (part(columns, bare.px, width), part(rows, bare.py, height));
    let header = source.header();
    let rise = SpanTable::rise(header.heights, header.grid.spacing);
    let mut block = BlockSpans::default();
    let steps = |range: &Range<u32>| range.start / BLOCK_SIDE..range.end.div_ceil(BLOCK_SIDE);

    for (column, row) in steps(&rows).flat_map(|row| steps(&columns).map(move |column| (column, row))) {
        let [x0, y0] = [column, row].map(|at| at * BLOCK_SIDE);
        let within =
            |first: u32, range: &Range<u32>| first.max(range.start)..(first + BLOCK_SIDE).min(range.end);
        let (columns, rows) = (within(x0, &columns), within(y0, &rows));
        add_placements(spans.placements_at(x0, y0), &header.objects, (&columns, &rows), tally);
        if !block.gather(&spans, &header.objects, [x0, y0], rise) {
            continue;
        }

        for y in rows {
            for x in columns.clone() {
                for span in block.of(x, y) {
                    tally.materials.entry(span.material).or_default().spans += 1;
                    tally.spans += 1;
                }
            }
        }
    }

    Ok(())
}

/// Counts those placements of a block whose middle voxel is one of `columns` and `rows`, which lie in the block.
fn add_placements(
    placements: &[Placement],
    objects: &SharedObjects,
    (columns, rows): Voxels<'_>,
    tally: &mut Tally,
) {
    for &placement in placements {
        let Some(object) = objects.get(placement) else { continue };
        let size = object.size(placement);
        let is_middle = |axis: usize, range: &Range<u32>| {
            let middle = i64::from(placement.first[axis]) + i64::from(size[axis] / 2);
            (i64::from(range.start)..i64::from(range.end)).contains(&middle)
        };
        if is_middle(0, columns) && is_middle(1, rows) {
            tally.objects[placement.number()].placed += 1;
        }
    }
}

/// Returns the surface of the finest voxel over a place (metres of the database's system); `None`: there is none.
///
/// # Errors
/// A page that is damaged.
pub fn attributes_at(source: &dyn PageSource, place: DVec2) -> Result<Option<Attributes>> {
    let header = source.header();
    let grid = &header.grid;
    let far = grid.far_corner();
    if !(place.cmpge(grid.origin).all() && place.cmple(far).all()) {
        return Ok(None);
    }
    for level in 0..header.level_count {
        let at = ((place - grid.origin) / grid.side(level)).floor();
        let (nx, ny) = grid.dims(level);
        let (x, y) = ((at.x as u32).min(nx - 1), (at.y as u32).min(ny - 1));
        let id = PageId { level, px: x / PAGE_SIDE, py: y / PAGE_SIDE };
        if let Some(page) = source.has(id).then(|| source.page(id)).transpose()?.flatten() {
            let (x, y) = (x % PAGE_SIDE, y % PAGE_SIDE);
            let is_there = page.heights[page.sample(x, y)] != HeightCode::EMPTY;
            return Ok(is_there.then(|| page.attributes_at(x, y)));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop::voxel::{
        Arrays, Cut, Facade, MemPages, Metadata, Span, SpanArrays, Symmetry, build_in_memory, build_standing,
    };

    /// 300 × 300 voxels of 2 m: 100 columns of water, the rest of grass, of another source from row 200 on; nothing in the first row.
    fn area() -> MemPages {
        let grid = Grid { nx: 300, ny: 300, spacing: 2.0, origin: DVec2::new(1000.0, 2000.0) };
        let voxels = || (0..300_u32).flat_map(|y| (0..300_u32).map(move |x| (x, y)));
        let heights: Vec<f64> = voxels().map(|(_, y)| if y == 0 { f64::NAN } else { 100.0 }).collect();
        let attributes: Vec<Attributes> = voxels()
            .map(|(x, y)| Attributes {
                source: u16::from(y >= 200),
                material: if x < 100 { 1 } else { 14 },
                flags: 0,
            })
            .collect();
        let colours = vec![[90; 3]; heights.len()];
        build_in_memory(grid, &heights, &colours, Some(&attributes), &Metadata::default()).unwrap()
    }

    #[test]
    fn areas_add_up_by_material_and_source() {
        let tally = tally(&area(), None).unwrap();
        let area = |material| tally.materials[&material].area;
        assert_eq!((area(1), area(14)), (100.0 * 299.0 * 4.0, 200.0 * 299.0 * 4.0));
        assert_eq!((tally.area, tally.empty), (300.0 * 299.0 * 4.0, 300.0 * 4.0));
        assert_eq!((tally.sources[&0], tally.sources[&1]), (300.0 * 199.0 * 4.0, 300.0 * 100.0 * 4.0));
        assert_eq!(tally.levels[0], LevelTally { pages: 4, area: tally.area });
        assert_eq!((tally.levels[1].pages, tally.levels[1].area), (1, 0.0));
    }

    #[test]
    fn heights_are_those_of_the_part() {
        let grid = Grid { nx: 200, ny: 100, spacing: 2.0, origin: DVec2::ZERO };
        let heights: Vec<f64> = (0..100).flat_map(|_| (0..200).map(f64::from)).collect();
        let area =
            build_in_memory(grid, &heights, &vec![[90; 3]; 20_000], None, &Metadata::default()).unwrap();
        for (bbox, wanted) in [(None, [0.0, 199.0]), (Some([40.0, 20.0, 60.0, 30.0]), [20.0, 29.0])] {
            let found = tally(&area, bbox).unwrap().heights.unwrap();
            assert!(
                found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 0.01),
                "{found:?}"
            );
        }
        assert_eq!(tally(&area, Some([-10.0, -10.0, 0.0, 0.0])).unwrap().heights, None);
    }

    #[test]
    fn a_part_of_the_area_has_its_own() {
        // 20 columns of water and 10 of grass, 5 rows.
        let found = tally(&area(), Some([1160.0, 2100.0, 1220.0, 2110.0])).unwrap();
        assert_eq!((found.materials[&1].area, found.materials[&14].area), (400.0, 200.0));
        assert_eq!(found.levels[0].pages, 1);
        assert_eq!(tally(&area(), Some([0.0, 0.0, 10.0, 10.0])).unwrap().area, 0.0);
    }

    #[test]
    fn places_tell_their_material() {
        let area = area();
        let at = |x: f64, y: f64| attributes_at(&area, DVec2::new(x, y)).unwrap().map(|found| found.material);
        assert_eq!((at(1199.9, 2100.0), at(1200.1, 2100.0)), (Some(1), Some(14)));
        assert_eq!((at(1200.1, 2001.0), at(999.0, 2100.0), at(1600.1, 2100.0)), (None, None, None));
    }

    /// 300 × 300 voxels of 1 m on which objects of 3 × 2 and of 20 × 12 voxels stand.
    fn placed(placed: &[([i64; 2], Placement)]) -> MemPages {
        let code = HeightCode { scale: 0.01, offset: -1.0 };
        let span = Span {
            low: Span::GROUND,
            high: 900,
            slope: [0, 0],
            cuts: [Cut::wall(0, 0), Cut::NONE, Cut::NONE],
            top: [9; 3],
            state: Span::OPAQUE,
            side: [9; 3],
            material: 4,
            facade: Facade::NONE,
        };

        let object =
            |size| SharedObject::new(size, SpanTable::rise(code, 1.0), |_, _, spans| spans.push(span));
        let objects = SharedObjects::new(vec![object([3, 2]), object([20, 12])]);
        let grid = Grid { nx: 300, ny: 300, spacing: 1.0, origin: DVec2::ZERO };
        let (heights, colours) = (vec![0.0; 90_000], vec![[90; 3]; 90_000]);
        let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
        let (spans, objects) = (&BTreeMap::new(), &objects);
        let standing = SpanArrays { heights: &heights, colours: &colours, spans, objects, placed, code };

        build_standing(&arrays, &standing, &Metadata::default()).unwrap()
    }

    #[test]
    fn placements_count_once_however_many_blocks_and_pages_they_reach() {
        let at = |number, first, turns| (first, Placement::new(number, Symmetry::new(turns), [0, 0], 100));
        // The second lies on four pages, the last but one on two; the third stands beside the area and reaches into it.
        let pages = placed(&[
            at(0, [100, 100], 0),
            at(0, [254, 255], 0),
            at(0, [-2, 20], 0),
            at(1, [120, 50], 0),
            at(1, [250, 3], 0),
            at(1, [10, 10], 1),
        ]);

        let found = tally(&pages, None).unwrap().objects;
        assert_eq!(found[0], ObjectTally { voxels: [3, 2], placed: 2, bytes: 16 + 7 * 4 + 6 * 20 });
        assert_eq!(found[1], ObjectTally { voxels: [20, 12], placed: 3, bytes: 16 + 241 * 4 + 240 * 20 });
        let bytes: u64 = found.iter().map(|object| object.bytes).sum();
        assert_eq!((16 + bytes).next_multiple_of(64), pages.header().objects.to_bytes().len() as u64);

        // Middles are at 260, 9; at 255, 256; and, turned, at 16, 20.
        for (bbox, expected) in [
            ([0.0, 0.0, 256.0, 300.0], [2, 2]),
            ([256.0, 0.0, 300.0, 300.0], [0, 1]),
            ([0.0, 0.0, 300.0, 256.0], [1, 3]),
            ([16.0, 20.0, 17.0, 21.0], [0, 1]),
        ] {
            let found = tally(&pages, Some(bbox)).unwrap().objects;
            assert_eq!([found[0].placed, found[1].placed], expected, "{bbox:?}");
        }

        assert_eq!(tally(&area(), None).unwrap().objects, []);
    }
}
