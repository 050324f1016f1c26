//! Radiance of the pages that were touched, shared by all workers.

use std::sync::Arc;

use super::lines::FilterScratch;
use super::posts::PageLight;
use super::{Facing, LineFilter, LineImage, RadiancePage};
use crate::cache::{Bytes, KeyedCache, Lent, Used};
use crate::sensor::VisualSensor;
use crate::sensor::radiance::part::PostPart;
use crate::simd::Isa;
use crate::sunlight::{ShadePage, Shades};
use crate::voxel::{PageId, PageSource};
use hedgehop_base::error::Result;

/// Bytes of radiance that are kept unless told otherwise.
const DEFAULT_BUDGET: usize = 1 << 30;

/// Image that is kept under a key.
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
pub struct LineStrip {
    /// Page of the strip.
    pub page: PageId,
    /// Filter that made the lines.
    pub filter: LineFilter,
    /// Counted from the page's first.
    pub index: u32,
}

impl LineStrip {
    /// The strip that holds post `post` of a page, counted along the planes.
    pub fn with(page: PageId, filter: LineFilter, post: u32) -> Self {
        Self { page, filter, index: post / (STRIP << filter.span.trailing_zeros()) }
    }

    /// Returns the first post.
    pub fn first(&self) -> u32 {
        self.index * self.posts()
    }

    /// Returns the number of posts along the planes; at the page's end fewer.
    pub fn posts(&self) -> u32 {
        STRIP << self.filter.span.trailing_zeros()
    }
}

/// Key of an image: posts of a page seen from above, or lines of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Key {
    Page(PageId),
    Lines(LineStrip),
}

/// Radiance of one database under one sun.
#[derive(Debug)]
pub struct Radiance {
    sensor: VisualSensor,
    /// `None`: nothing lies in shadow.
    shades: Option<Shades>,
    images: KeyedCache<Key, Image>,
    scratches: Used<FilterScratch>,
}

impl Radiance {
    /// Nothing is computed yet.
    pub fn new(sensor: VisualSensor) -> Self {
        Self::with_budget(sensor, DEFAULT_BUDGET)
    }

    /// The same with another limit in bytes. What the latest frames used is kept beyond it.
    pub fn with_budget(sensor: VisualSensor, budget: usize) -> Self {
        Self { sensor, shades: None, images: KeyedCache::new(budget), scratches: Used::default() }
    }

    /// The same with shadows. The shares of the sun are no part of the budget, but have one of their own.
    #[must_use]
    pub fn shaded(self, shades: Option<Shades>) -> Self {
        Self { shades, ..self }
    }

    /// Returns the shadows; `None`: nothing lies in shadow.
    pub fn shades(&self) -> Option<&Shades> {
        self.shades.as_ref()
    }

    /// Returns the sunlight on the posts of a page, where there are shadows.
    fn shade(&self, source: &dyn PageSource, id: PageId) -> Result<Option<Arc<ShadePage>>> {
        self.shades.as_ref().map_or(Ok(None), |shades| shades.page(source, id.surface()))
    }

    /// Bytes of radiance that are kept.
    pub fn bytes(&self) -> usize {
        self.images.bytes() + self.shades.as_ref().map_or(0, Shades::bytes)
    }

    /// A new frame begins: drops what was not used for longest if there is more than the budget allows.
    pub fn begin_frame(&self) {
        self.images.begin_frame();
        self.shades.iter().for_each(Shades::begin_frame);
    }

    /// Pages that are read to light a page: itself, and with shadows those towards the sun unless it is known what they hide.
    fn reads(&self, source: &dyn PageSource, id: PageId) -> impl Iterator<Item = PageId> {
        let seen = id.surface();
        let towards_sun = self.shades.iter().filter(move |shades| !shades.has(seen));
        std::iter::once(id).chain(towards_sun.flat_map(move |shades| shades.shade().supports(source, seen)))
    }

    /// Returns the value kept under the key of a page's image, or else the result of `make`. A page that `source` does not have is absent, also if its
    /// image is known from another frame that had it: pictures are the same whatever was rendered before.
    fn image(
        &self,
        source: &dyn PageSource,
        id: PageId,
        key: Key,
        make: impl FnOnce() -> Result<Option<Image>>,
    ) -> Result<Option<Image>> {
        if source.has(id) { self.images.get(key, make) } else { make() }
    }

    fn page(&self, source: &dyn PageSource, id: PageId) -> Result<Option<Arc<RadiancePage>>> {
        let bake = || {
            let shade = self.shade(source, id)?;
            let lamp = PageLight::new(&self.sensor).with_shade(shade.as_deref());
            let page =
                RadiancePage::bake(source, id, PostPart::ALL, &lamp, &Facing::down(0), None, Isa::best())?;
            Ok(page.map(|page| Image::Page(Arc::new(page))))
        };
        match self.image(source, id, Key::Page(id), bake)? {
            Some(Image::Page(page)) => Ok(Some(page)),
            _ => Ok(None),
        }
    }

    /// Returns the lines of a strip; unknown ones are computed if it `may_filter`, which is asked then only.
    fn lines(
        &self,
        source: &dyn PageSource,
        strip: LineStrip,
        scratch: &mut FilterScratch,
        may_filter: impl FnOnce() -> bool,
    ) -> Result<Option<Arc<LineImage>>> {
        let filter_lines = || {
            if !may_filter() {
                return Ok(None);
            }
            let part = PostPart::lines(strip.filter.facing.major, strip.first(), strip.posts());
            let shade = self.shade(source, strip.page)?;
            let lamp = PageLight::new(&self.sensor).with_shade(shade.as_deref());
            let lines = LineImage::bake(source, strip.page, part, &lamp, strip.filter, scratch, Isa::best())?;
            Ok(lines.map(|lines| Image::Lines(Arc::new(lines))))
        };
        match self.image(source, strip.page, Key::Lines(strip), filter_lines)? {
            Some(Image::Lines(lines)) => Ok(Some(lines)),
            _ => Ok(None),
        }
    }
}

/// Slots of a task's own images, a power of two.
const SLOTS: usize = 256;

/// An image, and what it is of.
type ImageSlot = Option<(LineStrip, Option<Arc<LineImage>>)>;

/// Pages that one task looked up.
pub struct RadiancePages<'a> {
    source: &'a dyn PageSource,
    radiance: &'a Radiance,
    slots: Vec<ImageSlot>,
    scratch: Lent<'a, FilterScratch>,
    /// Pages that were missing, unless they are waited for.
    missing: Option<Vec<PageId>>,
    /// Stands for their lines.
    dark: Arc<LineImage>,
}

impl<'a> RadiancePages<'a> {
    /// None is looked up yet.
    pub fn new(source: &'a dyn PageSource, radiance: &'a Radiance) -> Self {
        let dark = Arc::new(LineImage::dark());
        Self {
            source,
            radiance,
            slots: vec![None; SLOTS],
            scratch: radiance.scratches.lend(),
            missing: None,
            dark,
        }
    }

    /// Waits for no page: lines that are not known are dark where their page is not [at hand](PageSource::is_at_hand), which is
    /// [missing](Self::take_missing) then.
    #[must_use]
    pub fn without_waiting(self) -> Self {
        Self { missing: Some(Vec::new()), ..self }
    }

    /// Pages that were missing since this was asked last, some of them several times.
    pub fn take_missing(&mut self) -> Vec<PageId> {
        self.missing.as_mut().map(std::mem::take).unwrap_or_default()
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
    pub fn lines(&mut self, strip: LineStrip) -> Result<Option<Arc<LineImage>>> {
        let LineStrip { page, filter, index } = strip;
        let hash = page.px.wrapping_mul(7)
            ^ page.py.wrapping_mul(29)
            ^ u32::from(page.level).wrapping_mul(17)
            ^ u32::from(filter.span | filter.shift << 3).wrapping_mul(37)
            ^ index.wrapping_mul(41);
        let Self { source, radiance, slots, scratch, missing, dark } = self;
        let slot = &mut slots[hash as usize % SLOTS];

        if slot.as_ref().is_none_or(|(known, _)| *known != strip) {
            let mut absent = Vec::new();
            let may_filter = || {
                if missing.is_some() {
                    let is_absent =
                        |read: &PageId| (*read == page || source.has(*read)) && !source.is_at_hand(*read);
                    absent.extend(radiance.reads(*source, page).filter(is_absent));
                }
                absent.is_empty()
            };

            let lines = radiance.lines(*source, strip, scratch, may_filter)?;
            if !absent.is_empty() {
                missing.get_or_insert_default().append(&mut absent);
                return Ok(Some(Arc::clone(dark)));
            }

            *slot = Some((strip, lines));
        }

        Ok(slot.as_ref().and_then(|(_, lines)| lines.clone()))
    }
}
