//! Pages turned: what planes along x read side by side.

use std::sync::Arc;

use crate::error::Result;
use crate::simd::turned;
use crate::voxel::{APRON, Bytes, Derived, PageId, PageSource};

/// Bytes of turned pages that are kept.
const BUDGET: usize = 512 << 20;

/// Height codes of a page with apron, column by column.
#[derive(Debug, Clone)]
pub struct Columns(Arc<Vec<u16>>);

impl Columns {
    /// All of them.
    #[inline(always)]
    pub fn codes(&self) -> &[u16] {
        &self.0
    }
}

impl Bytes for Columns {
    fn bytes(&self) -> usize {
        size_of_val(self.codes())
    }
}

/// Height codes with rows and columns exchanged, kept for all frames of a database.
///
/// Sixteen planes along x meet a line in as many rows of a page: sixteen cache lines a step instead of one or two.
#[derive(Debug)]
pub struct TurnedPages(Derived<PageId, Columns>);

impl Default for TurnedPages {
    fn default() -> Self {
        Self::new(BUDGET)
    }
}

impl TurnedPages {
    /// Nothing yet, and at most `budget` bytes besides what the latest frames used.
    pub fn new(budget: usize) -> Self {
        Self(Derived::new(budget))
    }

    /// A new frame begins: see [`Derived::begin_frame`].
    pub fn begin_frame(&self) {
        self.0.begin_frame();
    }

    /// Columns of a page, each of its height and two aprons; `None` where it is absent from `source`, also if they are known from another frame
    /// that had it.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn get(&self, source: &dyn PageSource, id: PageId) -> Result<Option<Columns>> {
        let turn = || {
            let view = source.page(id)?;
            Ok(view.map(|view| Columns(Arc::new(turned(view.heights, (view.width + 2 * APRON) as usize)))))
        };
        if source.has(id) { self.0.get(id, turn) } else { turn() }
    }
}
