//! Files that a model is read from.

use std::fs;
use std::path::{Path, PathBuf};

use crate::model::Clause;
use hedgehop_base::document::unmarked;
use hedgehop_base::error::{Error, Result};

/// Bytes of all files of the largest model.
const MOST_BYTES: u64 = 512 << 20;

/// A model's files: each is put into a digest when it is read.
pub(super) struct Files<'h> {
    path: PathBuf,
    read: Vec<PathBuf>,
    bytes: u64,
    hasher: &'h mut blake3::Hasher,
}

impl<'h> Files<'h> {
    pub fn new(path: &Path, hasher: &'h mut blake3::Hasher) -> Self {
        Self { path: path.to_owned(), read: Vec::new(), bytes: 0, hasher }
    }

    /// Builds the error of a fault in the model.
    pub fn wrong(&self, what: impl Into<String>) -> Error {
        Error::invalid(&self.path, what)
    }

    /// The model's own bytes as text, without a mark of its encoding.
    pub fn text<'b>(&self, bytes: &'b [u8]) -> Result<&'b [u8]> {
        unmarked(&self.path, bytes)
    }

    /// Builds the error of a feature that is not read, with a remedy.
    pub fn unsupported(&self, what: impl Into<String>, remedy: &str) -> Error {
        Error::unsupported(&self.path, what, remedy)
    }

    /// The model's own file.
    pub fn first(&mut self) -> Result<Vec<u8>> {
        let path = self.path.clone();
        self.bytes_of(&path)
    }

    /// A file that the model names, beside it.
    pub fn beside(&mut self, name: &str) -> Result<Vec<u8>> {
        if let Some(what) = unusable(name) {
            return Err(self.wrong(what));
        }
        let path = self.path.parent().unwrap_or(".".as_ref()).join(name.replace('\\', "/"));
        self.bytes_of(&path).map_err(|error| match error {
            Error::Io { path, action, source } => {
                Error::io(path, format!("{action} it, which {} needs", self.path.display()), source)
            }
            other => other,
        })
    }

    /// All files that were read.
    pub fn read(self) -> Vec<PathBuf> {
        self.read
    }

    fn bytes_of(&mut self, path: &Path) -> Result<Vec<u8>> {
        let found = fs::metadata(path).map_err(|source| Error::io(path, "read", source))?;
        if !found.is_file() {
            return Err(Error::invalid(path, "is no regular file; a model's parts are files"));
        }
        self.bytes = self.bytes.saturating_add(found.len());
        if self.bytes > MOST_BYTES {
            let what =
                format!("its files hold more than the {MOST_BYTES} bytes that a model may have; simplify it");
            return Err(self.wrong(what));
        }
        let bytes = fs::read(path).map_err(|source| Error::io(path, "read", source))?;
        self.hasher.update(&(bytes.len() as u64).to_le_bytes()).update(&bytes);
        self.read.push(path.to_owned());
        Ok(bytes)
    }
}

/// Why a name is none of a file.
fn unusable(name: &str) -> Option<String> {
    if name.is_empty() || name.chars().any(char::is_control) {
        return Some(format!("{name:?} is no name of a file"));
    }
    let scheme = name.split_once(':').map(|(scheme, _)| scheme)?;
    let is_scheme = scheme.chars().all(|char| char.is_ascii_alphanumeric() || "+-.".contains(char));
    is_scheme.then(|| format!("it names {name:?}, which is no file beside it; put the file there"))
}

/// Bytes of a `data:` URI; `None`: it is none.
pub(super) fn data(uri: &str) -> Option<Clause<Vec<u8>>> {
    let rest = uri.strip_prefix("data:")?;
    Some(match rest.split_once(',') {
        Some((kind, text)) if kind.ends_with(";base64") => {
            base64(text.as_bytes()).ok_or_else(|| "it holds data that is no base64".to_owned())
        }
        Some(_) => Err("it holds data that is not written in base64".to_owned()),
        None => Err("it holds a data URI without a comma".to_owned()),
    })
}

/// A URI's name of a file: `%20` is a space.
pub(super) fn name_of(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, after @ ..] = rest {
        let hex = |digit: u8| (digit as char).to_digit(16).map(|digit| digit as u8);
        if *first == b'%'
            && let [high, low, left @ ..] = after
            && let (Some(high), Some(low)) = (hex(*high), hex(*low))
        {
            bytes.push(16 * high + low);
            rest = left;
        } else {
            bytes.push(*first);
            rest = after;
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// RFC 4648, section 4, with or without padding.
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let digits = text.iter().rposition(|byte| *byte != b'=').map_or(0, |last| last + 1);
    let mut bytes = Vec::with_capacity(digits / 4 * 3 + 2);
    for group in text[..digits].chunks(4) {
        let mut bits = 0_u32;
        for digit in group {
            let value = match digit {
                b'A'..=b'Z' => digit - b'A',
                b'a'..=b'z' => digit - b'a' + 26,
                b'0'..=b'9' => digit - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                _ => return None,
            };
            bits = bits << 6 | u32::from(value);
        }

        let missing = 4 - group.len() as u32;
        let [_, first, second, third] = (bits << (6 * missing)).to_be_bytes();
        let all = [first, second, third];
        match missing {
            3 => return None,
            missing => bytes.extend(&all[..3 - missing as usize]),
        }
    }

    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_rfc() {
        for (text, bytes) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg", "foob"),
            ("Zm9vYmFy", "foobar"),
        ] {
            assert_eq!(base64(text.as_bytes()).as_deref(), Some(bytes.as_bytes()), "{text}");
        }
        assert!(base64(b"Zm9vY").is_none() && base64(b"Zm 9").is_none());
    }

    #[test]
    fn names_are_of_files() {
        assert_eq!(name_of("a%20b%2Fc%zz%"), "a b/c%zz%");
        assert!(
            unusable("http://x/y.bin").is_some()
                && unusable("file:/etc/passwd").is_some()
                && unusable("").is_some()
        );
        assert!(unusable("../Textures/colormap.png").is_none());
    }
}
