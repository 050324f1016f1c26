//! The ground as a raster with north up: heights and colours at the pixels of a map.
//!
//! Where pixels are the voxels of a level they are its posts. Otherwise a pixel is the mean of points of the smooth surface, bilinear between
//! posts of the coarsest level that is no coarser than a pixel, at least as many as it has posts.

use std::ops::Range;

use glam::DVec2;

use super::posts::{PostReader, Posts, Sheet};
use hedgehop::voxel::{Grid, PageSource, RADIX};
use hedgehop_base::error::{Error, Result};

/// Distance of a corner from a voxel's, as a share of its side, that counts as none.
const SAME: f64 = 1e-6;

/// Points of a pixel each way, at most.
const MOST_POINTS: f64 = 8.0;

/// Extent of a map, and its pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapExtent {
    /// Upper left corner, metres of the database's system.
    pub north_west: DVec2,
    /// Side of a pixel, metres > 0.
    pub pixel: f64,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl MapExtent {
    /// The middle of a pixel, metres; column and row may lie beside the map.
    pub fn place(&self, column: f64, row: f64) -> DVec2 {
        self.north_west + DVec2::new(column + 0.5, -(row + 0.5)) * self.pixel
    }

    /// Returns the position of a place on the map, pixels from its upper left corner.
    pub fn pixel_of(&self, place: DVec2) -> DVec2 {
        let offset = (place - self.north_west) / self.pixel;
        DVec2::new(offset.x, -offset.y)
    }

    /// Pixels of the map.
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// The voxels of a level that a box (west, south, east, north; metres) touches, as pixels.
    ///
    /// # Errors
    /// [`Error::Configuration`]: the box lies beside the area.
    pub fn of_level(grid: &Grid, level: u8, bounds: [f64; 4]) -> Result<Self> {
        let bounds = within(grid, bounds)?;
        let (side, (nx, ny)) = (grid.side(level), grid.dims(level));
        let origin = grid.origin;
        let first = |at: f64| ((at / side + SAME).floor()).max(0.0);
        let end = |at: f64, limit: u32| ((at / side - SAME).ceil()).min(f64::from(limit));
        let (west, south) = (first(bounds[0] - origin.x), first(bounds[1] - origin.y));
        let (east, north) = (end(bounds[2] - origin.x, nx), end(bounds[3] - origin.y, ny));
        Ok(Self {
            north_west: origin + DVec2::new(west, north) * side,
            pixel: side,
            // A float converts saturating.
            width: (east - west).max(1.0) as u32,
            height: (north - south).max(1.0) as u32,
        })
    }

    /// A box in pixels of a size, from its upper left corner on.
    ///
    /// # Errors
    /// [`Error::Configuration`]: the box lies beside the area, or pixels are far wider than the coarsest voxels.
    pub fn of_pixels(grid: &Grid, pixel: f64, bounds: [f64; 4]) -> Result<Self> {
        let [west, south, east, north] = within(grid, bounds)?;
        // What a pixel needs is read at once.
        let widest = f64::from(RADIX) * grid.side(grid.level_count() - 1);
        if pixel > widest {
            return Err(Error::Configuration(format!(
                "pixels of {pixel} m are far wider than the coarsest voxels; here they may be {widest} m at most"
            )));
        }
        let count = |length: f64| (length / pixel - SAME).ceil().max(1.0) as u32;
        let north_west = DVec2::new(west, north);
        Ok(Self { north_west, pixel, width: count(east - west), height: count(north - south) })
    }
}

/// The part of a box that lies in the area.
fn within(grid: &Grid, [west, south, east, north]: [f64; 4]) -> Result<[f64; 4]> {
    let (near, far) = (grid.origin, grid.far_corner());
    let cut = [west.max(near.x), south.max(near.y), east.min(far.x), north.min(far.y)];
    if cut[0] < cut[2] && cut[1] < cut[3] {
        return Ok(cut);
    }
    Err(Error::Configuration(format!(
        "the box {west},{south},{east},{north} lies outside the area, which is {},{},{},{} in metres of its reference system",
        near.x, near.y, far.x, far.y
    )))
}

/// A map of the ground.
#[derive(Debug)]
pub struct GroundMap<'s> {
    extent: MapExtent,
    grid: Grid,
    reader: PostReader<'s>,
    /// Column and row (from the south) of the level's voxel that is the upper left pixel, where pixels are voxels.
    voxel: Option<[i64; 2]>,
    /// Points of a pixel each way.
    points: u32,
}

impl<'s> GroundMap<'s> {
    /// The ground of a database over an extent.
    pub fn new(source: &'s dyn PageSource, extent: MapExtent, sheet: Sheet) -> Self {
        let header = source.header();
        let grid = header.grid;
        let fits = |level: &u8| grid.side(*level) <= extent.pixel * (1.0 + SAME);
        let level = (0..header.level_count).rev().find(fits).unwrap_or(0);
        let side = grid.side(level);
        let corner = (extent.north_west - grid.origin) / side;
        let is_voxels =
            (side / extent.pixel - 1.0).abs() < SAME && (corner - corner.round()).abs().max_element() < SAME;
        let voxel = is_voxels.then(|| [corner.x.round() as i64, corner.y.round() as i64 - 1]);
        let points = (extent.pixel / side - SAME).ceil().clamp(1.0, MOST_POINTS) as u32;
        Self { extent, grid, reader: PostReader::new(source, level, sheet), voxel, points }
    }

    /// Returns the extent.
    pub fn extent(&self) -> &MapExtent {
        &self.extent
    }

    /// Heights of pixels, which may lie beside the map, `[rows][columns]`, the northernmost row first; metres, NaN where there is no surface.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn heights(&self, columns: Range<i64>, rows: Range<i64>) -> Result<Vec<f64>> {
        if let Some(voxel) = self.voxel {
            let (across, up) = voxels(voxel, &columns, &rows);
            return Ok(flipped(&self.reader.heights(across, up)?));
        }
        let (across, up) = self.posts_under(&columns, &rows);
        let posts = self.reader.heights(across, up)?;
        let mut heights =
            Vec::with_capacity(((rows.end - rows.start) * (columns.end - columns.start)) as usize);
        for row in rows {
            for column in columns.clone() {
                heights.push(self.mean(&posts, column, row));
            }
        }
        Ok(heights)
    }

    /// Colours of pixels, in the same order, sRGB-encoded: those of the voxels that lie at their middles.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn colours(&self, columns: Range<i64>, rows: Range<i64>) -> Result<Vec<[u8; 3]>> {
        if let Some(voxel) = self.voxel {
            let (across, up) = voxels(voxel, &columns, &rows);
            return Ok(flipped(&self.reader.colours(across, up)?));
        }
        let (across, up) = self.posts_under(&columns, &rows);
        let posts = self.reader.colours(across, up)?;
        let pixels = rows.flat_map(|row| columns.clone().map(move |column| (column, row)));
        let nearest = pixels.map(|(column, row)| {
            let post = self.post_of(self.extent.place(column as f64, row as f64)).round();
            let clamped = |at: f64, range: &Range<i64>| (at as i64).clamp(range.start, range.end - 1);
            posts.at(clamped(post.x, &posts.columns), clamped(post.y, &posts.rows))
        });
        Ok(nearest.collect())
    }

    /// A place in posts: whole numbers are posts.
    fn post_of(&self, place: DVec2) -> DVec2 {
        (place - self.grid.origin) / self.grid.side(self.reader.level()) - 0.5
    }

    /// Posts around all points of pixels.
    fn posts_under(&self, columns: &Range<i64>, rows: &Range<i64>) -> (Range<i64>, Range<i64>) {
        let at = |column: i64, row: i64| {
            self.post_of(self.extent.place(column as f64 - 0.5, row as f64 - 0.5)).floor()
        };
        let (low, high) = (at(columns.start, rows.end), at(columns.end, rows.start));
        (low.x as i64..high.x as i64 + 2, low.y as i64..high.y as i64 + 2)
    }

    /// Mean height of the points of a pixel; NaN if the one in the middle has no surface.
    fn mean(&self, posts: &Posts<f64>, column: i64, row: i64) -> f64 {
        let count = f64::from(self.points);
        let shares = || (0..self.points).map(|point| (f64::from(point) + 0.5) / count - 0.5);
        let (mut sum, mut known) = (0.0, 0.0);
        for (down, right) in shares().flat_map(|down| shares().map(move |right| (down, right))) {
            let height =
                bilinear(posts, self.post_of(self.extent.place(column as f64 + right, row as f64 + down)));
            if !height.is_nan() {
                sum += height;
                known += 1.0;
            }
        }
        if 2.0 * known >= count * count { sum / known } else { f64::NAN }
    }
}

/// Height between posts; NaN where the nearest one has no surface. Others without one are left out.
fn bilinear(posts: &Posts<f64>, place: DVec2) -> f64 {
    let low = place.floor();
    let part = place - low;
    let (column, row) = (low.x as i64, low.y as i64);
    let nearest = posts.at(column + i64::from(part.x >= 0.5), row + i64::from(part.y >= 0.5));
    let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(right, up)| {
        let along = |part: f64, is_far: i64| if is_far == 1 { part } else { 1.0 - part };
        (posts.at(column + right, row + up), along(part.x, right) * along(part.y, up))
    });
    let known = corners.iter().filter(|(height, _)| !height.is_nan());
    let (sum, weight) =
        known.fold((0.0, 0.0), |(sum, weight), (height, own)| (sum + height * own, weight + own));
    if nearest.is_nan() || weight <= 0.0 { f64::NAN } else { sum / weight }
}

/// Columns and rows of voxels, of which `first` is the upper left pixel.
fn voxels([column, row]: [i64; 2], columns: &Range<i64>, rows: &Range<i64>) -> (Range<i64>, Range<i64>) {
    (column + columns.start..column + columns.end, row - rows.end + 1..row - rows.start + 1)
}

/// Values with the northernmost row first.
fn flipped<T: Copy>(posts: &Posts<T>) -> Vec<T> {
    let width = (posts.columns.end - posts.columns.start).max(1) as usize;
    posts.values.chunks_exact(width).rev().flatten().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop::voxel::{MemPages, Metadata, build_in_memory};

    /// A plane that rises by 0.5 m a metre eastward and 0.25 m northward.
    fn plane() -> MemPages {
        let grid = Grid { nx: 300, ny: 280, spacing: 2.0, origin: DVec2::new(100.0, 200.0) };
        let heights: Vec<f64> = (0..280)
            .flat_map(|y| {
                (0..300)
                    .map(move |x| height(DVec2::new(101.0 + 2.0 * f64::from(x), 201.0 + 2.0 * f64::from(y))))
            })
            .collect();
        build_in_memory(grid, &heights, &vec![[9; 3]; heights.len()], None, &Metadata::default()).unwrap()
    }

    fn height(place: DVec2) -> f64 {
        0.5 * place.x + 0.25 * place.y
    }

    #[test]
    fn pixels_of_any_size_lie_on_the_surface() {
        let area = plane();
        let grid = area.header().grid;
        let bounds = [150.0, 260.0, 350.0, 400.0];
        let levels = [0, 1].map(|level| MapExtent::of_level(&grid, level, bounds).unwrap());
        let sizes = [1.3, 2.0, 5.0, 8.0].map(|pixel| MapExtent::of_pixels(&grid, pixel, bounds).unwrap());

        for extent in levels.into_iter().chain(sizes) {
            let map = GroundMap::new(&area, extent, Sheet::Surface);
            let heights = map.heights(0..i64::from(extent.width), 0..i64::from(extent.height)).unwrap();
            for (index, found) in heights.iter().enumerate() {
                let (row, column) = (index / extent.width as usize, index % extent.width as usize);
                let wanted = height(extent.place(column as f64, row as f64));
                assert!((found - wanted).abs() < 0.02, "{extent:?} {column} {row}: {found} {wanted}");
            }
        }

        assert_eq!((levels[0].width, levels[0].height), (100, 70));
        assert_eq!(levels[0].north_west, DVec2::new(150.0, 400.0));

        // Of coarser voxels those that the box touches.
        assert_eq!((levels[1].north_west, levels[1].width), (DVec2::new(148.0, 400.0), 26));
        assert!(MapExtent::of_level(&grid, 0, [0.0, 0.0, 50.0, 900.0]).is_err());
        let whole = MapExtent::of_level(&grid, 0, [f64::MIN, f64::MIN, f64::MAX, f64::MAX]).unwrap();
        assert_eq!((whole.width, whole.height), (300, 280));
    }
}
