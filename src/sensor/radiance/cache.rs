//! Radiance of the pages that were touched, shared by all workers.

use std::sync::Arc;

use super::{Facing, LineImage, RadiancePage, Weave};
use crate::error::Result;
use crate::sensor::VisualSensor;
use crate::simd::Isa;
use crate::voxel::{Bytes, Derived, PageId, PageSource};

/// Bytes of radiance that are kept unless told otherwise.
const DEFAULT_BUDGET: usize = 1 << 30;

/// What is kept under a key; `None`: the page is absent.
#[derive(Debug, Clone)]
enum Image {
    Page(Option<Arc<RadiancePage>>),
    Lines(Option<Arc<LineImage>>),
}

impl Bytes for Image {
    fn bytes(&self) -> usize {
        match self {
            Self::Page(page) => page.as_ref().map_or(0, |page| page.bytes()),
            Self::Lines(lines) => lines.as_ref().map_or(0, |lines| lines.bytes()),
        }
    }
}

/// What an image is of: posts of a page, or lines of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Key {
    Page(PageId, Facing),
    Lines(PageId, Weave),
}

/// Radiance of one database under one sun.
#[derive(Debug)]
pub struct Radiance {
    sensor: VisualSensor,
    images: Derived<Key, Image>,
}

impl Radiance {
    /// Nothing is computed yet.
    pub fn new(sensor: VisualSensor) -> Self {
        Self::with_budget(sensor, DEFAULT_BUDGET)
    }

    /// The same with another limit in bytes. What the latest frames used is kept beyond it.
    pub fn with_budget(sensor: VisualSensor, budget: usize) -> Self {
        Self { sensor, images: Derived::new(budget) }
    }

    /// The same sensor, with nothing computed yet and another limit.
    #[must_use]
    pub fn within(self, budget: usize) -> Self {
        Self::with_budget(self.sensor, budget)
    }

    /// Bytes of radiance that are kept.
    pub fn bytes(&self) -> usize {
        self.images.bytes()
    }

    /// A new frame begins: drops what was not used for longest if there is more than the budget allows.
    pub fn begin_frame(&self) {
        self.images.begin_frame();
    }

    fn page(&self, source: &dyn PageSource, id: PageId, facing: Facing) -> Result<Option<Arc<RadiancePage>>> {
        // Of the finest level there is nothing finer to be seen more or less of.
        let facing = if id.level == 0 { Facing::down(0) } else { facing };
        let bake = || {
            let page = RadiancePage::bake(source, id, &self.sensor, &facing, Isa::best())?;
            Ok(Image::Page(page.map(Arc::new)))
        };
        match self.images.get(Key::Page(id, facing), bake)? {
            Image::Page(page) => Ok(page),
            Image::Lines(_) => Ok(None),
        }
    }

    fn lines(&self, source: &dyn PageSource, id: PageId, weave: Weave) -> Result<Option<Arc<LineImage>>> {
        let weave_lines = || {
            let page = self.page(source, id, weave.facing)?;
            Ok(Image::Lines(page.map(|page| Arc::new(LineImage::new(&page, weave)))))
        };
        match self.images.get(Key::Lines(id, weave), weave_lines)? {
            Image::Lines(lines) => Ok(lines),
            Image::Page(_) => Ok(None),
        }
    }
}

/// Slots of a task's own images, a power of two.
const SLOTS: usize = 64;

/// An image, and what it is of.
type Slot = Option<(PageId, Weave, Option<Arc<LineImage>>)>;

/// What one task looked up.
pub struct RadiancePages<'a> {
    source: &'a dyn PageSource,
    radiance: &'a Radiance,
    slots: Vec<Slot>,
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

    /// A page's radiance seen from above; `None` where the page is absent.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn page(&self, id: PageId) -> Result<Option<Arc<RadiancePage>>> {
        self.radiance.page(self.source, id, Facing::down(0))
    }

    /// Lines of a page's radiance; `None` where the page is absent.
    ///
    /// # Errors
    /// A page that is damaged.
    #[inline]
    pub fn lines(&mut self, id: PageId, weave: Weave) -> Result<Option<Arc<LineImage>>> {
        let hash = id.px.wrapping_mul(7)
            ^ id.py.wrapping_mul(29)
            ^ u32::from(id.level).wrapping_mul(17)
            ^ u32::from(weave.span | weave.shift << 3).wrapping_mul(37);
        let slot = &mut self.slots[hash as usize % SLOTS];
        if slot.as_ref().is_none_or(|(known, knit, _)| *known != id || *knit != weave) {
            *slot = Some((id, weave, self.radiance.lines(self.source, id, weave)?));
        }
        Ok(slot.as_ref().and_then(|(_, _, lines)| lines.clone()))
    }
}
