//! Pages against their neighbours, and at the edge of the area.

use std::sync::atomic::AtomicU32;

use super::facing::Facing;
use super::posts::PageLight;
use super::tests::{Holey, bake, codes, rough, sensor};
use super::*;
use crate::sensor::radiance::part::{PostPart, RING};
use crate::simd::Isa;
use crate::voxel::{PAGE_SIDE, PageId, PageSource};

/// Holds every apron texel of a page against the page that the texel belongs to.
fn assert_seams(source: &impl PageSource, level: u8) -> usize {
    let (nx, ny) = source.header().grid.page_dims(level);
    let radiance = Radiance::new(sensor());
    let pages = RadiancePages::new(source, &radiance);
    let bake = |px, py| pages.page(PageId { level, px, py }).unwrap();
    let (ring, side) = (RING as i64, i64::from(PAGE_SIDE));
    let mut compared = 0;

    for (px, py) in (0..ny).flat_map(|py| (0..nx).map(move |px| (px, py))) {
        let Some(page) = bake(px, py) else { continue };
        let size = page.size.map(i64::from);
        for y in -ring..size[1] + ring {
            for x in -ring..size[0] + ring {
                let at = [x + i64::from(px) * side, y + i64::from(py) * side];
                let owner = at.map(|texel| texel.div_euclid(side));
                let is_own = (0..size[0]).contains(&x) && (0..size[1]).contains(&y);
                let is_outside =
                    owner[0] < 0 || owner[1] < 0 || owner[0] >= nx.into() || owner[1] >= ny.into();
                if is_own || is_outside {
                    continue;
                }

                let Some(other) = bake(owner[0] as u32, owner[1] as u32) else { continue };
                let inside = at.map(|texel| texel.rem_euclid(side));
                if inside[0] >= i64::from(other.size[0]) || inside[1] >= i64::from(other.size[1]) {
                    continue;
                }

                assert_eq!(
                    codes(&page, x, y),
                    codes(&other, inside[0], inside[1]),
                    "level {level}, page ({px}, {py}), texel ({x}, {y})"
                );
                compared += 1;
            }
        }
    }

    compared
}

#[test]
fn aprons_hold_what_the_neighbours_hold() {
    // One row or column more than whole pages, and odd and even rests.
    for (nx, ny) in [(257, 513), (300, 259)] {
        let compared = assert_seams(&rough(nx, ny, 7), 0);
        assert!(compared > 1000, "{compared}");
    }
}

#[test]
fn coarse_aprons_hold_what_the_neighbours_hold() {
    assert!(assert_seams(&rough(1030, 1045, 7), 1) > 500);
}

#[test]
fn at_the_edge_of_the_area_aprons_repeat_the_edge() {
    let source = rough(301, 17, 0);
    let page = bake(&source, 0, 1, 0).unwrap();
    assert_eq!(page.size, [45, 17]);
    for y in 0..17 {
        assert_eq!(codes(&page, 45, y), codes(&page, 44, y));
        assert_eq!(codes(&page, 48, y), codes(&page, 44, y));
    }
    for x in 0..45 {
        assert_eq!(codes(&page, x, -1), codes(&page, x, 0));
        assert_eq!(codes(&page, x, 17), codes(&page, x, 16));
    }
}

#[test]
fn a_page_needs_no_other() {
    let whole = rough(1300, 1300, 7);
    for level in 0..2 {
        let id = PageId { level, px: 0, py: 0 };
        let wanted = bake(&whole, level, 0, 0);
        let alone =
            Holey { whole: rough(1300, 1300, 7), absent: move |page| page != id, asked: AtomicU32::new(0) };
        assert!(bake(&alone, level, 0, 0) == wanted);
        assert!(bake(&alone, level, 1, 0).is_none());
    }
}

#[test]
fn parts_hold_what_the_whole_page_holds() {
    let source = rough(1200, 1100, 5);
    let uphill = Facing { major: 1, forward: true, incline: 0 };
    let bake = |id, part| {
        RadiancePage::bake(&source, id, part, &PageLight::new(&sensor()), &uphill, None, Isa::best()).unwrap()
    };

    // The area's south-west corner, its north-east one, and pages between.
    for (level, px, py) in [(0, 0, 0), (0, 4, 4), (0, 1, 2), (1, 0, 0), (1, 1, 1)] {
        let id = PageId { level, px, py };
        let whole = bake(id, PostPart::ALL).unwrap();
        for major in 0..2 {
            let axis = usize::from(major);
            for (first, count) in [(0, 32), (7, 5), (31, 128), (224, 64)] {
                let part = bake(id, PostPart::lines(major, first, count)).unwrap();
                let side = whole.size[axis];
                let first = (first as i32).min(side - 1);
                assert_eq!(part.size[axis], (count as i32).min(side - first), "{id}");
                assert_eq!(part.size[1 - axis], whole.size[1 - axis], "{id}");
                let ring = RING as i32;

                for y in -ring..part.size[1] + ring {
                    for x in -ring..part.size[0] + ring {
                        let at = if major == 0 { [x + first, y] } else { [x, y + first] };
                        assert_eq!(part.texel(x, y), whole.texel(at[0], at[1]), "{id}, {at:?}");
                    }
                }
            }
        }
    }
}
