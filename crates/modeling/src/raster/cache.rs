//! Decoded blocks within a budget of bytes, shared by threads.
//!
//! ```text
//! get(key): present          → touch, return
//!           being decoded    → wait, look again
//!           absent           → mark as being decoded, decode without the lock, insert,
//!                              drop the least recently used blocks beyond the budget
//! ```
//! A block that a reader still holds lives on after its eviction, so each thread may hold one block beyond the budget.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use hedgehop_base::error::Result;

/// Something whose size counts.
pub(super) trait Weigh {
    /// Bytes that it keeps allocated.
    fn weight(&self) -> u64;
}

/// The cache.
#[derive(Debug)]
pub(super) struct BlockCache<B> {
    budget: u64,
    state: Mutex<State<B>>,
    changed: Condvar,
}

#[derive(Debug)]
struct State<B> {
    blocks: HashMap<u64, (Arc<B>, u64)>,
    key_by_stamp: BTreeMap<u64, u64>,
    decoding: HashSet<u64>,
    bytes: u64,
    clock: u64,
}

impl<B: Weigh> BlockCache<B> {
    /// An empty cache of at most `budget` bytes.
    pub fn new(budget: u64) -> Self {
        let state = State {
            blocks: HashMap::new(),
            key_by_stamp: BTreeMap::new(),
            decoding: HashSet::new(),
            bytes: 0,
            clock: 0,
        };
        Self { budget, state: Mutex::new(state), changed: Condvar::new() }
    }

    /// The block `key`, decoded by `decode` if it is not here.
    pub fn get(&self, key: u64, decode: impl FnOnce() -> Result<B>) -> Result<Arc<B>> {
        let mut state = self.lock();
        loop {
            if let Some(block) = state.touch(key) {
                return Ok(block);
            }
            if state.decoding.insert(key) {
                break;
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        drop(state);
        // Frees the key however decoding ends, so that nobody waits for ever.
        let _claim = BlockClaim { cache: self, key };
        let block = Arc::new(decode()?);
        self.lock().insert(key, &block, self.budget);
        Ok(block)
    }

    fn lock(&self) -> MutexGuard<'_, State<B>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<B: Weigh> State<B> {
    fn touch(&mut self, key: u64) -> Option<Arc<B>> {
        let (block, stamp) = self.blocks.get_mut(&key)?;
        self.clock += 1;
        self.key_by_stamp.remove(stamp);
        *stamp = self.clock;
        self.key_by_stamp.insert(self.clock, key);
        Some(Arc::clone(block))
    }

    fn insert(&mut self, key: u64, block: &Arc<B>, budget: u64) {
        self.clock += 1;
        self.bytes += block.weight();
        self.blocks.insert(key, (Arc::clone(block), self.clock));
        self.key_by_stamp.insert(self.clock, key);
        while self.bytes > budget {
            let Some((_, oldest)) = self.key_by_stamp.pop_first() else { break };
            if let Some((block, _)) = self.blocks.remove(&oldest) {
                self.bytes -= block.weight();
            }
        }
    }
}

struct BlockClaim<'a, B: Weigh> {
    cache: &'a BlockCache<B>,
    key: u64,
}

impl<B: Weigh> Drop for BlockClaim<'_, B> {
    fn drop(&mut self) {
        self.cache.lock().decoding.remove(&self.key);
        self.cache.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;
    use hedgehop_base::error::Error;

    impl Weigh for Vec<u8> {
        fn weight(&self) -> u64 {
            self.len() as u64
        }
    }

    #[test]
    fn least_recently_used_goes_first() {
        let cache = BlockCache::new(20);
        let decoded = AtomicU32::new(0);
        let get = |key| {
            cache
                .get(key, || {
                    decoded.fetch_add(1, Ordering::Relaxed);
                    Ok(vec![key as u8; 10])
                })
                .unwrap()[0]
        };
        for key in [1, 2, 1, 3, 1] {
            assert_eq!(u64::from(get(key)), key);
        }
        assert_eq!(decoded.load(Ordering::Relaxed), 3);
        assert_eq!(cache.lock().bytes, 20);
        get(2);
        assert_eq!(decoded.load(Ordering::Relaxed), 4);
    }

    #[test]
    fn threads_share_one_decoding() {
        let cache = BlockCache::new(100);
        let decoded = AtomicU32::new(0);
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    cache
                        .get(7, || {
                            std::thread::sleep(std::time::Duration::from_millis(20));
                            decoded.fetch_add(1, Ordering::Relaxed);
                            Ok(vec![7; 10])
                        })
                        .unwrap()
                });
            }
        });
        assert_eq!(decoded.load(Ordering::Relaxed), 1);
    }

    #[test]
    fn a_failed_decoding_can_be_tried_again() {
        let cache = BlockCache::<Vec<u8>>::new(100);
        assert!(cache.get(1, || Err(Error::Configuration("no".into()))).is_err());
        assert!(cache.get(1, || Ok(vec![1])).is_ok());
    }
}
