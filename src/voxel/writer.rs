//! Writing a database file: everything under a temporary name beside the target, which it takes
//! only when it is whole and on the disk; or the target is [changed in place](super::patch). A build that is killed leaves
//! `NAME.part-…`, whose header is missing.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use tempfile::TempPath;

use super::assembly::{Assembly, PageReadback, Storage};
use super::patch::PartFile;
use super::undo::{is_of_another, journal_of};
use super::{
    ContentHash, EarlierFile, EarlierPage, EncodedPage, Grid, HeightCode, HeightRange, Metadata, PageEntry,
    PageId, SharedObjects,
};
use crate::voxel::folders::{folder_of, sync_folder};
use hedgehop_base::error::{Error, Result};

impl Storage for File {
    #[cfg(unix)]
    fn write_at(&self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        std::os::unix::fs::FileExt::write_all_at(self, bytes, offset)
    }

    #[cfg(unix)]
    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(self, bytes, offset)
    }

    #[cfg(windows)]
    fn write_at(&self, mut offset: u64, mut bytes: &[u8]) -> io::Result<()> {
        while !bytes.is_empty() {
            let written = std::os::windows::fs::FileExt::seek_write(self, bytes, offset)?;
            if written == 0 {
                return Err(io::ErrorKind::WriteZero.into());
            }
            offset += written as u64;
            bytes = &bytes[written..];
        }
        Ok(())
    }

    #[cfg(windows)]
    fn read_at(&self, mut offset: u64, mut bytes: &mut [u8]) -> io::Result<()> {
        while !bytes.is_empty() {
            let read = std::os::windows::fs::FileExt::seek_read(self, bytes, offset)?;
            if read == 0 {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            offset += read as u64;
            bytes = &mut bytes[read..];
        }
        Ok(())
    }

    #[cfg(any(target_os = "linux", target_os = "android"))]
    fn copy_from(&self, offset: u64, file: &File, from: u64, length: usize) -> io::Result<()> {
        // The system copies within itself; some file systems only say that both files have the same bytes.
        let (mut to, mut at, mut left) = (offset, from, length);
        while left > 0 {
            match rustix::fs::copy_file_range(file, Some(&mut at), self, Some(&mut to), left) {
                Ok(copied) if copied > 0 => left -= copied,
                // Not between these files: by hand.
                _ => break,
            }
        }
        let mut bytes = vec![0; left];
        file.read_at(at, &mut bytes)?;
        self.write_at(to, &bytes)
    }

    fn flush(&self) -> io::Result<()> {
        self.sync_all()
    }
}

/// Writes a database under a temporary name beside the target; dropped before [`Self::finish`], it
/// removes what it wrote, unless it is [kept](Self::keep).
#[derive(Debug)]
pub struct PageWriter {
    assembly: Assembly,
    part: Arc<PartFile>,
    objects: Arc<SharedObjects>,
    target: PathBuf,
    temporary: TempPath,
    overwrite: bool,
}

impl PageWriter {
    /// Starts `path`; an error if it exists and `overwrite` is false.
    pub fn create(path: &Path, grid: Grid, heights: HeightCode, overwrite: bool) -> Result<Self> {
        Self::check_target(path, overwrite)?;
        let (file, temporary) = temporary_beside(path)?;
        let part = Arc::new(PartFile::new(file));
        let storage: Arc<dyn Storage> = Arc::clone(&part) as _;
        let assembly = Assembly::new(path, storage, grid, heights)?;
        Ok(Self { assembly, part, objects: Arc::default(), target: path.to_owned(), temporary, overwrite })
    }

    /// Refuses a `path` that no database can take: it exists and `overwrite` is false, or it is a folder, a device or
    /// a pipe, which a rename would destroy.
    pub fn check_target(path: &Path, overwrite: bool) -> Result<()> {
        let refuse = |what: &str| {
            let path = path.display();
            Err(Error::Configuration(format!("{path} is {what}; name a file with -o, like AREA.hop")))
        };
        // A dangling link is no obstacle; one to a device is as much a device as its target.
        let target = fs::metadata(path).or_else(|_| fs::symlink_metadata(path));
        match target {
            Ok(found) if found.is_dir() => refuse("a folder"),
            Ok(found) if !found.is_file() && !found.is_symlink() => refuse("no regular file"),
            Ok(_) if !overwrite => Err(already_exists(path)),
            _ => Ok(()),
        }
    }

    /// The temporary name.
    pub fn part(&self) -> &Path {
        &self.temporary
    }

    /// Adds objects that pages place.
    pub fn with_objects(self, objects: Arc<SharedObjects>) -> Self {
        Self { objects, ..self }
    }

    /// The target is `base`: where pages of it stay in their place, it is changed in place, if no more than `most` bytes are new and nobody reads it.
    /// Before the first page.
    #[must_use]
    pub fn patching(self, base: &EarlierFile, most: u64) -> Self {
        if self.overwrite {
            self.part.patch(base, most);
        }
        self
    }

    /// Leaves what was written so far under its temporary name, for one who comes after.
    pub fn keep(self) {
        // What cannot be kept is lost: it can be made again.
        let _ = self.part.keep();
        let _ = self.temporary.keep();
    }

    /// Appends a page; each id once, in any order. Pages lie in the file in the order of their coming, so the
    /// same pages in the same order give the same bytes; the identity does not depend on the order.
    pub fn append(&mut self, page: &EncodedPage) -> Result<()> {
        self.assembly.append(page)
    }

    /// Appends a page that was set aside in a file.
    pub(super) fn append_set_aside(&mut self, id: PageId, entry: PageEntry, aside: &File) -> Result<()> {
        self.assembly.append_copy(id, entry, aside)
    }

    /// Appends a page that another file holds.
    pub fn append_earlier(&mut self, page: &EarlierPage) -> Result<()> {
        self.assembly.append_copy(page.id, page.entry, page.file())
    }

    /// Says how many bytes all pages may come to, for who runs out of disk, if not all of the grid's are written.
    pub fn expect(&mut self, bytes: u64) {
        self.assembly.expect(bytes);
    }

    /// A file without a name in the folder of the target.
    pub(super) fn file_aside(&self) -> Result<File> {
        tempfile::tempfile_in(folder_of(&self.target))
            .map_err(|error| Error::io(&self.target, "create a file beside it", error))
    }

    /// A file that stays if the program is killed, as that of the pages does; it is removed when the path is dropped.
    pub(super) fn named_file_aside(&self) -> Result<(File, TempPath)> {
        temporary_beside(&self.target)
    }

    /// Makes the error of a disk that refuses something.
    pub(super) fn error(&self, action: &str, error: io::Error) -> Error {
        self.assembly.storage_error(action, error)
    }

    /// A handle that reads back pages appended so far, from any thread.
    pub fn readback(&self) -> PageReadback {
        self.assembly.readback()
    }

    /// Writes directory, metadata and header, flushes to disk and gives the file its name. Returns identity and bytes.
    pub fn finish(self, metadata: &Metadata, height_range: HeightRange) -> Result<(ContentHash, u64)> {
        let sealed = self.seal(metadata, height_range)?;
        let result = (sealed.content_hash, sealed.bytes);
        sealed.publish().map(|()| result)
    }

    /// All of [`Self::finish`] but the name.
    pub fn seal(self, metadata: &Metadata, height_range: HeightRange) -> Result<SealedFile> {
        let (content_hash, bytes) = self.assembly.seal(metadata, &self.objects, height_range)?;
        Ok(SealedFile { content_hash, bytes, writer: self })
    }

    fn publish(self, bytes: u64) -> Result<()> {
        let Self { target, temporary, overwrite, part, assembly, .. } = self;
        let is_patched = part
            .publish(&target, bytes)
            .map_err(|error| assembly.storage_error("write it to the disk", error))?;
        if is_patched {
            return Ok(());
        }

        let journal = journal_of(&target);
        let has_own_journal = File::open(&target).is_ok_and(|file| !is_of_another(&journal, &file));
        let renamed =
            if overwrite { temporary.persist(&target) } else { temporary.persist_noclobber(&target) };
        renamed.map_err(|failure| match failure.error.kind() {
            io::ErrorKind::AlreadyExists => already_exists(&target),
            _ => Error::io(&target, "give the finished file this name", failure.error),
        })?;

        // What was of the file before goes with it, and what is of one that was moved away waits for that.
        if has_own_journal {
            let _ = fs::remove_file(journal);
        }

        sync_folder(folder_of(&target))
            .map_err(|error| Error::io(&target, "flush its folder to the disk", error))
    }
}

/// A database that is whole but for its name; dropped, it is removed.
#[derive(Debug)]
pub struct SealedFile {
    writer: PageWriter,
    /// Hash of the content.
    pub content_hash: ContentHash,
    /// Bytes of the file.
    pub bytes: u64,
}

impl SealedFile {
    /// Gives the file its name, or makes the one that has it the same; it is on the disk then.
    ///
    /// # Errors
    /// What was there before is there still.
    pub fn publish(self) -> Result<()> {
        self.writer.publish(self.bytes)
    }
}

/// A new file `NAME.part-…` in the folder of `path`, locked.
fn temporary_beside(path: &Path) -> Result<(File, TempPath)> {
    let name = path.file_name().ok_or_else(|| Error::invalid(path, "no file name to write a database to"))?;
    let mut prefix = name.to_owned();
    prefix.push(".part-");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix);
    // A database is as readable as any file that the user makes; temporary files would be private.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let made = builder.tempfile_in(folder_of(path));
    let (file, temporary) =
        made.map_err(|error| Error::io(path, "create a file beside it", error))?.into_parts();
    // Held until the file is closed: who finds one that nobody holds knows that its writer is gone. File systems without locks
    // leave that open.
    let _ = file.try_lock();
    Ok((file, temporary))
}

fn already_exists(path: &Path) -> Error {
    Error::Configuration(format!(
        "{} exists already; give --overwrite to replace it, or another name with -o",
        path.display()
    ))
}
