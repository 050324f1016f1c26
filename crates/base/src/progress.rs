//! Progress of long work, and the caller's means to stop it.
//!
//! The library never prints; programs implement [`Observer`].

/// Receives progress and answers whether to go on. All methods may be called from any thread.
pub trait Observer: Sync {
    /// A stage begins: `total` units of `unit` ("pages", "frames", …) are to be done.
    fn begin(&self, stage: &str, total: u64, unit: &str) {
        let _ = (stage, total, unit);
    }
    /// `count` more units of the stage are done.
    fn advance(&self, count: u64) {
        let _ = count;
    }
    /// The stage has ended.
    fn end(&self) {}
    /// Something the user should know once: an assumption, a repair.
    fn note(&self, text: &str) {
        let _ = text;
    }
    /// True once the user asked to stop; long loops ask at least a few times a second.
    fn cancelled(&self) -> bool {
        false
    }
}

/// Listens to nothing and never stops the work.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Observer for Silent {}
