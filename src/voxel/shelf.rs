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
//! What is set aside lies in a file, so that memory stays bounded: one without a name, or with one, if it is to stay when the program is killed.

use std::fs::File;
use std::path::Path;

use tempfile::TempPath;

use super::assembly::Storage;
use super::{EarlierPage, EncodedPage, PageEntry, PageId, PageWriter};
use hedgehop_base::error::Result;

/// Pages along the side of a block, a power of two.
const SIDE: u32 = 8;

/// A page that waits for its turn.
#[derive(Debug)]
enum Kept {
    /// Set aside, lying there.
    Aside(PageId, PageEntry),
    /// Another file has it.
    Earlier(EarlierPage),
}

impl Kept {
    fn id(&self) -> PageId {
        match self {
            Self::Aside(id, _) => *id,
            Self::Earlier(page) => page.id,
        }
    }
}

/// Takes pages of one level after the other, rows from the north, and appends them along the curve.
#[derive(Debug)]
pub struct Shelf<'w> {
    writer: &'w mut PageWriter,
    aside: File,
    name: Option<TempPath>,
    end: u64,
    kept: Vec<Kept>,
}

impl<'w> Shelf<'w> {
    /// Appends to `writer`, setting pages aside beside its target.
    pub fn new(writer: &'w mut PageWriter) -> Result<Self> {
        let aside = writer.file_aside()?;
        Ok(Self { writer, aside, name: None, end: 0, kept: Vec::new() })
    }

    /// The same in a file that stays if the program is killed.
    pub fn named(writer: &'w mut PageWriter) -> Result<Self> {
        let (aside, name) = writer.named_file_aside()?;
        Ok(Self { writer, aside, name: Some(name), end: 0, kept: Vec::new() })
    }

    /// The file in which pages are set aside, if it has a name.
    pub fn aside(&self) -> Option<&Path> {
        self.name.as_deref()
    }

    /// Takes the next page, of a level whose finer pages have all been [appended](Self::empty). Where it is set aside.
    pub fn take(&mut self, page: &EncodedPage) -> Result<PageEntry> {
        self.begin_band_of(page.id)?;
        self.aside
            .write_at(self.end, &page.bytes)
            .map_err(|error| self.writer.error("set a page aside", error))?;
        let EncodedPage { id, spans, crc, hash, .. } = *page;
        // Lengths are checked when it is appended.
        let length = u32::try_from(page.bytes.len()).unwrap_or(u32::MAX);
        let offset = if length > 0 { self.end } else { 0 };
        let entry = PageEntry { offset, length, spans, crc, hash };
        self.kept.push(Kept::Aside(id, entry));
        self.end += page.bytes.len() as u64;
        Ok(entry)
    }

    /// The same with a page that another file has.
    pub fn take_earlier(&mut self, page: EarlierPage) -> Result<()> {
        self.begin_band_of(page.id)?;
        self.kept.push(Kept::Earlier(page));
        Ok(())
    }

    fn begin_band_of(&mut self, id: PageId) -> Result<()> {
        match self.kept.last() {
            Some(kept) if band_of(kept.id()) != band_of(id) => self.empty(),
            _ => Ok(()),
        }
    }

    /// Appends what is set aside.
    pub fn empty(&mut self) -> Result<()> {
        self.kept.sort_by_key(|kept| place(kept.id()));
        for kept in std::mem::take(&mut self.kept) {
            match kept {
                Kept::Aside(id, entry) => self.writer.append_set_aside(id, entry, &self.aside)?,
                Kept::Earlier(page) => self.writer.append_earlier(&page)?,
            }
        }
        self.end = 0;
        Ok(())
    }
}

/// The band that a page is in; bare ground is in that of its surface.
fn band_of(id: PageId) -> (u8, u32) {
    (if id.is_bare() { 0 } else { id.level }, id.py / SIDE)
}

/// Returns the place of a page in its band: bare ground after its surface.
fn place(id: PageId) -> (u32, u32, bool) {
    (id.px / SIDE, along_curve(id.px % SIDE, id.py % SIDE), id.is_bare())
}

/// Returns how far along Hilbert's curve through a block a page lies: it begins in the south-west, and ends in the south-east.
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
