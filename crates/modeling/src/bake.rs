//! Shadows in a database's colours.
//!
//! The patent darkens voxels that lie in shadow when the database is made (Hughes 1994, shadows: colour × F). So does this, for one sun: by the share
//! of daylight that a post has left, so that what is lit by the same sun afterwards looks as if shadows had been computed then. Coarser levels are
//! means of finer ones, as ever; where these are not stored, they are darkened by what they see of the sun themselves.

mod keys;

use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;

use super::build_cache::{self, BuildCache, MadeRecord};
use super::counts::PageCounts;
use super::disk_space;
use super::workers::in_order;
use super::writing::Page;
use hedgehop::sunlight::{Daylight, SHADE_APRON, Shade, ShadePage, Shades, Sun};
use hedgehop::voxel::{
    APRON, ContentHash, Directory, EncodedPage, Metadata, PAGE_SIDE, PageBuffer, PageEntry, PageId,
    PageReadback, PageSource, PageView, PageWriter, Span, SpanTable, StandIn, VoxelBlock, half_steps,
    sparse_page,
};
use hedgehop_base::Size;
use hedgehop_base::colour::{linear_from_srgb8, srgb8_from_linear};
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;
use keys::BakingKeys;

/// Bytes of shares of the sun that are kept for neighbouring pages.
const KEPT: usize = 64 << 20;

/// Bytes of pages that are held until it is known whether the output can be changed in place.
const HELD: u64 = 64 << 20;

/// Pages after which what is not used any more goes.
const ROUND: u64 = 64;

/// Database that shadows are baked into, and the file it goes to.
#[derive(Clone, Copy)]
pub struct Baking<'a> {
    /// The database without shadows.
    pub source: &'a dyn PageSource,
    /// Directory and contents of its pages.
    pub directory: &'a Directory,
    /// The sun that throws them.
    pub sun: Sun,
    /// The database with shadows; its pages lie as those of `source` do.
    pub output: &'a Path,
    /// Whether `output` may be replaced.
    pub overwrite: bool,
    /// Whether what is baked is noted beside `output`, so that the next time only what changed since is.
    pub steps: bool,
    /// Threads that work.
    pub threads: usize,
}

/// Result of baking.
#[derive(Debug, Clone, Copy)]
pub struct Baked {
    /// Identity of the result.
    pub content_hash: ContentHash,
    /// Bytes of the file.
    pub bytes: u64,
    /// Pages that were written.
    pub pages: u64,
    /// Pages of these that were baked before.
    pub reused: u64,
}

/// Writes a database with the shadows of a sun in its colours. Nothing is left behind on error, on cancellation or on a kill that opens as
/// a database.
///
/// # Errors
/// [`Error::Configuration`]: the database has shadows already, the sun is below the horizon, or the output exists and may not be replaced; a page that is
/// damaged; what the disk refuses.
pub fn bake_shadows(baking: &Baking<'_>, observer: &dyn Observer) -> Result<Baked> {
    let Baking { source, directory, sun, output, overwrite, .. } = *baking;
    let header = source.header();
    if header.metadata.baked_sun.is_some() {
        let what =
            "the database's colours hold shadows already; bake them into the one that it was made from";
        return Err(Error::Configuration(what.into()));
    }

    check_shadows(sun)?;
    let cache = baking.steps.then(|| BuildCache::of(output));

    // Pages stay as long as they are. Where some are known, they may stay in their places, too.
    let bytes: u64 = directory.present().map(|(_, entry)| disk_space::placed(entry.length)).sum();
    if !cache.as_ref().is_some_and(BuildCache::knows_pages) {
        disk_space::check_bytes(output, bytes)?;
    }

    let mut writer = PageWriter::create(output, header.grid, header.heights, overwrite)?
        .with_objects(Arc::clone(&header.objects));
    writer.expect(bytes + header.objects.to_bytes().len() as u64);
    let mut writer = build_cache::begin(cache.as_ref(), writer, HELD)?;
    let shades = Shades::new(Shade::new(header, sun), KEPT);
    let oven = Oven { source, shades, daylight: Daylight::new(sun), finer: writer.readback() };
    let keys =
        cache.as_ref().map(|cache| (cache, BakingKeys::new(source, directory, sun, &oven.shades, cache)));
    let mut written = BakedPages::default();
    if let Err(error) = bake_pages(&oven, baking, keys.as_ref(), &mut writer, &mut written, observer) {
        return Err(build_cache::kept(cache.as_ref(), writer, written.pages, error));
    }

    source.intact()?;
    let metadata = Metadata { baked_sun: Some([sun.azimuth, sun.elevation]), ..header.metadata.clone() };
    let sealed = writer.seal(&metadata, header.height_range)?;
    let (content_hash, bytes) = build_cache::publish(cache.as_ref(), sealed)?;

    Ok(Baked { content_hash, bytes, pages: written.pages, reused: written.reused })
}

/// Pages that were written so far, and how many of them were baked before.
#[derive(Debug, Default)]
struct BakedPages {
    pages: u64,
    reused: u64,
}

/// Bakes all pages, finer levels first, in the order in which they lie.
fn bake_pages(
    oven: &Oven<'_>,
    Baking { directory, threads, .. }: &Baking<'_>,
    trace: Option<&(&BuildCache, BakingKeys<'_>)>,
    writer: &mut PageWriter,
    written: &mut BakedPages,
    observer: &dyn Observer,
) -> Result<()> {
    let pages = in_place(directory);
    observer.begin("shadows", pages.len() as u64, "pages");

    // Bare ground lies among the pages that stand on it.
    for pages in pages.chunk_by(|(_, a), (_, b)| a.surface().level == b.surface().level) {
        in_order(
            pages.len() as u64,
            *threads,
            observer,
            Vec::new,
            |scratch, task| {
                let (_, id) = pages[task as usize];
                if directory.is_empty_page(id) {
                    return Ok((Page::Made(oven.unlit(id)?), None));
                }

                let key = trace.map(|(_, keys)| keys.of(id, &oven.finer)).transpose()?;
                let known = trace
                    .zip(key)
                    .and_then(|((cache, _), key)| cache.page(&oven.source.header().grid, id, key, scratch));
                let page = match known {
                    Some(known) => Page::Reused(known.page),
                    None => Page::Made(oven.page(id)?),
                };
                Ok((page, key))
            },
            |task, (page, key)| {
                let id = page.id();
                written.pages += 1;
                written.reused += u64::from(matches!(page, Page::Reused(_)));
                page.append_to(writer)?;
                let made = |(key, entry)| MadeRecord {
                    id,
                    entry,
                    key,
                    counts: PageCounts::default(),
                    has_bare: false,
                };
                let noted = key.zip(oven.finer.entry(id)).map(made);
                trace.map_or(Ok(()), |(cache, _)| cache.made(noted.as_slice()))?;
                if task % ROUND == 0 || task + 1 == pages.len() as u64 {
                    oven.shades.begin_frame();
                }

                observer.advance(1);
                Ok(())
            },
        )?;
    }

    observer.end();
    Ok(())
}

/// All pages in the order in which they lie; those without bytes come first of their level.
fn in_place(directory: &Directory) -> Vec<(u64, PageId)> {
    let mut first = HashMap::new();
    for (id, entry) in directory.present().filter(|(_, entry)| entry.length > 0) {
        let first = first.entry(id.level).or_insert(entry.offset);
        *first = entry.offset.min(*first);
    }
    let place = |(id, entry): (PageId, &PageEntry)| match entry.length {
        0 => (first.get(&id.level).map_or(0, |first| first - 1), id),
        _ => (entry.offset, id),
    };
    let mut pages: Vec<_> = directory.present().map(place).collect();
    pages.sort_unstable();
    pages
}

/// Whether a sun throws shadows that can be baked.
///
/// # Errors
/// [`Error::Configuration`]: it is below the horizon.
pub fn check_shadows(sun: Sun) -> Result<()> {
    if sun.is_up() {
        return Ok(());
    }
    let what = format!("at {:.1}° the sun throws no shadows; choose one above the horizon", sun.elevation);
    Err(Error::Configuration(what))
}

fn absent(id: PageId) -> Error {
    Error::Configuration(format!("{id} is not stored; take the pages of the database's directory"))
}

/// Makes pages with shadows.
struct Oven<'s> {
    source: &'s dyn PageSource,
    shades: Shades,
    daylight: Daylight,
    /// Pages that have been made.
    finer: PageReadback,
}

/// A page, and what its posts see of the sun.
struct Lit<'s> {
    id: PageId,
    view: PageView<'s>,
    shares: Arc<ShadePage>,
}

impl<'s> Oven<'s> {
    fn page(&self, id: PageId) -> Result<EncodedPage> {
        let page = self.copy(id)?;
        if id.is_bare() {
            let spans = self.darkened_spans(id)?;
            return Ok(PageBuffer { colours: self.darkened(id)?, spans, ..page }.encode(id));
        }
        let colours = if id.level == 0 {
            self.darkened(id)?
        } else {
            let header = self.source.header();
            sparse_page(&self.finer, &mut Alone(self), &header.grid, header.heights, id)?.colours
        };
        Ok(PageBuffer { colours, ..page }.encode(id))
    }

    /// A page without any surface, which light does not change.
    fn unlit(&self, id: PageId) -> Result<EncodedPage> {
        let (view, bounds) = (self.source.page(id)?, self.source.bounds(id)?);
        let mut page = view.ok_or_else(|| absent(id))?.to_buffer();
        if let Some(bounds) = bounds {
            (page.low, page.high) = (bounds.low.to_vec(), bounds.high.to_vec());
        }
        Ok(page.encode(id))
    }

    /// The page as it is.
    fn copy(&self, id: PageId) -> Result<PageBuffer> {
        let mut page = self.lit(id)?.view.to_buffer();
        if id.is_bare() {
            return Ok(page);
        }
        if let Some(bounds) = self.source.bounds(id)? {
            (page.low, page.high) = (bounds.low.to_vec(), bounds.high.to_vec());
        }
        Ok(page)
    }

    fn lit(&self, id: PageId) -> Result<Lit<'s>> {
        let view = self.source.page(self.source.ground_of(id))?.ok_or_else(|| absent(id))?;
        let shares = self.shades.page(self.source, id.surface())?.ok_or_else(|| absent(id))?;
        Ok(Lit { id, view, shares })
    }

    /// Darkens the spans of a page of bare ground to the light that comes to the surface there. Objects that are placed stay as they are.
    fn darkened_spans(&self, id: PageId) -> Result<SpanTable> {
        let Some(spans) = self.source.spans(id)? else { return Ok(SpanTable::default()) };
        let lit = self.lit(id)?;
        let header = self.source.header();
        let size = Size { width: lit.view.width, height: lit.view.height };
        let rise = SpanTable::rise(header.heights, header.grid.spacing);
        let table = SpanTable::new(size, rise, |x, y, all| {
            let share = lit.shares.about([x, y].map(|at| (at + SHADE_APRON) as usize));
            let left = self.daylight.on(Vec3::Z, share) / self.daylight.on(Vec3::Z, 1.0);
            let dark = |colour: [u8; 3]| {
                (Vec3::from_array(linear_from_srgb8(colour)) * left).to_array().map(srgb8_from_linear)
            };
            let own = spans.at(x, y).iter();
            all.extend(own.map(|span| Span { top: dark(span.top), side: dark(span.side), ..span }));
        });
        Ok(table.with_objects(size, &header.objects, spans.placements()))
    }

    /// Colours of a page and around it, each as the page says to which it belongs.
    fn darkened(&self, id: PageId) -> Result<Vec<[u8; 3]>> {
        let own = self.lit(id)?;
        let (nx, ny) = self.source.header().grid.dims(id.surface().level);
        let place = |page: u32, at: u32, count: u32| {
            let post = (page * PAGE_SIDE + at).saturating_sub(APRON).min(count - 1);
            (post / PAGE_SIDE, post % PAGE_SIDE)
        };
        let mut beside: Vec<Lit<'_>> = Vec::new();
        let mut colours = Vec::with_capacity(own.view.colours.len());

        for y in 0..own.view.height + 2 * APRON {
            for x in 0..own.view.width + 2 * APRON {
                let ((px, column), (py, row)) = (place(id.px, x, nx), place(id.py, y, ny));
                let owner = PageId { level: id.level, px, py };
                if owner == id {
                    colours.push(self.colour(&own, [column, row].map(|post| post + APRON)));
                    continue;
                }
                if beside.iter().all(|lit| lit.id != owner) && self.source.has(owner.surface()) {
                    beside.push(self.lit(owner)?);
                }
                colours.push(match beside.iter().find(|lit| lit.id == owner) {
                    Some(other) => self.colour(other, [column, row].map(|post| post + APRON)),
                    // Beside a corridor nobody else says what lies there.
                    None => self.colour(&own, [x, y]),
                });
            }
        }

        Ok(colours)
    }

    /// Colour of a post, counted with the apron, by the share of daylight that comes to it.
    fn colour(&self, lit: &Lit<'_>, [x, y]: [u32; 2]) -> [u8; 3] {
        let Lit { id, view, shares } = lit;
        let [width, height] = [view.width, view.height].map(|side| side + 2 * APRON);
        let colour = view.colours[(y * width + x) as usize];
        let share = shares.at([x, y].map(|at| at.saturating_sub(APRON - SHADE_APRON) as usize));
        if share == 1.0 {
            return colour;
        }

        let header = self.source.header();
        let level = id.surface().level;
        let half_step = 0.5 * header.heights.scale / header.grid.side(level);
        let code = |x: u32, y: u32| view.heights[(y.min(height - 1) * width + x.min(width - 1)) as usize];
        let here = code(x, y);

        // Where the area ends the apron repeats its last post: half the way, so twice the slope.
        let slope = |behind, ahead, (page, at, count): (u32, u32, u32)| {
            let post = page * PAGE_SIDE + at;
            let is_last = post <= APRON || post + 1 >= count + APRON;
            f64::from(half_steps(here, behind, ahead) << i32::from(is_last)) * half_step
        };
        let (nx, ny) = header.grid.dims(level);
        let eastward = slope(code(x.saturating_sub(1), y), code(x + 1, y), (id.px, x, nx));
        let northward = slope(code(x, y.saturating_sub(1)), code(x, y + 1), (id.py, y, ny));
        let normal = Vec3::new(-eastward as f32, -northward as f32, 1.0).normalize();
        let left = self.daylight.on(normal, share) / self.daylight.on(normal, 1.0);

        (Vec3::from_array(linear_from_srgb8(colour)) * left).to_array().map(srgb8_from_linear)
    }
}

/// Stands in for finer pages that are not stored: the coarse page itself, darkened.
struct Alone<'o, 's>(&'o Oven<'s>);

impl StandIn for Alone<'_, '_> {
    fn finer(&mut self, _: PageId, _: Range<u32>, _: Range<u32>) -> Result<Option<VoxelBlock>> {
        Ok(None)
    }

    fn page(&mut self, id: PageId) -> Result<PageBuffer> {
        Ok(PageBuffer { colours: self.0.darkened(id)?, ..self.0.copy(id)? })
    }
}
