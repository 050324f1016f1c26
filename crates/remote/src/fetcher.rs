//! Connections that fill the holes of a sparse copy.
//!
//! ```text
//! announce(range) ──▶ queue ──▶ 8 threads: ask for a run of blocks; again after a pause, if that failed
//!                                          is it of the database that was opened? write it, and tell who waits
//! fill(range) ──▶ front of the queue, and wait
//! every 32 MiB, or second: the bits of what was written
//! ```
//! What cannot be had once ends the run: nothing is filled from then on, and no frame is whole.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use std::{io, thread};

use super::backoff::Backoff;
use super::blocks::{BLOCK, blocks_of};
use super::cache::CacheEntry;
use super::client::{Answer, CONNECTIONS, Client, Condition, Trouble};
use super::queue::FetchQueue;
use super::validator::Validator;
use hedgehop::memory::HoleFiller;
use hedgehop::voxel::HEADER_BYTES;
use hedgehop_base::error::{Error, Result};

/// Bytes, and time, between two commits.
const COMMITTED: u64 = 32 << 20;
const COMMITTED_AFTER: Duration = Duration::from_secs(1);
/// Bytes between two looks at the bound of the cache.
const ROOM: u64 = 64 << 20;

/// Remedy for a database that is another one by now.
const REPLACED: &str = "it was replaced on its server while it was in use; repeat the command";

/// Origin of a copy's bytes.
#[derive(Debug)]
pub(crate) struct Origin {
    pub client: Client,
    /// State of the database when it was opened.
    pub validator: Validator,
    /// First bytes of the database.
    pub start: Vec<u8>,
}

/// Fills the holes of a copy.
#[derive(Debug)]
pub(crate) struct Fetcher {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    origin: Origin,
    entry: CacheEntry,
    state: Mutex<FetchState>,
    /// Told of news to fetch, of bytes that are there, of failures and of the end.
    changed: Condvar,
    has_failed: AtomicBool,
}

#[derive(Debug)]
struct FetchState {
    queue: FetchQueue,
    failure: Option<Failure>,
    is_started: bool,
    is_ended: bool,
    /// Bytes since the last commit, its time, and bytes since the last look at the bound.
    uncommitted: u64,
    committed: Instant,
    unbounded: u64,
}

/// Reason why nothing can be had any more.
#[derive(Debug, Clone)]
struct Failure {
    path: PathBuf,
    action: String,
    what: String,
}

impl Failure {
    fn error(&self) -> Error {
        Error::io(&self.path, self.action.as_str(), io::Error::other(self.what.clone()))
    }
}

impl Origin {
    /// Asks for a range until there is an answer, or none is to be expected. `pause` waits, and says whether to go on.
    ///
    /// # Errors
    /// A sentence with its remedy.
    pub fn ask(
        client: &Client,
        range: &Range<u64>,
        condition: Condition<'_>,
        pause: impl Fn(Duration) -> bool,
    ) -> Result<Answer, String> {
        let mut backoff = Backoff::default();
        loop {
            let (what, asked) = match client.ask(range, condition) {
                Ok(answer) => return Ok(answer),
                Err(Trouble::Replaced) => return Err(REPLACED.into()),
                Err(Trouble::Lasting(what)) => return Err(what),
                Err(Trouble::Passing(what, asked)) => (what, asked),
            };
            if !backoff.next(asked).is_some_and(&pause) {
                let times = backoff.attempts();
                let times = if times == 1 { "once".into() } else { format!("{times} times") };
                return Err(format!(
                    "{what} (tried {times}); repeat the command later: what was fetched is kept"
                ));
            }
        }
    }
}

impl Fetcher {
    /// Connects to nobody before something is missing.
    pub fn new(origin: Origin, entry: CacheEntry) -> Self {
        let state = FetchState {
            queue: FetchQueue::new(origin.validator.length),
            failure: None,
            is_started: false,
            is_ended: false,
            uncommitted: 0,
            committed: Instant::now(),
            unbounded: 0,
        };
        let shared = Shared {
            origin,
            entry,
            state: Mutex::new(state),
            changed: Condvar::new(),
            has_failed: AtomicBool::new(false),
        };
        Self { shared: Arc::new(shared) }
    }

    /// Returns the copy whose holes are filled.
    pub fn entry(&self) -> &CacheEntry {
        &self.shared.entry
    }

    /// Starts the connections, once.
    fn start(&self, state: &mut FetchState) {
        if std::mem::replace(&mut state.is_started, true) {
            return;
        }
        let start = |_: &usize| {
            let shared = self.shared.clone();
            thread::Builder::new().name("hedgehop-fetch".into()).spawn(move || shared.work()).is_ok()
        };
        if (0..CONNECTIONS).filter(start).count() == 0 {
            self.shared.fail_with(state, self.shared.of_server("no thread can be started for it".into()));
        }
    }
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, FetchState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn of_server(&self, what: String) -> Failure {
        let path = self.origin.client.address().shown().to_owned();
        Failure { path, action: "go on reading it".into(), what }
    }

    fn of_cache(&self, error: &Error) -> Failure {
        let path = self.origin.client.address().shown().to_owned();
        Failure { path, action: "keep a copy of it".into(), what: error.to_string() }
    }

    fn fail_with(&self, state: &mut FetchState, failure: Failure) {
        state.failure.get_or_insert(failure);
        self.has_failed.store(true, Ordering::Release);
        self.changed.notify_all();
    }

    fn fail(&self, failure: Failure) {
        self.fail_with(&mut self.state(), failure);
    }

    /// Whether an outcome of the copy was good; a bad one ends the run.
    fn is_kept(&self, outcome: Result<()>) -> bool {
        outcome.map_err(|error| self.fail(self.of_cache(&error))).is_ok()
    }

    /// Fetches runs of blocks, one after the other, until the end.
    fn work(&self) {
        while let Some(run) = self.next_run() {
            let bytes = run.start * BLOCK..(run.end * BLOCK).min(self.origin.validator.length);
            let copy = self.entry.copy();
            // Another process may have brought it meanwhile.
            let is_told = self.is_kept(copy.refresh(bytes.clone()));
            if is_told && copy.has(&bytes) {
                self.state().queue.end(run);
                self.changed.notify_all();
                continue;
            }

            let is_kept = match self.fetch(&bytes) {
                Ok(fetched) => self.is_kept(copy.write(&fetched, bytes.start)),
                Err(what) => {
                    self.fail(self.of_server(what));
                    false
                }
            };

            let mut state = self.state();
            state.queue.end(run);
            if !is_kept {
                return;
            }
            let count = bytes.end - bytes.start;
            state.uncommitted += count;
            state.unbounded += count;
            let is_due = state.uncommitted >= COMMITTED || state.committed.elapsed() >= COMMITTED_AFTER;
            if is_due {
                (state.uncommitted, state.committed) = (0, Instant::now());
            }
            let is_room_due = state.unbounded >= ROOM;
            if is_room_due {
                state.unbounded = 0;
            }
            drop(state);
            self.changed.notify_all();

            if is_due && !self.is_kept(copy.commit()) {
                return;
            }
            if is_room_due {
                self.entry.make_room();
            }
        }
    }

    /// Waits for the next run of blocks to be fetched; `None`: nothing is fetched any more.
    fn next_run(&self) -> Option<Range<u64>> {
        let copy = self.entry.copy();
        let mut state = self.state();
        loop {
            if state.is_ended || state.failure.is_some() {
                return None;
            }
            if let Some(run) = state.queue.take(|block| copy.has_block(block)) {
                return Some(run);
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Asks for bytes of the database that was opened.
    fn ask(&self, bytes: &Range<u64>) -> Result<Vec<u8>, String> {
        let pause = |time| {
            let state = self.state();
            let goes_on = |state: &mut FetchState| !state.is_ended && state.failure.is_none();
            let waited = self.changed.wait_timeout_while(state, time, goes_on);
            goes_on(&mut waited.unwrap_or_else(PoisonError::into_inner).0)
        };
        match Origin::ask(&self.origin.client, bytes, Condition::Same(&self.origin.validator), pause)? {
            Answer::Part(bytes, _) => Ok(bytes),
            Answer::Unchanged => Err("the server answered what it was not asked; check the address".into()),
        }
    }

    /// Asks for bytes, and makes sure that they are of the database that was opened. Where a server gives no entity tags that are equal only for equal bytes, the
    /// header tells afterwards, which holds the identity of all of them. Nothing else is ever written: others may have mapped the copy.
    fn fetch(&self, bytes: &Range<u64>) -> Result<Vec<u8>, String> {
        let fetched = self.ask(bytes)?;
        if self.origin.validator.strong_etag().is_none() {
            let header = 0..HEADER_BYTES as u64;
            if self.ask(&header)? != self.origin.start[..HEADER_BYTES] {
                return Err(REPLACED.into());
            }
        }
        Ok(fetched)
    }
}

impl HoleFiller for Fetcher {
    fn announce(&self, range: Range<u64>) {
        if self.is_filled(range.clone()) {
            return;
        }
        let mut state = self.shared.state();
        state.queue.push_ahead(blocks_of(&range));
        self.start(&mut state);
        drop(state);
        self.shared.changed.notify_all();
    }

    fn fill(&self, range: Range<u64>) -> bool {
        let copy = self.shared.entry.copy();
        copy.mark_used(&range);
        if self.has_failed() {
            return false;
        }
        if copy.has(&range) {
            return true;
        }
        if !self.shared.is_kept(copy.refresh(range.clone())) {
            return false;
        }

        let mut state = self.shared.state();
        state.queue.push_urgent(blocks_of(&range));
        self.start(&mut state);
        self.shared.changed.notify_all();
        loop {
            if state.failure.is_some() {
                return false;
            }
            if copy.has(&range) {
                return true;
            }
            state = self.shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn is_filled(&self, range: Range<u64>) -> bool {
        self.shared.entry.copy().has(&range)
    }

    fn refill(&self, range: Range<u64>) -> bool {
        self.shared.is_kept(self.shared.entry.copy().drop_blocks(&range)) && self.fill(range)
    }

    fn has_failed(&self) -> bool {
        self.shared.has_failed.load(Ordering::Acquire)
    }

    fn intact(&self) -> Result<()> {
        self.shared.state().failure.as_ref().map_or(Ok(()), |failure| Err(failure.error()))
    }
}

impl Drop for Fetcher {
    /// Keeps what was fetched.
    fn drop(&mut self) {
        self.shared.state().is_ended = true;
        self.shared.changed.notify_all();
        // Bytes that cannot be kept are fetched again.
        let _ = self.shared.entry.copy().commit();
        let _ = self.shared.entry.close();
    }
}
