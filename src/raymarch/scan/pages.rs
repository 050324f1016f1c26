//! Pages that a task looked up, so that the next block finds them at once.

use std::rc::Rc;

use super::turned::{ColumnStrip, STRIP, TurnedColumns, TurnedPages};
use crate::voxel::{APRON, BoundsView, HeightsView, PAGE_SIDE, PageId, PageSource};
use hedgehop_base::error::Result;

/// Slots; a power of two. A task's planes touch some dozens of pages.
const SLOTS: usize = 64;

/// Height codes of lines of a page, one after the other.
#[derive(Clone)]
pub enum Codes<'a> {
    /// Codes as they are stored: lines are rows.
    Rows(&'a [u16]),
    /// Lines are columns.
    Columns(Rc<TurnedColumns>),
}

impl Codes<'_> {
    /// All of them.
    #[inline(always)]
    pub fn all(&self) -> &[u16] {
        match self {
            Self::Rows(codes) => codes,
            Self::Columns(columns) => columns.codes(),
        }
    }
}

/// A page, or a strip of one, turned; `None`: it is absent.
type PageSlot<K, T> = Option<(K, Option<T>)>;

/// Looks pages up, and remembers some.
pub struct Pages<'a> {
    source: &'a dyn PageSource,
    turned: &'a TurnedPages,
    heights: Vec<PageSlot<PageId, HeightsView<'a>>>,
    bounds: Vec<PageSlot<PageId, BoundsView<'a>>>,
    columns: Vec<PageSlot<ColumnStrip, Rc<TurnedColumns>>>,
}

impl<'a> Pages<'a> {
    /// Nothing is looked up yet.
    pub fn new(source: &'a dyn PageSource, turned: &'a TurnedPages) -> Self {
        let (heights, bounds, columns) = (vec![None; SLOTS], vec![None; SLOTS], vec![None; SLOTS]);
        Self { source, turned, heights, bounds, columns }
    }

    /// The database.
    pub fn source(&self) -> &'a dyn PageSource {
        self.source
    }

    /// A page's heights; `None` where it is absent.
    #[inline]
    pub fn heights(&mut self, id: PageId) -> Result<Option<HeightsView<'a>>> {
        let id = self.source.ground_of(id);
        remember(&mut self.heights[slot_of(id, 0)], id, || self.source.heights(id))
    }

    /// A page's bounds; `None` where it is absent.
    #[inline]
    pub fn bounds(&mut self, id: PageId) -> Result<Option<BoundsView<'a>>> {
        remember(&mut self.bounds[slot_of(id, 0)], id, || self.source.bounds(id))
    }

    /// Height codes of a page's lines for planes along axis `major`, and how many one line has; `None` where it is absent. Those
    /// along x are the lines of a strip.
    #[inline]
    pub fn codes(&mut self, id: PageId, major: usize, strip: u32) -> Result<Option<(Codes<'a>, i32)>> {
        let id = self.source.ground_of(id);
        if major == 1 {
            let view = self.heights(id)?;
            return Ok(view.map(|view| (Codes::Rows(view.heights), (view.width + 2 * APRON) as i32)));
        }
        let find = || Ok(self.turned.get(self.source, (id, strip))?.map(Rc::new));
        let codes = remember(&mut self.columns[slot_of(id, strip)], (id, strip), find)?;
        let size = self.source.header().grid.page_size(id);
        Ok(codes.zip(size).map(|(codes, size)| (Codes::Columns(codes), (size.height + 2 * APRON) as i32)))
    }

    /// The same if the page was looked up lately.
    #[inline]
    pub fn known_codes(&mut self, id: PageId, major: usize, strip: u32) -> Option<(Codes<'a>, i32)> {
        let id = self.source.ground_of(id);
        let is_known = match major {
            1 => self.heights[slot_of(id, 0)].as_ref().is_some_and(|(known, _)| *known == id),
            _ => self.columns[slot_of(id, strip)].as_ref().is_some_and(|(known, _)| *known == (id, strip)),
        };
        if is_known { self.codes(id, major, strip).ok().flatten() } else { None }
    }
}

/// Returns how many lines of a page for planes along axis `major` are read together with a line of it, and the number of their strip.
#[inline]
pub fn together(major: usize, line: u32) -> (u32, u32) {
    if major == 1 { (PAGE_SIDE, 0) } else { (STRIP, line / STRIP) }
}

/// Returns the slot in which a page, or a strip of it, is remembered.
#[inline]
fn slot_of(id: PageId, strip: u32) -> usize {
    let hash = id.px.wrapping_mul(7) ^ id.py.wrapping_mul(29) ^ u32::from(id.level).wrapping_mul(17);
    (hash ^ strip.wrapping_mul(43)) as usize % SLOTS
}

/// Returns the value in a slot under a key, or else the result of `find`.
#[inline]
fn remember<K: PartialEq, T: Clone>(
    slot: &mut PageSlot<K, T>,
    key: K,
    find: impl FnOnce() -> Result<Option<T>>,
) -> Result<Option<T>> {
    match slot {
        Some((known, found)) if *known == key => Ok(found.clone()),
        _ => {
            let found = find()?;
            *slot = Some((key, found.clone()));
            Ok(found)
        }
    }
}
