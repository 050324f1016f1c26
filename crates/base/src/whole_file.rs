//! Files that are read whole.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::{Error, Result};

/// Reads all bytes of a regular file: what never ends, or waits for somebody to write, is refused.
///
/// # Errors
/// [`Error::Io`]; [`Error::Invalid`] of what is no regular file, or has more than `most` bytes.
pub fn read_whole_file(path: &Path, most: u64) -> Result<Vec<u8>> {
    let io = |source| Error::io(path, "read", source);
    let about = std::fs::metadata(path).map_err(io)?;
    if about.is_dir() {
        return Err(Error::invalid(path, "is a folder; name a file"));
    }
    if !about.is_file() {
        return Err(Error::invalid(path, "is no regular file; name one"));
    }

    let mut bytes = Vec::new();
    File::open(path).map_err(io)?.take(most + 1).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > most {
        return Err(Error::invalid(path, format!("has more than {most} bytes, which is too large")));
    }
    Ok(bytes)
}
