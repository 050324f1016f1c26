//! Pages that a task looked up, so that the next block finds them at once.

use std::rc::Rc;

use super::turned::{Columns, TurnedPages};
use crate::error::Result;
use crate::voxel::{APRON, BoundsView, PageId, PageSource, PageView};

/// Slots; a power of two. A task's planes touch some dozens of pages.
const SLOTS: usize = 64;

/// Height codes of a page, line by line across the planes.
#[derive(Clone)]
pub enum Codes<'a> {
    /// As they are stored: lines are rows.
    Rows(&'a [u16]),
    /// Lines are columns.
    Columns(Rc<Columns>),
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

/// A page, turned or not; `None`: it is absent.
type Slot<T> = Option<(PageId, Option<T>)>;

/// Looks pages up, and remembers some.
pub struct Pages<'a> {
    source: &'a dyn PageSource,
    turned: &'a TurnedPages,
    views: Vec<Slot<PageView<'a>>>,
    bounds: Vec<Slot<BoundsView<'a>>>,
    columns: Vec<Slot<Rc<Columns>>>,
}

impl<'a> Pages<'a> {
    /// Nothing is looked up yet.
    pub fn new(source: &'a dyn PageSource, turned: &'a TurnedPages) -> Self {
        let (views, bounds, columns) = (vec![None; SLOTS], vec![None; SLOTS], vec![None; SLOTS]);
        Self { source, turned, views, bounds, columns }
    }

    /// The database.
    pub fn source(&self) -> &'a dyn PageSource {
        self.source
    }

    /// A page; `None` where it is absent.
    #[inline]
    pub fn get(&mut self, id: PageId) -> Result<Option<PageView<'a>>> {
        remember(&mut self.views, id, || self.source.page(id))
    }

    /// A page's bounds; `None` where it is absent.
    #[inline]
    pub fn bounds(&mut self, id: PageId) -> Result<Option<BoundsView<'a>>> {
        remember(&mut self.bounds, id, || self.source.bounds(id))
    }

    /// Height codes of a page for planes along axis `major`, and how many one line has; `None` where it is absent.
    #[inline]
    pub fn codes(&mut self, id: PageId, major: usize) -> Result<Option<(Codes<'a>, i32)>> {
        if major == 1 {
            let view = self.get(id)?;
            return Ok(view.map(|view| (Codes::Rows(view.heights), (view.width + 2 * APRON) as i32)));
        }
        let codes = remember(&mut self.columns, id, || Ok(self.turned.get(self.source, id)?.map(Rc::new)))?;
        let size = self.source.header().grid.page_size(id);
        Ok(codes.zip(size).map(|(codes, (_, height))| (Codes::Columns(codes), (height + 2 * APRON) as i32)))
    }

    /// The same if the page was looked up lately.
    #[inline]
    pub fn known_codes(&mut self, id: PageId, major: usize) -> Option<(Codes<'a>, i32)> {
        let slot = slot_of(id);
        let is_known = match major {
            1 => self.views[slot].as_ref().is_some_and(|(known, _)| *known == id),
            _ => self.columns[slot].as_ref().is_some_and(|(known, _)| *known == id),
        };
        if is_known { self.codes(id, major).ok().flatten() } else { None }
    }
}

/// Where a page is remembered.
#[inline]
fn slot_of(id: PageId) -> usize {
    let hash = id.px.wrapping_mul(7) ^ id.py.wrapping_mul(29) ^ u32::from(id.level).wrapping_mul(17);
    hash as usize % SLOTS
}

/// What is in the page's slot, or else what `find` finds.
#[inline]
fn remember<T: Clone>(
    slots: &mut [Slot<T>],
    id: PageId,
    find: impl FnOnce() -> Result<Option<T>>,
) -> Result<Option<T>> {
    let slot = &mut slots[slot_of(id)];
    match slot {
        Some((known, found)) if *known == id => Ok(found.clone()),
        _ => {
            let found = find()?;
            *slot = Some((id, found.clone()));
            Ok(found)
        }
    }
}
