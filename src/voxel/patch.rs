//! Changing a database in place, where it differs in little from the one that is to be there.
//!
//! ```text
//! pages come in the order in which they lie:
//!     the file to be changed has it at the very byte where it would be written  ──▶ it stays
//!     it was made anew                                                          ──▶ held in memory
//!     it moved, or more is held than may be  ──▶ all that came so far is written to a file of its own, and all that comes from now on
//! at the end, if it never came to that:
//!     blocks of 4096 bytes that differ, and gaps that are not zero ──▶ a journal of what they held ──▶ overwritten
//! ```
//! Readers hold a database by a lock that they share ([`super::open_to_read`]), and a change takes it alone; where it cannot have
//! that, the file of its own is written as well.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::EarlierFile;
use super::ahead::Ahead;
use super::assembly::Storage;
use super::format::{PAGE_ALIGNMENT, header as at};
use super::undo::{
    ByteRange, Ends, Record, is_of_another, journal_of, recover, remove_journal, stage, write_journal,
};

/// Bytes that are compared, and overwritten, at once.
const BLOCK: u64 = 4096;
/// Bytes between pages.
static GAP: [u8; PAGE_ALIGNMENT as usize] = [0; PAGE_ALIGNMENT as usize];

/// Destination of a database that is being written: a file of its own, or for the time being nowhere.
#[derive(Debug)]
pub(super) struct PartFile {
    file: File,
    patch: Mutex<Option<FileChange>>,
    ahead: Ahead,
}

/// A change that is being put together.
#[derive(Debug)]
struct FileChange {
    base: EarlierFile,
    /// State of the file when it was opened.
    known: FileSigns,
    /// Ranges that stay, in the order of their coming.
    kept: Vec<ByteRange>,
    held: BTreeMap<u64, Vec<u8>>,
    /// Bytes of `held`, and how many they may be.
    bytes: u64,
    most: u64,
}

/// Signs by which one tells whether somebody changed a file.
#[derive(Debug, Clone, PartialEq, Eq)]
struct FileSigns {
    length: u64,
    header: Record,
}

impl FileSigns {
    fn of(file: &File) -> io::Result<Self> {
        let mut header = [0; at::SIZE];
        file.read_at(0, &mut header)?;
        Ok(Self { length: file.metadata()?.len(), header })
    }
}

/// Bytes that a file does not have yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Piece<'a> {
    offset: u64,
    bytes: &'a [u8],
}

impl PartFile {
    pub fn new(file: File) -> Self {
        Self { file, patch: Mutex::new(None), ahead: Ahead::default() }
    }

    /// Changes `base` in place if it can be, and if no more than `most` bytes of it change. Before anything is written.
    pub fn patch(&self, base: &EarlierFile, most: u64) {
        let known = FileSigns::of(base.file()).ok().filter(|_| cfg!(unix));
        // What is written twice, to the journal and in place, should be far less than all of it.
        *self.lock() = known.map(|known| FileChange {
            base: base.clone(),
            most: most.min(known.length / 4),
            known,
            kept: Vec::new(),
            held: BTreeMap::new(),
            bytes: 0,
        });
    }

    /// Writes what is held to the file, and no more: who looks there for pages finds those, and not the ones that stay where they are.
    pub fn keep(&self) -> io::Result<()> {
        match self.lock().take() {
            Some(patch) => {
                patch.held.iter().try_for_each(|(offset, bytes)| self.file.write_at(*offset, bytes))
            }
            None => Ok(()),
        }
    }

    /// Ends a file of `length` bytes. Returns whether `target` was changed in place; otherwise the file has all.
    pub fn publish(&self, target: &Path, length: u64) -> io::Result<bool> {
        let Some(patch) = self.lock().take() else { return Ok(false) };
        if patch.apply(target, length)? {
            return Ok(true);
        }
        patch.spill(&self.file)?;
        self.file.sync_all()?;
        Ok(false)
    }

    fn lock(&self) -> MutexGuard<'_, Option<FileChange>> {
        self.patch.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Has the patch take what comes, or if it cannot, writes to the file what it has.
    fn is_taken(&self, take: impl FnOnce(&mut FileChange) -> io::Result<bool>) -> io::Result<bool> {
        let mut guard = self.lock();
        let Some(patch) = &mut *guard else { return Ok(false) };
        if take(patch)? {
            return Ok(true);
        }
        patch.spill(&self.file)?;
        *guard = None;
        Ok(false)
    }
}

impl Storage for PartFile {
    fn write_at(&self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        if self.is_taken(|patch| patch.hold(offset, bytes.len(), || Ok(bytes.to_vec())))? {
            return Ok(());
        }
        self.file.write_at(offset, bytes)?;
        self.ahead.wrote(bytes.len(), &self.file);
        Ok(())
    }

    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        let guard = self.lock();
        let Some(patch) = &*guard else {
            drop(guard);
            return self.file.read_at(offset, bytes);
        };
        if let Some(held) = patch.held_at(offset, bytes.len()) {
            bytes.copy_from_slice(held);
            return Ok(());
        }
        let base = patch.base.clone();
        drop(guard);
        base.file().read_at(offset, bytes)
    }

    fn copy_from(&self, offset: u64, file: &File, from: u64, length: usize) -> io::Result<()> {
        let read = || {
            let mut bytes = vec![0; length];
            file.read_at(from, &mut bytes).map(|()| bytes)
        };
        let is_taken = self.is_taken(|patch| match std::ptr::eq(file, patch.base.file()) {
            true if offset == from => {
                patch.kept.push(ByteRange { offset, length: length as u64 });
                Ok(true)
            }
            true => Ok(false),
            false => patch.hold(offset, length, read),
        })?;
        if !is_taken {
            self.file.copy_from(offset, file, from, length)?;
            self.ahead.wrote(length, &self.file);
        }
        Ok(())
    }

    fn flush(&self) -> io::Result<()> {
        if self.lock().is_some() {
            return Ok(());
        }
        self.ahead.end()?;
        self.file.sync_all()
    }
}

impl FileChange {
    /// Holds what comes at a byte, unless that would be too much.
    fn hold(
        &mut self,
        offset: u64,
        length: usize,
        bytes: impl FnOnce() -> io::Result<Vec<u8>>,
    ) -> io::Result<bool> {
        self.bytes += length as u64;
        if self.bytes > self.most {
            return Ok(false);
        }
        if length > 0 {
            self.held.insert(offset, bytes()?);
        }
        Ok(true)
    }

    fn held_at(&self, offset: u64, length: usize) -> Option<&[u8]> {
        let (begin, held) = self.held.range(..=offset).next_back()?;
        let start = usize::try_from(offset - begin).ok()?;
        held.get(start..start.checked_add(length)?)
    }

    /// Writes all that came so far to a file.
    fn spill(&self, file: &File) -> io::Result<()> {
        for ByteRange { offset, length } in &self.kept {
            file.copy_from(*offset, self.base.file(), *offset, *length as usize)?;
        }
        self.held.iter().try_for_each(|(offset, bytes)| file.write_at(*offset, bytes))
    }

    /// Changes the file in place, to be `length` bytes long; or says that this is not to be.
    fn apply(&self, target: &Path, length: u64) -> io::Result<bool> {
        let Some((0, header)) = self.held.first_key_value() else { return Ok(false) };
        let Ok(header) = Record::try_from(header.as_slice()) else { return Ok(false) };
        let Some(pieces) = self.pieces(length)? else { return Ok(false) };
        let ends = Ends { lengths: [self.known.length, length], headers: [self.known.header, header] };
        if pieces.is_empty() && ends.headers[0] == header && self.known.length == length {
            return Ok(true);
        }
        if self.known.length.saturating_sub(length) > self.most {
            return Ok(false);
        }

        let Some(file) = self.seize(target)? else { return Ok(false) };
        let (journal, ranges) = (journal_of(target), before(&pieces, &ends));
        if is_of_another(&journal, &file) {
            drop(file);
            self.hold_again()?;
            return Ok(false);
        }
        if write_journal(&journal, &file, &ends, &ranges).is_err() {
            // Nothing was changed yet. What cannot be removed is not whole, or of no use.
            let _ = remove_journal(&journal);
            drop(file);
            self.hold_again()?;
            return Ok(false);
        }

        let changed = overwrite(&file, &ends, &pieces);
        if changed.is_ok() {
            // The file is whole: whoever opens it next removes what is left.
            let _ = remove_journal(&journal);
            return Ok(true);
        }

        // What cannot be taken back now is when the file is opened next.
        let _ = file.write_at(0, &[0; at::SIZE]);
        drop(file);
        let _ = recover(target);

        changed.map(|()| true)
    }

    /// Lists the pieces that the file does not have yet, but for the header; `None` if pages lie otherwise than they can.
    fn pieces(&self, length: u64) -> io::Result<Option<Vec<Piece<'_>>>> {
        let mut all: Vec<(ByteRange, Option<&[u8]>)> = self.kept.iter().map(|range| (*range, None)).collect();
        all.extend(self.held.iter().map(|(offset, bytes)| {
            (ByteRange { offset: *offset, length: bytes.len() as u64 }, Some(bytes.as_slice()))
        }));
        all.sort_unstable_by_key(|(range, _)| range.offset);
        let (mut pieces, mut end, mut scratch) = (Vec::new(), 0, Vec::new());
        for (range, held) in all {
            let gap = range.offset.checked_sub(end).and_then(|gap| GAP.get(..usize::try_from(gap).ok()?));
            let Some(gap) = gap else { return Ok(None) };
            self.differing(end, gap, &mut scratch, &mut pieces)?;
            // The header comes last.
            if let Some(bytes) = held.filter(|_| range.offset > 0) {
                self.differing(range.offset, bytes, &mut scratch, &mut pieces)?;
            }
            end = range.offset + range.length;
        }
        Ok((end == length).then_some(pieces))
    }

    /// Adds the blocks of `bytes` that the file holds otherwise, or not at all.
    fn differing<'a>(
        &self,
        offset: u64,
        bytes: &'a [u8],
        scratch: &mut Vec<u8>,
        pieces: &mut Vec<Piece<'a>>,
    ) -> io::Result<()> {
        let there = self.known.length.saturating_sub(offset).min(bytes.len() as u64) as usize;
        scratch.resize(there, 0);
        self.base.file().read_at(offset, scratch)?;
        let mut start = 0;
        let mut open: Option<usize> = None;

        while start < bytes.len() {
            let at = offset + start as u64;
            let end = bytes.len().min(start + (BLOCK - at % BLOCK) as usize);
            let differs = scratch.get(start..end) != Some(&bytes[start..end]);
            match (differs, open) {
                (true, None) => open = Some(start),
                (false, Some(begin)) => {
                    pieces.push(Piece { offset: offset + begin as u64, bytes: &bytes[begin..start] });
                    open = None;
                }
                _ => {}
            }

            start = end;
        }

        pieces.extend(open.map(|begin| Piece { offset: offset + begin as u64, bytes: &bytes[begin..] }));
        Ok(())
    }

    /// Opens the file to be changed, for this build alone; `None` if that cannot be had.
    fn seize(&self, target: &Path) -> io::Result<Option<File>> {
        if !self.is_alone(target) {
            return Ok(None);
        }
        let Ok(file) = OpenOptions::new().read(true).write(true).open(target) else { return Ok(None) };
        let base = self.base.file();
        // Where there are no locks, there is no change in place.
        if !is_same(&file, base) || base.try_lock_shared().is_err() || base.unlock().is_err() {
            return Ok(None);
        }
        if file.try_lock().is_ok() && FileSigns::of(&file)? == self.known && self.is_alone(target) {
            return Ok(Some(file));
        }
        drop(file);
        self.hold_again()?;
        Ok(None)
    }

    /// Holds the file as a reader does once more, after it was let go for a moment.
    fn hold_again(&self) -> io::Result<()> {
        let is_held = self.base.file().try_lock_shared().is_ok();
        if is_held && FileSigns::of(self.base.file())? == self.known {
            return Ok(());
        }
        Err(io::Error::other("another build changed it meanwhile; repeat the command"))
    }

    /// Whether the file to be changed has this name, may be written, and has no other name.
    #[cfg(unix)]
    fn is_alone(&self, target: &Path) -> bool {
        use std::os::unix::fs::MetadataExt;
        let Ok((named, base)) =
            target.symlink_metadata().and_then(|named| Ok((named, self.base.file().metadata()?)))
        else {
            return false;
        };
        named.is_file()
            && (named.dev(), named.ino()) == (base.dev(), base.ino())
            && named.nlink() == 1
            && !named.permissions().readonly()
    }

    /// Answers that it is not known how many names a file has.
    #[cfg(not(unix))]
    fn is_alone(&self, _: &Path) -> bool {
        false
    }
}

#[cfg(unix)]
fn is_same(one: &File, other: &File) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |file: &File| file.metadata().map(|metadata| (metadata.dev(), metadata.ino())).ok();
    place(one).is_some_and(|place_of_one| place(other) == Some(place_of_one))
}

#[cfg(not(unix))]
fn is_same(_: &File, _: &File) -> bool {
    false
}

/// Ranges of the file that a change destroys.
fn before(pieces: &[Piece<'_>], ends: &Ends) -> Vec<ByteRange> {
    let [length, new_length] = ends.lengths;
    let inside = |piece: &Piece<'_>| {
        let end = length.min(piece.offset + piece.bytes.len() as u64);
        ByteRange { offset: piece.offset, length: end.saturating_sub(piece.offset) }
    };
    let cut = ByteRange { offset: new_length, length: length.saturating_sub(new_length) };
    pieces.iter().map(inside).chain([cut]).filter(|range| range.length > 0).collect()
}

/// Overwrites pieces of a file. While it is at it, the file has no header: nobody takes it for a database, wherever it is moved.
fn overwrite(file: &File, ends: &Ends, pieces: &[Piece<'_>]) -> io::Result<()> {
    stage();
    file.write_at(0, &[0; at::SIZE])?;
    stage();
    file.sync_all()?;
    stage();
    file.set_len(ends.lengths[1])?;
    for Piece { offset, bytes } in pieces {
        stage();
        file.write_at(*offset, bytes)?;
    }
    stage();
    file.sync_all()?;
    stage();
    file.write_at(0, &ends.headers[1])?;
    stage();
    file.sync_all()
}
