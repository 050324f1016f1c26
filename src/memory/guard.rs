//! Guard against mapped files that cannot be read any more: one was cut short, or the disk failed.
//!
//! ```text
//! a thread reads a mapped byte that the file does not give ──▶ SIGBUS ──▶ is the address in a watched mapping?
//!     yes: note the byte; put zeros in the place of the whole mapping; let the thread read on
//!     no:  whoever was to be told of the signal before is told
//! who rendered asks the mapping afterwards, and throws away what was made of zeros
//! ```
//!
//! A system signals the thread that reads, wherever it is; unwinding from there is not possible, so that it must be given something to
//! read. Zeros take the place of all of the mapping and not of one page of it: one signal per file then, however large it is.
//! A mapping that failed once stays failed, so that nothing which is kept of the zeros, such as light of a page, is ever shown.
//!
//! The handler calls nothing but `mmap` and, to hand a signal on, `sigaction` and `raise`; it takes no lock and allocates nothing. The table that it reads has a
//! fixed number of slots, each with a version as of a sequence lock: a slot that changes while it is looked at is not that of the mapping
//! that is being read.

#![expect(
    unsafe_code,
    reason = "a signal handler, and zeros in the place of a mapping; the contract is at `Watch::new`"
)]

use std::ffi::{c_int, c_void};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering, fence};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::{io, ptr};

use hedgehop_base::error::{Error, Result};

/// Mappings that can be watched at once.
const SLOTS: usize = 256;
/// No byte of the mapping failed.
const NONE: u64 = u64::MAX;

/// A watched mapping, as the handler sees it.
struct GuardSlot {
    is_taken: AtomicBool,
    /// Odd while the bounds change.
    version: AtomicUsize,
    start: AtomicUsize,
    end: AtomicUsize,
    /// The first byte that failed, counted from the file's first, or [`NONE`].
    failed: AtomicU64,
}

impl GuardSlot {
    const fn free() -> Self {
        Self {
            is_taken: AtomicBool::new(false),
            version: AtomicUsize::new(0),
            start: AtomicUsize::new(0),
            end: AtomicUsize::new(0),
            failed: AtomicU64::new(NONE),
        }
    }

    /// Changes the bounds; by the one who took the slot.
    fn bound(&self, addresses: Range<usize>) {
        let version = self.version.load(Ordering::Relaxed);
        self.version.store(version.wrapping_add(1), Ordering::Relaxed);
        fence(Ordering::Release);
        self.start.store(addresses.start, Ordering::Relaxed);
        self.end.store(addresses.end, Ordering::Relaxed);
        self.version.store(version.wrapping_add(2), Ordering::Release);
    }

    /// The bounds; `None` while they change.
    fn bounds(&self) -> Option<Range<usize>> {
        let version = self.version.load(Ordering::Acquire);
        let addresses = self.start.load(Ordering::Relaxed)..self.end.load(Ordering::Relaxed);
        fence(Ordering::Acquire);
        let is_settled = version.is_multiple_of(2) && self.version.load(Ordering::Relaxed) == version;
        is_settled.then_some(addresses)
    }
}

static TABLE: [GuardSlot; SLOTS] = [const { GuardSlot::free() }; SLOTS];

/// Watches a mapping for as long as it lives.
pub(super) struct Watch(Option<&'static GuardSlot>);

impl Watch {
    /// Watches a mapping; without a free slot it is not watched.
    ///
    /// # Safety
    /// `mapping` is a whole mapping of a file from its first byte on, which begins where a page of the system does, is only read, and
    /// outlives the returned value; nobody reads it after that.
    pub unsafe fn new(mapping: &[u8]) -> Self {
        let take = |slot: &&GuardSlot| {
            slot.is_taken.compare_exchange(false, true, Ordering::Acquire, Ordering::Relaxed).is_ok()
        };
        let slot = TABLE.iter().find(take);
        if let Some(slot) = slot {
            slot.failed.store(NONE, Ordering::Relaxed);
            slot.bound(mapping.as_ptr_range().start.addr()..mapping.as_ptr_range().end.addr());
        }
        Self(slot)
    }

    /// The first byte that the file did not give; zeros have been read since in its place, and of all others.
    #[inline]
    pub fn failed(&self) -> Option<u64> {
        self.0.map(|slot| slot.failed.load(Ordering::Relaxed)).filter(|byte| *byte != NONE)
    }
}

impl std::fmt::Debug for Watch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Watch").field("failed", &self.failed()).finish_non_exhaustive()
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        if let Some(slot) = self.0 {
            slot.bound(0..0);
            slot.is_taken.store(false, Ordering::Release);
        }
    }
}

/// Handler of the signal before this one.
static BEFORE: OnceLock<libc::sigaction> = OnceLock::new();

/// Has databases that cannot be read any more, because their file was cut short or the disk failed, end what is rendered from them with an
/// error instead of the process with a bus error.
///
/// This is for the whole process, and is meant for `main`: it takes the signal SIGBUS, and hands on what is not a database's. Called again
/// it does nothing. At most 256 open databases are looked after; those beyond end the process as before.
///
/// # Errors
/// The system refuses the handler.
pub fn guard_mapped_files() -> Result<()> {
    static INSTALLING: Mutex<()> = Mutex::new(());
    let _one = INSTALLING.lock().unwrap_or_else(PoisonError::into_inner);
    if BEFORE.get().is_some() {
        return Ok(());
    }
    install().map_err(|error| Error::Configuration(format!("cannot look after mapped files: {error}")))
}

fn install() -> io::Result<()> {
    let done = |code: c_int| if code == 0 { Ok(()) } else { Err(io::Error::last_os_error()) };
    // SAFETY: all zeros are a value of this C structure of integers and pointers that may be null.
    let (mut before, mut action): (libc::sigaction, libc::sigaction) = unsafe { std::mem::zeroed() };
    // SAFETY: both pointers are null or valid for the call.
    done(unsafe { libc::sigaction(libc::SIGBUS, ptr::null(), &raw mut before) })?;
    // Before the handler can run: it looks there.
    let _ = BEFORE.set(before);
    let handler: extern "C" fn(c_int, *mut libc::siginfo_t, *mut c_void) = on_bus_error;
    action.sa_sigaction = handler as usize;
    action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK | libc::SA_RESTART;
    // SAFETY: the handler has the signature that SA_SIGINFO asks for, and does only what a handler may, see the module.
    done(unsafe { libc::sigaction(libc::SIGBUS, &raw const action, ptr::null_mut()) })
}

extern "C" fn on_bus_error(signal: c_int, info: *mut libc::siginfo_t, context: *mut c_void) {
    // SAFETY: the system passes a valid description of the signal.
    let (address, is_of_system) = unsafe { ((*info).si_addr().addr(), (*info).si_code > 0) };
    // Of the system: not one that a process sent, which has no address.
    if !(is_of_system && TABLE.iter().any(|slot| gives_zeros(slot, address))) {
        hand_on(signal, info, context);
    }
}

/// Puts zeros in the place of a slot's mapping if it holds `address`.
fn gives_zeros(slot: &GuardSlot, address: usize) -> bool {
    let Some(bounds) = slot.bounds().filter(|bounds| bounds.contains(&address)) else { return false };
    let byte = (address - bounds.start) as u64;
    // Noted before zeros can be read by anyone. A thread that fails while another one does this finds it noted, and repeats it.
    let _ = slot.failed.compare_exchange(NONE, byte, Ordering::SeqCst, Ordering::SeqCst);
    let flags = libc::MAP_FIXED | libc::MAP_PRIVATE | libc::MAP_ANONYMOUS | libc::MAP_NORESERVE;
    let start = ptr::with_exposed_provenance_mut(bounds.start);
    // SAFETY: by the contract of `Watch::new` all of this range is one mapping that is only read. It is not unmapped meanwhile: the
    // thread that was interrupted is reading it.
    let zeros = unsafe { libc::mmap(start, bounds.len(), libc::PROT_READ, flags, -1, 0) };
    zeros != libc::MAP_FAILED
}

/// Has the signal do what it would have done without this handler.
fn hand_on(signal: c_int, info: *mut libc::siginfo_t, context: *mut c_void) {
    let Some(before) = BEFORE.get() else { return };
    match before.sa_sigaction {
        libc::SIG_IGN => {}
        libc::SIG_DFL => {
            // SAFETY: gives the signal back what it had; it comes again as soon as this handler has returned.
            unsafe {
                libc::sigaction(signal, before, ptr::null_mut());
                libc::raise(signal);
            }
        }
        handler if before.sa_flags & libc::SA_SIGINFO != 0 => {
            // SAFETY: whoever put this handler there with SA_SIGINFO promised that it has this signature.
            let handler: extern "C" fn(c_int, *mut libc::siginfo_t, *mut c_void) =
                unsafe { std::mem::transmute(handler) };
            handler(signal, info, context);
        }
        handler => {
            // SAFETY: as above, without SA_SIGINFO.
            let handler: extern "C" fn(c_int) = unsafe { std::mem::transmute(handler) };
            handler(signal);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::io::Write;

    use memmap2::Mmap;

    use super::*;

    #[test]
    fn a_mapping_that_is_cut_short_reads_as_zeros_and_says_where() {
        guard_mapped_files().unwrap();
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&[7; 1 << 20]).unwrap();
        let map = |file: &File| unsafe { Mmap::map(file) }.unwrap();
        let (cut, whole) = (map(&file), map(&file));
        let other = tempfile::tempfile().unwrap();
        other.set_len(1 << 20).unwrap();
        let other = map(&other);
        let (watch, beside) = unsafe { (Watch::new(&cut), Watch::new(&other)) };
        assert_eq!((cut[600_000], watch.failed()), (7, None));
        file.set_len(4096).unwrap();

        let threads: Vec<_> = std::thread::scope(|scope| {
            let read = |at: usize| {
                scope.spawn({
                    let cut = &cut;
                    move || cut[at]
                })
            };
            [600_000, 700_000, 800_000].map(read).into_iter().map(|thread| thread.join().unwrap()).collect()
        });

        assert_eq!(threads, [0; 3]);
        assert!([600_000, 700_000, 800_000].contains(&watch.failed().unwrap()));
        assert_eq!((cut[0], whole[0], beside.failed()), (0, 7, None));
        drop(watch);

        // Its slot is free again, and knows nothing of what was there.
        assert_eq!(unsafe { Watch::new(&whole) }.failed(), None);
    }

    #[test]
    fn a_slot_that_changes_has_no_bounds() {
        let slot = GuardSlot::free();
        slot.bound(10..20);
        assert_eq!(slot.bounds(), Some(10..20));
        slot.version.fetch_add(1, Ordering::Relaxed);
        assert_eq!(slot.bounds(), None);
    }
}
