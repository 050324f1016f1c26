//! Byte order marks at the beginning of text files.

use std::path::Path;

use crate::error::{Error, Result};

/// Bytes that decide about a mark.
const LONGEST: usize = 4;

/// The mark that editors on Windows put before UTF-8.
const UTF_8: &[u8] = b"\xef\xbb\xbf";

/// Marks of encodings that are not read; the longer ones first, as they begin with shorter ones.
const OTHERS: [(&[u8], &str); 4] = [
    (b"\xff\xfe\0\0", "UTF-32"),
    (b"\0\0\xfe\xff", "UTF-32"),
    (b"\xff\xfe", "UTF-16"),
    (b"\xfe\xff", "UTF-16"),
];

/// The bytes of a text file without a mark of UTF-8.
///
/// # Errors
/// The mark of another encoding, with the command that writes the file anew.
pub fn unmarked<'b>(path: &Path, bytes: &'b [u8]) -> Result<&'b [u8]> {
    let head = &bytes[..bytes.len().min(LONGEST)];
    match OTHERS.iter().find(|(mark, _)| head.starts_with(mark)) {
        Some((_, name)) => Err(Error::unsupported(
            path,
            format!("is text in {name}, and UTF-8 is read"),
            format!("write it anew: iconv -f {name} -t UTF-8 IN > OUT"),
        )),
        None => Ok(bytes.strip_prefix(UTF_8).unwrap_or(bytes)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_skipped_or_named() {
        let path = Path::new("a.obj");
        assert_eq!(unmarked(path, b"\xef\xbb\xbfv 1").unwrap(), b"v 1");
        for sound in [&b""[..], b"v", b"\xef\xbb", b"v \xef\xbb\xbf"] {
            assert_eq!(unmarked(path, sound).unwrap(), sound);
        }
        for (bytes, name) in [
            (&b"\xff\xfev\0"[..], "UTF-16"),
            (b"\xfe\xff\0v", "UTF-16"),
            (b"\xff\xfe\0\0v\0\0\0", "UTF-32"),
            (b"\0\0\xfe\xff\0\0\0v", "UTF-32"),
        ] {
            let told = unmarked(path, bytes).unwrap_err().to_string();
            assert!(told.contains(name) && told.contains("iconv -f UTF"), "{told}");
        }
    }
}
