//! A database that builds keep under one name gets another one, with its log.
//!
//! ```text
//! FROM.steps ──copied──▶ TO.part-taken.steps │ FROM ──▶ TO │ TO.part-taken.steps ──▶ TO.steps │ FROM.steps goes
//! killed before FROM has its new name: both databases are as they were, and their logs, too
//! killed after it:                     the log is found, like that of any build that was killed before it could give it its name
//! ```

use std::ffi::OsString;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use super::log::{KnownSteps, Log, Stamp};
use super::{TICK, beside, forget, parts, stamp};
use hedgehop::voxel::EarlierFile;
use hedgehop_base::error::{Error, Result};

/// Ends the name of the part that a log is of while it is on its way.
const ON_ITS_WAY: &str = ".part-taken";

/// Gives the database that builds keep at `from` the name `to`, with what is known of its cacheto` makes only what changed.
/// What was at `to` is replaced, and nothing is left of either build.
///
/// # Errors
/// What the disk refuses; both are then what they were.
pub fn take_over(from: &Path, to: &Path) -> Result<()> {
    let known = KnownSteps::read(&beside(from)).left.filter(|left| stamp(from).is_ok_and(|now| now == *left));
    let mut part = OsString::from(to);
    part.push(ON_ITS_WAY);
    let on_its_way = beside(&PathBuf::from(part));

    // Of a build that was killed here.
    let _ = fs::remove_file(&on_its_way);
    let mut log = Log::after(fs::read(beside(from)).map_err(|error| Error::io(beside(from), "read", error))?);
    log.begin(&on_its_way)
        .map_err(|error| Error::io(&on_its_way, "write what is known of the pages", error))?;
    fs::rename(from, to).map_err(|error| Error::io(to, "give the finished file this name", error))?;

    // A new name is a change of the file to the system, but of none of its bytes. What is changed from now on has another time.
    std::thread::sleep(TICK);
    if let Some((before, now)) = known.zip(stamp(to).ok())
        && is_renamed(&before, &now)
    {
        log.left(&now);
        // Without it the next build reads all pages.
        let _ = log.write();
    }

    // Where this fails, the next build finds the log under the name that it has.
    if let Some(path) = log.keep() {
        let _ = fs::rename(path, beside(to));
    }
    // What cannot be removed takes room, and no more.
    let _ = fs::remove_file(beside(from));
    let left = parts(from).into_iter().chain(parts(to));

    // Others may be written still.
    left.filter(|part| EarlierFile::open_abandoned(part).is_some()).for_each(|part| forget(&part));
    flush_folder(to).map_err(|error| Error::io(to, "flush its folder to the disk", error))
}

/// Whether a file is what it was but for the time of its last change, which a new name sets.
fn is_renamed(before: &Stamp, now: &Stamp) -> bool {
    let but_for_change = |stamp: &Stamp| [stamp.times.first().copied(), stamp.times.get(2).copied()];
    now.is_fine() && before.bytes == now.bytes && but_for_change(before) == but_for_change(now)
}

/// Makes a new name durable; only Unix can flush a folder.
fn flush_folder(file: &Path) -> std::io::Result<()> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}
