//! Flights for which there is too little room: light is computed ahead of need, and the paint that it is made of goes.
//!
//! ```text
//! as long as there is room:   heights, bounds and paint of a frame come; its workers light what they look at
//! from then on:               heights and bounds come, and stay until the frame is delivered
//!                             page by page paint of what is not lit comes, is lit, and may go
//! ```
//!
//! Light takes a fraction of what its paint does, and paint is most of a page: a view takes a third of the memory. To light what may be
//! looked at takes longer than to light what is, and longer than to read paint again: it is not done before a flight has come where a
//! view has no room.

use std::collections::{HashMap, HashSet};

use super::Flight;
use super::flight::{Foresight, LOOKAHEAD};
use super::resident::{Expected, Held};
use super::sync::Receiver;
use crate::error::Result;
use crate::voxel::{PageId, PageNeeds, PagePart};

/// Pages whose paint is in memory together to be lit, if there is room for it.
const TOGETHER: usize = 24;

/// Of the memory for pages, light that is computed ahead may take so many tenths.
const LENT_TENTHS: u64 = 3;

/// Computes the light of frames ahead of need.
pub trait Lighting {
    /// Light may take so many bytes more than its own from now on.
    fn lend(&self, bytes: u64);

    /// Bytes beyond its own that light takes, and all else that is computed from pages.
    fn borrowed(&self) -> u64;

    /// As [`Foresight::needs`], without paint; and pages whose paint it takes to light what is not known of the frame's light, in the order of need. What is
    /// known stays known until the frame is delivered.
    ///
    /// # Errors
    /// A page that is damaged.
    fn unlit(&self, frame: u32) -> Result<(PageNeeds, Vec<PageId>)>;

    /// Computes what [`Self::unlit`] last said of a page, of which heights and paint are in memory. It stays known until that frame is delivered.
    ///
    /// # Errors
    /// A page that is damaged.
    fn light(&self, page: PageId) -> Result<()>;
}

/// Prepares frames of a flight.
pub(super) struct Lamp<'a, 'p> {
    pub flight: &'a Flight<'p>,
    pub foresight: &'a dyn Foresight,
    pub lighting: &'a dyn Lighting,
    pub news: &'a Receiver<()>,
}

impl Lamp<'_, '_> {
    /// As of [`Flight::look_ahead`], from frame number `next` on.
    pub fn look_ahead(&self, next: u32, count: u32) {
        self.lighting.lend(self.flight.pages.budget() / 10 * LENT_TENTHS);
        self.prepare(next, count);
        // What the last frames will look at is kept for them.
        self.lighting.lend(0);
    }

    fn prepare(&self, mut next: u32, count: u32) {
        let pages = self.flight.pages;
        let (mut foreseen, mut lent) = (None, 0);
        while next < count && !self.flight.is_stopped() {
            let done = self.flight.done();
            if next < done + LOOKAHEAD {
                // What is free again of it is hardly given back to the system. Half of the memory is for pages whatever happens.
                lent = self.lighting.borrowed().clamp(lent, lent.max(pages.budget() / 2));
                pages.lend(lent);
                // Who renders the frame meets the same error.
                let (needs, unlit) =
                    foreseen.get_or_insert_with(|| self.lighting.unlit(next).unwrap_or_default());
                let is_behind = |page| self.foresight.is_behind(done, page);
                if let Some(expected) = pages.expect(next, needs, is_behind) {
                    self.light(next, unlit, expected);
                    foreseen = None;
                    next += 1;
                    self.flight.let_begin(next);
                    continue;
                }
            }
            if self.news.recv().is_err() {
                return;
            }
        }
    }

    /// Brings what a frame expects, and lights pages in turn.
    fn light(&self, frame: u32, unlit: &[PageId], expected: Vec<Expected>) {
        // A page is read once for all of its parts: those that are lit come with their paint.
        let dark: HashSet<_> = unlit.iter().copied().collect();
        let (with_paint, expected): (Vec<_>, _) =
            expected.into_iter().partition(|(part, _)| dark.contains(&part.page()));
        let pages = self.flight.pages;
        pages.read(&expected);
        let mut by_page: HashMap<_, Vec<_>> = HashMap::new();
        for one in with_paint {
            by_page.entry(one.0.page()).or_default().push(one);
        }
        let (mut rest, mut most) = (unlit, TOGETHER);
        while !rest.is_empty() {
            let (together, later) = rest.split_at(rest.len().min(most));
            let paint: Vec<_> = together.iter().map(|page| PagePart::Paint(*page)).collect();
            let held = self.wait_for(frame, &paint, together.len() == 1);
            if held.is_none() && together.len() > 1 {
                most = together.len() / 2;
                continue;
            }
            rest = later;
            let mut coming: Vec<_> =
                together.iter().filter_map(|page| by_page.remove(page)).flatten().collect();
            let held = held.map(|(paint, held)| {
                coming.extend(paint);
                held
            });
            coming.sort_by_key(|(part, _)| together.iter().position(|page| *page == part.page()));
            pages.read(&coming);
            // Without the paint it is for the frame's workers.
            let Some(held) = held else { continue };
            for page in together {
                // Who looks at it meets the same error.
                let _ = self.lighting.light(*page);
            }
            pages.let_go_of(held);
        }
    }

    /// As [`ResidentPages::expect_all`](super::ResidentPages::expect_all), if need be when frames in flight have ended; `None`: there is no room.
    fn wait_for(&self, frame: u32, parts: &[PagePart], must: bool) -> Option<(Vec<Expected>, Held)> {
        loop {
            let done = self.flight.done();
            let is_behind = |page| self.foresight.is_behind(done, page);
            let expected = self.flight.pages.expect_all(frame, parts, is_behind);
            let can_wait = must && frame > done && !self.flight.is_stopped();
            if expected.is_some() || !can_wait || self.news.recv().is_err() {
                return expected;
            }
        }
    }
}
