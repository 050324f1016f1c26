//! Light that frames ahead will look at, computed before they begin.
//!
//! ```text
//! groups of planes ─▶ stretches of lines (footprint) ─▶ strips of light
//!                                                         known: they stay
//!                                                         not known: their page's paint is needed, once
//!      where ground may be too steep for a stride ──────▶ those of shorter strides too, as the page's heights tell
//! ```
//!
//! A strip of light takes a fraction of what it is made of, so that a view of which all strips are known needs little memory.

use std::collections::{HashMap, HashSet};

use super::Renderer;
use crate::error::Result;
use crate::raymarch::scan::{Rises, Stretch};
use crate::sensor::radiance::{Lighter, Strip, Weaves};
use crate::space::Camera;
use crate::subimage::Farm;
use crate::voxel::{PAGE_SIDE, PageId, PageNeeds, PagePart, PageSource};

/// Pages and directions whose steepness is remembered, some three kilobytes each.
const MOST_RISES: usize = 1 << 11;

/// Strips that were asked about lately; a power of two.
const RECENT: usize = 256;

/// Lights what frames will look at.
#[derive(Debug, Default)]
pub struct Ahead {
    lighter: Lighter,
    /// By page, what of the light of the frame that was asked about last is not known.
    unlit: HashMap<PageId, Unlit>,
    /// By page, and by axis and sense of the planes.
    rises: HashMap<(PageId, usize, bool), Rises>,
}

/// What is not known of a page's light.
#[derive(Debug, Default)]
struct Unlit {
    strips: Vec<Strip>,
    /// Stretches of lines that may be seen at shorter strides, if the page is steep there.
    doubts: Vec<Threads>,
}

/// Lines that a group of planes may see, as they are woven for it.
pub type Threads = (Stretch, Weaves);

impl Ahead {
    /// Parts of pages that a frame may touch if light is computed ahead: no paint; and the pages whose paint that takes, in the order of need.
    ///
    /// # Errors
    /// As of [`Renderer::foresee`].
    pub fn unlit<S: PageSource>(
        &mut self,
        renderer: &Renderer<'_, S>,
        camera: &Camera,
        farm: &Farm,
    ) -> Result<(PageNeeds, Vec<PageId>)> {
        let (PageNeeds { mut parts, mut likely }, threads) = renderer.foresee_threads(camera, farm)?;
        self.unlit.clear();
        let mut seen = Seen { renderer, recent: vec![None; RECENT], known: HashSet::new() };
        for thread in &threads {
            thread.0.pages().for_each(|page| self.collect(thread, page, &mut seen));
        }
        let is_paint = |part: &mut PagePart| matches!(part, PagePart::Paint(_));
        let mut paint: Vec<_> = parts.extract_if(..likely, is_paint).collect();
        likely -= paint.len();
        paint.extend(parts.extract_if(likely.., is_paint));
        let pages = paint.iter().map(|part| part.page()).filter(|page| self.unlit.contains_key(page));
        Ok((PageNeeds { parts, likely }, pages.collect()))
    }

    /// Notes what is not known of the light of some lines on a page.
    fn collect<S: PageSource>(&mut self, thread: &Threads, page: PageId, seen: &mut Seen<'_, S>) {
        let (stretch, weaves) = thread;
        let mut note = |log: usize| {
            strips(thread, page, log, |strip| {
                if !seen.is_known(strip) {
                    self.unlit.entry(page).or_default().strips.push(strip);
                }
            });
        };
        stretch.own().for_each(&mut note);
        if stretch.shorter().next().is_none() {
            return;
        }
        let rises = self.rises.get(&(page, weaves.major, weaves.forward));
        match rises.and_then(|rises| rises.may_divide(stretch, stretch.on(page))) {
            Some(false) => {}
            Some(true) => stretch.shorter().for_each(note),
            None => self.unlit.entry(page).or_default().doubts.push(*thread),
        }
    }

    /// Lights what is not known of a page, whose heights and paint are in memory.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn light<S: PageSource>(&mut self, renderer: &Renderer<'_, S>, page: PageId) -> Result<()> {
        let Unlit { strips: mut wanted, doubts } = self.unlit.remove(&page).unwrap_or_default();
        if !doubts.is_empty()
            && let Some(view) = renderer.source.heights(page)?
        {
            if self.rises.len() >= MOST_RISES {
                self.rises.clear();
            }
            let mut known: HashSet<_> = wanted.iter().copied().collect();
            for thread in &doubts {
                let (stretch, weaves) = thread;
                let rises = self.rises.entry((page, weaves.major, weaves.forward)).or_default();
                rises.measure(stretch, &view, weaves.major, weaves.forward);
                if rises.may_divide(stretch, stretch.on(page)) == Some(true) {
                    let mut add = |strip| wanted.extend(known.insert(strip).then_some(strip));
                    stretch.shorter().for_each(|log| strips(thread, page, log, &mut add));
                }
            }
        }
        let radiance = &renderer.shared.radiance;
        wanted.into_iter().try_for_each(|strip| self.lighter.light(renderer.source, radiance, strip))
    }
}

/// Strips that were asked about for a frame.
struct Seen<'r, S> {
    renderer: &'r Renderer<'r, S>,
    recent: Vec<Option<Strip>>,
    known: HashSet<Strip>,
}

impl<S: PageSource> Seen<'_, S> {
    /// Whether there is nothing more to do about a strip: its light is known, and stays, or it was asked for before.
    fn is_known(&mut self, strip: Strip) -> bool {
        let Strip { page, weave, index } = strip;
        let kind = u32::from(
            weave.span | weave.shift << 3 | weave.facing.major << 5 | u8::from(weave.facing.forward) << 6,
        );
        let hash = page.px ^ page.py << 3 ^ u32::from(page.level) << 5 ^ index << 6 ^ kind;
        let recent = &mut self.recent[hash as usize % RECENT];
        if *recent == Some(strip) {
            return true;
        }
        *recent = Some(strip);
        !self.known.insert(strip) || self.renderer.shared.radiance.keep(strip)
    }
}

/// Strips of a page's lines of which one stands for `1 << log`.
fn strips((stretch, weaves): &Threads, page: PageId, log: usize, tell: impl FnMut(Strip)) {
    let lines = stretch.on(page)[weaves.major].map(|line| line.min(PAGE_SIDE - 1));
    weaves.strips(page, 1 << log, lines, stretch.distances, tell);
}
