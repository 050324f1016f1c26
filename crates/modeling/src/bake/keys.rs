//! Keys of pages with shadows.
//!
//! ```text
//! light of a page     ← the way of the sun's rays to it, the pages whose heights they pass
//! page of level 1     ← the page without shadows, it and the shares of its light and those around it, whose voxels its apron repeats
//! coarser page        ← the page without shadows, the finer ones with shadows; where some are absent, as of level 1
//! ```
//! Rays to a page pass over a kilometre of others, and few of these throw a shadow as far as that: what goes on is not what light was made of, but what came of it.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use crate::build_cache::{BuildCache, Key, Keyer};
use hedgehop::sunlight::{Shades, Sun};
use hedgehop::voxel::{Directory, PageId, PageReadback, PageSource, finer_pages};
use hedgehop_base::error::Result;

/// Keys of the pages of one database under one sun.
pub(super) struct BakingKeys<'a> {
    source: &'a dyn PageSource,
    directory: &'a Directory,
    shades: &'a Shades,
    steps: &'a BuildCache,
    settings: Key,
    /// Keys of the shares of the sun on pages.
    lights: Mutex<HashMap<PageId, Key>>,
}

impl<'a> BakingKeys<'a> {
    pub fn new(
        source: &'a dyn PageSource,
        directory: &'a Directory,
        sun: Sun,
        shades: &'a Shades,
        steps: &'a BuildCache,
    ) -> Self {
        let header = source.header();
        let settings = Keyer::of("shadows").with(&sun).with(&header.grid).with(&header.heights);
        let settings = settings.with(&header.level_count).with(&header.has_spans).key();
        Self { source, directory, shades, steps, settings, lights: Mutex::default() }
    }

    /// Returns the key of a page; all finer ones have been written.
    ///
    /// # Errors
    /// A page, this one or one towards the sun, that is damaged.
    pub fn of(&self, id: PageId, finer: &PageReadback) -> Result<Key> {
        let keyer = self.with_page(Keyer::of("shaded").with_key(self.settings), id);
        let grid = &self.source.header().grid;
        let (mut keyer, mut is_whole) = (keyer, id.level > 0 && !id.is_bare());
        for finer_id in finer_pages(grid, id) {
            let hash = finer.entry(finer_id).map(|entry| entry.hash);
            is_whole &= hash.is_some();
            keyer = keyer.with_bytes(hash.as_ref().map_or(&[], |hash| hash));
        }
        Ok(if is_whole { keyer } else { self.with_around(keyer, id)? }.key())
    }

    /// Adds what a page is without shadows, with the bare ground under it.
    fn with_page(&self, keyer: Keyer, id: PageId) -> Keyer {
        let surface = id.surface();
        let bare = Some(surface.bare()).filter(|_| surface.level == 0);
        [Some(surface), bare].into_iter().flatten().fold(keyer.with(&id), |keyer, id| {
            let entry = self.directory.get(id);
            keyer.with_bytes(entry.map_or(&[], |entry| &entry.hash))
        })
    }

    /// Adds a page, those around it, and the light on them.
    fn with_around(&self, mut keyer: Keyer, id: PageId) -> Result<Keyer> {
        let around = |at: u32| at.saturating_sub(1)..=at + 1;
        for (px, py) in around(id.py).flat_map(|py| around(id.px).map(move |px| (px, py))) {
            let page = PageId { px, py, ..id.surface() };
            if self.source.has(page) {
                keyer = self.with_page(keyer, page).with_key(self.light(page)?);
            }
        }
        Ok(keyer)
    }

    /// Returns the key of the shares of the sun on a page: as they were found before of the same, or else found now.
    fn light(&self, id: PageId) -> Result<Key> {
        let lights = || self.lights.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = lights().get(&id) {
            return Ok(*known);
        }

        let shade = self.shades.shade();
        let keyer = Keyer::of("light").with(&shade.way(id));
        let keyer = shade.supports(self.source, id).into_iter().fold(keyer, |keyer, support| {
            let entry = self.directory.get(support);
            keyer.with(&support).with_bytes(entry.map_or(&[], |entry| &entry.hash))
        });
        let key = keyer.key();
        let light = match self.steps.light(key) {
            Some(light) => light,
            None => self.found(id)?,
        };
        if lights().insert(id, light).is_none() {
            self.steps.lit(key, light);
        }

        Ok(light)
    }

    /// Finds the shares of the sun on a page for their key.
    fn found(&self, id: PageId) -> Result<Key> {
        let page = self.shades.page(self.source, id)?;
        let keyer = page
            .iter()
            .fold(Keyer::of("shares"), |keyer, page| keyer.with(&page.stride).with_bytes(&page.shares));
        Ok(keyer.key())
    }
}
