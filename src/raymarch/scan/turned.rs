//! Strips of pages turned: what planes along x read side by side.

use std::sync::Arc;

use crate::cache::{Bytes, KeyedCache};
use crate::simd::turned;
use crate::voxel::{APRON, PageId, PageSource};
use hedgehop_base::error::Result;

/// Bytes of turned pages that are kept.
const BUDGET: usize = 512 << 20;

/// Lines of a strip: as many as the longest block of the march has, which so lies in one strip. Of a page that is seen at its rim or between
/// hills, few are read.
pub const STRIP: u32 = 64;

/// Strip of a page, counted from its first column.
pub type ColumnStrip = (PageId, u32);

/// Height codes of a strip of columns of a page, and of the apron around it, column by column.
#[derive(Debug, Clone)]
pub struct TurnedColumns(Arc<Vec<u16>>);

impl TurnedColumns {
    /// All of them.
    #[inline(always)]
    pub fn codes(&self) -> &[u16] {
        &self.0
    }
}

impl Bytes for TurnedColumns {
    fn bytes(&self) -> usize {
        size_of_val(self.codes())
    }
}

/// Height codes of strips with rows and columns exchanged, kept for all frames of a database.
///
/// Sixteen planes along x meet a line in as many rows of a page: sixteen cache lines a step instead of one or two.
#[derive(Debug)]
pub struct TurnedPages(KeyedCache<ColumnStrip, TurnedColumns>);

impl Default for TurnedPages {
    fn default() -> Self {
        Self::new(BUDGET)
    }
}

impl TurnedPages {
    /// Nothing yet, and at most `budget` bytes besides what the latest frames used.
    pub fn new(budget: usize) -> Self {
        Self(KeyedCache::new(budget))
    }

    /// A new frame begins: see [`KeyedCache::begin_frame`].
    pub fn begin_frame(&self) {
        self.0.begin_frame();
    }

    /// Columns of a strip and of two aprons, each of the page's height and two aprons; `None` where the page is absent from `source`, also if they are
    /// known from another frame that had it.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn get(&self, source: &dyn PageSource, strip: ColumnStrip) -> Result<Option<TurnedColumns>> {
        let (id, index) = strip;
        let turn = || {
            let view = source.heights(id)?;
            Ok(view.map(|view| {
                let (first, width) = (index * STRIP, view.width + 2 * APRON);
                let columns = first as usize..width.min(first + STRIP + 2 * APRON) as usize;
                TurnedColumns(Arc::new(turned(view.heights, width as usize, columns)))
            }))
        };
        if source.has(id) { self.0.get(strip, turn) } else { turn() }
    }
}
