//! Bare ground and what stands on it, stored and read again.

use std::collections::BTreeMap;

use super::*;
use crate::voxel::fixed_header::header_crc;
use crate::voxel::format::header;
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
        facade: Facade::NONE,
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
                found.insert((px * PAGE_SIDE + x, py * PAGE_SIDE + y), here.iter().collect());
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

/// A façade of which no byte is that of another field.
const FACADE: Facade = Facade {
    floor: 0x1122,
    eaves: 0x3344,
    storeys: 5,
    look: 0x61,
    bays: [Bays { facing: 7, width: 80, phase: 9 }, Bays { facing: 71, width: 81, phase: 10 }],
};

#[test]
fn facades_lie_behind_the_spans_of_a_page_that_has_some() {
    let size = Size { width: 8, height: 8 };
    let encoded = |facade: Facade| {
        let table = SpanTable::new(size, 1.0, |x, y, spans| {
            spans.extend((x == 3 && y < 2).then(|| post(10, [0, 0])));
            spans
                .last_mut()
                .into_iter()
                .for_each(|span| span.facade = if y == 1 { facade } else { Facade::NONE });
        });
        let mut bytes = vec![0; table.bytes()];
        table.encode(&mut bytes);
        bytes
    };

    // Head, a block, three numbers, two spans from a multiple of 16 on, and two façades behind them.
    let (plain, with) = (encoded(Facade::NONE), encoded(FACADE));
    let [spans, facades] = [48..88, 96..120];
    assert_eq!(plain[12..16], [0; 4]);
    assert_eq!((&plain[16..96], with[12]), (&with[16..96], 2));
    assert_eq!(plain[spans][..6], [0, 0, 10, 0, 0, 0]);
    assert_eq!(with[facades][12..], [0x22, 0x11, 0x44, 0x33, 5, 0x61, 7, 80, 9, 71, 81, 10]);

    for (bytes, facade) in [(plain, Facade::NONE), (with, FACADE)] {
        let bytes = AlignedBytes::copy_of(&bytes);
        let view = SpansView::new(bytes.as_slice(), size).unwrap();
        let found: Vec<Facade> = view.all().iter().map(|span| span.facade).collect();
        assert_eq!(found, [Facade::NONE, facade]);
        let table = view.to_table();
        assert_eq!(table.spans(), view.all());
    }
}

#[test]
fn spans_of_version_8_are_read_without_facades() {
    let spans = spans();
    let pages = area(&spans);
    let mut bytes = pages.bytes().to_vec();
    header::VERSION.put(&mut bytes, &8_u32.to_le_bytes());
    let crc = header_crc(&bytes[..header::SIZE]);
    header::HEADER_CRC.put(&mut bytes, &crc.to_le_bytes());
    let old = MemPages::from_bytes("old.hop", &bytes).unwrap();

    assert_eq!(old.header().version, 8);
    let id = PageId { level: 0, px: 0, py: 0 }.bare();
    let here = |pages: &MemPages| pages.spans(id).unwrap().unwrap().all().iter().collect::<Vec<_>>();
    assert_eq!((here(&old), here(&old).len()), (here(&pages), 4));
    assert!(here(&old).iter().all(|span| span.facade.is_none()));
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
