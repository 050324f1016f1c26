//! Locks of chunks: `parts/0007.lock` is held by the worker that is at chunk 7, and says which process that is.
//!
//! The system lets go of a lock when its process ends, however it does. Where a file system has no locks, two workers may do the
//! same, and write the same bytes.

use std::fs::{File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::job;
use hedgehop::progress::Observer;
use hedgehop::{Error, Result};

/// Time between tries to get a lock.
const PAUSE: Duration = Duration::from_millis(200);

/// Waits until nobody else works on a chunk, and keeps others from it until what it returns is dropped; `None` where the file system has
/// no locks.
pub fn lock(job: &Path, number: u64, observer: &dyn Observer) -> Result<Option<File>> {
    let path = path(job, number);
    let file = File::options().create(true).truncate(false).write(true).open(&path);
    let file = file.map_err(|error| Error::io(&path, "open it", error))?;

    let mut is_told = false;
    loop {
        match file.try_lock() {
            Ok(()) => {
                sign(&file);
                return Ok(Some(file));
            }
            Err(TryLockError::Error(_)) => return Ok(None),
            Err(TryLockError::WouldBlock) => {}
        }

        if !is_told {
            observer.note(&format!("another worker is at chunk {number}; waiting for what it leaves"));
            is_told = true;
        }
        if observer.cancelled() {
            return Err(Error::Interrupted(format!("chunk {number} is left to the worker that is at it")));
        }
        std::thread::sleep(PAUSE);
    }
}

/// Whether somebody works on a chunk now, as far as the file system has locks that say so.
pub fn is_locked(job: &Path, number: u64) -> bool {
    let Ok(file) = File::options().write(true).open(path(job, number)) else { return false };
    matches!(file.try_lock(), Err(TryLockError::WouldBlock))
}

/// Returns the process of this machine that works on a chunk, if there is one.
pub fn worker_here(job: &Path, number: u64) -> Option<u32> {
    if is_locked(job, number) { signed_here(&path(job, number)) } else { None }
}

/// Returns the process of this machine that a lock names; `None` of another machine's.
pub fn signed_here(path: &Path) -> Option<u32> {
    let text = std::fs::read_to_string(path).ok()?;
    let (process, host) = text.trim().split_once(' ')?;
    if host == host_name() { process.parse().ok().filter(|process| *process > 1) } else { None }
}

fn path(job: &Path, number: u64) -> PathBuf {
    job::parts(job).join(format!("{number:04}.lock"))
}

/// Says in the file whose it is. That it cannot be said keeps nobody from working.
pub fn sign(mut file: &File) {
    let text = format!("{} {}\n", std::process::id(), host_name());
    let _ = file.set_len(0).and_then(|()| file.write_all(text.as_bytes()));
}

/// Name of this machine; empty where the system does not say.
fn host_name() -> String {
    #[cfg(unix)]
    {
        rustix::system::uname().nodename().to_string_lossy().into_owned()
    }
    #[cfg(not(unix))]
    {
        String::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop::progress::Silent;

    #[test]
    fn a_lock_is_held_by_one_and_says_by_whom() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(job::parts(folder.path())).unwrap();
        assert!(!is_locked(folder.path(), 7) && worker_here(folder.path(), 7).is_none());
        let held = lock(folder.path(), 7, &Silent).unwrap();
        assert!(held.is_some() && is_locked(folder.path(), 7));
        assert_eq!(worker_here(folder.path(), 7), Some(std::process::id()));
        drop(held);
        assert!(!is_locked(folder.path(), 7) && worker_here(folder.path(), 7).is_none());
    }
}
