//! A cyclic code built into voxels, as colours and as heights, against the code's own levels.
//!
//! Of the study of cyclic codes for surface texture (AFHRL on ACTES), whose levels are averages.

use super::support::{built, north_up, sheet, terrain};
use hedgehop::voxel::{PAGE_SIDE, PageId, PageSource};
use hedgehop_base::colour::srgb8_from_linear;
use hedgehop_geo::Crs;
use hedgehop_texture::{CyclicCode, Direction, LevelTables, Strand};

/// Voxels of a metre along each side.
const SIDE: u32 = 256;

/// Height of one tone, metres.
const RISE: f64 = 0.25;

fn code() -> LevelTables {
    let direction = Direction { column: 1, row: 1 };
    LevelTables::new(Strand { code: CyclicCode::default(), direction, phase: 3 })
}

/// Linear light of a tone.
fn light(tone: f64) -> f32 {
    (tone / 255.0) as f32
}

#[test]
fn voxels_built_of_a_code_have_its_levels() {
    let code = code();
    let leaf = |x: u32, y: u32| code.sum(0, x.into(), y.into()) as f64;
    let painted = |column: u32, row: u32| {
        let grey = srgb8_from_linear(light(leaf(column, SIDE - 1 - row)));
        [grey, grey, grey, 255]
    };
    let (crs, geo, size) = (Crs::local(), north_up(0.0, f64::from(SIDE), 1.0), (SIDE, SIDE));
    let raised = terrain(&crs, geo, size, |x, y| 50.0 + RISE * leaf(x as u32, y as u32));
    let area = built(vec![raised], vec![sheet(&crs, geo, size, painted)], |_| {});
    let heights = &area.pages.header().heights;

    // Rounding of leaves averages out; of each parent its own is left.
    for (level, side) in [(0_u8, 1), (1, 4), (2, 16), (3, 64)] {
        let (mut colours, mut codes) = (0, 0.0_f64);
        for (x, y) in (0..SIDE / side).flat_map(|y| (0..SIDE / side).map(move |x| (x, y))) {
            let id = PageId { level, px: x / PAGE_SIDE, py: y / PAGE_SIDE };
            let page = area.pages.page(id).unwrap().unwrap();
            let sample = page.sample(x % PAGE_SIDE, y % PAGE_SIDE);
            let mean = code.sum(level.into(), x.into(), y.into()) as f64 / f64::from(side * side);

            let grey = srgb8_from_linear(light(mean));
            colours = page.colours[sample].map(|own| own.abs_diff(grey)).into_iter().fold(colours, u8::max);
            let height = heights.decode(page.heights[sample]).unwrap();
            codes = codes.max((height - 50.0 - RISE * mean).abs() / heights.scale);
        }
        assert!(colours <= 1, "level {level}: colours differ by {colours}");
        assert!(codes <= 1.0, "level {level}: heights differ by {codes} steps");
    }
}
