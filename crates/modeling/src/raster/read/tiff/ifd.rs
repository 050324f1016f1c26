//! TIFF directories (Adobe, *TIFF 6.0*, 1992, §2; BigTIFF by Aldus/AWare): tags with their values, classic and big, both
//! byte orders.
//!
//! ```text
//! classic: II|MM 42 offset:u32          directory: count:u16 { tag:u16 kind:u16 count:u32 value|offset:u32 }
//! big:     II|MM 43 8 0 offset:u64      directory: count:u64 { tag:u16 kind:u16 count:u64 value|offset:u64 }
//! ```
//! Directories are read here and not through the `tiff` crate, because that limits a tag to about 32 000 values (a COG of 100 000² pixels has
//! more tiles), keeps a copy of them per decoder, and refuses text that is no ASCII.

use std::collections::BTreeMap;

use crate::raster::file::InputFile;
use crate::raster::sample::ByteOrder;
use hedgehop_base::error::{Error, Result};

/// More entries than any sound directory has.
const MOST_ENTRIES: u64 = 4096;

/// Bytes of a value of each kind (index: TIFF's type code).
const KIND_BYTES: [u64; 19] = [0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8];

#[derive(Debug, Clone, Copy)]
struct Entry {
    kind: u16,
    count: u64,
    /// Begin of the values, bytes.
    at: u64,
}

/// One directory; values are read when asked for.
#[derive(Debug)]
pub(super) struct Directory<'a> {
    file: &'a InputFile,
    pub order: ByteOrder,
    entries: BTreeMap<u16, Entry>,
    /// Begin of the next directory; 0 if this is the last.
    next: u64,
    big: bool,
}

impl<'a> Directory<'a> {
    /// The first directory of a file.
    pub fn first(file: &'a InputFile) -> Result<Self> {
        let head = file.bytes_at(0, 8)?;
        let order = if head[0] == b'I' { ByteOrder::Little } else { ByteOrder::Big };
        let big = order.unsigned(&head[2..4]) == 43;
        let at = if big { order.unsigned(&file.bytes_at(8, 8)?) } else { order.unsigned(&head[4..8]) };
        Self::read(file, order, big, at)
    }

    /// The directory after this one.
    pub fn next(&self) -> Result<Option<Self>> {
        if self.next == 0 {
            return Ok(None);
        }
        Self::read(self.file, self.order, self.big, self.next).map(Some)
    }

    fn read(file: &'a InputFile, order: ByteOrder, big: bool, at: u64) -> Result<Self> {
        let (count_bytes, entry_bytes, inline) = if big { (8, 20, 8) } else { (2, 12, 4) };
        let count = order.unsigned(&file.bytes_at(at, count_bytes)?);
        if count > MOST_ENTRIES {
            let what =
                format!("states {count} tags in its directory at byte {at}; it is damaged, fetch it again");
            return Err(Error::invalid(file.path(), what));
        }

        let first = at + count_bytes;
        let bytes = file.bytes_at(first, count * entry_bytes + inline)?;
        let (records, next) = bytes.split_at((count * entry_bytes) as usize);
        let mut entries = BTreeMap::new();

        for (index, record) in records.chunks_exact(entry_bytes as usize).enumerate() {
            let (kind, tag) = (order.unsigned(&record[2..4]) as u16, order.unsigned(&record[..2]) as u16);
            let (number, value) = record[4..].split_at(inline as usize);
            let count = order.unsigned(number);
            let Some(size) = KIND_BYTES.get(usize::from(kind)).filter(|size| **size > 0) else { continue };
            let own = first + index as u64 * entry_bytes + 4 + inline;
            let at = if count.saturating_mul(*size) <= inline { own } else { order.unsigned(value) };
            entries.entry(tag).or_insert(Entry { kind, count, at });
        }

        Ok(Self { file, order, entries, next: order.unsigned(next), big })
    }

    /// Whether a tag is there.
    pub fn has(&self, tag: u16) -> bool {
        self.entries.contains_key(&tag)
    }

    /// Number of values of a tag.
    pub fn count(&self, tag: u16) -> u64 {
        self.entries.get(&tag).map_or(0, |entry| entry.count)
    }

    /// The values' bytes and the size of one; at most `most` values.
    fn values(&self, tag: u16, most: u64) -> Result<Option<(u16, Vec<u8>)>> {
        let Some(entry) = self.entries.get(&tag) else { return Ok(None) };
        if entry.count > most {
            return Err(self
                .wrong(tag, format!("holds {} values, more than the {most} that make sense", entry.count)));
        }
        let size = KIND_BYTES[usize::from(entry.kind)];
        Ok(Some((entry.kind, self.file.bytes_at(entry.at, entry.count * size)?)))
    }

    /// An error about a tag.
    pub fn wrong(&self, tag: u16, what: impl std::fmt::Display) -> Error {
        Error::invalid(self.file.path(), format!("its TIFF tag {tag} {what}; it is damaged, fetch it again"))
    }

    /// Unsigned integers, at most `most`.
    pub fn unsigneds(&self, tag: u16, most: u64) -> Result<Option<Vec<u64>>> {
        let Some((kind, bytes)) = self.values(tag, most)? else { return Ok(None) };
        if !matches!(kind, 1 | 3 | 4 | 7 | 13 | 16 | 18) {
            return Err(self.wrong(tag, "holds no unsigned integers"));
        }
        let size = KIND_BYTES[usize::from(kind)] as usize;
        Ok(Some(bytes.chunks_exact(size).map(|value| self.order.unsigned(value)).collect()))
    }

    /// One unsigned integer below 2³²; the first if there are several.
    pub fn unsigned(&self, tag: u16) -> Result<Option<u32>> {
        let Some(values) = self.unsigneds(tag, 65_535)? else { return Ok(None) };
        let first = values.first().and_then(|value| u32::try_from(*value).ok());
        first.map(Some).ok_or_else(|| self.wrong(tag, "holds no 32-bit integer"))
    }

    /// Floating-point numbers, at most `most`.
    pub fn doubles(&self, tag: u16, most: u64) -> Result<Option<Vec<f64>>> {
        let Some((kind, bytes)) = self.values(tag, most)? else { return Ok(None) };
        match kind {
            12 => Ok(Some(bytes.chunks_exact(8).map(|v| f64::from_bits(self.order.unsigned(v))).collect())),
            11 => {
                let single = |v: &[u8]| f64::from(f32::from_bits(self.order.unsigned(v) as u32));
                Ok(Some(bytes.chunks_exact(4).map(single).collect()))
            }
            _ => Err(self.wrong(tag, "holds no floating-point numbers")),
        }
    }

    /// Text up to its NUL; bytes that are no UTF-8 are replaced.
    pub fn text(&self, tag: u16, most: u64) -> Result<Option<String>> {
        let Some((kind, bytes)) = self.values(tag, most)? else { return Ok(None) };
        if !matches!(kind, 1 | 2 | 7) {
            return Err(self.wrong(tag, "holds no text"));
        }
        let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
        Ok(Some(String::from_utf8_lossy(&bytes[..end]).into_owned()))
    }
}
