//! TOML files that people write: what is in them, and where something is wrong.

mod mark;

use std::fs;
use std::ops::Range;
use std::path::Path;

use serde::de::DeserializeOwned;
use toml::Spanned;

use crate::error::{Error, Result};

pub use mark::unmarked;

/// Bytes of the largest file.
const MOST_BYTES: u64 = 64 << 20;

/// Tables of the largest file: each takes up to a kilobyte while it is read.
const MOST_TABLES: usize = 250_000;

/// Longest text after a line's number, characters.
const MOST_MESSAGE: usize = 500;

/// Kind of file, for messages about it.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    /// Name as in "that a scene may have".
    pub name: &'static str,
    /// Manual that tells all keys.
    pub manual: &'static str,
}

/// A file while it is read.
#[derive(Debug)]
pub struct Reading<'f> {
    /// The file.
    pub path: &'f Path,
    /// Bytes behind the ends of lines.
    lines: Vec<usize>,
}

impl<'f> Reading<'f> {
    /// Reads a file into a table; `hasher` takes all bytes of it.
    ///
    /// # Errors
    /// A file that cannot be read, is too large, or is no TOML of that table; with its line.
    pub fn open<T: DeserializeOwned>(
        path: &'f Path,
        kind: Kind,
        hasher: &mut blake3::Hasher,
    ) -> Result<(Self, T)> {
        let text = text_of(path, kind, hasher)?;
        let reading = Self::of(path, &text);
        let table = toml::from_str(&text).map_err(|error| {
            let message = error.message().trim().replace('\n', ", ");
            let span = error.span().unwrap_or(0..0);
            let given = text.get(span.clone()).unwrap_or_default();
            if message.ends_with("expected a sequence") && given.starts_with('[') {
                let name = given.lines().next().unwrap_or_default().trim_matches(['[', ']', ' ']);
                return reading
                    .wrong(span, format!("write [[{name}]], in two brackets: there may be several"));
            }
            reading.wrong(span, format!("{message}; {} lists all keys", kind.manual))
        })?;
        Ok((reading, table))
    }

    /// A file of which the text is known.
    pub fn of(path: &'f Path, text: &str) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Self { path, lines: ends.map(|(at, _)| at + 1).collect() }
    }

    /// Builds the error of a fault at a place of the file.
    pub fn wrong(&self, span: Range<usize>, what: impl std::fmt::Display) -> Error {
        let line = self.line(&span);
        Error::invalid(self.path, format!("line {line}: {}", plain(&what.to_string())))
    }

    /// The line of a place of the file, from 1 on.
    pub fn line(&self, span: &Range<usize>) -> usize {
        1 + self.lines.partition_point(|end| *end <= span.start)
    }

    /// A number that `holds`; `want` says which do, beginning with a verb.
    pub fn number(
        &self,
        key: &str,
        value: &Spanned<f64>,
        holds: impl Fn(f64) -> bool,
        want: &str,
    ) -> Result<f64> {
        let checked = Self::checked(key, *value.get_ref(), holds, want);
        checked.map_err(|what| self.wrong(value.span(), what))
    }

    /// The same, of which only the sentence is told.
    pub fn checked(key: &str, number: f64, holds: impl Fn(f64) -> bool, want: &str) -> Result<f64, String> {
        let is_sound = number.is_finite() && holds(number);
        if is_sound { Ok(number) } else { Err(format!("{key} {want}, not {number}")) }
    }

    /// Exactly so many numbers.
    pub fn numbers<const N: usize>(&self, key: &str, values: &Spanned<Vec<f64>>) -> Result<[f64; N]> {
        let given = values.get_ref();
        let what = || format!("{key} must be {N} numbers, not {}", given.len());
        <[f64; N]>::try_from(given.as_slice()).map_err(|_| self.wrong(values.span(), what()))
    }

    /// Builds the error of something that a place of the file names; `whose` says what that is.
    pub fn through(&self, span: Range<usize>, whose: &str, error: Error) -> Error {
        match error {
            Error::Io { path, action, source } => {
                let (line, file) = (self.line(&span), self.path.display());
                let action = if action == "read" { "read it" } else { &action };
                Error::io(path, plain(&format!("{action}, {whose} (line {line} of {file})")), source)
            }
            Error::Unsupported { path, what, remedy } => {
                let what = format!("line {}: {whose}: {}: {what}", self.line(&span), path.display());
                Error::unsupported(self.path, plain(&what), plain(&remedy))
            }
            stopped @ Error::Interrupted(_) => stopped,
            other => self.wrong(span, format!("{whose}: {other}")),
        }
    }
}

/// The line of a byte, from 1 on.
fn line_at(bytes: &[u8], at: usize) -> usize {
    1 + bytes[..at.min(bytes.len())].iter().filter(|byte| **byte == b'\n').count()
}

/// Text for a sentence: in one line, without characters that steer terminals, and of some length at most.
pub fn plain(text: &str) -> String {
    let shown = text.chars().map(|char| if char.is_control() { '\u{fffd}' } else { char });
    let mut plain: String = shown.clone().take(MOST_MESSAGE).collect();
    if shown.count() > MOST_MESSAGE {
        plain.push('…');
    }
    plain
}

/// All of a regular file, without a mark of its encoding; `hasher` takes all bytes of it.
///
/// # Errors
/// A file that cannot be read, is too large, or is no text.
pub fn text_of(path: &Path, kind: Kind, hasher: &mut blake3::Hasher) -> Result<String> {
    let found = fs::metadata(path).map_err(|source| Error::io(path, "read", source))?;
    if !found.is_file() {
        return Err(Error::invalid(path, format!("is no regular file; a {} is a TOML file", kind.name)));
    }
    if found.len() > MOST_BYTES {
        let length = found.len();
        let what = format!("holds {length} bytes, more than the {MOST_BYTES} that a {} may have", kind.name);
        return Err(Error::invalid(path, what));
    }

    let bytes = fs::read(path).map_err(|source| Error::io(path, "read", source))?;
    hasher.update(&bytes);
    let bytes = unmarked(path, &bytes)?;
    let text = str::from_utf8(bytes).map_err(|error| {
        let line = line_at(bytes, error.valid_up_to());
        Error::invalid(path, format!("line {line}: not UTF-8; save it as UTF-8"))
    })?;
    let tables = text.matches("[[").count() + text.matches('{').count();
    if tables > MOST_TABLES {
        let what = format!("has {tables} tables, more than the {MOST_TABLES} that a {} may have", kind.name);
        return Err(Error::invalid(path, what));
    }

    Ok(text.to_owned())
}
