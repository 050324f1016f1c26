//! The points of a LAS or LAZ file, chunk by chunk.

use std::fs::File;
use std::io::BufReader;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use las::{PointData, PointDataBuilder, Reader};

use super::head::Head;
use hedgehop_base::error::{Error, Result};

/// Bytes of records that are held at once, if a record is no longer.
const CHUNK_BYTES: usize = 1 << 20;
/// Bytes that are read ahead.
const AHEAD: usize = 1 << 18;

/// A point as its file has it.
#[derive(Debug, Clone, Copy)]
pub(super) struct RawPoint {
    /// Place in the file's units.
    pub place: [f64; 3],
    /// ASPRS class.
    pub class: u8,
    /// Whether its file says that it is not to be used.
    pub is_withheld: bool,
    /// Red, green, blue, as stored.
    pub colour: [u16; 3],
}

/// Reads a file from its beginning to its end.
pub(super) struct Points {
    path: PathBuf,
    head: Head,
    reader: Reader,
    data: PointData,
    /// Number of the next point.
    next: u64,
}

impl Points {
    /// Opens a file whose head was found sound.
    pub fn open(path: &Path, head: &Head) -> Result<Self> {
        let file = File::open(path).map_err(|error| Error::io(path, "open", error))?;
        let reader = guarded(|| Reader::new(BufReader::with_capacity(AHEAD, file)));
        let reader = reader.map_err(|what| damaged(path, &what))?;
        let data = PointDataBuilder::new().for_header(reader.header()).build();
        if data.record_len() != head.record || reader.header().number_of_points() != head.count {
            let what = "states a record that does not go with its format; it is damaged, fetch it again";
            return Err(Error::invalid(path, what));
        }
        Ok(Self { path: path.to_owned(), head: head.clone(), reader, data, next: 0 })
    }

    /// Goes to a point by its number; false where the file has no table for that.
    pub fn seek(&mut self, number: u64) -> bool {
        self.next = number;
        guarded(|| self.reader.seek(number)).is_ok()
    }

    /// Hands over up to `most` points; how many there were, 0 after the last.
    pub fn take(&mut self, most: u64, mut take: impl FnMut(RawPoint)) -> Result<u64> {
        let fit = (CHUNK_BYTES / self.head.record).max(1) as u64;
        let wanted = most.min(fit).min(self.head.count.saturating_sub(self.next));
        if wanted == 0 {
            return Ok(0);
        }
        let filled = guarded(|| self.reader.fill_points(wanted, &mut self.data));
        filled.map_err(|what| {
            damaged(&self.path, &format!("its points from number {} on: {what}", self.next))
        })?;
        let records = self.data.raw_bytes().chunks_exact(self.head.record);
        records.for_each(|record| take(self.head.point(record)));
        self.next += wanted;
        Ok(wanted)
    }
}

/// Calls the decoder, and turns its panics into reasons. Where it is built with assertions some of them are about what files hold, and it is of no use
/// after one of these has failed.
fn guarded<T>(decode: impl FnOnce() -> las::Result<T>) -> std::result::Result<T, String> {
    match catch_unwind(AssertUnwindSafe(decode)) {
        Ok(decoded) => decoded.map_err(|error| error.to_string()),
        Err(_) => Err("it contradicts itself".into()),
    }
}

fn damaged(path: &Path, what: &dyn std::fmt::Display) -> Error {
    Error::invalid(path, format!("cannot be decoded ({what}); it is cut short or damaged, fetch it again"))
}

impl Head {
    /// A point from its record, which is as long as the head says.
    fn point(&self, record: &[u8]) -> RawPoint {
        let count = |at: usize| i32::from_le_bytes([0, 1, 2, 3].map(|byte| record[at + byte]));
        let place = [0, 1, 2].map(|axis| f64::from(count(4 * axis)) * self.scale[axis] + self.offset[axis]);
        let (class, is_withheld) = if self.is_extended {
            (record[16], record[15] & 4 != 0)
        } else {
            (record[15] & 31, record[15] & 128 != 0)
        };
        let code = |at: usize| u16::from_le_bytes([record[at], record[at + 1]]);
        let colour = self.colour.map_or([0; 3], |at| [at, at + 2, at + 4].map(code));
        RawPoint { place, class, is_withheld, colour }
    }
}
