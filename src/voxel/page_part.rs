//! Parts of a page.

use super::PageId;

/// Planes of a page that are read by the same readers, and are in memory together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PagePart {
    /// Heights of a surface.
    Heights(PageId),
    /// Looks of a surface and its materials: colours, relief and attributes.
    Paint(PageId),
    /// Bounds that tell where it cannot be seen. Pages of level index 0 and of bare ground have none.
    Bounds(PageId),
    /// Spans that stand on it: of bare ground alone.
    Spans(PageId),
}

impl PagePart {
    /// Parts that a page has at most.
    pub const COUNT: usize = 3;

    /// Returns the page that it is a part of.
    pub fn page(self) -> PageId {
        match self {
            Self::Heights(page) | Self::Paint(page) | Self::Bounds(page) | Self::Spans(page) => page,
        }
    }

    /// Returns the number of the part, 0 to 2, in the order in which they lie in the file.
    #[inline]
    pub fn number(self) -> usize {
        match self {
            Self::Heights(_) => 0,
            Self::Bounds(_) | Self::Spans(_) => 1,
            Self::Paint(_) => 2,
        }
    }

    /// The part of a page with a number.
    #[inline]
    pub fn numbered(number: usize, page: PageId) -> Self {
        match number {
            0 => Self::Heights(page),
            1 if page.is_bare() => Self::Spans(page),
            1 => Self::Bounds(page),
            _ => Self::Paint(page),
        }
    }

    /// The parts that a page has.
    pub fn all(page: PageId) -> impl Iterator<Item = Self> {
        let third = if page.is_bare() { Self::Spans(page) } else { Self::Bounds(page) };
        [Self::Heights(page), Self::Paint(page), third].into_iter().take(if page.level == 0 { 2 } else { 3 })
    }

    /// Lists the parts that show a page's surface.
    pub fn posts(page: PageId) -> [Self; 2] {
        [Self::Heights(page), Self::Paint(page)]
    }
}

/// Parts of pages that somebody is about to read, in the order of need.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PageNeeds {
    /// First those that are likely to be read, then the others that may be.
    pub parts: Vec<PagePart>,
    /// Number of those that are likely needed.
    pub likely: usize,
}

impl PageNeeds {
    /// Takes paint out, and returns it.
    pub fn take_paint(&mut self) -> Vec<PagePart> {
        let is_paint = |part: &mut PagePart| matches!(part, PagePart::Paint(_));
        let mut paint: Vec<_> = self.parts.extract_if(..self.likely, is_paint).collect();
        self.likely -= paint.len();
        paint.extend(self.parts.extract_if(self.likely.., is_paint));
        paint
    }
}

impl From<Vec<PagePart>> for PageNeeds {
    /// All of them are likely.
    fn from(parts: Vec<PagePart>) -> Self {
        Self { likely: parts.len(), parts }
    }
}

/// Samples around a page's voxels that repeat the neighbours' (or, at the edge of the area, the
/// page's own), so that whatever is made of a page, its filtered light too, is made of it alone.
pub const APRON: u32 = 6;

/// Apron of the relief: slopes need heights one further out.
pub const RELIEF_APRON: u32 = APRON - 1;
