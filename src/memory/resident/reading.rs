//! Reading of expected pages, in the order of need and in long stretches.

use super::{Expected, MIB, ResidentPages};
use crate::voxel::{PageNeeds, PagePart};

/// Bytes that the system is asked for at once: so many that the disk reads long stretches, and so few that what is needed first
/// comes first.
const ANNOUNCED: usize = 24 * MIB as usize;

/// Pages of a database begin at multiples of this in their file.
const ALIGNMENT: usize = 4096;

impl ResidentPages {
    /// Brings parts into memory that were expected, in order.
    pub(in crate::memory) fn read(&self, expected: &[Expected]) {
        let mut bytes = 0;
        let mut latest = 0..0;
        let batches = expected.chunk_by(|(part, _), _| {
            // Of a page that may be left out all is checked at once, and its parts follow one another.
            let needed = self.file.store().needed_for(*part);
            bytes += if needed == latest { 0 } else { needed.len() };
            latest = needed;
            let goes_on = bytes < ANNOUNCED;
            bytes = if goes_on { bytes } else { 0 };
            goes_on
        });

        let mut batches = batches.peekable();
        if let Some(first) = batches.peek() {
            self.announce(first);
        }

        while let Some(batch) = batches.next() {
            // The disk goes on while checksums are taken.
            if let Some(next) = batches.peek() {
                self.announce(next);
            }
            for &(part, index) in batch {
                // Whoever needs a damaged page is told so when it is touched.
                let _ = self.fetch(part, index);
            }
        }
    }

    /// Parts of a frame's needs that are not on this machine; without paint, if that is left out.
    fn missing(&self, needs: &PageNeeds, leaves_paint: bool) -> Vec<Expected> {
        let store = self.file.store();
        let is_meant = |part: &&PagePart| !(leaves_paint && matches!(part, PagePart::Paint(_)));
        let parts = needs.parts.iter().filter(is_meant);
        let stored = parts.filter_map(|part| Some((*part, self.index(*part)?)));
        stored.filter(|(part, _)| !store.is_filled(store.needed_for(*part))).collect()
    }

    /// Whether what a frame needs can be read without waiting for another machine.
    pub(in crate::memory) fn is_at_hand_for(&self, needs: &PageNeeds, leaves_paint: bool) -> bool {
        self.missing(needs, leaves_paint).is_empty()
    }

    /// Announces what must come from another machine for a frame.
    pub(in crate::memory) fn announce_missing(&self, needs: &PageNeeds, leaves_paint: bool) {
        self.announce(&self.missing(needs, leaves_paint));
    }

    /// Says what will be read, in stretches as long as they lie in the file.
    pub(super) fn announce(&self, parts: &[Expected]) {
        let store = self.file.store();
        let needed = parts.iter().map(|(part, _)| store.needed_for(*part));
        let mut extents: Vec<_> = needed.filter(|extent| !extent.is_empty()).collect();
        extents.sort_unstable_by_key(|extent| extent.start);
        let mut run: Option<std::ops::Range<usize>> = None;

        for extent in extents {
            run = match run.take() {
                Some(run) if extent.start <= run.end.next_multiple_of(ALIGNMENT) => {
                    Some(run.start..extent.end.max(run.end))
                }
                other => {
                    if let Some(run) = other {
                        store.announce(run);
                    }
                    Some(extent)
                }
            };
        }

        if let Some(run) = run {
            store.announce(run);
        }
    }
}
