//! Pages that a task looked up, so that the next block finds them at once.

use crate::error::Result;
use crate::voxel::{PageId, PageSource, PageView};

/// Slots; a power of two. A task's planes touch some dozens of pages.
const SLOTS: usize = 64;

/// Looks pages up, and remembers some.
pub struct Pages<'a> {
    source: &'a dyn PageSource,
    slots: Vec<Option<(PageId, Option<PageView<'a>>)>>,
}

impl<'a> Pages<'a> {
    /// Nothing is looked up yet.
    pub fn new(source: &'a dyn PageSource) -> Self {
        Self { source, slots: vec![None; SLOTS] }
    }

    /// The database.
    pub fn source(&self) -> &'a dyn PageSource {
        self.source
    }

    /// A page; `None` where it is absent.
    #[inline]
    pub fn get(&mut self, id: PageId) -> Result<Option<PageView<'a>>> {
        let hash = id.px.wrapping_mul(7) ^ id.py.wrapping_mul(29) ^ u32::from(id.level).wrapping_mul(17);
        let slot = &mut self.slots[hash as usize % SLOTS];
        match slot {
            Some((known, view)) if *known == id => Ok(*view),
            _ => {
                let view = self.source.page(id)?;
                *slot = Some((id, view));
                Ok(view)
            }
        }
    }
}
