//! Heights and colours of a rectangle of one level's posts, gathered from the pages under it.
//!
//! ```text
//! for each page under the rectangle:
//!     it is stored → its samples
//!     it is absent → the smooth surface of the finest coarser level that is stored there, at the posts
//! beside the area → no surface
//! ```

use std::ops::Range;

use glam::DVec2;

use hedgehop::raymarch::PageCursor;
use hedgehop::voxel::{APRON, Grid, PAGE_SIDE, PageId, PageSource};
use hedgehop_base::error::Result;

/// Surface of the finest level that is read where something stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sheet {
    /// The highest, roofs and crowns of trees included.
    #[default]
    Surface,
    /// The ground under what stands on it.
    Bare,
}

/// A rectangle of posts of one level. Columns count eastward and rows northward over the whole level; both may lie beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct Posts<T> {
    /// Columns.
    pub columns: Range<i64>,
    /// Rows.
    pub rows: Range<i64>,
    /// Values, `[rows][columns]`, row 0 southernmost.
    pub values: Vec<T>,
}

impl<T: Copy> Posts<T> {
    fn filled(columns: Range<i64>, rows: Range<i64>, value: T) -> Self {
        let count = |range: &Range<i64>| (range.end - range.start).max(0) as usize;
        let values = vec![value; count(&columns) * count(&rows)];
        Self { columns, rows, values }
    }

    /// Returns the index of a post of the rectangle in `values`.
    pub fn index(&self, column: i64, row: i64) -> usize {
        let width = self.columns.end - self.columns.start;
        ((row - self.rows.start) * width + column - self.columns.start) as usize
    }

    /// The value at a post of the rectangle.
    pub fn at(&self, column: i64, row: i64) -> T {
        self.values[self.index(column, row)]
    }
}

/// Reads rectangles of one level's posts.
#[derive(Debug)]
pub struct PostReader<'s> {
    source: &'s dyn PageSource,
    level: u8,
    sheet: Sheet,
}

/// The part of a rectangle that lies on a page.
struct Part {
    id: PageId,
    columns: Range<i64>,
    rows: Range<i64>,
}

impl<'s> PostReader<'s> {
    /// Reads posts of a level index below [`hedgehop::voxel::Header::level_count`]. Coarser levels know only one sheet, the surface.
    pub fn new(source: &'s dyn PageSource, level: u8, sheet: Sheet) -> Self {
        Self { source, level, sheet }
    }

    /// The level index.
    pub fn level(&self) -> u8 {
        self.level
    }

    /// Returns the place of a post, metres of the database's system.
    pub fn place(&self, column: i64, row: i64) -> DVec2 {
        let grid = &self.source.header().grid;
        grid.origin + (DVec2::new(column as f64, row as f64) + 0.5) * grid.side(self.level)
    }

    /// Heights of the posts, metres above the database's datum; NaN where there is no surface.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn heights(&self, columns: Range<i64>, rows: Range<i64>) -> Result<Posts<f64>> {
        let mut posts = Posts::filled(columns, rows, f64::NAN);
        let code = self.source.header().heights;
        for part in self.parts(&posts.columns, &posts.rows) {
            let id = self.sheet_of(part.id);
            if let Some(view) = self.source.heights(id)? {
                let decode = |code_here| code.decode(code_here).unwrap_or(f64::NAN);
                copy(&mut posts, &part, view.heights, view.width, decode);
            } else {
                self.coarser_heights(&mut posts, &part)?;
            }
        }
        Ok(posts)
    }

    /// Height codes of the posts; 0 where there is no surface, and where the level is not stored.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn codes(&self, columns: Range<i64>, rows: Range<i64>) -> Result<Posts<u16>> {
        let mut posts = Posts::filled(columns, rows, 0);
        for part in self.parts(&posts.columns, &posts.rows) {
            if let Some(view) = self.source.heights(self.sheet_of(part.id))? {
                copy(&mut posts, &part, view.heights, view.width, |code| code);
            }
        }
        Ok(posts)
    }

    /// Colours of the voxels, sRGB-encoded; black beside the area.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn colours(&self, columns: Range<i64>, rows: Range<i64>) -> Result<Posts<[u8; 3]>> {
        let mut posts = Posts::filled(columns, rows, [0; 3]);
        for part in self.parts(&posts.columns, &posts.rows) {
            if let Some(view) = self.source.page(self.sheet_of(part.id))? {
                copy(&mut posts, &part, view.colours, view.width, |colour| colour);
            } else {
                self.coarser_colours(&mut posts, &part)?;
            }
        }
        Ok(posts)
    }

    fn sheet_of(&self, id: PageId) -> PageId {
        let is_bare = self.sheet == Sheet::Bare && id.level == 0;
        if is_bare { self.source.ground_of(id.bare()) } else { id }
    }

    /// The pages of the level under a rectangle.
    fn parts(&self, columns: &Range<i64>, rows: &Range<i64>) -> Vec<Part> {
        let (nx, ny) = self.source.header().grid.dims(self.level);
        let level = self.level;
        let inside = |range: &Range<i64>, limit: u32| range.start.max(0)..range.end.min(i64::from(limit));
        let (columns, rows) = (inside(columns, nx), inside(rows, ny));
        if columns.is_empty() || rows.is_empty() {
            return Vec::new();
        }

        let side = i64::from(PAGE_SIDE);
        let pages = |range: &Range<i64>| range.start / side..(range.end - 1) / side + 1;
        let cut =
            |range: &Range<i64>, page: i64| range.start.max(page * side)..range.end.min((page + 1) * side);
        let part = |px: i64, py: i64| Part {
            id: PageId { level, px: px as u32, py: py as u32 },
            columns: cut(&columns, px),
            rows: cut(&rows, py),
        };

        pages(&rows)
            .flat_map(|py| pages(&columns).map(move |px| (px, py)))
            .map(|(px, py)| part(px, py))
            .collect()
    }

    /// Posts where the level is absent.
    fn coarser_heights(&self, posts: &mut Posts<f64>, part: &Part) -> Result<()> {
        let mut cursor = PageCursor::new(self.source);
        let side = f64::from(Grid::side_units(self.level));
        for row in part.rows.clone() {
            for column in part.columns.clone() {
                let units = (DVec2::new(column as f64, row as f64) + 0.5) * side;
                let height = cursor.height_from(self.level + 1, units)?;
                let index = posts.index(column, row);
                posts.values[index] = height.unwrap_or(f64::NAN);
            }
        }
        Ok(())
    }

    /// Colours where the level is absent: of the coarser voxels that lie there.
    fn coarser_colours(&self, posts: &mut Posts<[u8; 3]>, part: &Part) -> Result<()> {
        let levels = self.source.header().level_count;
        let side = Grid::side_units(self.level);
        for level in self.level + 1..levels {
            let finer = i64::from(Grid::side_units(level) / side);
            let page_of = |at: i64| (at / finer / i64::from(PAGE_SIDE)) as u32;
            // A finer page lies within one page of each coarser level.
            let id = PageId { level, px: page_of(part.columns.start), py: page_of(part.rows.start) };
            let Some(view) = self.source.page(id)? else { continue };
            let within = |at: i64| (at / finer % i64::from(PAGE_SIDE)) as u32;
            for row in part.rows.clone() {
                for column in part.columns.clone() {
                    let index = posts.index(column, row);
                    posts.values[index] = view.colours[view.sample(within(column), within(row))];
                }
            }
            return Ok(());
        }
        Ok(())
    }
}

/// Copies samples of a page (with apron, `width` of its voxels eastward) to where they belong.
fn copy<T: Copy, U: Copy>(
    posts: &mut Posts<U>,
    part: &Part,
    samples: &[T],
    width: u32,
    convert: impl Fn(T) -> U,
) {
    let stride = (width + 2 * APRON) as usize;
    let first = |page: u32| i64::from(page) * i64::from(PAGE_SIDE) - i64::from(APRON);
    let count = (part.columns.end - part.columns.start) as usize;
    for row in part.rows.clone() {
        let from =
            (row - first(part.id.py)) as usize * stride + (part.columns.start - first(part.id.px)) as usize;
        let to = posts.index(part.columns.start, row);
        let targets = posts.values[to..to + count].iter_mut();
        targets.zip(&samples[from..from + count]).for_each(|(target, sample)| *target = convert(*sample));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop::voxel::{Metadata, build_in_memory};

    #[test]
    fn rectangles_run_over_pages_and_beside_the_area() {
        let grid = Grid { nx: 300, ny: 270, spacing: 2.0, origin: DVec2::new(10.0, 20.0) };
        let value = |x: i64, y: i64| (x + 1000 * y) as f64 * 0.25;
        let heights: Vec<f64> = (0..270)
            .flat_map(|y| (0..300).map(move |x| if (x, y) == (7, 9) { f64::NAN } else { value(x, y) }))
            .collect();
        let colours: Vec<[u8; 3]> = (0..270)
            .flat_map(|y| (0..300).map(move |x: i32| [(x % 256) as u8, (y % 256) as u8, 7]))
            .collect();
        let area = build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap();
        let reader = PostReader::new(&area, 0, Sheet::Surface);
        let posts = reader.heights(-2..302, -1..271).unwrap();
        for (column, row) in [(0, 0), (255, 255), (256, 255), (256, 256), (299, 269), (3, 260)] {
            assert!((posts.at(column, row) - value(column, row)).abs() < 2.0, "{column} {row}");
        }
        for (column, row) in [(-1, 5), (300, 5), (5, -1), (5, 270), (7, 9)] {
            assert!(posts.at(column, row).is_nan(), "{column} {row}");
        }

        let colours = reader.colours(250..262, 100..101).unwrap();
        assert_eq!((colours.at(251, 100), colours.at(257, 100)), ([251, 100, 7], [1, 100, 7]));
        assert_eq!(reader.codes(7..8, 9..10).unwrap().values, [0]);
        assert_eq!(reader.place(0, 0), DVec2::new(11.0, 21.0));
        assert!(reader.heights(400..410, 0..5).unwrap().values.iter().all(|height| height.is_nan()));
    }
}
