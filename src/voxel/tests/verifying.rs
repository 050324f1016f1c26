//! What [`verify`] finds, one kind of damage at a time.

use std::sync::Mutex;

use super::*;
use hedgehop_base::progress::{Observer, Silent};

/// Whether `change` to page `id` of a sound database, written with right hashes, is found in the words
/// `expected`.
fn assert_found(id: PageId, change: &dyn Fn(&mut PageBuffer), expected: &str) {
    let sound = Terrain::new(600, 20, 0.1, 21).pages();
    assert_eq!(verify(&sound, &Silent).unwrap().problems, []);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("changed.hop");
    let header = sound.header();
    let mut writer = PageWriter::create(&path, header.grid, header.heights, false).unwrap();
    for other in sound.directory().ids() {
        let mut page = sound.whole_page(other).unwrap().unwrap().to_buffer();
        if other == id {
            change(&mut page);
        }
        writer.append(&page.encode(other)).unwrap();
    }
    writer.finish(&header.metadata, header.height_range).unwrap();
    let changed = MemPages::from_bytes(&path, &std::fs::read(&path).unwrap()).unwrap();
    let report = verify(&changed, &Silent).unwrap();
    let found = |problem: &Problem| problem.page == Some(id) && problem.what.contains(expected);
    assert!(!report.is_sound() && report.problems.iter().any(found), "{expected}: {:?}", report.problems);
}

const FINEST: PageId = PageId { level: 0, px: 1, py: 0 };
const COARSER: PageId = PageId { level: 1, px: 0, py: 0 };

#[test]
fn damage_that_checksums_do_not_show_is_found() {
    assert_found(FINEST, &|page| page.heights[0] ^= 2, "apron");
    assert_found(FINEST, &|page| page.colours[3][1] ^= 0x40, "apron");
    assert_found(COARSER, &|page| page.heights[162 * 8 + 75] += 3, "heights are not what level 1 gives");
    assert_found(COARSER, &|page| page.low[70] += 1, "lower bounds are not what level 1 gives");
    assert_found(COARSER, &|page| page.high[70] -= 1, "upper bounds are not what level 1 gives");
    assert_found(COARSER, &|page| page.high[70] = 0, "contradict each other");
    assert_found(
        COARSER,
        &|page| page.colours[162 * 7 + 25][0] ^= 0x40,
        "colours are not what level 1 gives",
    );
    assert_found(
        COARSER,
        &|page| page.relief[160 * 6 + 20].spread[2] ^= 2,
        "slopes are not what level 1 gives",
    );
    assert_found(COARSER, &|page| page.attributes[9].material ^= 1, "attributes are not what level 1 gives");
}

#[test]
fn codes_outside_the_range_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("narrow.hop");
    let sound = Terrain::new(10, 10, 0.0, 4).pages();
    let header = sound.header();
    let mut writer = PageWriter::create(&path, header.grid, header.heights, false).unwrap();
    for id in sound.directory().ids() {
        writer.append(&sound.whole_page(id).unwrap().unwrap().to_buffer().encode(id)).unwrap();
    }
    writer.finish(&header.metadata, HeightRange { low: 100.0, high: 101.0 }).unwrap();
    let report =
        verify(&MemPages::from_bytes(&path, &std::fs::read(&path).unwrap()).unwrap(), &Silent).unwrap();
    assert!(report.problems.iter().all(|problem| problem.what.contains("header's range")));
    assert!(!report.is_sound());
}

#[test]
fn damage_of_bytes_is_listed_page_by_page() {
    let sound = Terrain::new(600, 300, 0.0, 8).pages();
    let mut bytes = sound.bytes().to_vec();
    let mut damaged = Vec::new();
    for (id, entry) in sound.directory().present().filter(|(id, _)| id.level == 0 && id.px > 0) {
        bytes[entry.offset as usize + 64] ^= 1;
        damaged.push(Problem { page: Some(id), byte: entry.offset, what: "wrong checksum".into() });
    }
    bytes[300] = 1;
    damaged.push(Problem { page: None, byte: 300, what: "a gap between pages that is not zero".into() });
    let report = verify(&MemPages::from_bytes("damaged.hop", &bytes).unwrap(), &Silent).unwrap();
    assert_eq!(report.problems, damaged);
    assert_eq!((report.pages, report.absent), (sound.directory().len() as u64, 0));
}

/// Counts, and stops when told.
struct Counter {
    advanced: Mutex<u64>,
    stop: bool,
}

impl Observer for Counter {
    fn advance(&self, count: u64) {
        *self.advanced.lock().unwrap() += count;
    }
    fn cancelled(&self) -> bool {
        self.stop
    }
}

#[test]
fn progress_is_told_and_interruption_obeyed() {
    let pages = Terrain::new(600, 20, 0.0, 2).pages();
    let observer = Counter { advanced: Mutex::new(0), stop: false };
    verify(&pages, &observer).unwrap();
    assert_eq!(*observer.advanced.lock().unwrap(), pages.directory().len() as u64);
    assert!(matches!(
        verify(&pages, &Counter { stop: true, ..observer }),
        Err(hedgehop_base::Error::Interrupted(_))
    ));
}
