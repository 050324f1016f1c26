//! Values computed from pages and kept: shared by all workers, within a budget of bytes.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{PoisonError, RwLock};

use hedgehop_base::error::Result;

/// Something that takes memory.
pub trait Bytes {
    /// Returns the size in memory, bytes.
    fn bytes(&self) -> usize;
}

#[derive(Debug)]
struct Entry<V> {
    value: V,
    /// Frame in which it was last looked up.
    used: AtomicU64,
}

/// Values by key. What was not used for longest makes room, but nothing that frames in flight may need.
#[derive(Debug)]
pub struct KeyedCache<K, V> {
    budget: usize,
    frame: AtomicU64,
    entries: RwLock<HashMap<K, Entry<V>>>,
}

impl<K: Eq + Hash + Copy + Ord, V: Clone + Bytes> KeyedCache<K, V> {
    /// Nothing yet, and at most `budget` bytes besides what the latest frames used.
    pub fn new(budget: usize) -> Self {
        Self { budget, frame: AtomicU64::new(0), entries: RwLock::default() }
    }

    /// Bytes that are kept.
    pub fn bytes(&self) -> usize {
        let entries = self.entries.read().unwrap_or_else(PoisonError::into_inner);
        entries.values().map(|entry| entry.value.bytes()).sum()
    }

    /// Whether something is kept under a key.
    pub fn has(&self, key: K) -> bool {
        self.entries.read().unwrap_or_else(PoisonError::into_inner).contains_key(&key)
    }

    /// A new frame begins: drops what was not used for longest if there is more than the budget allows.
    pub fn begin_frame(&self) {
        let now = self.frame.fetch_add(1, Ordering::Relaxed) + 1;
        let mut entries = self.entries.write().unwrap_or_else(PoisonError::into_inner);
        let mut bytes: usize = entries.values().map(|entry| entry.value.bytes()).sum();
        if bytes <= self.budget {
            return;
        }

        // Frames in flight beside this one may still need theirs.
        let mut old: Vec<(u64, K)> = entries
            .iter()
            .map(|(key, entry)| (entry.used.load(Ordering::Relaxed), *key))
            .filter(|(used, _)| used + 2 < now)
            .collect();
        old.sort_unstable();

        for (_, key) in old {
            if bytes <= self.budget {
                break;
            }
            bytes -= entries.remove(&key).map_or(0, |entry| entry.value.bytes());
        }
    }

    /// Returns the value kept under a key, or else the result of `make`, outside of any lock: two workers may make the same, and find
    /// the same. Where it finds nothing, nothing is kept: a page that is not there now may come.
    ///
    /// # Errors
    /// Those of `make`; nothing is kept then.
    pub fn get(&self, key: K, make: impl FnOnce() -> Result<Option<V>>) -> Result<Option<V>> {
        let now = self.frame.load(Ordering::Relaxed);
        if let Some(entry) = self.entries.read().unwrap_or_else(PoisonError::into_inner).get(&key) {
            // Written once a frame: a write takes the line from all other workers.
            if entry.used.load(Ordering::Relaxed) != now {
                entry.used.store(now, Ordering::Relaxed);
            }
            return Ok(Some(entry.value.clone()));
        }
        let Some(value) = make()? else { return Ok(None) };
        let mut entries = self.entries.write().unwrap_or_else(PoisonError::into_inner);
        let entry = entries.entry(key).or_insert(Entry { value, used: AtomicU64::new(now) });
        Ok(Some(entry.value.clone()))
    }
}
