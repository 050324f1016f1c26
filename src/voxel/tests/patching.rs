//! Databases that are changed in place: always the bytes from before or those from after, whatever is stopped where.

use std::cell::Cell;
use std::fs::{self, File, OpenOptions};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use super::super::fixed_header::FixedHeader;
use super::*;
use crate::voxel::undo::journal_of;

thread_local! {
    static LEFT: Cell<u32> = const { Cell::new(u32::MAX) };
}

/// Stops here if it is time to.
pub fn stage() {
    let left = LEFT.get();
    LEFT.set(left.saturating_sub(1));
    assert!(left > 0, "stopped");
}

/// Does something, but for what comes after so many stages; `None` if it was stopped.
fn until<T>(stages: u32, act: impl FnOnce() -> T) -> Option<T> {
    LEFT.set(stages);
    let result = catch_unwind(AssertUnwindSafe(act));
    LEFT.set(u32::MAX);
    result.ok()
}

/// A database, and one that differs from it in a page of each level and in its metadata.
struct Change {
    before: MemPages,
    after: MemPages,
    note: &'static str,
    folder: tempfile::TempDir,
}

impl Change {
    fn new(note_before: &str, note: &'static str) -> Self {
        let mut terrain = Terrain::new(1100, 900, 0.0, 11);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("area.hop");
        let before = Metadata { notes: vec![note_before.into()], ..Metadata::default() };
        write_arrays(&path, &terrain.arrays(), &before, false).unwrap();
        let before = MemPages::from_bytes(&path, &fs::read(&path).unwrap()).unwrap();
        terrain.colours[300 * 1100 + 300] = [1, 2, 3];
        terrain.colours[301 * 1100 + 300] = [1, 2, 3];
        let clean = folder.path().join("clean");
        let metadata = Metadata { notes: vec![note.into()], ..Metadata::default() };
        write_arrays(&clean, &terrain.arrays(), &metadata, false).unwrap();
        let after = MemPages::from_bytes(&path, &fs::read(&clean).unwrap()).unwrap();
        fs::remove_file(clean).unwrap();
        Self { before, after, note, folder }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("area.hop")
    }

    fn journal(&self) -> PathBuf {
        self.folder.path().join("area.hop.undo")
    }

    fn restore(&self) {
        // Not in place: tests ask whether it is the same file.
        let _ = fs::remove_file(self.path());
        let _ = fs::remove_file(self.journal());
        fs::write(self.path(), self.before.bytes()).unwrap();
    }

    /// Makes one of the other; an error is one of the writer.
    fn make(&self) -> Result<(), hedgehop_base::error::Error> {
        let header = self.after.header();
        let base = EarlierFile::open(&self.path()).unwrap();
        let mut writer =
            PageWriter::create(&self.path(), header.grid, header.heights, true)?.patching(&base, 64 << 20);
        let mut all: Vec<_> = self.after.directory().present().collect();
        all.sort_by_key(|(_, entry)| entry.offset);
        let mut scratch = Vec::new();

        for (id, entry) in all {
            let old = self.before.directory().get(id).unwrap();
            if old.hash == entry.hash {
                writer.append_earlier(&base.page(&header.grid, id, old, &mut scratch).unwrap())?;
            } else {
                let page = self.after.whole_page(id).unwrap().unwrap().to_buffer();
                writer.append(&page.encode(id))?;
                assert_eq!(writer.readback().page(id)?, Some(page));
            }
        }

        let metadata = Metadata { notes: vec![self.note.into()], ..Metadata::default() };
        writer.finish(&metadata, header.height_range).map(drop)
    }

    fn is_before(&self) -> bool {
        fs::read(self.path()).unwrap() == self.before.bytes()
    }

    fn is_after(&self) -> bool {
        fs::read(self.path()).unwrap() == self.after.bytes()
    }

    /// Whether there is nothing beside it.
    fn is_alone(&self) -> bool {
        fs::read_dir(self.folder.path()).unwrap().count() == 1
    }
}

#[cfg(unix)]
fn file_number(path: &Path) -> u64 {
    std::os::unix::fs::MetadataExt::ino(&fs::metadata(path).unwrap())
}

/// Changes of metadata of the same length, to more, and to less.
fn changes() -> [Change; 3] {
    let long = "a note that is longer than those of other databases are ".repeat(200).leak();
    [Change::new("one", "two"), Change::new("one", long), Change::new(long, "one")]
}

#[test]
#[cfg(unix)]
fn only_what_changed_is_written() {
    for change in changes() {
        change.restore();
        let number = file_number(&change.path());
        let stages = 10_000;
        until(stages, || change.make().unwrap()).unwrap();
        assert!(change.is_after() && change.is_alone());
        assert_eq!(file_number(&change.path()), number, "changed in place");
    }
    // Nothing to change at all.
    let change = Change::new("one", "two");
    fs::write(change.path(), change.after.bytes()).unwrap();
    let change = Change { before: MemPages::from_bytes("b", change.after.bytes()).unwrap(), ..change };
    until(0, || change.make().unwrap()).expect("nothing is written");
    assert!(change.is_after() && change.is_alone());
}

#[test]
#[cfg(unix)]
fn gaps_between_pages_become_zeros() {
    let change = Change::new("one", "two");
    change.restore();
    let number = file_number(&change.path());
    let ends = change
        .before
        .directory()
        .present()
        .map(|(_, entry)| (entry.offset + u64::from(entry.length)) as usize);
    let gaps = ends.filter(|end| end % 4096 != 0).chain([300]);
    let mut bytes = change.before.bytes().to_vec();
    let last = change.before.directory().present().map(|(_, entry)| entry.offset as usize).max().unwrap();
    gaps.filter(|gap| *gap < last).for_each(|gap| bytes[gap] = 7);
    assert!(bytes.iter().zip(change.before.bytes()).filter(|(a, b)| a != b).count() > 3);
    fs::write(change.path(), &bytes).unwrap();
    change.make().unwrap();
    assert!(change.is_after() && file_number(&change.path()) == number);
}

#[test]
#[cfg(unix)]
fn a_change_that_is_stopped_anywhere_is_taken_back_or_done() {
    let (mut taken_back, mut done) = (0, 0);
    for change in changes() {
        for stages in 0.. {
            change.restore();
            if until(stages, || change.make().unwrap()).is_some() {
                break;
            }

            // Whoever opens it may be stopped as well, at any stage of that.
            for stages in 0..40 {
                if until(stages, || drop(open_to_read(&change.path()))).is_some() {
                    break;
                }
                let header = fs::read(change.path()).unwrap();
                let opens = FixedHeader::parse(&change.path(), &header).is_ok();
                assert!(!opens || change.is_before() || change.is_after(), "{stages}");
            }

            assert!(change.is_alone() && (change.is_before() || change.is_after()), "{stages}");
            (taken_back, done) =
                (taken_back + u32::from(change.is_before()), done + u32::from(change.is_after()));
            drop(open_to_read(&change.path()).unwrap());
            change.make().unwrap();
            assert!(change.is_after() && change.is_alone());
        }
    }

    assert!(taken_back > 20 && done >= 3, "{taken_back} {done}");
}

/// A change that was stopped when all but the header was written.
#[cfg(unix)]
fn stopped(change: &Change) -> (Vec<u8>, Vec<u8>) {
    change.restore();
    let mut last = None;
    for stages in 0.. {
        change.restore();
        if until(stages, || change.make().unwrap()).is_some() {
            return last.expect("a change has stages");
        }
        let file = fs::read(change.path()).unwrap();
        if change.journal().exists() && file[..256].iter().all(|byte| *byte == 0) {
            last = Some((file, fs::read(change.journal()).unwrap()));
        }
    }
    unreachable!()
}

#[test]
#[cfg(unix)]
fn damaged_journals_change_nothing() {
    let change = Change::new("one", "two");
    let (half, journal) = stopped(&change);
    let opened = |file: &[u8], journal: &[u8]| {
        fs::write(change.path(), file).unwrap();
        fs::write(change.journal(), journal).unwrap();
        drop(open_to_read(&change.path()).unwrap());
        fs::read(change.path()).unwrap()
    };
    assert!(opened(&half, &journal) == change.before.bytes());
    let damages = (0..journal.len()).step_by(journal.len() / 60).chain([0, 8, 16, 24, 31]);

    for at in damages {
        let mut damaged = journal.clone();
        damaged[at] ^= 0x20;

        // All that is left of what the file held is not thrown away.
        for journal in [&damaged[..], &journal[..at]] {
            fs::write(change.path(), &half).unwrap();
            fs::write(change.journal(), journal).unwrap();
            let told = open_to_read(&change.path()).unwrap_err().to_string();
            assert!(told.contains("the journal is damaged") && told.contains("--overwrite"), "{at}: {told}");
            assert!(fs::read(change.path()).unwrap() == half, "{at}");
            assert!(fs::read(change.journal()).unwrap() == journal, "{at}");
        }

        // A whole database stays as it is, and the journal goes.
        assert!(opened(change.before.bytes(), &journal[..at]) == change.before.bytes());
        assert!(!change.journal().exists());
    }

    // A whole journal that is of no use, or of another file.
    assert!(opened(change.after.bytes(), &journal) == change.after.bytes() && !change.journal().exists());
    let other = Terrain::new(300, 40, 0.2, 7).pages();
    assert!(opened(other.bytes(), &journal) == other.bytes() && change.journal().exists());
    assert!(opened(&half[..half.len() / 2], &journal) == half[..half.len() / 2]);

    // What was moved away may come back for its journal, whatever is built here meanwhile.
    fs::remove_file(change.path()).unwrap();
    for _ in 0..2 {
        write_arrays(&change.path(), &Terrain::new(300, 40, 0.2, 7).arrays(), &Metadata::default(), true)
            .unwrap();
        assert!(fs::read(change.journal()).unwrap() == journal);
    }

    assert!(opened(&half, &journal) == change.before.bytes() && !change.journal().exists());
    // A database that has no journal any more says that it is none.
    fs::write(change.path(), &half).unwrap();
    let error = MemPages::from_bytes("area.hop", &fs::read(change.path()).unwrap()).unwrap_err();
    assert!(error.to_string().contains("no header yet"), "{error}");
}

#[test]
#[cfg(unix)]
fn what_is_in_use_or_has_other_names_is_replaced() {
    let change = Change::new("one", "two");
    let replaced = |prepare: &dyn Fn(&Path) -> Option<File>| {
        change.restore();
        let (held, number) = (prepare(&change.path()), file_number(&change.path()));
        change.make().unwrap();
        let is_read_only = fs::metadata(change.path()).unwrap().permissions().readonly();
        assert!(change.is_after() && !is_read_only && !journal_of(&change.path()).exists());
        if let Some(mut held) = held {
            let mut bytes = Vec::new();
            std::io::Read::read_to_end(&mut held, &mut bytes).unwrap();
            assert!(bytes == change.before.bytes(), "who reads it sees what it was");
        }
        file_number(&change.path()) != number
    };

    assert!(!replaced(&|_| None));
    assert!(replaced(&|path| Some(open_to_read(path).unwrap())));
    let other = change.folder.path().join("other");
    assert!(replaced(&|path| {
        fs::hard_link(path, &other).unwrap();
        None
    }));
    assert!(fs::read(&other).unwrap() == change.before.bytes());

    assert!(replaced(&|path| {
        let mut permissions = fs::metadata(path).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(path, permissions).unwrap();
        None
    }));
    assert!(replaced(&|path| {
        fs::rename(path, &other).unwrap();
        std::os::unix::fs::symlink(&other, path).unwrap();
        None
    }));
    assert!(fs::read(&other).unwrap() == change.before.bytes());
}

#[test]
#[cfg(unix)]
fn who_opens_a_database_waits_for_a_change() {
    let change = Change::new("one", "two");
    let (half, journal) = stopped(&change);
    fs::write(change.path(), half).unwrap();
    fs::write(change.journal(), journal).unwrap();
    let writer = OpenOptions::new().write(true).open(change.path()).unwrap();
    writer.try_lock().unwrap();
    std::thread::scope(|scope| {
        let reader = scope.spawn(|| open_to_read(&change.path()).map(drop));
        std::thread::sleep(std::time::Duration::from_millis(100));
        assert!(!reader.is_finished() && !change.is_before());
        drop(writer);
        reader.join().unwrap().unwrap();
    });
    assert!(change.is_before() && change.is_alone());
}

#[test]
fn what_is_being_written_for_the_first_time_is_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("area.hop");
    let writer = PageWriter::create(&path, grid(300, 40), HeightCode::spanning(0.0, 1.0), false).unwrap();
    let begun = std::time::Instant::now();
    let error = open_to_read(writer.part()).unwrap_err().to_string();
    assert!(error.contains("another process is writing it"), "{error}");
    assert!(begun.elapsed().as_secs() < 10);
}
