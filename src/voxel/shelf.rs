//! Pages in the order in which they lie in the file: along a space-filling curve, so that what is near on the ground is near
//! on the disk.
//!
//! ```text
//! pages are made row by row, as rasters are stored ──▶ a band of eight rows, set aside ──▶ appended block by block:
//!
//!   north  +---------+---------+----        in each block of 8 × 8 pages Hilbert's curve, from the south-west to the
//!          | block 0 | block 1 | …          south-east, so that the next block goes on where it ends
//!          +---------+---------+----
//!          | …                              the next band
//! ```
//!
//! A flight that crosses the area reads some tens of pages at a stretch (Hilbert, "Über die stetige Abbildung einer Linie auf ein
//! Flächenstück", 1891). To make pages in that order instead would have rasters of long strips decoded again for every block.
//! What is set aside lies in a file without a name: memory stays bounded.

use std::fs::File;

use super::assembly::Storage;
use super::{EncodedPage, PageId, PagePart, PageWriter};
use crate::error::Result;

/// Pages along the side of a block, a power of two.
const SIDE: u32 = 8;

/// A page that was set aside.
#[derive(Debug)]
struct Kept {
    id: PageId,
    offset: u64,
    length: usize,
    spans: u32,
    crc: [u32; PagePart::COUNT],
    hash: [u8; 16],
}

/// Takes pages of one level after the other, rows from the north, and appends them along the curve.
#[derive(Debug)]
pub struct Shelf<'w> {
    writer: &'w mut PageWriter,
    aside: File,
    end: u64,
    kept: Vec<Kept>,
}

impl<'w> Shelf<'w> {
    /// Appends to `writer`, setting pages aside beside its target.
    pub fn new(writer: &'w mut PageWriter) -> Result<Self> {
        let aside = writer.file_aside()?;
        Ok(Self { writer, aside, end: 0, kept: Vec::new() })
    }

    /// Takes the next page, of a level whose finer pages have all been [appended](Self::empty).
    pub fn take(&mut self, page: &EncodedPage) -> Result<()> {
        let is_next_band = |kept: &Kept| band_of(kept.id) != band_of(page.id);
        if self.kept.last().is_some_and(is_next_band) {
            self.empty()?;
        }
        self.aside
            .write_at(self.end, &page.bytes)
            .map_err(|error| self.writer.error("set a page aside", error))?;
        let EncodedPage { id, spans, crc, hash, .. } = *page;
        self.kept.push(Kept { id, offset: self.end, length: page.bytes.len(), spans, crc, hash });
        self.end += page.bytes.len() as u64;
        Ok(())
    }

    /// Appends what is set aside.
    pub fn empty(&mut self) -> Result<()> {
        self.kept.sort_by_key(|kept| place(kept.id));
        for kept in std::mem::take(&mut self.kept) {
            let mut bytes = vec![0; kept.length];
            self.aside
                .read_at(kept.offset, &mut bytes)
                .map_err(|error| self.writer.error("read a page that was set aside", error))?;
            let Kept { id, spans, crc, hash, .. } = kept;
            self.writer.append(&EncodedPage { id, bytes, spans, crc, hash })?;
        }
        self.end = 0;
        Ok(())
    }
}

/// The band that a page is in; bare ground is in that of its surface.
fn band_of(id: PageId) -> (u8, u32) {
    (if id.is_bare() { 0 } else { id.level }, id.py / SIDE)
}

/// Where a page comes in its band: bare ground after its surface.
fn place(id: PageId) -> (u32, u32, bool) {
    (id.px / SIDE, along_curve(id.px % SIDE, id.py % SIDE), id.is_bare())
}

/// How far along Hilbert's curve through a block a page lies: it begins in the south-west, and ends in the south-east.
fn along_curve(mut x: u32, mut y: u32) -> u32 {
    let (mut along, mut side) = (0, SIDE / 2);
    while side > 0 {
        let (east, north) = (u32::from(x & side > 0), u32::from(y & side > 0));
        along += side * side * ((3 * east) ^ north);
        // The first and the last quarter lie turned.
        if north == 0 {
            if east == 1 {
                (x, y) = (SIDE - 1 - x, SIDE - 1 - y);
            }
            (x, y) = (y, x);
        }
        side /= 2;
    }
    along
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_goes_from_neighbour_to_neighbour() {
        let mut pages: Vec<(u32, u32)> = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))).collect();
        pages.sort_by_key(|&(x, y)| along_curve(x, y));
        assert_eq!((pages[0], pages[pages.len() - 1]), ((0, 0), (SIDE - 1, 0)));
        for pair in pages.windows(2) {
            assert_eq!(pair[0].0.abs_diff(pair[1].0) + pair[0].1.abs_diff(pair[1].1), 1, "{pair:?}");
        }
    }
}
