//! Memory of what was behind a URL last, so that a database which did not change is opened without fetching anything.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::address::Address;
use super::validator::Validator;

/// First line of a file that this version reads.
const FIRST_LINE: &str = "hedgehop 1";

/// Database that was behind a URL.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Known {
    /// State of the database.
    pub validator: Validator,
    /// First bytes of the database.
    pub start: Vec<u8>,
}

/// Names the file for a URL, by a hash of all of it: databases may differ by their queries alone.
fn file(folder: &Path, address: &Address) -> PathBuf {
    let hash = blake3::hash(address.secret().as_bytes()).to_hex();
    folder.join(format!("url-{}.txt", &hash[..32]))
}

impl Known {
    /// Reads what was behind a URL; `None`: nobody knows.
    pub fn read(folder: &Path, address: &Address) -> Option<Self> {
        let text = fs::read_to_string(file(folder, address)).ok()?;
        let mut lines = text.lines();
        lines.next().filter(|line| *line == FIRST_LINE)?;
        let etag = lines.next().filter(|etag| !etag.contains(char::is_control))?.to_owned();
        let length = lines.next()?.parse().ok()?;
        let hex = lines.next()?.as_bytes();
        let digit = |byte: u8| char::from(byte).to_digit(16);
        let byte = |pair: &[u8; 2]| Some((digit(pair[0])? << 4 | digit(pair[1])?) as u8);
        let start = hex.as_chunks::<2>().0.iter().map(byte).collect::<Option<Vec<u8>>>()?;
        // All of it was written.
        lines.next().filter(|line| *line == "end")?;
        let validator = Validator { etag: Some(etag), last_modified: None, length };
        validator.strong_etag().is_some().then_some(Self { validator, start })
    }

    /// Writes it, if it can be told from what comes later; failures cost another request.
    pub fn write(&self, folder: &Path, address: &Address) {
        let Some(etag) = self.validator.strong_etag() else { return };
        let mut hex = String::new();
        for byte in &self.start {
            // Writing to a string does not fail.
            let _ = write!(hex, "{byte:02x}");
        }
        let text = format!("{FIRST_LINE}\n{etag}\n{}\n{hex}\nend\n", self.validator.length);
        if let Ok(mut written) = tempfile::NamedTempFile::new_in(folder)
            && written.write_all(text.as_bytes()).is_ok()
        {
            let _ = written.persist(file(folder, address));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read_and_the_url_is_not_in_it() {
        let folder = tempfile::tempdir().unwrap();
        let address = Address::of("https://me:secret@host/area.hop?signature=hidden").unwrap();
        let validator = Validator { etag: Some("\"a b\"".into()), last_modified: None, length: 12345 };
        let known = Known { validator, start: (0..=255).collect() };
        known.write(folder.path(), &address);
        assert_eq!(Known::read(folder.path(), &address), Some(known));
        assert_eq!(Known::read(folder.path(), &Address::of("https://host/area.hop?other").unwrap()), None);
        let written: Vec<_> =
            fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path()).collect();
        let text = fs::read_to_string(&written[0]).unwrap() + &written[0].display().to_string();
        assert!(!text.contains("secret") && !text.contains("hidden"), "{text}");
    }

    #[test]
    fn weak_tags_are_not_remembered() {
        let folder = tempfile::tempdir().unwrap();
        let address = Address::of("https://host/area.hop").unwrap();
        let validator = Validator { etag: Some("W/\"a\"".into()), last_modified: None, length: 1 };
        Known { validator, start: vec![1] }.write(folder.path(), &address);
        assert_eq!(Known::read(folder.path(), &address), None);
    }
}
