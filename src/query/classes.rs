//! What the ground of a database is made of: areas by material, and what stands on it.
//!
//! ```text
//! for each stored page, each of its voxels that no stored page holds more finely: its area counts for its material and its source
//! for each page of bare ground: its spans count for their materials
//! ```

use std::collections::BTreeMap;

use glam::DVec2;

use crate::error::Result;
use crate::voxel::{
    Attributes, BLOCK_SIDE, BlockSpans, Grid, HeightCode, PAGE_SIDE, PageId, PageSource, RADIX, SpanTable,
};

/// Areas and numbers by class.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tally {
    /// By the number of the material of the highest surface; 0: not known.
    pub materials: BTreeMap<u8, ClassTally>,
    /// Area by elevation source, m².
    pub sources: BTreeMap<u16, f64>,
    /// By level, finest first.
    pub levels: Vec<LevelTally>,
    /// Area with a surface, m².
    pub area: f64,
    /// Area without any, m².
    pub empty: f64,
    /// Spans that stand on the ground.
    pub spans: u64,
}

/// What there is of a material.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ClassTally {
    /// Area of the surface seen from above, m².
    pub area: f64,
    /// Spans, which stand on the ground.
    pub spans: u64,
}

/// What there is of a level.
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
pub fn tally<S: PageSource>(source: &S, bbox: Option<[f64; 4]>) -> Result<Tally> {
    let header = source.header();
    let grid = &header.grid;
    let mut tally = Tally::default();
    for level in 0..header.level_count {
        tally.levels.push(LevelTally::default());
        let side = grid.side(level);
        let [columns, rows] = voxels_within(grid, level, bbox);
        let pages = |voxels: &std::ops::Range<u32>| voxels.start / PAGE_SIDE..voxels.end.div_ceil(PAGE_SIDE);
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

type Voxels<'r> = (&'r std::ops::Range<u32>, &'r std::ops::Range<u32>);

/// Columns and rows of a level whose centres lie in an area.
fn voxels_within(grid: &Grid, level: u8, bbox: Option<[f64; 4]>) -> [std::ops::Range<u32>; 2] {
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
fn part(voxels: &std::ops::Range<u32>, page: u32, size: u32) -> std::ops::Range<u32> {
    let first = page * PAGE_SIDE;
    let place = |voxel: u32| voxel.saturating_sub(first).min(size);
    place(voxels.start)..place(voxels.end)
}

fn add_page<S: PageSource>(
    source: &S,
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
    for y in rows {
        let has_finer: [bool; RADIX as usize] = std::array::from_fn(|quarter| {
            let (px, py) = (id.px * RADIX + quarter as u32, id.py * RADIX + y / QUARTER);
            id.level > 0 && source.has(PageId { level: id.level - 1, px, py })
        });
        for x in columns.clone().filter(|x| !has_finer[(x / QUARTER) as usize]) {
            if page.heights[page.sample(x, y)] == HeightCode::EMPTY {
                empty += 1;
                continue;
            }
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
    tally.empty += empty as f64 * area;
    Ok(())
}

fn add_spans<S: PageSource>(
    source: &S,
    bare: PageId,
    (columns, rows): Voxels<'_>,
    tally: &mut Tally,
) -> Result<()> {
    if !source.has(bare) {
        return Ok(());
    }
    let Some(spans) = source.spans(bare)? else { return Ok(()) };
    let (width, height) = source.header().grid.page_size(bare.surface()).unwrap_or((0, 0));
    let (columns, rows) = (part(columns, bare.px, width), part(rows, bare.py, height));
    let header = source.header();
    let rise = SpanTable::rise(header.heights, header.grid.spacing);
    let mut block = BlockSpans::default();
    let steps = |range: &std::ops::Range<u32>| range.start / BLOCK_SIDE..range.end.div_ceil(BLOCK_SIDE);
    for (column, row) in steps(&rows).flat_map(|row| steps(&columns).map(move |column| (column, row))) {
        let [x0, y0] = [column, row].map(|at| at * BLOCK_SIDE);
        if !block.gather(&spans, &header.objects, [x0, y0], rise) {
            continue;
        }
        for y in y0.max(rows.start)..(y0 + BLOCK_SIDE).min(rows.end) {
            for x in x0.max(columns.start)..(x0 + BLOCK_SIDE).min(columns.end) {
                for span in block.of(x, y) {
                    tally.materials.entry(span.material).or_default().spans += 1;
                    tally.spans += 1;
                }
            }
        }
    }
    Ok(())
}

/// What the finest voxel over a place (metres of the database's system) says of its surface; `None`: there is none.
///
/// # Errors
/// A page that is damaged.
pub fn attributes_at<S: PageSource>(source: &S, place: DVec2) -> Result<Option<Attributes>> {
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
    use crate::voxel::{MemPages, Metadata, build_in_memory};

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
}
