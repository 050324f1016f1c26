//! The journal of a change in place: what a database held before, so that a change that was stopped can be taken back.
//!
//! ```text
//! AREA.hop.undo: magic | bytes of the file before (8 bytes) and after (8) | ranges (8) | header before (256) and after (256)
//!                | of each range where it begins (8) and its bytes (8) | what all ranges held | BLAKE3 of all before (32)
//!
//! change:   lock AREA.hop alone │ write the journal │ header to zeros │ overwrite the ranges │ header after │ remove the journal
//! recover:  header before or after: the file is whole, remove the journal
//!           header of zeros or torn: overwrite the ranges with what they held │ header before │ remove the journal
//! ```
//! Every │ waits for the disk. So a header that is valid says that all of its file is, whatever was stopped where; and a journal that is not whole
//! says that nothing was overwritten yet. After "Transaction Processing" (Gray and Reuter 1993, §9): undo logging, write-ahead.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::assembly::Storage;
use super::format::header as at;
use crate::voxel::folders::{folder_of, sync_folder};
use hedgehop_base::error::{Error, Result};

/// Ending of a journal's name.
const SUFFIX: &str = ".undo";
const MAGIC: [u8; 8] = *b"HOPUNDO1";
/// Bytes before the table of ranges, of an entry of it, and of the checksum.
const HEAD: u64 = 8 + 3 * 8 + 2 * at::SIZE as u64;
const ENTRY: u64 = 16;
const HASH: u64 = 32;
/// Bytes that are copied at a time.
const CHUNK: usize = 1 << 16;
/// Longest wait for one who changes a database: for its disk, that is.
const PATIENCE: Duration = Duration::from_secs(30);
const PAUSE: Duration = Duration::from_millis(5);

/// The first bytes of a database.
pub(super) type Record = [u8; at::SIZE];

/// Bytes of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ByteRange {
    pub offset: u64,
    pub length: u64,
}

/// Changes of a file besides its ranges.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Ends {
    /// Bytes of the file, before and after.
    pub lengths: [u64; 2],
    /// Headers before and after.
    pub headers: [Record; 2],
}

/// State of a file by its header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum UndoState {
    /// Whole: as it was before the change, or as it is after it.
    Whole,
    /// The change was stopped.
    Half,
    /// Another file.
    Foreign,
}

impl Ends {
    fn state(&self, file: &File) -> io::Result<UndoState> {
        let length = file.metadata()?.len();
        let mut record = [0; at::SIZE];
        if length < at::SIZE as u64 {
            return Ok(UndoState::Foreign);
        }
        file.read_at(0, &mut record)?;
        let [before, after] = &self.headers;
        if (0..2).any(|side| record == self.headers[side] && length == self.lengths[side]) {
            return Ok(UndoState::Whole);
        }
        let [least, most] = [self.lengths[0].min(self.lengths[1]), self.lengths[0].max(self.lengths[1])];
        let is_torn = record
            .iter()
            .zip(before.iter().zip(after))
            .all(|(now, (b, a))| *now == 0 || now == b || now == a);
        Ok(if is_torn && (least..=most).contains(&length) { UndoState::Half } else { UndoState::Foreign })
    }
}

/// A whole journal, opened.
#[derive(Debug)]
struct Journal {
    ends: Ends,
    ranges: Vec<ByteRange>,
    file: File,
}

impl Journal {
    /// The journal at `path`; `None` if there is none, or none that is whole.
    fn read(path: &Path) -> io::Result<Option<Self>> {
        let file = match File::open(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            file => file?,
        };
        let length = file.metadata()?.len();
        match Self::parse(&file, length) {
            // What ends too early was never finished.
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(None),
            Err(error) => Err(error),
            Ok(parsed) => Ok(parsed.map(|(ends, ranges)| Self { ends, ranges, file })),
        }
    }

    fn parse(file: &File, length: u64) -> io::Result<Option<(Ends, Vec<ByteRange>)>> {
        if length < HEAD + HASH || !is_intact(file, length)? {
            return Ok(None);
        }

        let mut reader = BufReader::new(file);
        io::Seek::seek(&mut reader, io::SeekFrom::Start(MAGIC.len() as u64))?;
        let lengths = [number(&mut reader)?, number(&mut reader)?];
        let count = number(&mut reader)?;
        let mut headers = [[0; at::SIZE]; 2];
        headers.iter_mut().try_for_each(|header| reader.read_exact(header))?;
        if count > (length - HEAD - HASH) / ENTRY {
            return Ok(None);
        }

        let mut ranges = Vec::new();
        let mut end = HEAD + count * ENTRY + HASH;
        for _ in 0..count {
            let range = ByteRange { offset: number(&mut reader)?, length: number(&mut reader)? };
            let is_inside = range.offset.checked_add(range.length).is_some_and(|end| end <= lengths[0]);
            let Some(sum) = end.checked_add(range.length).filter(|_| is_inside) else { return Ok(None) };
            end = sum;
            ranges.push(range);
        }

        Ok((end == length).then_some((Ends { lengths, headers }, ranges)))
    }

    /// Gives `target` back what it held.
    fn take_back(&self, target: &File) -> io::Result<()> {
        stage();
        target.set_len(self.ends.lengths[0])?;
        let mut from = HEAD + self.ranges.len() as u64 * ENTRY;
        for range in &self.ranges {
            stage();
            copy(&self.file, from, target, *range)?;
            from += range.length;
        }
        stage();
        target.sync_all()?;
        stage();
        target.write_at(0, &self.ends.headers[0])?;
        target.sync_all()
    }
}

fn number(reader: &mut impl Read) -> io::Result<u64> {
    let mut bytes = [0; 8];
    reader.read_exact(&mut bytes)?;
    Ok(u64::from_le_bytes(bytes))
}

/// Whether a file of so many bytes begins as a journal does, and ends with its checksum.
fn is_intact(file: &File, length: u64) -> io::Result<bool> {
    let mut magic = [0; MAGIC.len()];
    file.read_at(0, &mut magic)?;
    if magic != MAGIC {
        return Ok(false);
    }
    let (mut hasher, mut chunk, mut at) = (blake3::Hasher::new(), vec![0; CHUNK], 0);
    while at < length - HASH {
        let bytes = &mut chunk[..(length - HASH - at).min(CHUNK as u64) as usize];
        file.read_at(at, bytes)?;
        hasher.update(bytes);
        at += bytes.len() as u64;
    }
    let mut hash = [0; HASH as usize];
    file.read_at(at, &mut hash)?;
    Ok(hasher.finalize() == hash)
}

/// Copies bytes of a file, from `from` on, to a range of another.
fn copy(source: &File, from: u64, target: &File, range: ByteRange) -> io::Result<()> {
    let (mut chunk, mut done) = (vec![0; CHUNK], 0);
    while done < range.length {
        let bytes = &mut chunk[..(range.length - done).min(CHUNK as u64) as usize];
        source.read_at(from + done, bytes)?;
        target.write_at(range.offset + done, bytes)?;
        done += bytes.len() as u64;
    }
    Ok(())
}

/// The journal of a database, which lies beside the file itself, by whatever links it is called.
pub(super) fn journal_of(database: &Path) -> PathBuf {
    let mut name = database.canonicalize().unwrap_or_else(|_| database.to_owned()).into_os_string();
    name.push(SUFFIX);
    name.into()
}

/// Writes the journal of a change of `base`, and waits for the disk.
pub(super) fn write_journal(path: &Path, base: &File, ends: &Ends, ranges: &[ByteRange]) -> io::Result<()> {
    stage();
    let mut writer = BufWriter::with_capacity(CHUNK, File::create(path)?);
    let mut hasher = blake3::Hasher::new();
    let mut put = |bytes: &[u8]| {
        hasher.update(bytes);
        writer.write_all(bytes)
    };
    put(&MAGIC)?;
    for number in [ends.lengths[0], ends.lengths[1], ranges.len() as u64] {
        put(&number.to_le_bytes())?;
    }

    ends.headers.iter().try_for_each(|header| put(header))?;
    for ByteRange { offset, length } in ranges {
        put(&offset.to_le_bytes())?;
        put(&length.to_le_bytes())?;
    }

    let mut chunk = vec![0; CHUNK];
    for range in ranges {
        let mut done = 0;
        while done < range.length {
            let bytes = &mut chunk[..(range.length - done).min(CHUNK as u64) as usize];
            base.read_at(range.offset + done, bytes)?;
            put(bytes)?;
            done += bytes.len() as u64;
        }
    }

    let hash = hasher.finalize();
    writer.flush()?;
    stage();
    writer.write_all(hash.as_bytes())?;
    writer.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()?;

    sync_folder(folder_of(path))
}

/// Removes a journal that is done with.
pub(super) fn remove_journal(path: &Path) -> io::Result<()> {
    stage();
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => sync_folder(folder_of(path)),
    }
}

/// Takes back a change of `database` that was stopped, and removes a journal that is of no more use. Nothing happens while somebody
/// else holds the file: who reads it found it whole, and who changes it is not done.
///
/// # Errors
/// There is a journal, and the file cannot be written.
pub(super) fn recover(database: &Path) -> io::Result<()> {
    let path = journal_of(database);
    if !path.is_file() || !database.is_file() {
        return Ok(());
    }

    let target = OpenOptions::new().read(true).write(true).open(database)?;
    match target.try_lock() {
        Err(TryLockError::WouldBlock) => return Ok(()),
        locked => locked?,
    }

    // Read now: who held the file may have removed it.
    let Some(journal) = Journal::read(&path)? else {
        // One that was never finished belongs to a file that is whole; beside another it may be all that is left of what was there.
        return if has_header(&target) { remove_journal(&path) } else { Err(damaged()) };
    };

    match journal.ends.state(&target)? {
        UndoState::Whole => remove_journal(&path),
        UndoState::Half => journal.take_back(&target).and_then(|()| remove_journal(&path)),
        // It is another file's, which may come back.
        UndoState::Foreign => Ok(()),
    }
}

/// Whether a change of `file` was stopped: its journal says so, or cannot be read while the file has no header.
fn is_half_changed(database: &Path, file: &File) -> bool {
    let path = journal_of(database);
    match Journal::read(&path) {
        Ok(Some(journal)) => journal.ends.state(file).is_ok_and(|state| state == UndoState::Half),
        Ok(None) | Err(_) => path.is_file() && !has_header(file),
    }
}

/// Whether a journal at `path` is that of another file than `database`, which may come back for it.
pub(super) fn is_of_another(path: &Path, database: &File) -> bool {
    let journal = Journal::read(path).ok().flatten();
    journal.is_some_and(|journal| journal.ends.state(database).is_ok_and(|state| state == UndoState::Foreign))
}

fn has_header(file: &File) -> bool {
    let mut record: Record = [0; at::SIZE];
    file.read_at(0, &mut record).is_ok() && record.iter().any(|byte| *byte != 0)
}

fn damaged() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, "the journal is damaged")
}

/// Whether a file that somebody holds has no header because it is new: while one is changed, there is a journal.
fn is_being_made(database: &Path, file: &File) -> bool {
    !has_header(file) && !journal_of(database).exists()
}

/// Opens a database so that nobody changes it in place while it is open. A change that was stopped is taken back before; one that is going on
/// is waited for.
///
/// # Errors
/// There is no such file; a change that was stopped cannot be taken back; somebody writes it, and does not end.
pub fn open_to_read(database: &Path) -> Result<File> {
    let begun = Instant::now();
    loop {
        let recovered = recover(database);
        let open = |error| Error::io(database, "open it as a database", error);
        let file = File::open(database).map_err(open)?;
        let is_late = begun.elapsed() > PATIENCE;

        match file.try_lock_shared() {
            Err(TryLockError::WouldBlock) if is_late || is_being_made(database, &file) => {
                let what = "another process is writing it; repeat the command when that one has ended";
                return Err(open(io::Error::new(io::ErrorKind::ResourceBusy, what)));
            }
            Err(TryLockError::WouldBlock) => {}
            // Where a file system has no locks, nothing is changed in place.
            Ok(()) | Err(TryLockError::Error(_)) if !is_half_changed(database, &file) => return Ok(file),
            Ok(()) | Err(TryLockError::Error(_)) => match recovered {
                Err(why) => return Err(stuck(database, &why)),
                // Who held it has gone meanwhile.
                Ok(()) if is_late => return Err(stuck(database, &io::ErrorKind::TimedOut.into())),
                Ok(()) => {}
            },
        }

        drop(file);
        std::thread::sleep(PAUSE);
    }
}

fn stuck(database: &Path, why: &io::Error) -> Error {
    let journal = journal_of(database);
    Error::invalid(
        database,
        format!(
            "a build was stopped while it changed it, and what it held before cannot be written back from {}: {why}; \
             make the database, the journal and their folder writable and repeat the command, or build it again with --overwrite",
            journal.display()
        ),
    )
}

/// A place where tests stop a change, as a kill would.
pub(super) fn stage() {
    #[cfg(test)]
    super::tests::patching::stage();
}
