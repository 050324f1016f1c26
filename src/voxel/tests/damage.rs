//! Damaged databases: an error or the same content, never a panic.

use std::path::Path;

use bytemuck::cast_slice;

use super::super::directory::CRC;
use super::super::fixed_header::header_crc;
use super::super::format::{Field, VERSION, entry, header as at, page};
use super::*;

/// A whole database of four levels and less than 22 KB, and its bytes.
fn small() -> (MemPages, Vec<u8>) {
    let pages = Terrain::new(20, 7, 0.1, 77).pages();
    let bytes = pages.bytes().to_vec();
    assert!(bytes.len() < 22_000 && pages.header().level_count == 4);
    (pages, bytes)
}

/// Everything that can be read from a database.
fn content(bytes: &[u8]) -> hedgehop_base::Result<(Header, Vec<Option<PageBuffer>>)> {
    let pages = MemPages::from_bytes("damaged.hop", bytes)?;
    let read = |id| Ok(pages.whole_page(id)?.map(|view| view.to_buffer()));
    let read = pages.directory().ids().map(read).collect::<hedgehop_base::Result<_>>()?;
    Ok((pages.header().clone(), read))
}

/// Whether two pages are the same, faster than element by element.
fn is_same(one: &PageView<'_>, other: &PageView<'_>) -> bool {
    let PageView { width, height, heights, low, high, colours, relief, attributes, spans } = *one;
    (width, height, heights, low, high) == (other.width, other.height, other.heights, other.low, other.high)
        && cast_slice::<_, u8>(colours) == cast_slice::<_, u8>(other.colours)
        && cast_slice::<_, u8>(relief) == cast_slice::<_, u8>(other.relief)
        && cast_slice::<_, u8>(attributes) == cast_slice::<_, u8>(other.attributes)
        && spans == other.spans
}

/// Bytes of a file, borrowed.
struct Lent<'a>(&'a AlignedBytes);

impl FileBytes for Lent<'_> {
    fn bytes(&self) -> &[u8] {
        self.0.as_slice()
    }
}

/// Whether a header and pages, one of them before all others, are all that can be read.
fn reads_as(
    (header, sound): (&Header, &[(PageId, Option<PageView<'_>>)]),
    bytes: &AlignedBytes,
    first: PageId,
) -> hedgehop_base::Result<bool> {
    let pages = PageStore::new("damaged.hop", Lent(bytes))?;
    pages.whole_page(first)?;
    let mut reads_as =
        pages.header() == header && pages.directory().ids().eq(sound.iter().map(|(id, _)| *id));
    for (id, page) in sound {
        reads_as &= match (pages.whole_page(*id)?, page) {
            (Some(found), Some(page)) => is_same(&found, page),
            (found, page) => found.is_none() && page.is_none(),
        };
    }
    Ok(reads_as)
}

#[test]
fn every_prefix_is_refused() {
    let (_, bytes) = small();
    for length in 0..bytes.len() {
        let error = content(&bytes[..length]).expect_err("a prefix opened").to_string();
        assert!(error.contains("build it again"), "{length} bytes: {error}");
    }
}

#[test]
fn every_flipped_byte_is_refused_or_changes_nothing() {
    let (sound, bytes) = small();
    let mut bytes = AlignedBytes::copy_of(&bytes);
    let length = bytes.as_slice().len();
    let directory = sound.directory();
    let extents: Vec<_> = directory
        .present()
        .map(|(id, entry)| (id, entry.offset..entry.offset + u64::from(entry.length)))
        .collect();
    let pages: Vec<_> = directory.ids().map(|id| (id, sound.whole_page(id).unwrap())).collect();
    let mut harmless = 0;

    for position in 0..length {
        // All others are sound: read last, they need not be read where this one is refused.
        let holder = extents.iter().find(|(_, extent)| extent.contains(&(position as u64)));
        let first = holder.map_or(extents[0].0, |(id, _)| *id);
        for flip in 1..=0xff {
            bytes.as_mut_slice()[position] ^= flip;
            match reads_as((sound.header(), &pages), &bytes, first) {
                Ok(is_same) => {
                    harmless += 1;
                    assert!(is_same, "byte {position} ^ {flip:#x} changed what is read");
                }
                Err(error) => assert!(error.to_string().starts_with("damaged.hop: "), "{error}"),
            }
            bytes.as_mut_slice()[position] ^= flip;
        }
    }

    assert!(harmless < 255 * length, "something must have been refused");
}

/// Makes all checksums right again, as far as the file says where things are, of a grid as `sound` has it.
fn reseal(bytes: &mut [u8], sound: &Directory) {
    let range = |offset: Field, length: Field, record: &[u8], limit: usize| {
        let start = usize::try_from(offset.u64(record)).unwrap_or(limit).min(limit);
        let length = if length.size == 4 { u64::from(length.u32(record)) } else { length.u64(record) };
        start
            ..usize::try_from(length)
                .ok()
                .and_then(|length| start.checked_add(length))
                .map_or(limit, |end| end.min(limit))
    };

    let limit = bytes.len();
    let directory = range(at::DIRECTORY_OFFSET, at::DIRECTORY_LENGTH, bytes, limit);
    for start in directory.clone().step_by(entry::SIZE) {
        let Some(record) = bytes.get(start..start + entry::SIZE) else { break };
        let page = range(entry::OFFSET, entry::LENGTH, record, limit);
        let index = (start - directory.start) / entry::SIZE;
        let Some((id, (.., size))) = sound.ids().nth(index).and_then(|id| Some((id, sound.locate(id)?)))
        else {
            break;
        };

        for (part, field) in PagePart::all(id).map(|part| (part, CRC[part.number()])) {
            let at = part.range(size, [page.len(), 0]);
            let bytes_of_part = bytes.get(page.start + at.start..page.start + at.end).unwrap_or_default();
            let crc = crc32fast::hash(bytes_of_part);
            field.put(&mut bytes[start..start + entry::SIZE], &crc.to_le_bytes());
        }
    }

    let crc = crc32fast::hash(&bytes[directory]);
    at::DIRECTORY_CRC.put(bytes, &crc.to_le_bytes());
    let crc = crc32fast::hash(&bytes[range(at::METADATA_OFFSET, at::METADATA_LENGTH, bytes, limit)]);
    at::METADATA_CRC.put(bytes, &crc.to_le_bytes());
    let crc = header_crc(bytes);
    at::HEADER_CRC.put(bytes, &crc.to_le_bytes());
}

/// Values that break arithmetic, at every position of everything that steers reading, with right checksums.
#[test]
fn hostile_numbers_with_right_checksums_never_panic() {
    let (pages, bytes) = small();
    let directory_start = at::DIRECTORY_OFFSET.u64(&bytes) as usize;
    let page_starts: Vec<_> = pages.directory().present().map(|(_, entry)| entry.offset as usize).collect();
    let steering = (0..at::SIZE)
        .chain(directory_start..bytes.len())
        .chain(page_starts.iter().flat_map(|&start| start..start + page::SIZE));
    let values: [&[u8]; 7] =
        [&[0], &[0xff], &[0x7f], &[0; 4], &[0xff; 4], &[0xff; 8], &[0, 0, 0, 0, 0, 0, 0xf0, 0x7f]];
    let (mut refused, mut read) = (0, 0);

    for position in steering {
        for value in values {
            let mut hostile = bytes.clone();
            let end = (position + value.len()).min(bytes.len());
            hostile[position..end].copy_from_slice(&value[..end - position]);
            reseal(&mut hostile, pages.directory());

            match content(&hostile) {
                Ok((header, _)) => {
                    read += 1;
                    let sound = header.grid.check().is_ok() && header.heights.check().is_ok();
                    assert!(sound, "byte {position}: {:?}", header.grid);
                    let store = MemPages::from_bytes("hostile.hop", &hostile).unwrap();
                    verify(&store, &hedgehop_base::progress::Silent).unwrap();
                }
                Err(_) => refused += 1,
            }
        }
    }

    assert!(refused > 1000 && read > 100, "refused {refused}, read {read}");
}

#[test]
fn refusals_name_file_place_and_remedy() {
    let (pages, bytes) = small();
    let refusal = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut changed = bytes.clone();
        change(&mut changed);
        content(&changed).unwrap_err().to_string()
    };
    let newer = format!(
        "newer version of hedgehop: format {}, and this one reads 7 to {VERSION}; update",
        VERSION + 1
    );
    let page_start = pages.directory().present().last().unwrap().1.offset as usize;

    for (error, expected) in [
        (refusal(&|b| b.clear()), "damaged.hop: the file is empty; the build was killed"),
        (refusal(&|b| b[..4096].fill(0)), "it has no header yet; the build was killed"),
        (refusal(&|b| b[0] = b'P'), "not a hedgehop database (byte 0); make one with `hedgehop build"),
        (refusal(&|b| b[at::VERSION.offset] = VERSION as u8 + 1), newer.as_str()),
        (refusal(&|b| b.truncate(9000)), "truncated at byte 9000 of "),
        (refusal(&|b| b.push(0)), "more bytes follow its end"),
        (refusal(&|b| b[at::NX.offset] ^= 1), "wrong checksum of the header at byte 12; the file is damaged"),
        (refusal(&|b| *b.last_mut().unwrap() ^= 1), "wrong checksum of the metadata at byte "),
        (refusal(&|b| b[page_start + 70] ^= 1), "page (0, 0) of level 64 at byte "),
    ] {
        assert!(error.contains(expected), "{error}\n  does not say: {expected}");
    }
}

#[test]
fn a_bad_page_is_refused_at_every_touch_and_others_are_read() {
    let (pages, mut bytes) = small();
    let bad = PageId { level: 0, px: 0, py: 0 };
    bytes[pages.directory().get(bad).unwrap().offset as usize + 100] ^= 4;
    let pages = MemPages::from_bytes(Path::new("damaged.hop"), &bytes).unwrap();
    for _ in 0..3 {
        assert!(pages.page(bad).is_err());
        assert!(pages.page(PageId { level: 1, ..bad }).unwrap().is_some());
    }
    assert_eq!(pages.touched().pages, 1);
}

/// The bytes with a bit of each of these parts turned.
fn damaged(pages: &MemPages, parts: &[PagePart]) -> Vec<u8> {
    let mut bytes = pages.bytes().to_vec();
    parts.iter().for_each(|part| bytes[pages.stretch(*part).end - 1] ^= 1);
    bytes
}

#[test]
fn a_damaged_part_is_refused_and_the_others_are_read() {
    let (pages, _) = small();
    for id in pages.directory().ids() {
        for bad in PagePart::all(id) {
            let store = MemPages::from_bytes("damaged.hop", &damaged(&pages, &[bad])).unwrap();
            assert_eq!(store.heights(id).is_err(), bad == PagePart::Heights(id), "{bad:?}");
            assert_eq!(store.bounds(id).is_err(), bad == PagePart::Bounds(id), "{bad:?}");
            assert_eq!(store.page(id).is_err(), bad != PagePart::Bounds(id), "{bad:?}");
            assert!(store.whole_page(id).is_err(), "{bad:?}");
            for part in PagePart::all(id) {
                let expected = if part == bad { None } else { Some(pages.part_bytes(part)) };
                assert_eq!(store.load(part).ok(), expected, "{part:?} beside {bad:?}");
            }
            let good: u64 =
                PagePart::all(id).filter(|part| *part != bad).map(|part| pages.part_bytes(part)).sum();
            assert_eq!(store.touched(), Touched { pages: 1, bytes: good }, "{bad:?}");
        }
    }
}

#[test]
fn a_page_is_left_out_whichever_of_its_parts_is_damaged_and_whichever_is_asked_for() {
    let (pages, _) = small();
    let id = PageId { level: 1, px: 0, py: 0 };
    for bad in PagePart::all(id) {
        let bytes = damaged(&pages, &[bad]);
        let ask: [&dyn Fn(&MemPages) -> bool; 3] = [
            &|store| store.heights(id).unwrap().is_none(),
            &|store| store.bounds(id).unwrap().is_none(),
            &|store| store.page(id).unwrap().is_none(),
        ];
        for first in ask {
            let coarser = Trust { verify: Verify::FirstTouch, damaged: Damaged::Coarser };
            let store = MemPages::from_bytes("damaged.hop", &bytes).unwrap().trusting(coarser);
            assert!(store.has(id) && !store.is_damaged(id));
            assert_eq!(store.needed_for(bad), store.extent(id).unwrap(), "all of it is checked at once");
            assert!(first(&store) && ask.iter().all(|ask| ask(&store)), "{bad:?}");
            assert!(!store.has(id) && store.is_damaged(id));
        }
    }
}
