//! Radiance of the pages that were touched, shared by all workers.

use std::sync::Arc;

use super::lines::Loom;
use super::page::Part;
use super::{Facing, LineImage, RadiancePage, Weave};
use crate::error::Result;
use crate::sensor::VisualSensor;
use crate::simd::Isa;
use crate::voxel::{Bytes, Derived, PageId, PageSource};

/// Bytes of radiance that are kept unless told otherwise.
const DEFAULT_BUDGET: usize = 1 << 30;

/// What is kept under a key.
#[derive(Debug, Clone)]
enum Image {
    Page(Arc<RadiancePage>),
    Lines(Arc<LineImage>),
}

impl Bytes for Image {
    fn bytes(&self) -> usize {
        match self {
            Self::Page(page) => page.bytes(),
            Self::Lines(lines) => lines.bytes(),
        }
    }
}

/// Lines that are computed together: from afar, few of a page are seen at one stride and footprint.
const STRIP: u32 = 32;

/// Some neighbouring lines of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Strip {
    /// Of which page.
    pub page: PageId,
    /// Which lines, and what they stand for.
    pub weave: Weave,
    /// Counted from the page's first.
    pub index: u32,
}

impl Strip {
    /// The strip that holds post `post` of a page, counted along the planes.
    pub fn with(page: PageId, weave: Weave, post: u32) -> Self {
        Self { page, weave, index: post / (STRIP << weave.span.trailing_zeros()) }
    }

    /// Its first post.
    pub fn first(&self) -> u32 {
        self.index * self.posts()
    }

    /// Its posts along the planes; at the page's end fewer.
    pub fn posts(&self) -> u32 {
        STRIP << self.weave.span.trailing_zeros()
    }
}

/// What an image is of: posts of a page seen from above, or lines of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Key {
    Page(PageId),
    Lines(Strip),
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

    /// Bytes of radiance that are kept.
    pub fn bytes(&self) -> usize {
        self.images.bytes()
    }

    /// A new frame begins: drops what was not used for longest if there is more than the budget allows.
    pub fn begin_frame(&self) {
        self.images.begin_frame();
    }

    /// So many bytes more than the budget may be kept.
    pub fn lend(&self, bytes: usize) {
        self.images.lend(bytes);
    }

    /// Bytes beyond the budget that are kept.
    pub fn borrowed(&self) -> usize {
        self.images.borrowed()
    }

    /// Whether a strip is known; if so, it stays for the frames that memory looks ahead.
    pub fn keep(&self, strip: Strip) -> bool {
        self.images.keep(Key::Lines(strip))
    }

    /// What is known under the key of a page's image, or else what `make` finds. A page that `source` does not have is absent, also if its
    /// image is known from another frame that had it: pictures are the same whatever was rendered before.
    fn image(
        &self,
        source: &dyn PageSource,
        (id, key): (PageId, Key),
        make: impl FnOnce() -> Result<Option<Image>>,
    ) -> Result<Option<Image>> {
        if source.has(id) { self.images.get(key, make) } else { make() }
    }

    fn page(&self, source: &dyn PageSource, id: PageId) -> Result<Option<Arc<RadiancePage>>> {
        let bake = || {
            let page =
                RadiancePage::bake(source, (id, Part::ALL), &self.sensor, &Facing::down(0), Isa::best())?;
            Ok(page.map(|page| Image::Page(Arc::new(page))))
        };
        match self.image(source, (id, Key::Page(id)), bake)? {
            Some(Image::Page(page)) => Ok(Some(page)),
            _ => Ok(None),
        }
    }

    fn lines(
        &self,
        source: &dyn PageSource,
        strip: Strip,
        loom: &mut Loom,
    ) -> Result<Option<Arc<LineImage>>> {
        let weave_lines = || {
            let part = Part::lines(strip.weave.facing.major, strip.first(), strip.posts());
            let lines =
                LineImage::bake(source, (strip.page, part), &self.sensor, strip.weave, (loom, Isa::best()))?;
            Ok(lines.map(|lines| Image::Lines(Arc::new(lines))))
        };
        match self.image(source, (strip.page, Key::Lines(strip)), weave_lines)? {
            Some(Image::Lines(lines)) => Ok(Some(lines)),
            _ => Ok(None),
        }
    }
}

/// Lights strips ahead of the frames that look at them.
#[derive(Debug, Default)]
pub struct Lighter(Loom);

impl Lighter {
    /// Lights a strip of a page that is in memory. It stays for the frames that memory looks ahead.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn light(&mut self, source: &dyn PageSource, radiance: &Radiance, strip: Strip) -> Result<()> {
        if radiance.lines(source, strip, &mut self.0)?.is_some() {
            radiance.keep(strip);
        }
        Ok(())
    }
}

/// Slots of a task's own images, a power of two.
const SLOTS: usize = 256;

/// An image, and what it is of.
type Slot = Option<(Strip, Option<Arc<LineImage>>)>;

/// What one task looked up.
pub struct RadiancePages<'a> {
    source: &'a dyn PageSource,
    radiance: &'a Radiance,
    slots: Vec<Slot>,
    loom: Loom,
}

impl<'a> RadiancePages<'a> {
    /// None is looked up yet.
    pub fn new(source: &'a dyn PageSource, radiance: &'a Radiance) -> Self {
        Self { source, radiance, slots: vec![None; SLOTS], loom: Loom::default() }
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
        self.radiance.page(self.source, id)
    }

    /// Radiance of a strip of lines; `None` where the page is absent.
    ///
    /// # Errors
    /// A page that is damaged.
    #[inline]
    pub fn lines(&mut self, strip: Strip) -> Result<Option<Arc<LineImage>>> {
        let Strip { page, weave, index } = strip;
        let hash = page.px.wrapping_mul(7)
            ^ page.py.wrapping_mul(29)
            ^ u32::from(page.level).wrapping_mul(17)
            ^ u32::from(weave.span | weave.shift << 3).wrapping_mul(37)
            ^ index.wrapping_mul(41);
        let slot = &mut self.slots[hash as usize % SLOTS];
        if slot.as_ref().is_none_or(|(known, _)| *known != strip) {
            *slot = Some((strip, self.radiance.lines(self.source, strip, &mut self.loom)?));
        }
        Ok(slot.as_ref().and_then(|(_, lines)| lines.clone()))
    }
}
