//! Sources of pages.

use super::{BoundsView, Header, HeightsView, PageId, PageView, SpansView};
use hedgehop_base::error::Result;

/// Gives out pages. The marchers are generic over it.
pub trait PageSource: Sync {
    /// Returns the header: what the database is.
    fn header(&self) -> &Header;

    /// The page, `None` where it is absent (stored at a coarser level only, or outside the area).
    /// A page whose checksum or shape is wrong is an error, every time it is asked for, unless such pages are to be left out
    /// ([`super::Damaged::Coarser`]). The first touch of a page's heights or paint
    /// reads all of that part; later ones cost some tens of nanoseconds.
    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>>;

    /// The page's heights, as [`Self::page`]. Who looks for where a surface is reads nothing else of a page, and what it looks like may be
    /// known from before. Those who have all of a page at once need not tell it apart.
    fn heights(&self, id: PageId) -> Result<Option<HeightsView<'_>>> {
        Ok(self.page(id)?.map(|view| view.heights()))
    }

    /// The page's bounds, as [`Self::page`], where all planes but these are there. Who looks for what may be seen at all reads nothing
    /// else of a page, and who looks at what is seen, not them.
    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>>;

    /// Returns what stands on a page of bare ground, as [`Self::page`]; nothing on others. Nobody asks for bare ground unless the header says that
    /// [something stands](Header::has_spans), and who gives out such an area must tell what.
    fn spans(&self, id: PageId) -> Result<Option<SpansView<'_>>> {
        let _ = id;
        Ok(None)
    }

    /// The page that has the ground of `id`: of a page of bare ground that is absent, that of level index 0, where nothing stands.
    fn ground_of(&self, id: PageId) -> PageId {
        if id.is_bare() && self.header().has_spans && self.has(id) { id } else { id.surface() }
    }

    /// Whether the page is stored and was not left out as damaged; told without reading it where that can be.
    fn has(&self, id: PageId) -> bool {
        !matches!(self.page(id), Ok(None))
    }

    /// Whether what is seen of a page, heights and paint, can be read without waiting for the disk. Who has other work does that first, and
    /// then has the page [brought](Self::bring).
    fn is_at_hand(&self, id: PageId) -> bool {
        let _ = id;
        true
    }

    /// A page that is not at hand will be brought soon: the disk may begin.
    fn announce(&self, id: PageId) {
        let _ = id;
    }

    /// Brings what is seen of pages to hand, and waits until it is there. A page that is damaged is left to
    /// whoever reads it.
    fn bring(&self, pages: &[PageId]) {
        let _ = pages;
    }

    /// Whether the page was touched, found damaged and left out, so that a coarser level stands in for it.
    fn is_damaged(&self, id: PageId) -> bool {
        let _ = id;
        false
    }

    /// Whether all that was read through views so far was the database's. To be asked after the reading, before what was made of
    /// it is shown: a file may change or fail under its readers, and stays refused then.
    ///
    /// # Errors
    /// It was not.
    fn intact(&self) -> Result<()> {
        Ok(())
    }
}

/// Tells the identity of the database, not its pages.
impl std::fmt::Debug for dyn PageSource + '_ {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("PageSource").field(&self.header().content_hash).finish()
    }
}
