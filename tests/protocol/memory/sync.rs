//! The names of `src/memory/sync.rs`, for threads of which shuttle says who goes on.

use std::collections::VecDeque;

pub use shuttle::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, AtomicU64};
pub use shuttle::sync::mpsc::{Receiver, SyncSender as Sender, channel, sync_channel as bounded};
pub use shuttle::sync::{Condvar, Mutex, MutexGuard};
pub use shuttle::thread::{Scope, ThreadId, current, yield_now};

/// crossbeam's queue, at which shuttle could not change threads.
#[derive(Debug)]
pub struct SegQueue<T>(Mutex<VecDeque<T>>);

impl<T> Default for SegQueue<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T> SegQueue<T> {
    pub fn push(&self, what: T) {
        self.0.lock().unwrap().push_back(what);
    }

    pub fn pop(&self) -> Option<T> {
        self.0.lock().unwrap().pop_front()
    }
}

/// A scope, with one thread more: when the last thread of a scope ends, shuttle 0.9 wakes who opened the scope, whatever it waits for. This one
/// ends when nothing else is waited for.
pub fn scope<'env, T>(work: impl for<'scope> FnOnce(&'scope Scope<'scope, 'env>) -> T) -> T {
    shuttle::thread::scope(|scope| {
        let (end, is_ended) = channel::<()>();
        scope.spawn(move || is_ended.recv().is_err());
        let result = work(scope);
        drop(end);
        result
    })
}

/// Starts a thread; shuttle's have no names here.
pub fn spawn<'scope>(
    scope: &'scope Scope<'scope, '_>,
    _name: &str,
    work: impl FnOnce() + Send + 'scope,
) -> std::io::Result<()> {
    scope.spawn(work);
    Ok(())
}
