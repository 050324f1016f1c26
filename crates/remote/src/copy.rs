//! Sparse copy of a database, and the bits that say which of its blocks are there.
//!
//! ```text
//! fetched ──▶ write the bytes ──▶ there, for this process ──▶ wait for the disk ──▶ set the bits, under a lock ──▶ there, for everybody
//! ```
//! A process that is killed leaves bytes without bits, which are fetched again, and never bits without bytes.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::blocks::{BLOCK, BlockSet, blocks_of};
use super::positioned::{punch, read_at, write_at};
use hedgehop_base::error::{Error, Result};

/// Names in a database's folder: the copy, and its bits.
pub(crate) const DATA: &str = "area.hop";
pub(crate) const PRESENT: &str = "present";

/// Sparse copy of a database. Several processes may have it open; each maps it.
#[derive(Debug)]
pub(crate) struct SparseCopy {
    folder: PathBuf,
    length: u64,
    data: File,
    present: File,
    state: Mutex<CopyState>,
    /// Held while bits are brought to the disk.
    committing: Mutex<()>,
}

#[derive(Debug)]
struct CopyState {
    /// Blocks that are there, for this process.
    here: BlockSet,
    /// Blocks among them whose bits are not on the disk, as runs.
    fresh: Vec<Range<u64>>,
    /// Blocks that this process has read.
    used: BlockSet,
    is_closed: bool,
}

impl SparseCopy {
    /// Opens or makes the copy of a database of `length` bytes in a folder. Nobody else opens it meanwhile.
    pub fn open(folder: &Path, length: u64) -> Result<Self> {
        let refused = |error| Error::io(folder, "keep a copy of the database there", error);
        fs::create_dir_all(folder).map_err(refused)?;
        let (data, present) = (folder.join(DATA), folder.join(PRESENT));
        let bits = BlockSet::empty(length).bits().len() as u64;

        // Bits without their bytes say nothing; who still has them open goes on with both.
        let has_length =
            |file: &Path, length: u64| fs::metadata(file).is_ok_and(|found| found.len() == length);
        if !(has_length(&data, length) && has_length(&present, bits)) {
            for file in [&present, &data] {
                match fs::remove_file(file) {
                    Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(refused(error)),
                    _ => {}
                }
            }
        }

        let open = |file: &Path, length: u64| {
            let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(file)?;
            file.set_len(length)?;
            Ok(file)
        };
        let present = open(&present, bits).map_err(refused)?;
        let data = open(&data, length).map_err(refused)?;
        let copy = Self {
            folder: folder.to_owned(),
            length,
            data,
            present,
            state: Mutex::new(CopyState {
                here: BlockSet::empty(length),
                fresh: Vec::new(),
                used: BlockSet::empty(length),
                is_closed: false,
            }),
            committing: Mutex::default(),
        };
        copy.refresh(0..length)?;

        Ok(copy)
    }

    fn state(&self) -> MutexGuard<'_, CopyState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn failed(&self, action: &'static str) -> impl Fn(io::Error) -> Error {
        move |error| {
            let what = io::Error::new(error.kind(), format!("{error}; give another folder by --cache"));
            Error::io(&self.folder, action, what)
        }
    }

    /// Returns the file to be mapped.
    pub fn data(&self) -> Result<File> {
        self.data.try_clone().map_err(self.failed("open the copy"))
    }

    /// Whether all blocks of a range are there.
    pub fn has(&self, bytes: &Range<u64>) -> bool {
        self.state().here.has_all(blocks_of(bytes))
    }

    /// Whether a block is there.
    pub fn has_block(&self, block: u64) -> bool {
        self.state().here.has(block)
    }

    /// Notes that this process reads a range.
    pub fn mark_used(&self, bytes: &Range<u64>) {
        self.state().used.insert(blocks_of(bytes));
    }

    /// Learns which blocks of a range other processes have brought.
    pub fn refresh(&self, bytes: Range<u64>) -> Result<()> {
        let (first, mut bits) = stored_bits(&blocks_of(&bytes));
        read_at(&self.present, &mut bits, first as u64)
            .map_err(self.failed("read which parts of it are there"))?;
        self.state().here.unite(first, &bits);
        Ok(())
    }

    /// Writes whole blocks, the last one of the file apart.
    pub fn write(&self, bytes: &[u8], place: u64) -> Result<()> {
        if self.state().is_closed {
            return Ok(());
        }
        write_at(&self.data, bytes, place).map_err(self.failed("write the copy"))?;
        let blocks = blocks_of(&(place..place + bytes.len() as u64));
        let mut state = self.state();
        state.here.insert(blocks.clone());
        state.fresh.push(blocks);
        Ok(())
    }

    /// Brings to the disk what was written, then its bits.
    pub fn commit(&self) -> Result<()> {
        let _one = self.committing.lock().unwrap_or_else(PoisonError::into_inner);
        let fresh = std::mem::take(&mut self.state().fresh);
        // Once it is closed, others may free what the bits would say is there.
        if fresh.is_empty() || self.state().is_closed {
            return Ok(());
        }

        self.data.sync_data().map_err(self.failed("bring the copy to the disk"))?;
        self.change_bits(&fresh, |set, run| set.insert(run))
    }

    /// Has blocks of a range fetched again that are there, for this process and those to come.
    pub fn drop_blocks(&self, bytes: &Range<u64>) -> Result<()> {
        let _one = self.committing.lock().unwrap_or_else(PoisonError::into_inner);
        let blocks = blocks_of(bytes);
        // From the disk first: to learn what others have brought must not bring them back.
        self.change_bits(std::slice::from_ref(&blocks), |set, run| set.remove(run))?;
        let mut state = self.state();
        state.here.remove(blocks.clone());
        let fresh = std::mem::take(&mut state.fresh);
        let outside =
            |run: Range<u64>| [run.start..run.end.min(blocks.start), run.start.max(blocks.end)..run.end];
        state.fresh = fresh.into_iter().flat_map(outside).filter(|run| !run.is_empty()).collect();
        Ok(())
    }

    /// Changes bits on the disk, which others change, too.
    fn change_bits(&self, runs: &[Range<u64>], change: impl Fn(&mut BlockSet, Range<u64>)) -> Result<()> {
        let changed = || {
            self.present.lock()?;
            let change_run = |run: &Range<u64>| {
                let (first, mut bits) = stored_bits(run);
                read_at(&self.present, &mut bits, first as u64)?;
                let mut set = BlockSet::of_bits(bits);
                let shift = first as u64 * 8;
                change(&mut set, run.start - shift..run.end - shift);
                write_at(&self.present, set.bits(), first as u64)
            };
            let outcome = runs.iter().try_for_each(change_run);
            self.present.unlock()?;
            outcome
        };
        changed().map_err(self.failed("note which parts of it are there"))
    }

    /// Writes nothing from now on. What was not committed is fetched again by whoever needs it.
    pub fn close(&self) {
        let _one = self.committing.lock().unwrap_or_else(PoisonError::into_inner);
        self.state().is_closed = true;
    }

    /// Frees blocks until at most `allowed` bytes are there, those first that this process has not read. Nobody else may have the copy open, and nobody map it.
    pub fn shrink(&self, allowed: u64) -> Result<()> {
        let mut there = {
            let mut bits = BlockSet::empty(self.length).bits().to_vec();
            read_at(&self.present, &mut bits, 0).map_err(self.failed("read which parts of it are there"))?;
            BlockSet::of_bits(bits)
        };
        let excess = there.count().saturating_sub(allowed / BLOCK);
        let state = self.state();
        let (used, unused): (Vec<u64>, Vec<u64>) =
            there.runs().into_iter().flatten().rev().partition(|block| state.used.has(*block));
        drop(state);
        let mut gone = BlockSet::empty(self.length);
        for block in unused.into_iter().chain(used).take(excess as usize) {
            gone.insert(block..block + 1);
            there.remove(block..block + 1);
        }

        // Bits first: bytes without bits are fetched again.
        let written = write_at(&self.present, there.bits(), 0).and_then(|()| self.present.sync_data());
        written.map_err(self.failed("note which parts of it are there"))?;
        let is_freed = gone.runs().iter().all(|run| {
            let (start, end) = (run.start * BLOCK, (run.end * BLOCK).min(self.length));
            punch(&self.data, start, end - start)
        });
        if !is_freed {
            // Where files have no holes to be punched, all of it goes.
            let nothing = BlockSet::empty(self.length);
            let cleared = write_at(&self.present, nothing.bits(), 0).and_then(|()| self.present.sync_data());
            let emptied =
                cleared.and_then(|()| self.data.set_len(0)).and_then(|()| self.data.set_len(self.length));
            emptied.map_err(self.failed("free its disk space"))?;
        }

        Ok(())
    }
}

/// Finds the first byte of the bits of blocks, and makes room for as many bytes as hold them.
fn stored_bits(blocks: &Range<u64>) -> (usize, Vec<u8>) {
    let (first, end) = ((blocks.start / 8) as usize, blocks.end.div_ceil(8) as usize);
    (first, vec![0; end.saturating_sub(first)])
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENGTH: u64 = 40 * BLOCK + 7;

    fn at(block: u64) -> Range<u64> {
        block * BLOCK..(block + 1) * BLOCK
    }

    #[test]
    fn bits_reach_others_only_once_bytes_are_on_the_disk() {
        let folder = tempfile::tempdir().unwrap();
        let (one, other) = (SparseCopy::open(folder.path(), LENGTH), SparseCopy::open(folder.path(), LENGTH));
        let (one, other) = (one.unwrap(), other.unwrap());
        one.write(&[7; 2 * BLOCK as usize], 8 * BLOCK).unwrap();
        assert!(one.has(&at(9)) && !one.has(&at(10)));
        // As if `one` were killed now.
        other.refresh(0..LENGTH).unwrap();
        assert!(!other.has(&at(9)));
        assert!(!SparseCopy::open(folder.path(), LENGTH).unwrap().has(&at(8)));

        one.commit().unwrap();
        other.write(&[9; 7], 40 * BLOCK).unwrap();
        other.commit().unwrap();
        other.refresh(0..LENGTH).unwrap();
        assert!(other.has(&at(9)) && other.has(&(40 * BLOCK..LENGTH)));
        one.refresh(at(40)).unwrap();
        assert!(one.has_block(40) && !one.has_block(39));
    }

    #[test]
    fn dropped_blocks_are_gone_for_all() {
        let folder = tempfile::tempdir().unwrap();
        let copy = SparseCopy::open(folder.path(), LENGTH).unwrap();
        copy.write(&[7; 8 * BLOCK as usize], 0).unwrap();
        copy.commit().unwrap();
        copy.write(&[7; 4 * BLOCK as usize], 8 * BLOCK).unwrap();
        copy.drop_blocks(&(3 * BLOCK..9 * BLOCK)).unwrap();
        copy.refresh(0..LENGTH).unwrap();
        assert!(copy.has(&(0..3 * BLOCK)) && !copy.has_block(3) && !copy.has_block(8) && copy.has_block(9));
        copy.commit().unwrap();
        let again = SparseCopy::open(folder.path(), LENGTH).unwrap();
        let there: Vec<u64> = (0..41).filter(|block| again.has_block(*block)).collect();
        assert_eq!(there, [0, 1, 2, 9, 10, 11]);
    }

    #[test]
    fn shrinking_keeps_what_was_read_last() {
        let folder = tempfile::tempdir().unwrap();
        let copy = SparseCopy::open(folder.path(), LENGTH).unwrap();
        copy.write(&[7; 20 * BLOCK as usize], 0).unwrap();
        copy.mark_used(&(4 * BLOCK..8 * BLOCK));
        copy.commit().unwrap();
        copy.close();
        copy.write(&[8; BLOCK as usize], 0).unwrap();
        copy.commit().unwrap();
        copy.shrink(4 * BLOCK + 100).unwrap();
        let again = SparseCopy::open(folder.path(), LENGTH).unwrap();
        let there: Vec<u64> = (0..41).filter(|block| again.has_block(*block)).collect();
        assert_eq!(there, [4, 5, 6, 7]);
        let mut bytes = [1; BLOCK as usize];
        read_at(&again.data, &mut bytes, 4 * BLOCK).unwrap();
        assert_eq!(bytes, [7; BLOCK as usize]);
        #[cfg(target_os = "linux")]
        {
            read_at(&again.data, &mut bytes, 0).unwrap();
            assert_eq!(bytes, [0; BLOCK as usize], "freed, and not written to after it was closed");
        }
    }

    #[test]
    fn bits_without_their_bytes_are_not_believed() {
        let folder = tempfile::tempdir().unwrap();
        let copy = SparseCopy::open(folder.path(), LENGTH).unwrap();
        copy.write(&[7; BLOCK as usize], 0).unwrap();
        copy.commit().unwrap();
        fs::remove_file(folder.path().join(DATA)).unwrap();
        assert!(!SparseCopy::open(folder.path(), LENGTH).unwrap().has_block(0));
    }
}
