//! Pages without any surface, which have no bytes.

use std::path::Path;

use super::super::fixed_header::{FixedHeader, header_crc};
use super::super::format::{Field, entry, header as at};
use super::super::version_7::in_full;
use super::*;
use hedgehop_base::Size;
use hedgehop_base::progress::Silent;

/// Random ground in two corners of an area, 6 x 4 pages of the finest level.
fn apart() -> MemPages {
    let mut terrain = Terrain::new(1400, 900, 0.02, 5);
    let void = Attributes { source: 3, material: 2, flags: Attributes::VOID };
    for (index, height) in terrain.heights.iter_mut().enumerate() {
        let (x, y) = (index % 1400, index / 1400);
        if !(x < 200 && y < 240 || x >= 1100 && y >= 700) {
            *height = f64::NAN;
            terrain.colours[index] = [0; 3];
            terrain.attributes[index] = void;
        }
    }
    terrain.pages()
}

/// Pages of the finest level that have bytes, of [`apart`].
fn has_bytes(id: PageId) -> bool {
    (id.px == 0 && id.py == 0) || (id.px >= 4 && id.py >= 2)
}

#[test]
fn readers_see_what_they_see_in_full() {
    let pages = apart();
    let full = in_full(&pages).unwrap();
    assert_eq!(full.header().version, 7);
    assert!(full.directory().present().all(|(_, entry)| entry.empty().is_none()));
    let directory = pages.directory();
    let finest = directory.present().filter(|(id, _)| id.level == 0);
    let with_bytes: Vec<_> = finest.filter(|(_, entry)| entry.empty().is_none()).map(|(id, _)| id).collect();
    assert!(with_bytes.iter().all(|id| has_bytes(*id)) && with_bytes.len() >= 3, "{with_bytes:?}");
    let empty = directory.len() - directory.present().filter(|(_, entry)| entry.length > 0).count();
    assert_eq!((directory.len(), empty), (24 + 2 + 1 + 1, 24 - 5));
    assert!(pages.bytes().len() < full.bytes().len() / 2);

    for id in directory.ids() {
        let [here, there] = [&pages, &full].map(|pages| pages.whole_page(id).unwrap().unwrap());
        assert!(here.to_buffer() == there.to_buffer(), "{id}");
        assert_eq!(here.attributes, there.attributes, "{id}: one value, or each its own");
        let [here, there] = [&pages, &full].map(|pages| pages.page(id).unwrap().unwrap());
        assert!(here.to_buffer() == there.to_buffer(), "{id}: posts");
        let [here, there] = [&pages, &full].map(|pages| pages.heights(id).unwrap().unwrap());
        assert_eq!((here.width, here.heights), (there.width, there.heights), "{id}");
        let [here, there] = [&pages, &full].map(|pages| pages.bounds(id).unwrap().unwrap());
        assert_eq!((here.width, here.low, here.high), (there.width, there.low, there.high), "{id}");
        assert!(pages.has(id) && !pages.is_damaged(id) && pages.spans(id).unwrap().is_none());
    }

    for (pages, empty) in [(&pages, empty), (&full, 0)] {
        let report = verify(pages, &Silent).unwrap();
        assert_eq!((report.problems, report.absent), (Vec::new(), 0));
        assert_eq!((report.pages, report.empty), (28, empty as u64));
    }

    let touched = pages.touched();
    assert_eq!(touched.pages, 28 - empty as u64, "what has no bytes is not touched");

    // A reader that has damaged pages left out sees the same.
    let trust = Trust { damaged: Damaged::Coarser, ..Trust::default() };
    let lenient = MemPages::from_bytes("a", pages.bytes()).unwrap().trusting(trust);
    let id = PageId { level: 0, px: 2, py: 1 };
    assert!(lenient.page(id).unwrap().is_some() && lenient.damaged().is_empty());
    assert_eq!(lenient.load(PagePart::Heights(id)).unwrap(), 0);
    assert!(lenient.extent(id).is_none() && lenient.needed_for(PagePart::Paint(id)).is_empty());
}

#[test]
fn what_voxels_are_tells_databases_apart() {
    let flat = |attributes: Attributes| {
        let terrain = Terrain::new(300, 20, 0.0, 1);
        let nothing = vec![f64::NAN; terrain.heights.len()];
        let attributes = vec![attributes; nothing.len()];
        let (grid, metadata) = (terrain.grid, Metadata::default());
        build_in_memory(grid, &nothing, &terrain.colours, Some(&attributes), &metadata).unwrap()
    };

    let numbered = Attributes { source: 259, material: 7, flags: 1 };
    let all = [Attributes::default(), Attributes { flags: 3, ..Attributes::default() }, numbered];
    let databases = all.map(flat);
    for (pages, attributes) in databases.iter().zip(all) {
        // No page at all has bytes, not even of the coarsest level.
        assert!(pages.directory().present().all(|(_, entry)| entry.empty() == Some(&attributes)));
        assert_eq!(pages.directory().present().count(), pages.directory().len());
        assert!(verify(pages, &Silent).unwrap().is_sound());
        let view = pages.whole_page(PageId { level: 3, px: 0, py: 0 }).unwrap().unwrap();
        assert_eq!(view.attributes, [attributes]);
    }

    let hashes = databases.each_ref().map(|pages| pages.header().content_hash);
    assert!(hashes[0] != hashes[1] && hashes[1] != hashes[2] && hashes[0] != hashes[2]);

    // Flags that nobody stores, bare ground, voxels that differ, and what finer levels hold need bytes.
    let id = PageId { level: 1, px: 0, py: 0 };
    let size = Size { width: 30, height: 20 };
    let mut page = PageBuffer::empty(id, size, Attributes::default());
    assert!(page.encode(id).bytes.is_empty());
    let finest = PageId { level: 0, ..id };
    assert!(PageBuffer::empty(finest, size, all[0]).entry_alone(finest.bare()).is_none());
    page.high[7] = 1;
    assert!(!page.encode(id).bytes.is_empty());
    page.high[7] = 0;
    page.attributes[3].source = 1;
    assert!(!page.encode(id).bytes.is_empty());
    page.attributes.fill(Attributes { flags: Attributes::STAND_IN, ..Attributes::default() });
    assert!(!page.encode(id).bytes.is_empty());
}

/// A database whose directory's record of page `id` was changed, with right checksums.
fn forged(pages: &MemPages, id: PageId, change: impl Fn(&mut [u8])) -> Vec<u8> {
    let mut bytes = pages.bytes().to_vec();
    let start = at::DIRECTORY_OFFSET.u64(&bytes) as usize;
    let record = start + pages.directory().index(id).unwrap() * entry::SIZE;
    change(&mut bytes[record..record + entry::SIZE]);
    let end = start + at::DIRECTORY_LENGTH.u64(&bytes) as usize;
    let crc = crc32fast::hash(&bytes[start..end]);
    at::DIRECTORY_CRC.put(&mut bytes, &crc.to_le_bytes());
    seal(&mut bytes);
    bytes
}

fn seal(bytes: &mut [u8]) {
    let crc = header_crc(bytes);
    at::HEADER_CRC.put(bytes, &crc.to_le_bytes());
}

#[test]
fn forged_entries_are_refused_or_found() {
    let pages = apart();
    let (empty, stored) = (PageId { level: 0, px: 2, py: 1 }, PageId { level: 0, px: 0, py: 0 });
    let refused = |id: PageId, change: &dyn Fn(&mut [u8])| {
        let error = MemPages::from_bytes("forged.hop", &forged(&pages, id, change)).unwrap_err().to_string();
        assert!(error.contains("directory, page") && error.contains("length"), "{error}");
    };
    let put = |field: Field, value: u32| move |record: &mut [u8]| field.put(record, &value.to_le_bytes());
    refused(empty, &|record| entry::OFFSET.put(record, &4096_u64.to_le_bytes()));
    for field in [entry::SPANS, entry::HEIGHTS_CRC, entry::SECOND_CRC] {
        refused(empty, &put(field, 1));
    }
    for flags in [4_u32, 0x80] {
        refused(empty, &put(entry::PAINT_CRC, flags << 24));
    }

    refused(empty, &put(entry::LENGTH, 1));
    refused(stored, &put(entry::LENGTH, 0));

    // What can be is read without harm, and told by a check of everything.
    let found = |id: PageId, change: &dyn Fn(&mut [u8])| {
        let forged = MemPages::from_bytes("forged.hop", &forged(&pages, id, change)).unwrap();
        let _ = forged.whole_page(id).unwrap();
        let problems = verify(&forged, &Silent).unwrap().problems;
        problems.into_iter().map(|problem| (problem.page, problem.what)).collect::<Vec<_>>()
    };
    let hash = (Some(empty), "its hash is not that of the directory".to_owned());
    assert!(found(empty, &|record| record[entry::HASH.offset] ^= 1).contains(&hash));
    assert!(found(empty, &put(entry::PAINT_CRC, 1)).contains(&hash));

    // A page with a surface that is said to have none.
    let lost = found(stored, &|record| {
        let alone = PageEntry::of_empty(Attributes::default());
        record.fill(0);
        entry::PAINT_CRC.put(record, &alone.crc[2].to_le_bytes());
        entry::HASH.put(record, &alone.hash);
    });
    let coarser = PageId { level: 1, ..stored };
    assert!(
        lost.iter().any(|(page, what)| *page == Some(coarser) && what.contains("level 1 gives")),
        "{lost:?}"
    );

    // Bare ground has bytes, whatever it is.
    assert!(!PageEntry::of_empty(Attributes::default()).can_be_empty(stored.bare()));
    assert!(PageEntry::of_empty(Attributes::default()).can_be_empty(stored));
}

#[test]
fn files_of_version_7_have_no_such_entries() {
    let pages = apart();
    let mut bytes = pages.bytes().to_vec();
    at::VERSION.put(&mut bytes, &7_u32.to_le_bytes());
    seal(&mut bytes);
    let error = MemPages::from_bytes("old.hop", &bytes).unwrap_err().to_string();
    assert!(error.contains("no page can lie at byte 0, length 0"), "{error}");
    // The version is not to be mistaken for another one.
    at::VERSION.put(&mut bytes, &8_u32.to_le_bytes());
    let error = MemPages::from_bytes("old.hop", &bytes).unwrap_err().to_string();
    assert!(error.contains("wrong checksum of the header"), "{error}");
    at::VERSION.put(&mut bytes, &6_u32.to_le_bytes());
    let error = MemPages::from_bytes("old.hop", &bytes).unwrap_err().to_string();
    assert!(error.contains("format 6, and this one reads 7 to 9"), "{error}");
}

#[test]
fn pages_are_read_back_and_taken_over() {
    let pages = apart();
    let folder = tempfile::tempdir().unwrap();
    let [one, other] = ["one.hop", "other.hop"].map(|name| folder.path().join(name));
    std::fs::write(&one, pages.bytes()).unwrap();
    let file = EarlierFile::open(&one).unwrap();
    let Header { grid, heights, metadata, height_range, .. } = pages.header();
    let mut writer = PageWriter::create(&other, *grid, *heights, false).unwrap();
    let (readback, mut scratch) = (writer.readback(), Vec::new());

    for (id, entry) in pages.directory().present() {
        let page = file.page(grid, id, entry, &mut scratch).expect("a page as it was written");
        writer.append_earlier(&page).unwrap();
        let back = readback.page(id).unwrap().unwrap();
        assert!(back == pages.whole_page(id).unwrap().unwrap().to_buffer(), "{id}");
        assert!(writer.append_earlier(&page).is_err(), "{id}: twice");
    }

    writer.finish(metadata, *height_range).unwrap();
    assert!(std::fs::read(&other).unwrap() == pages.bytes());

    // Notes of steps may be damaged.
    let id = PageId { level: 0, px: 2, py: 1 };
    let entry = *pages.directory().get(id).unwrap();
    for wrong in [
        PageEntry { hash: [1; 16], ..entry },
        PageEntry { offset: 64, ..entry },
        PageEntry { crc: [0, 0, 0x0400_0000], ..entry },
        PageEntry::default(),
    ] {
        assert!(file.page(grid, id, &wrong, &mut scratch).is_none(), "{wrong:?}");
    }

    assert!(file.page(grid, id.bare(), &entry, &mut scratch).is_none());
    let path = Path::new("a.hop");
    assert!(FixedHeader::decode(path, pages.bytes()).unwrap().version == crate::voxel::format::VERSION);
}
