//! Objects that are stored once and placed many times.

use std::collections::BTreeMap;

use super::*;
use crate::voxel::{BLOCK_SIDE, BlockSpans, SpanArrays, Symmetry, build_standing, verify};
use hedgehop_base::progress::Silent;

const SIDE: u32 = 300;
const CODE: HeightCode = HeightCode { scale: 0.01, offset: -1.0 };

/// A span that tells which voxel of an object it was made for.
fn marked(x: u16, y: u16, low: u16) -> Span {
    Span {
        low,
        high: 900 + x,
        slope: [10, 3],
        cuts: [Cut::wall(20, 5), Cut::wall(90, 7), Cut::wall(201, -3)],
        top: [x as u8, y as u8, 7],
        state: Span::OPAQUE,
        side: [1, 2, 3],
        material: 4,
        facade: Facade::NONE,
    }
}

/// Three voxels by two, one of which is empty, one with something that hangs above.
fn object(rise: f64) -> SharedObject {
    SharedObject::new([3, 2], rise, |x, y, spans| {
        if (x, y) != (2, 1) {
            spans.push(marked(x, y, Span::GROUND));
        }
        if (x, y) == (0, 0) {
            spans.push(Span { high: 2000, ..marked(x, y, 1500) });
        }
    })
}

fn area(placed: &[([i64; 2], Placement)]) -> MemPages {
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: 1.0, origin: DVec2::ZERO };
    let ground = vec![0.0; (SIDE * SIDE) as usize];
    let colours = vec![[90; 3]; ground.len()];
    let arrays = Arrays { grid, heights: &ground, colours: &colours, attributes: None };
    let own = BTreeMap::from([((100, 100), vec![Span { high: 500, ..marked(0, 0, Span::GROUND) }])]);
    let objects = SharedObjects::new(vec![object(SpanTable::rise(CODE, 1.0))]);
    let standing = SpanArrays {
        heights: &ground,
        colours: &colours,
        spans: &own,
        objects: &objects,
        placed,
        code: CODE,
    };
    build_standing(&arrays, &standing, &Metadata::default()).unwrap()
}

fn at(first: [i64; 2], symmetry: u64, foot: u16) -> ([i64; 2], Placement) {
    (first, Placement::new(0, Symmetry::new(symmetry), [0, 0], foot))
}

/// What stands on a voxel of the area.
fn spans_at(pages: &MemPages, x: u32, y: u32) -> Vec<Span> {
    let id = PageId { level: 0, px: x / PAGE_SIDE, py: y / PAGE_SIDE }.bare();
    let Some(view) = pages.spans(id).unwrap() else { return Vec::new() };
    let mut block = BlockSpans::default();
    let rise = SpanTable::rise(CODE, 1.0);
    block.gather(&view, &pages.header().objects, [x % PAGE_SIDE, y % PAGE_SIDE], rise);
    let spans = block.of(x % PAGE_SIDE, y % PAGE_SIDE);
    let corner = |span: &Span| {
        let steps: i32 = span.slope.iter().map(|slope| i32::from(slope.unsigned_abs())).sum();
        f64::from(span.high) + f64::from(steps) * rise
    };
    let highest = spans.iter().map(corner).reduce(f64::max);
    let top = f64::from(block.tops()[(y % BLOCK_SIDE * BLOCK_SIDE + x % BLOCK_SIDE) as usize]);
    assert!(
        highest.map_or(top == 0.0, |highest| (0.25..1.0).contains(&(top - highest))),
        "{top} {highest:?}"
    );
    spans.to_vec()
}

#[test]
fn an_object_stands_where_it_is_placed_across_blocks_and_pages() {
    let pages =
        area(&[at([254, 255], 0, 100), at([-1, 20], 0, 7), at([298, -1], 0, 7), at([100, 100], 0, 50)]);
    assert!(verify(&pages, &Silent).unwrap().is_sound());
    for (x, y) in (0..2).flat_map(|y| (0..3).map(move |x| (x, y))) {
        let here = spans_at(&pages, 254 + u32::from(x), 255 + u32::from(y));
        let expected = match (x, y) {
            (2, 1) => vec![],
            (0, 0) => vec![
                Span { high: 1000, ..marked(0, 0, Span::GROUND) },
                Span { low: 1600, high: 2100, ..marked(0, 0, 0) },
            ],
            _ => vec![Span { high: 1000 + x, ..marked(x, y, Span::GROUND) }],
        };
        assert_eq!(here, expected, "({x}, {y})");
    }

    // What lies beside the area is nowhere; what stands there by itself stays, in order of height.
    assert_eq!(spans_at(&pages, 0, 20)[0].top, [1, 0, 7]);
    assert_eq!(spans_at(&pages, 299, 0)[0].top, [1, 1, 7]);
    let highs: Vec<u16> = spans_at(&pages, 100, 100).iter().map(|span| span.high).collect();
    assert_eq!(highs, [500, 950, 2050]);
    assert_eq!(spans_at(&pages, 253, 255), []);
}

#[test]
fn turns_and_mirrors_move_voxels_slopes_and_walls_alike() {
    // The direction of a slope must lead from one voxel of the object to the same neighbour, however it is turned.
    for symmetry in 0..8 {
        let pages = area(&[at([40, 40], symmetry, 0)]);
        let mut found = BTreeMap::new();
        for (x, y) in (40..43).flat_map(|x| (40..43).map(move |y| (x, y))) {
            for span in spans_at(&pages, x, y) {
                found.insert((span.top[0], span.top[1]), (glam::IVec2::new(x as i32, y as i32), span));
            }
        }

        assert_eq!(found.len(), 5, "{symmetry}");
        let (origin, span) = found[&(0, 0)];
        let (east, north) = (found[&(1, 0)].0 - origin, found[&(0, 1)].0 - origin);
        assert_eq!((east.length_squared(), north.length_squared(), east.dot(north)), (1, 1, 0), "{symmetry}");
        assert_eq!(east.perp_dot(north), if symmetry < 4 { 1 } else { -1 }, "{symmetry}");
        let slope = east * 10 + north * 3;
        assert_eq!([i32::from(span.slope[0]), i32::from(span.slope[1])], [slope.x, slope.y], "{symmetry}");
        let [cos, sin] = [20.0_f32, 20.0].map(|facing| facing * std::f32::consts::TAU / 256.0);
        let expected = east.as_vec2() * cos.cos() + north.as_vec2() * sin.sin();
        let [x, y] = span.cuts[0].normal();
        assert!((glam::Vec2::new(x, y) - expected).length() < 1e-5, "{symmetry}");
    }
}

#[test]
fn a_placement_costs_eight_bytes_for_each_block_that_it_reaches() {
    let placed: Vec<_> = (0..30).map(|index| at([8 * index, 8 * index], index as u64, 9)).collect();
    let [few, many] = [&placed[..1], &placed[..]].map(|placed| {
        let pages = area(placed);
        pages.stretch(PagePart::Spans(PageId { level: 0, px: 0, py: 0 }.bare())).len()
    });
    // Rounded to what a part ends with.
    assert!((29 * 8 - 63..29 * 8 + 64).contains(&(many - few)), "{few} {many}");
    let pages = area(&placed);
    let view = pages.spans(PageId { level: 0, px: 0, py: 0 }.bare()).unwrap().unwrap();
    assert_eq!(view.placements().len(), 30);
    assert_eq!(view.placements_at(8 * BLOCK_SIDE, 8 * BLOCK_SIDE).len(), 1);
}

#[test]
fn damaged_objects_are_refused() {
    let objects = SharedObjects::new(vec![object(1.0), object(1.0)]);
    let whole = objects.to_bytes();
    assert_eq!(SharedObjects::decode(&whole, 1.0).unwrap(), objects);
    assert_eq!(SharedObjects::decode(&[], 1.0).unwrap(), SharedObjects::default());

    for length in 1..whole.len() {
        // What is cut off may be nothing but what pads the end.
        if let Ok(read) = SharedObjects::decode(&whole[..length], 1.0) {
            assert_eq!(read, objects);
        }
    }

    for byte in 0..whole.len() {
        for bit in 0..8 {
            let mut bytes = whole.clone();
            bytes[byte] ^= 1 << bit;
            if let Ok(read) = SharedObjects::decode(&bytes, 1.0) {
                // Whatever it says, asking is safe.
                let placed = (0..read.len() as u16)
                    .flat_map(|number| (0..8).map(move |symmetry| (number, Symmetry::new(symmetry))));
                for (number, symmetry) in placed {
                    let placement = Placement::new(number, symmetry, [0, 0], 9);
                    let object = read.get(placement).unwrap();
                    let [width, depth] = object.size(placement);
                    let asked = (0..depth).flat_map(|y| (0..width).map(move |x| [x, y]));
                    assert!(
                        asked.map(|voxel| object.spans_at(placement, voxel).count()).sum::<usize>() < 5000
                    );
                }
            }
        }
    }
}

#[test]
fn placements_that_contradict_their_block_are_found() {
    let pages = area(&[at([40, 40], 0, 100)]);
    let id = PageId { level: 0, px: 0, py: 0 }.bare();
    let view = pages.spans(id).unwrap().unwrap();
    let rise = SpanTable::rise(CODE, 1.0);
    let objects = &pages.header().objects;
    assert_eq!(view.check(rise, objects), None);
    assert!(view.check(rise, &SharedObjects::default()).is_some(), "its object is not there");
    let higher = SharedObjects::new(vec![SharedObject::new([3, 2], rise, |_, _, spans| {
        spans.push(Span { high: 60_000, ..marked(0, 0, Span::GROUND) });
    })]);
    assert!(view.check(rise, &higher).is_some(), "its object is higher than the block");
}
