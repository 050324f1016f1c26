//! Radiance of the pages that were touched, shared by all workers.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};

use super::RadiancePage;
use crate::error::Result;
use crate::sensor::VisualSensor;
use crate::simd::Isa;
use crate::voxel::{PageId, PageSource};

/// Bytes of radiance that are kept unless told otherwise.
const DEFAULT_BUDGET: usize = 1 << 30;

#[derive(Debug)]
struct Entry {
    page: Option<Arc<RadiancePage>>,
    /// Frame in which it was last looked up.
    used: AtomicU64,
}

impl Entry {
    fn bytes(&self) -> usize {
        self.page.as_ref().map_or(0, |page| page.bytes())
    }
}

/// Radiance of one database under one sun.
#[derive(Debug)]
pub struct Radiance {
    sensor: VisualSensor,
    budget: usize,
    frame: AtomicU64,
    pages: RwLock<HashMap<PageId, Entry>>,
}

impl Radiance {
    /// Nothing is computed yet.
    pub fn new(sensor: VisualSensor) -> Self {
        Self::with_budget(sensor, DEFAULT_BUDGET)
    }

    /// The same with another limit in bytes. What the latest frames used is kept beyond it.
    pub fn with_budget(sensor: VisualSensor, budget: usize) -> Self {
        Self { sensor, budget, frame: AtomicU64::new(0), pages: RwLock::default() }
    }

    /// Bytes of radiance that are kept.
    pub fn bytes(&self) -> usize {
        let pages = self.pages.read().unwrap_or_else(PoisonError::into_inner);
        pages.values().map(Entry::bytes).sum()
    }

    /// A new frame begins: drops what was not used for longest if there is more than the budget allows.
    pub fn begin_frame(&self) {
        let now = self.frame.fetch_add(1, Ordering::Relaxed) + 1;
        let mut pages = self.pages.write().unwrap_or_else(PoisonError::into_inner);
        let mut bytes: usize = pages.values().map(Entry::bytes).sum();
        if bytes <= self.budget {
            return;
        }
        // Frames in flight beside this one may still need theirs.
        let mut old: Vec<(u64, PageId)> = pages
            .iter()
            .map(|(id, entry)| (entry.used.load(Ordering::Relaxed), *id))
            .filter(|(used, _)| used + 2 < now)
            .collect();
        old.sort_unstable();
        for (_, id) in old {
            if bytes <= self.budget {
                break;
            }
            bytes -= pages.remove(&id).map_or(0, |entry| entry.bytes());
        }
    }

    fn page(&self, source: &dyn PageSource, id: PageId) -> Result<Option<Arc<RadiancePage>>> {
        let now = self.frame.load(Ordering::Relaxed);
        if let Some(entry) = self.pages.read().unwrap_or_else(PoisonError::into_inner).get(&id) {
            entry.used.store(now, Ordering::Relaxed);
            return Ok(entry.page.clone());
        }
        // Outside of any lock: two workers may compute the same page, and find the same.
        let baked = RadiancePage::bake(source, id, &self.sensor, Isa::best())?;
        let page = baked.map(Arc::new);
        let mut pages = self.pages.write().unwrap_or_else(PoisonError::into_inner);
        let entry = pages.entry(id).or_insert(Entry { page, used: AtomicU64::new(now) });
        Ok(entry.page.clone())
    }
}

/// Slots of a task's own pages, a power of two.
const SLOTS: usize = 64;

/// The pages that one task looked up.
pub struct RadiancePages<'a> {
    source: &'a dyn PageSource,
    radiance: &'a Radiance,
    slots: Vec<Option<(PageId, Option<Arc<RadiancePage>>)>>,
}

impl<'a> RadiancePages<'a> {
    /// None is looked up yet.
    pub fn new(source: &'a dyn PageSource, radiance: &'a Radiance) -> Self {
        Self { source, radiance, slots: vec![None; SLOTS] }
    }

    /// The database.
    pub fn source(&self) -> &'a dyn PageSource {
        self.source
    }

    /// A page's radiance; `None` where the page is absent.
    #[inline]
    pub fn get(&mut self, id: PageId) -> Result<Option<Arc<RadiancePage>>> {
        let hash = id.px.wrapping_mul(7) ^ id.py.wrapping_mul(29) ^ u32::from(id.level).wrapping_mul(17);
        let slot = &mut self.slots[hash as usize % SLOTS];
        if slot.as_ref().is_none_or(|(known, _)| *known != id) {
            *slot = Some((id, self.radiance.page(self.source, id)?));
        }
        Ok(slot.as_ref().and_then(|(_, page)| page.clone()))
    }
}
