//! SQLite databases, as far as tables of them are read: *Database File Format* (sqlite.org/fileformat2.html, public domain).
//!
//! ```text
//! page 1      header of 100 bytes, then the root of the table of tables (type, name, table, root page, SQL)
//! interior    0x05: … count at 3, right-most child at 8, cell offsets from 12; cell = child u32, key varint
//! leaf        0x0D: … count at 3, cell offsets from 8; cell = length varint, row id varint, record (its end on overflow pages)
//! record      header's length, a type for each value (varints), then the values
//! ```
//! Every page is used once at most, and all records together cannot be longer than the file: a file that says otherwise is damaged.

use std::collections::HashSet;
use std::fs::{self, File};
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::bytes::{Bytes, Order};
use hedgehop_base::error::{Error, Result};

/// First bytes of a database.
pub(super) const MAGIC: &[u8] = b"SQLite format 3\0";
const HEADER: usize = 100;
/// Deepest tree; real ones have five levels.
const DEEPEST: usize = 20;
/// Most columns of a table that are read (SQLite's own limit is 2000, at most 32767).
const MOST_COLUMNS: usize = 32_767;

/// A value of a row.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum SqlCell {
    Null,
    Integer(i64),
    Real(f64),
    Text(String),
    Blob(Vec<u8>),
}

impl SqlCell {
    pub fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }
    pub fn integer(&self) -> Option<i64> {
        match self {
            Self::Integer(number) => Some(*number),
            _ => None,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Utf8,
    Utf16(Order),
}

/// A database file.
#[derive(Debug)]
pub(super) struct Database {
    path: PathBuf,
    file: File,
    length: u64,
    page_size: usize,
    /// Bytes of a page that are not reserved.
    usable: usize,
    pages: u64,
    encoding: Encoding,
}

/// A table: where it begins, and its columns.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SqlTable {
    pub name: String,
    root: u32,
    pub columns: Vec<String>,
    /// The column that is the row's id.
    id: Option<usize>,
}

impl Database {
    /// Opens a file, which must be whole without a journal beside it.
    pub fn open(path: &Path) -> Result<Self> {
        let io = |error| Error::io(path, "read", error);
        for (ending, remedy) in [
            (
                "-wal",
                "close the program that writes it, or put it into the file: sqlite3 FILE 'PRAGMA wal_checkpoint(TRUNCATE)'",
            ),
            (
                "-journal",
                "it was not closed in good order; open it once with the program that wrote it, or with sqlite3",
            ),
        ] {
            let beside = PathBuf::from(format!("{}{ending}", path.display()));
            if fs::metadata(&beside).is_ok_and(|metadata| metadata.len() > 0) {
                let what =
                    format!("has a journal beside it ({}), without which it is not whole", beside.display());
                return Err(Error::unsupported(path, what, remedy));
            }
        }

        let mut file = File::open(path).map_err(io)?;
        let length = file.metadata().map_err(io)?.len();
        let mut header = [0; HEADER];
        let wrong = |what: String| Error::invalid(path, format!("{what}; copy the file again"));
        file.read_exact(&mut header)
            .map_err(|_| wrong(format!("has {length} bytes, fewer than an SQLite header")))?;
        let page_size = match u16::from_be_bytes([header[16], header[17]]) {
            1 => 65_536,
            size => usize::from(size),
        };
        let usable = page_size.saturating_sub(usize::from(header[20]));
        if !page_size.is_power_of_two() || page_size < 512 || usable < 480 {
            return Err(wrong(format!(
                "byte 16: its pages cannot have {page_size} bytes, {usable} of them in use"
            )));
        }

        let encoding = match u32::from_be_bytes([header[56], header[57], header[58], header[59]]) {
            0 | 1 => Encoding::Utf8,
            2 => Encoding::Utf16(Order::Little),
            3 => Encoding::Utf16(Order::Big),
            other => return Err(wrong(format!("byte 56: text encoding {other} is none"))),
        };
        let pages = length / page_size as u64;

        Ok(Self { path: path.to_owned(), file, length, page_size, usable, pages, encoding })
    }

    /// Builds the error of a damaged page.
    fn damaged(&self, page: u32, what: &str) -> Error {
        Error::invalid(&self.path, format!("page {page}: {what}; the file is damaged, copy it again"))
    }

    fn page(&mut self, number: u32) -> Result<Vec<u8>> {
        if number == 0 || u64::from(number) > self.pages {
            return Err(self.damaged(number, &format!("there are {} pages", self.pages)));
        }
        let mut bytes = vec![0; self.page_size];
        let start = u64::from(number - 1) * self.page_size as u64;
        let read = self.file.seek(SeekFrom::Start(start)).and_then(|_| self.file.read_exact(&mut bytes));
        read.map_err(|error| Error::io(&self.path, "read", error))?;
        Ok(bytes)
    }

    /// All tables that can be read.
    pub fn tables(&mut self) -> Result<Vec<SqlTable>> {
        let schema = SqlTable { name: "sqlite_schema".to_owned(), root: 1, columns: Vec::new(), id: None };
        let mut tables = Vec::new();
        self.rows(&schema, |_, row| {
            let text = |index: usize| row.get(index).and_then(SqlCell::text);
            let root = row.get(3).and_then(SqlCell::integer).and_then(|root| u32::try_from(root).ok());
            if let (Some("table"), Some(name), Some(root), Some(sql)) = (text(0), text(1), root, text(4))
                && let Some((columns, id)) = super::sql::columns(sql)
            {
                tables.push(SqlTable { name: name.to_owned(), root, columns, id });
            }
            Ok(())
        })?;
        Ok(tables)
    }

    /// Hands over each row of a table in the order of their ids: id and values, one for each column.
    pub fn rows(
        &mut self,
        table: &SqlTable,
        mut each: impl FnMut(i64, Vec<SqlCell>) -> Result<()>,
    ) -> Result<()> {
        let mut seen = HashSet::new();
        let mut budget = self.length;

        // Pages to go through, the last one first, with their depth.
        let mut stack = vec![(table.root, 0)];
        while let Some((number, depth)) = stack.pop() {
            if depth > DEEPEST || !seen.insert(number) {
                return Err(self.damaged(number, "its tree goes round in circles"));
            }

            let page = self.page(number)?;
            let start = if number == 1 { HEADER } else { 0 };
            let cells = u16::from_be_bytes([page[start + 3], page[start + 4]]);
            let (kind, right) = (page[start], u32_at(&page, start + 8));
            let offsets = start + if kind == 5 { 12 } else { 8 };
            let Some(offsets) = page.get(offsets..offsets + 2 * usize::from(cells)) else {
                return Err(self.damaged(number, "it has more cells than room"));
            };

            let offsets =
                offsets.chunks_exact(2).map(|pair| usize::from(u16::from_be_bytes([pair[0], pair[1]])));
            match kind {
                5 => {
                    let children =
                        offsets.map(|at| u32_at(&page, at)).chain([right]).collect::<Option<Vec<_>>>();
                    let children = children.ok_or_else(|| self.damaged(number, "a cell lies beyond it"))?;
                    stack.extend(children.into_iter().rev().map(|child| (child, depth + 1)));
                }
                13 => {
                    for at in offsets {
                        let Some((length, id, rest)) = page[..self.usable].get(at..).and_then(leaf_cell)
                        else {
                            return Err(self.damaged(number, "a cell lies beyond it"));
                        };
                        let left = budget.checked_sub(length);
                        budget =
                            left.ok_or_else(|| self.damaged(number, "its rows are longer than the file"))?;
                        let record = self.record(number, rest, length as usize)?;
                        let values = self.values(&record, table, id);
                        each(
                            id,
                            values.ok_or_else(|| self.damaged(number, &format!("row {id} is no record")))?,
                        )?;
                    }
                }
                other => return Err(self.damaged(number, &format!("kind {other} is none of a table"))),
            }
        }

        Ok(())
    }

    /// All bytes of a record, of which `here` begins on a leaf.
    fn record(&mut self, page: u32, here: &[u8], length: usize) -> Result<Vec<u8>> {
        let usable = self.usable;
        let (most, least) = (usable - 35, (usable - 12) * 32 / 255 - 23);
        let local = match least + length.saturating_sub(least) % (usable - 4) {
            _ if length <= most => length,
            local if local <= most => local,
            _ => least,
        };
        let mut record =
            here.get(..local).ok_or_else(|| self.damaged(page, "a row lies beyond it"))?.to_vec();
        let mut next = u32_at(here, local);

        while record.len() < length {
            let number = next.filter(|number| *number != 0);
            let number = number.ok_or_else(|| self.damaged(page, "a row ends too early"))?;
            let bytes = self.page(number)?;
            next = u32_at(&bytes, 0);
            let part = (length - record.len()).min(usable - 4);
            record.extend_from_slice(&bytes[4..4 + part]);
        }

        Ok(record)
    }

    /// The values of a record, one for each column of the table (all that there are where its columns are not known).
    fn values(&self, record: &[u8], table: &SqlTable, id: i64) -> Option<Vec<SqlCell>> {
        let (header_length, rest) = varint(record)?;
        let header = record.get(..usize::try_from(header_length).ok()?)?;
        let mut types = header.get(record.len() - rest.len()..)?;
        let mut body = Bytes::of(&record[header.len()..]);
        let mut values = Vec::new();
        while !types.is_empty() && values.len() < MOST_COLUMNS {
            let (kind, rest) = varint(types)?;
            types = rest;
            values.push(self.value(kind, &mut body)?);
        }
        if !table.columns.is_empty() {
            // Rows from before a column was added are shorter.
            values.resize(table.columns.len(), SqlCell::Null);
        }
        if let Some(value) = table.id.and_then(|column| values.get_mut(column)) {
            *value = SqlCell::Integer(id);
        }
        Some(values)
    }

    fn value(&self, kind: u64, body: &mut Bytes<'_>) -> Option<SqlCell> {
        Some(match kind {
            0 => SqlCell::Null,
            1..=6 => {
                let bytes = body.take([1, 2, 3, 4, 6, 8][kind as usize - 1])?;
                let sign = if bytes[0] & 0x80 != 0 { -1 } else { 0 };
                SqlCell::Integer(bytes.iter().fold(sign, |number: i64, byte| number << 8 | i64::from(*byte)))
            }
            7 => SqlCell::Real(body.f64(Order::Big)?),
            8 | 9 => SqlCell::Integer(kind as i64 - 8),
            10 | 11 => return None,
            _ => {
                let bytes = body.take(usize::try_from((kind - 12) / 2).ok()?)?;
                if kind.is_multiple_of(2) {
                    SqlCell::Blob(bytes.to_vec())
                } else {
                    SqlCell::Text(self.text(bytes))
                }
            }
        })
    }

    fn text(&self, bytes: &[u8]) -> String {
        match self.encoding {
            Encoding::Utf8 => String::from_utf8_lossy(bytes).into_owned(),
            Encoding::Utf16(order) => {
                let mut units = Bytes::of(bytes);
                let units: Vec<u16> = std::iter::from_fn(|| units.u16(order)).collect();
                String::from_utf16_lossy(&units)
            }
        }
    }
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..).and_then(|bytes| Bytes::of(bytes).u32(Order::Big))
}

/// Length of its record, row id, and what follows.
fn leaf_cell(bytes: &[u8]) -> Option<(u64, i64, &[u8])> {
    let (length, rest) = varint(bytes)?;
    let (id, rest) = varint(rest)?;
    Some((length, id.cast_signed(), rest))
}

/// A number of one to nine bytes, seven bits in each but the ninth, and what follows.
fn varint(bytes: &[u8]) -> Option<(u64, &[u8])> {
    let mut number = 0;
    for (index, byte) in bytes.iter().enumerate().take(9) {
        if index == 8 {
            return Some((number << 8 | u64::from(*byte), &bytes[9..]));
        }
        number = number << 7 | u64::from(byte & 0x7f);
        if byte & 0x80 == 0 {
            return Some((number, &bytes[index + 1..]));
        }
    }
    None
}
