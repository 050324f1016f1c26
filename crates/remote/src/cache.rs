//! Cache folder: copies of databases, within a bound.
//!
//! ```text
//! CACHE/lock              held by whoever opens a copy
//!       ID.lock           held in common by all who have the copy open, alone by whoever evicts it; last changed when it was last in use
//!       ID/area.hop, ID/present
//!       url-….txt         what was behind a URL last
//! ```
//! The bound holds for all copies together. Copies that are in use are never evicted, and of one that is in use nothing goes: a process may have mapped it, and would read
//! zeros. A flight that needs more than the bound takes more for as long as it lasts.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::blocks::{BLOCK, BlockSet};
use super::copy::{DATA, PRESENT, SparseCopy};
use hedgehop_base::error::{Error, Result};

/// Bytes that copies may take together, unless told otherwise.
pub const DEFAULT_SIZE: u64 = 20 << 30;

/// Ending of the files that are locked while a copy is in use.
const LOCK: &str = ".lock";

/// Place and bound of the cache.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CacheSettings {
    /// Folder of the cache, which need not exist.
    pub folder: PathBuf,
    /// Bytes that copies may take together.
    pub size: u64,
}

/// Finds the folder for the cache where the system keeps such things; `None`: it does not say where.
pub fn default_folder() -> Option<PathBuf> {
    let named = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let of_system = if cfg!(windows) {
        named("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        named("HOME").map(|home| home.join("Library/Caches"))
    } else {
        let absolute = named("XDG_CACHE_HOME").filter(|folder| folder.is_absolute());
        absolute.or_else(|| named("HOME").map(|home| home.join(".cache")))
    };
    of_system.map(|folder| folder.join("hedgehop"))
}

/// Copies of databases.
#[derive(Debug)]
pub(crate) struct Cache {
    settings: CacheSettings,
}

/// A copy in use.
#[derive(Debug)]
pub(crate) struct CacheEntry {
    cache: Cache,
    name: String,
    copy: SparseCopy,
    lock: File,
}

/// A copy in the folder, as its bits tell.
#[derive(Debug)]
struct StoredCopy {
    name: String,
    bytes: u64,
    used: SystemTime,
}

impl Cache {
    /// Opens or makes the folder.
    pub fn open(settings: CacheSettings) -> Result<Self> {
        fs::create_dir_all(&settings.folder)
            .map_err(|error| Error::io(&settings.folder, "make it for copies of databases", error))?;
        Ok(Self { settings })
    }

    /// Returns the folder.
    pub fn folder(&self) -> &Path {
        &self.settings.folder
    }

    fn file(&self, name: &str) -> io::Result<File> {
        let path = self.folder().join(name);
        OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)
    }

    /// Opens or makes the copy of a database of `length` bytes, which is in use from then on.
    pub fn entry(self, name: String, length: u64) -> Result<CacheEntry> {
        let locked = || {
            let opening = self.file("lock")?;
            opening.lock()?;
            let lock = self.file(&format!("{name}{LOCK}"))?;
            lock.lock_shared()?;
            lock.set_modified(SystemTime::now())?;
            Ok((opening, lock))
        };
        let (_opening, lock) = locked().map_err(|error: io::Error| {
            let what = format!("{error}; give a folder on a disk of this machine by --cache");
            Error::io(self.folder(), "lock it", io::Error::other(what))
        })?;
        let copy = SparseCopy::open(&self.folder().join(&name), length)?;

        Ok(CacheEntry { cache: self, name, copy, lock })
    }

    /// Lists the copies in the folder, least recently used first. What cannot be read is left out.
    fn stored(&self) -> Vec<StoredCopy> {
        let entries = fs::read_dir(self.folder()).into_iter().flatten().flatten();
        let stored = |entry: fs::DirEntry| {
            let name = entry.file_name().into_string().ok().filter(|name| is_identity(name))?;
            // A link may lead anywhere.
            entry.file_type().ok().filter(fs::FileType::is_dir)?;
            let bits = fs::read(entry.path().join(PRESENT)).ok()?;
            let lock = fs::metadata(self.folder().join(format!("{name}{LOCK}")));
            let used = lock.and_then(|lock| lock.modified()).unwrap_or(SystemTime::UNIX_EPOCH);
            Some(StoredCopy { name, bytes: BlockSet::of_bits(bits).count() * BLOCK, used })
        };
        let mut stored: Vec<_> = entries.filter_map(stored).collect();
        stored.sort_by_key(|copy| copy.used);
        stored
    }

    /// Evicts copies until all take at most the bound, but for `kept` and others in use. Returns how many bytes are left for `kept`.
    fn make_room(&self, kept: &str) -> u64 {
        let stored = self.stored();
        let mut sum: u64 = stored.iter().map(|copy| copy.bytes).sum();
        let mut others: u64 = stored.iter().filter(|copy| copy.name != kept).map(|copy| copy.bytes).sum();
        for copy in stored.iter().filter(|copy| copy.name != kept) {
            if sum <= self.settings.size {
                break;
            }
            if self.evict(&copy.name) {
                sum -= copy.bytes;
                others -= copy.bytes;
            }
        }
        self.settings.size.saturating_sub(others)
    }

    /// Evicts a copy unless somebody has it open; whether it is gone.
    fn evict(&self, name: &str) -> bool {
        let Ok(lock) = self.file(&format!("{name}{LOCK}")) else { return false };
        match lock.try_lock() {
            Err(TryLockError::WouldBlock | TryLockError::Error(_)) => false,
            // The bits first: without them the bytes are nobody's.
            Ok(()) => {
                let folder = self.folder().join(name);
                let remove = |name: &str| fs::remove_file(folder.join(name)).is_ok();
                // Files of other programs stay, and their folder.
                remove(PRESENT) && remove(DATA) && fs::remove_dir(&folder).is_ok()
            }
        }
    }
}

/// Whether a name is that of a copy: content hash, length and layout of a database.
fn is_identity(name: &str) -> bool {
    let parts: Vec<&str> = name.split('-').collect();
    let is_hex = |text: &str| text.len() >= 16 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    matches!(parts.as_slice(), [hash, length, layout]
        if is_hex(hash) && length.parse::<u64>().is_ok() && is_hex(layout))
}

impl CacheEntry {
    /// Returns the copy.
    pub fn copy(&self) -> &SparseCopy {
        &self.copy
    }

    /// Evicts copies that are not in use until the bound holds, as far as it can.
    pub fn make_room(&self) {
        self.cache.make_room(&self.name);
    }

    /// Ends the use, which nobody has mapped any more: the bound holds from then on, unless others have copies open.
    pub fn close(&self) -> Result<()> {
        self.copy.close();
        // When it was last in use is for the order of eviction alone.
        let _ = self.lock.set_modified(SystemTime::now());
        let allowed = self.cache.make_room(&self.name);
        let bytes = |copy: &StoredCopy| if copy.name == self.name { copy.bytes } else { 0 };
        let own: u64 = self.cache.stored().iter().map(bytes).sum();

        // Whoever else has it open does this in turn.
        let is_alone = self.lock.unlock().is_ok() && self.lock.try_lock().is_ok();
        if own > allowed && is_alone {
            self.copy.shrink(allowed)?;
        }
        let _ = self.lock.unlock();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Identity of a database that the letter stands for.
    fn identity(letter: &str) -> String {
        format!("{}-100-{}", letter.repeat(64), letter.repeat(16))
    }

    fn entry(folder: &Path, name: &str, size: u64) -> CacheEntry {
        let settings = CacheSettings { folder: folder.to_owned(), size: size * BLOCK };
        Cache::open(settings).unwrap().entry(identity(name), 100 * BLOCK).unwrap()
    }

    /// Blocks that are stored of each copy.
    fn blocks(folder: &Path) -> Vec<(String, u64)> {
        let cache = Cache::open(CacheSettings { folder: folder.to_owned(), size: 0 }).unwrap();
        let mut blocks: Vec<_> =
            cache.stored().into_iter().map(|copy| (copy.name[..1].to_owned(), copy.bytes / BLOCK)).collect();
        blocks.sort();
        blocks
    }

    fn fill(entry: &CacheEntry, blocks: u64) {
        entry.copy().write(&vec![1; (blocks * BLOCK) as usize], 0).unwrap();
        entry.copy().commit().unwrap();
    }

    #[test]
    fn copies_least_recently_used_are_evicted_and_those_in_use_are_not() {
        let folder = tempfile::tempdir().unwrap();
        for (name, seconds) in [("b", 2), ("a", 1), ("c", 3)] {
            let entry = entry(folder.path(), name, 1000);
            fill(&entry, 10);
            entry.close().unwrap();
            entry
                .lock
                .set_modified(SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds))
                .unwrap();
        }
        let in_use = entry(folder.path(), "a", 25);
        entry(folder.path(), "d", 25).make_room();
        assert_eq!(blocks(folder.path()), [("a".into(), 10), ("c".into(), 10), ("d".into(), 0)]);
        drop(in_use);
        fs::remove_dir_all(folder.path().join(identity("d"))).unwrap();
    }

    #[test]
    fn a_copy_beyond_the_bound_shrinks_when_its_last_user_goes() {
        let folder = tempfile::tempdir().unwrap();
        let (one, other) = (entry(folder.path(), "a", 6), entry(folder.path(), "a", 6));
        fill(&one, 10);
        one.copy().mark_used(&(0..BLOCK));
        one.close().unwrap();
        assert_eq!(blocks(folder.path()), [("a".into(), 10)], "the other one may have mapped it");
        drop(one);
        other.close().unwrap();
        assert_eq!(blocks(folder.path()), [("a".into(), 6)]);
    }

    #[cfg(unix)]
    #[test]
    fn what_is_not_of_the_cache_stays() {
        let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let photos = folder.path().join("photos");
        fs::create_dir(&photos).unwrap();
        for place in [photos.as_path(), elsewhere.path()] {
            fs::write(place.join(PRESENT), [255; 8]).unwrap();
            fs::write(place.join("wedding.jpg"), b"x").unwrap();
        }
        std::os::unix::fs::symlink(elsewhere.path(), folder.path().join(identity("b"))).unwrap();
        entry(folder.path(), "a", 0).make_room();
        for place in [photos.as_path(), elsewhere.path()] {
            assert!(place.join(PRESENT).exists() && place.join("wedding.jpg").exists());
        }
    }
}
