//! Parts of pages that memory lets go of, and what they share with those that stay.

use std::ops::Range;
use std::sync::{Arc, Mutex};

use super::*;
use crate::voxel::{FileBytes, PageStore};

/// What is mapped at once, bytes.
const MAPPED: usize = 4096;

#[derive(Debug)]
struct Watched {
    bytes: AlignedBytes,
    forgotten: Arc<Mutex<Vec<Range<usize>>>>,
}

impl FileBytes for Watched {
    fn bytes(&self) -> &[u8] {
        self.bytes.as_slice()
    }

    fn forget(&self, range: Range<usize>) {
        self.forgotten.lock().unwrap().push(range);
    }
}

#[test]
fn parts_go_but_for_what_they_share_with_parts_that_stay() {
    let pages = Terrain::new(300, 290, 0.0, 7).pages();
    let forgotten = Arc::default();
    let bytes = Watched { bytes: AlignedBytes::copy_of(pages.bytes()), forgotten: Arc::clone(&forgotten) };
    let store = PageStore::new("area.hop", bytes).unwrap();

    let forget = |part: PagePart, stays: &[PagePart]| {
        store.forget(part, |other| stays.contains(&other));
        let all: Vec<Range<usize>> = std::mem::take(&mut *forgotten.lock().unwrap());
        assert!(all.len() <= 1);
        all.first().cloned().unwrap_or(0..0)
    };

    for (id, _) in store.directory().present() {
        let extent = store.extent(id).unwrap();
        for part in PagePart::all(id) {
            let own = store.stretch(part);
            let alone = forget(part, &[]);
            if own.is_empty() {
                assert!(alone.is_empty());
                continue;
            }

            assert!(alone.start <= own.start && own.end <= alone.end, "{part:?}: {alone:?} of {own:?}");
            assert!(extent.start <= alone.start && alone.end <= extent.end, "{part:?}");
            assert!(own.start - alone.start < MAPPED && alone.end - own.end < MAPPED, "{part:?}");
            for other in PagePart::all(id).filter(|other| *other != part) {
                let beside = forget(part, &[other]);
                let stays = store.stretch(other);
                let mapped = stays.start / MAPPED * MAPPED..stays.end.next_multiple_of(MAPPED);
                let is_apart = beside.end <= mapped.start || mapped.end <= beside.start;
                assert!(stays.is_empty() || beside.is_empty() || is_apart, "{part:?} beside {other:?}");
            }
        }
    }
}
