//! Threads, and what they share and wait with, as the protocol of pages uses them.
//!
//! The test `protocol` puts others in their place, which run threads in thousands of orders: what steers who goes on when comes from here.

pub use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, AtomicU64};
pub use std::sync::{Condvar, Mutex, MutexGuard};
pub use std::thread::{Scope, ThreadId, current, scope};

pub use crossbeam::channel::{Receiver, Sender, bounded};
pub use crossbeam::queue::SegQueue;

/// Starts a thread with a name.
pub fn spawn<'scope>(
    scope: &'scope Scope<'scope, '_>,
    name: &str,
    work: impl FnOnce() + Send + 'scope,
) -> std::io::Result<()> {
    std::thread::Builder::new().name(name.into()).spawn_scoped(scope, work).map(drop)
}
