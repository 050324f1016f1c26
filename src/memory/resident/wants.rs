//! Holdings and wants of frames that never wait.

use std::sync::PoisonError;

use super::super::deferred_eviction::DeferredEviction;
use super::super::sync::{Mutex, MutexGuard, SegQueue};
use crate::voxel::PagePart;

/// Holdings and wants of frames that never wait.
#[derive(Debug, Default)]
pub(super) struct Late {
    deferred: Mutex<DeferredEviction>,
    /// Each part of a page once, while its state says that it is wanted.
    pub(super) wanted: SegQueue<PagePart>,
}

impl Late {
    pub(super) fn deferred(&self) -> MutexGuard<'_, DeferredEviction> {
        self.deferred.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
