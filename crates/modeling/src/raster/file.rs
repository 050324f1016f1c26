//! An input file: reads at positions, from any thread, checked against its length.

use std::fs::File;
use std::path::{Path, PathBuf};

use hedgehop_base::error::{Error, Result};

/// A file that is read at given positions.
#[derive(Debug)]
pub(crate) struct InputFile {
    path: PathBuf,
    file: File,
    length: u64,
}

impl InputFile {
    /// Opens a file; directories, devices and pipes are refused.
    pub fn open(path: &Path) -> Result<Self> {
        // Before it is opened, since opening a pipe waits for its writer.
        if std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
            return Err(Error::invalid(path, "is no regular file; write its content to one first"));
        }
        let file = File::open(path).map_err(|e| Error::io(path, "open", e))?;
        let metadata = file.metadata().map_err(|e| Error::io(path, "examine", e))?;
        if metadata.is_dir() {
            return Err(Error::invalid(path, "is a directory; name the raster files in it"));
        }
        Ok(Self { path: path.to_owned(), file, length: metadata.len() })
    }

    /// Returns the path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the length, bytes.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Another handle that reads sequentially from its own position.
    pub fn reopen(&self) -> Result<File> {
        File::open(&self.path).map_err(|e| Error::io(&self.path, "open", e))
    }

    /// Fills `buffer` from byte `offset` on.
    pub fn read_at(&self, buffer: &mut [u8], offset: u64) -> Result<()> {
        self.check(offset, buffer.len() as u64)?;
        read_exact_at(&self.file, buffer, offset)
            .map_err(|e| Error::io(&self.path, format!("read {} bytes at byte {offset}", buffer.len()), e))
    }

    /// `length` bytes from byte `offset` on; allocates nothing unless the file holds them.
    pub fn bytes_at(&self, offset: u64, length: u64) -> Result<Vec<u8>> {
        self.check(offset, length)?;
        let size = usize::try_from(length).map_err(|_| {
            Error::invalid(&self.path, format!("{length} bytes at byte {offset} exceed memory"))
        })?;
        let mut bytes = vec![0; size];
        self.read_at(&mut bytes, offset)?;
        Ok(bytes)
    }

    /// Up to `length` bytes from the beginning.
    pub fn head(&self, length: u64) -> Result<Vec<u8>> {
        self.bytes_at(0, length.min(self.length))
    }

    fn check(&self, offset: u64, length: u64) -> Result<()> {
        match offset.checked_add(length) {
            Some(end) if end <= self.length => Ok(()),
            _ => Err(Error::invalid(
                &self.path,
                format!(
                    "holds {} bytes, but {length} bytes at byte {offset} are needed; it is cut short or damaged, fetch it again",
                    self.length
                ),
            )),
        }
    }
}

#[cfg(unix)]
pub(crate) fn read_exact_at(file: &File, buffer: &mut [u8], offset: u64) -> std::io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, buffer, offset)
}

#[cfg(windows)]
pub(crate) fn read_exact_at(file: &File, mut buffer: &mut [u8], mut offset: u64) -> std::io::Result<()> {
    use std::os::windows::fs::FileExt;
    while !buffer.is_empty() {
        match file.seek_read(buffer, offset)? {
            0 => return Err(std::io::ErrorKind::UnexpectedEof.into()),
            count => {
                buffer = &mut buffer[count..];
                offset += count as u64;
            }
        }
    }
    Ok(())
}
