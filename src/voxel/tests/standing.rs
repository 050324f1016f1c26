//! Bare ground and what stands on it, stored and read again.

use std::collections::BTreeMap;

use super::*;
use crate::voxel::{SpanArrays, build_standing, verify};
use hedgehop_base::Size;
use hedgehop_base::progress::Silent;

const SIDE: u32 = 300;

/// A span on the ground of height code `high`.
fn post(high: u16, slope: [i8; 2]) -> Span {
    Span {
        low: Span::GROUND,
        high,
        slope,
        cuts: [Cut::NONE; 3],
        top: [200, 40, 30],
        state: Span::OPAQUE,
        side: [120, 110, 100],
        material: 3,
    }
}

/// Flat ground with a few spans, the last one in the corner.
fn spans() -> BTreeMap<(u32, u32), Vec<Span>> {
    let hanging = Span { low: 900, state: 9 | Span::PARALLEL, ..post(1000, [64, -64]) };
    BTreeMap::from([
        ((3, 7), vec![post(500, [0, 0])]),
        ((4, 7), vec![post(500, [2, 3]), hanging]),
        ((250, 9), vec![hanging]),
        ((299, 299), vec![post(65_000, [-128, 127])]),
    ])
}

fn area(spans: &BTreeMap<(u32, u32), Vec<Span>>) -> MemPages {
    area_of(SIDE, spans)
}

/// Flat ground of so many voxels along a side, with spans.
fn area_of(side: u32, spans: &BTreeMap<(u32, u32), Vec<Span>>) -> MemPages {
    let grid = Grid { nx: side, ny: side, spacing: 1.0, origin: DVec2::ZERO };
    let code = HeightCode { scale: 0.01, offset: -1.0 };
    let ground = vec![0.0; (side * side) as usize];
    let mut heights = ground.clone();
    for ((x, y), spans) in spans {
        let top = spans.iter().map(|span| span.high).max().unwrap();
        heights[(y * side + x) as usize] = code.decode(top).unwrap();
    }
    let colours = vec![[90; 3]; ground.len()];
    let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
    let (objects, placed) = (&SharedObjects::default(), &[]);
    let standing = SpanArrays { heights: &ground, colours: &colours, spans, objects, placed, code };
    build_standing(&arrays, &standing, &Metadata::default()).unwrap()
}

#[test]
fn spans_are_read_as_they_were_written() {
    let spans = spans();
    let pages = area(&spans);
    assert!(pages.header().has_spans);
    let report = verify(&pages, &Silent).unwrap();
    assert_eq!(report.problems, []);
    let mut found = BTreeMap::new();

    for (px, py) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let id = PageId { level: 0, px, py };
        assert!(pages.spans(id).unwrap().is_none(), "only bare ground has spans");
        let Some(view) = pages.spans(id.bare()).unwrap() else { continue };
        let Size { width, height } = pages.header().grid.page_size(id).unwrap();

        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let here = view.at(x, y);
            if !here.is_empty() {
                found.insert((px * PAGE_SIDE + x, py * PAGE_SIDE + y), here.to_vec());
            }
        }

        assert_eq!(
            view.blocks().iter().map(|block| block.occupied.count_ones()).sum::<u32>(),
            match (px, py) {
                (0, 0) => 3,
                (1, 1) => 1,
                _ => 0,
            }
        );
    }

    assert_eq!(found, spans);
    // Beside a page on which something stands near the border there is bare ground, too; elsewhere there is none.
    let has = |px, py| pages.has(PageId { level: 0, px, py }.bare());
    assert_eq!([has(0, 0), has(1, 0), has(0, 1), has(1, 1)], [true, true, false, true]);
}

#[test]
fn blocks_bound_their_spans_slopes_and_all() {
    let pages = area(&spans());
    let view = pages.spans(PageId { level: 0, px: 0, py: 0 }.bare()).unwrap().unwrap();
    let block = view.block(4, 7);
    assert_eq!((block.low, block.occupied), (Span::GROUND, 0b11 << (7 * 8 + 3)));
    // Two in one over half a voxel each way: 2 m of 1 cm.
    assert_eq!(block.high, 1000 + 200);
    let hanging = view.block(250, 9);
    assert_eq!((hanging.low, hanging.high), (900 - 200, 1000 + 200));
}

#[test]
fn an_area_without_spans_is_as_it_was() {
    let pages = area(&BTreeMap::new());
    assert!(!pages.header().has_spans);
    assert_eq!(pages.directory().present().count(), pages.directory().len());
}

#[test]
fn every_flipped_bit_of_spans_is_found() {
    let near = spans().into_iter().filter(|((x, _), _)| *x < 40);
    let pages = area_of(40, &near.chain([((39, 39), vec![post(900, [-128, 127])])]).collect());
    let id = PageId { level: 0, px: 0, py: 0 }.bare();
    let stretch = pages.stretch(PagePart::Spans(id));
    assert!(stretch.len() > 200, "{stretch:?}");
    for byte in stretch {
        let mut bytes = pages.bytes().to_vec();
        bytes[byte] ^= 1 << (byte % 8);
        let damaged = MemPages::from_bytes("damaged.hop", &bytes).unwrap();
        assert!(damaged.spans(id).is_err(), "byte {byte}");
        assert!(damaged.page(id).is_ok() && damaged.heights(id).is_ok(), "byte {byte}");
        assert!(!verify(&damaged, &Silent).unwrap().is_sound(), "byte {byte}");
    }
}

#[test]
fn spans_that_contradict_themselves_read_as_nothing_or_are_refused() {
    let size = Size { width: 20, height: 20 };
    let table = SpanTable::new(size, 1.0, |x, y, spans| {
        spans.extend((x == y).then(|| post(10 + x as u16, [1, 1])));
    });
    let mut whole = vec![0; table.bytes()];
    table.encode(&mut whole);
    let aligned = |bytes: &[u8]| AlignedBytes::copy_of(bytes);
    assert_eq!(
        SpansView::new(aligned(&whole).as_slice(), size).unwrap().check(1.0, &SharedObjects::default()),
        None
    );
    let mut refused = 0;

    for byte in 0..whole.len() {
        for bit in 0..8 {
            let mut bytes = whole.clone();
            bytes[byte] ^= 1 << bit;
            let bytes = aligned(&bytes);
            let Ok(view) = SpansView::new(bytes.as_slice(), size) else {
                refused += 1;
                continue;
            };
            // Whatever it says, asking is safe.
            let asked: usize = (0..400).map(|at| view.at(at % 20, at / 20).len()).sum();
            assert!(asked <= 400 * 20, "{asked}");
        }
    }

    assert!(refused > 100, "{refused}");
    for length in 0..whole.len() {
        assert!(length == 0 || SpansView::new(aligned(&whole[..length]).as_slice(), size).is_err());
    }
}

#[test]
fn cuts_that_make_no_sense_are_found() {
    let (wall, none) = (Cut::wall(20, 9), Cut::NONE);
    let size = Size { width: 1, height: 1 };
    let checked = |cuts: [Cut; 3], state: u8| {
        let table = SpanTable::new(size, 1.0, |_, _, spans| {
            spans.push(Span { cuts, state, ..post(10, [0, 0]) });
        });
        let mut bytes = vec![0; table.bytes()];
        table.encode(&mut bytes);
        let bytes = AlignedBytes::copy_of(&bytes);
        SpansView::new(bytes.as_slice(), size).unwrap().check(1.0, &SharedObjects::default())
    };

    let [first, second] = Span::JOINED.map(|bit| Span::OPAQUE | bit);
    for (cuts, state) in [
        ([none; 3], Span::OPAQUE),
        ([Cut::round(5), none, none], Span::OPAQUE),
        ([wall, none, none], first),
        ([wall, Cut::wall(90, 0), none], first | second),
        ([wall, Cut::wall(90, 0), Cut::wall(200, 0)], first),
    ] {
        assert_eq!(checked(cuts, state), None, "{cuts:?}");
    }

    for (cuts, state) in [
        ([none, wall, none], Span::OPAQUE),
        ([wall, none, wall], Span::OPAQUE),
        ([wall, Cut::round(5), none], Span::OPAQUE),
        ([wall, wall, Cut::round(5)], Span::OPAQUE),
        ([Cut::round(5), wall, none], Span::OPAQUE),
        ([none; 3], first),
        ([wall, none, none], second),
    ] {
        assert!(checked(cuts, state).is_some(), "{cuts:?}");
    }
}
