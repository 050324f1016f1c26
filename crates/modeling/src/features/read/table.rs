//! dBASE tables: the attributes of Shapefiles.
//!
//! ```text
//! header   32 bytes: version, date, rows u32 at 4, header's length u16 at 8, row's length u16 at 10, language at 29
//! fields   32 bytes each: name 11, type 1, …, length u8 at 16, decimals u8 at 17; 0x0D ends them
//! rows     ' ' or '*' (deleted), then fields one after another
//! ```
//! All little-endian. Layout after dBASE's level 5 and what GDAL writes: text, numbers as text, logical values, dates, and FoxPro's binary
//! numbers.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use super::super::layer::{Attributes, Value};
use super::bytes::{Bytes, Order};
use super::hstore;
use hedgehop_base::error::{Error, Result};

/// Encoding of letters beyond ASCII.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Letters {
    Utf8,
    /// Windows 1252, of which ISO 8859-1 is a part.
    Western,
    /// Not told: UTF-8 where it is that, else Western.
    Guess,
    /// One that is not known here.
    Foreign,
}

#[derive(Debug)]
struct TableField {
    name: Arc<str>,
    kind: u8,
    offset: usize,
    length: usize,
}

/// A table.
#[derive(Debug)]
pub(super) struct Table {
    bytes: Vec<u8>,
    fields: Vec<TableField>,
    rows: usize,
    first: usize,
    stride: usize,
    letters: Letters,
}

impl Table {
    /// The table of a file's bytes; `code_page` is the `.cpg` beside it.
    pub fn open(path: &Path, code_page: Option<&Path>, bytes: Vec<u8>) -> Result<Self> {
        let wrong = |what: String| Error::invalid(path, format!("{what}; copy the file again"));
        let mut head = Bytes::of(&bytes);
        let header = head
            .take(32)
            .ok_or_else(|| wrong(format!("has {} bytes, fewer than a dBASE header", bytes.len())))?;
        let mut numbers = Bytes::of(&header[4..12]);
        let (rows, first, stride) =
            (numbers.u32(Order::Little), numbers.u16(Order::Little), numbers.u16(Order::Little));
        let (rows, first, stride) =
            (rows.unwrap_or(0) as usize, usize::from(first.unwrap_or(0)), usize::from(stride.unwrap_or(0)));
        let letters = letters(code_page, header[29])?;
        let (mut fields, mut offset) = (Vec::new(), 1);

        while let Some(record) = head.take(32) {
            // The mark of the end stands where a name would begin.
            if record[0] == 0x0d || bytes.len() - head.len() > first {
                break;
            }
            let kind = record[11];
            let long = if kind == b'C' { usize::from(record[17]) << 8 } else { 0 };
            let length = usize::from(record[16]) + long;
            let name = record[..11].split(|byte| *byte == 0).next().unwrap_or_default();
            let name = decode(name.trim_ascii(), letters);
            fields.push(TableField { name: Arc::from(name), kind, offset, length });
            offset += length;
        }

        if stride == 0 || offset > stride || first > bytes.len() {
            return Err(wrong(format!(
                "its fields take {offset} bytes, but its header says {stride} a row from byte {first} on"
            )));
        }

        let present = (bytes.len() - first) / stride;
        if rows > present {
            return Err(wrong(format!("byte 4 says {rows} rows, but there are {present}")));
        }

        Ok(Self { bytes, fields, rows, first, stride, letters })
    }

    /// Returns the number of rows, deleted ones included.
    pub fn len(&self) -> usize {
        self.rows
    }

    /// Returns notes on the table.
    pub fn notes(&self) -> Option<String> {
        (self.letters == Letters::Foreign).then(|| {
            "has attributes in letters that are not known here; those beyond ASCII are lost".to_owned()
        })
    }

    /// The attributes of row `index`, from 0; an error if it is deleted. Rows past the end have none.
    pub fn row(&self, index: usize) -> Result<Attributes, String> {
        let mut attributes = Attributes::default();
        if index >= self.rows {
            return Ok(attributes);
        }

        let from = self.first + index * self.stride;
        let row = &self.bytes[from..from + self.stride];
        if row[0] == b'*' {
            return Err("it is marked as deleted".to_owned());
        }

        for field in &self.fields {
            let bytes = &row[field.offset..field.offset + field.length];
            match field.value(bytes, self.letters) {
                Some(Value::Text(text)) if &*field.name == "other_tags" => {
                    hstore::add(&mut attributes, &text)
                }
                Some(value) => attributes.push(field.name.clone(), value),
                None => {}
            }
        }

        Ok(attributes)
    }
}

impl TableField {
    fn value(&self, bytes: &[u8], letters: Letters) -> Option<Value> {
        let text = bytes.split(|byte| *byte == 0).next().unwrap_or_default().trim_ascii();
        match self.kind {
            b'N' | b'F' => {
                let text = std::str::from_utf8(text).ok()?;
                text.parse().ok().map(Value::Number)
            }
            b'I' | b'+' => {
                let number = Bytes::of(bytes).u32(Order::Little)?.cast_signed();
                Some(Value::Number(f64::from(number)))
            }
            b'O' | b'B' if self.length == 8 => Bytes::of(bytes).f64(Order::Little).map(Value::Number),
            b'L' => match text.first()? {
                b'T' | b't' | b'Y' | b'y' => Some(Value::Text("yes".to_owned())),
                b'F' | b'f' | b'N' | b'n' => Some(Value::Text("no".to_owned())),
                _ => None,
            },
            b'C' | b'D' => Some(Value::Text(decode(text, letters))),
            _ => None,
        }
    }
}

fn letters(code_page: Option<&Path>, language: u8) -> Result<Letters> {
    /// A `.cpg` holds one name.
    const LONGEST: u64 = 1000;

    if let Some(path) = code_page {
        let length = fs::metadata(path).map_err(|error| Error::io(path, "read", error))?.len();
        if length <= LONGEST {
            let bytes = fs::read(path).map_err(|error| Error::io(path, "read", error))?;
            let name = String::from_utf8_lossy(&bytes).trim().to_ascii_uppercase();
            let name: String = name.chars().filter(|c| c.is_ascii_alphanumeric()).collect();
            return Ok(match name.as_str() {
                "" => Letters::Guess,
                "UTF8" | "65001" | "CP65001" => Letters::Utf8,
                "ISO88591" | "88591" | "LATIN1" | "1252" | "CP1252" | "ANSI1252" | "WINDOWS1252" => {
                    Letters::Western
                }
                "ASCII" | "USASCII" => Letters::Guess,
                _ => Letters::Foreign,
            });
        }
    }

    Ok(match language {
        0 => Letters::Guess,
        0x03 | 0x57 | 0x58 | 0x59 => Letters::Western,
        _ => Letters::Foreign,
    })
}

/// Characters of Windows 1252 between 0x80 and 0x9F, where ISO 8859-1 has controls.
const WESTERN: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž', '\u{8f}', '\u{90}',
    '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}', 'ž', 'Ÿ',
];

fn decode(bytes: &[u8], letters: Letters) -> String {
    let western = || {
        let letter = |byte: &u8| match byte {
            0x80..0xa0 => WESTERN[usize::from(*byte) - 0x80],
            _ => char::from(*byte),
        };
        bytes.iter().map(letter).collect()
    };
    match letters {
        Letters::Utf8 => String::from_utf8_lossy(bytes).into_owned(),
        Letters::Western => western(),
        Letters::Guess => std::str::from_utf8(bytes).map_or_else(|_| western(), str::to_owned),
        Letters::Foreign => bytes
            .iter()
            .map(|byte| if byte.is_ascii() { char::from(*byte) } else { char::REPLACEMENT_CHARACTER })
            .collect(),
    }
}
