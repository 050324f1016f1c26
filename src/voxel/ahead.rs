//! Brings what was written to the disk while more is being made.
//!
//! A file must be on the disk before it gets its name. A system with much memory would begin to write only then, and all cores would wait for the disk.

use std::fs::File;
use std::io;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};

/// Bytes from one flush to the next; smaller files are not worth a thread.
const STRETCH: u64 = 32 << 20;

/// Flushes one file from time to time.
#[derive(Debug, Default)]
pub(super) struct Ahead(Mutex<WritebackState>);

#[derive(Debug, Default)]
struct WritebackState {
    /// Bytes since the last flush was asked for.
    written: u64,
    flusher: Option<Flusher>,
}

#[derive(Debug)]
struct Flusher {
    wake: SyncSender<()>,
    thread: JoinHandle<io::Result<()>>,
}

impl Ahead {
    /// Notes that so many bytes were written to the file.
    pub fn wrote(&self, bytes: usize, file: &File) {
        let mut state = self.lock();
        state.written += bytes as u64;
        if state.written < STRETCH {
            return;
        }
        state.written = 0;
        if state.flusher.is_none() {
            state.flusher = Flusher::start(file);
        }
        if let Some(flusher) = &state.flusher {
            // One that waits flushes this, too. One that failed tells it at the end.
            let _ = flusher.wake.try_send(());
        }
    }

    /// Waits until no flush is under way.
    ///
    /// # Errors
    /// What went wrong in one: the system tells that once, so the last flush of all would not know it.
    pub fn end(&self) -> io::Result<()> {
        let flusher = self.lock().flusher.take();
        let Some(Flusher { wake, thread }) = flusher else { return Ok(()) };
        drop(wake);
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }

    fn lock(&self) -> MutexGuard<'_, WritebackState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Ahead {
    /// The file is closed afterwards: nobody holds its lock for longer than its writer lives.
    fn drop(&mut self) {
        // Who gives a file up does not care whether it is on the disk.
        let _ = self.end();
    }
}

impl Flusher {
    /// `None`: there is no handle or no thread for it; then all is flushed at the end.
    fn start(file: &File) -> Option<Self> {
        let file = file.try_clone().ok()?;
        let (wake, woken) = sync_channel(1);
        let flush = move || woken.iter().try_for_each(|()| file.sync_data());
        let thread = thread::Builder::new().name("flush".into()).spawn(flush).ok()?;
        Some(Self { wake, thread })
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn long_files_are_flushed_on_the_way_and_short_ones_at_the_end() {
        let mut file = tempfile::tempfile().unwrap();
        let ahead = Ahead::default();
        file.write_all(&[7; 4096]).unwrap();
        ahead.wrote(4096, &file);
        assert!(ahead.lock().flusher.is_none());
        for _ in 0..5 {
            ahead.wrote(STRETCH as usize, &file);
            assert!(ahead.lock().flusher.is_some() && ahead.lock().written == 0);
        }
        ahead.end().unwrap();
        assert!(ahead.lock().flusher.is_none());
    }

    /// A pipe cannot be flushed, which stands for a disk that fails.
    #[test]
    #[cfg(target_os = "linux")]
    fn what_fails_on_the_way_is_told_at_the_end() {
        let (_reader, writer) = io::pipe().unwrap();
        let file = File::from(std::os::fd::OwnedFd::from(writer));
        let ahead = Ahead::default();
        ahead.wrote(STRETCH as usize, &file);
        assert!(ahead.end().is_err());
        assert!(ahead.end().is_ok(), "it is told once");
    }
}
