//! Feathering: a source gives way to lower ones towards where it ends.
//!
//! ```text
//! distance = pixels to the nearest one without data, counted as a king moves on a chessboard
//! ramp     = 0 at the outermost pixels with data and beyond, 1 from FEATHER pixels inward
//! ceded    = (b − a) / (a + b − a·b), at least 0, for ramps a of a source and b of a lower one
//! ```
//! So a source cedes 1 − a where the lower one goes on, all at its edge however little they overlap, and nothing where both end together.
//!
//! Sources that follow each other, lie on like lattices and overlap little are tiles of one *sheet*. Towards other sources a sheet ends where all of its
//! tiles do, so that nothing shows through where they abut; between each other tiles count by their own ends.
//!
//! Two things are left. Ramps do not tell why a source ends, so that towards a corner where both end a transition narrows as the distance to it does.
//! In a gap between tiles that is narrower than a pixel their kernels lack the gap's part, and a lower source shows by as much.

use std::ops::Range;

use glam::DVec2;

use super::footprint::Bounds;
use super::kernel::Samples;
use super::warp::{RasterPlacement, Rect, TOLERANCE, WarpField, world};
use crate::raster::Window;
use hedgehop::Size;
use hedgehop::voxel::Grid;
use hedgehop_base::error::Result;

/// Width of the transition from a source to a lower one, in pixels of the upper; a quarter of its shorter side if that is less.
pub(super) const FEATHER: u32 = 16;
/// The distance of pixels that are further inside than the ramp reaches.
const FAR: u8 = FEATHER as u8 + 1;
/// Bytes held for a pixel while distances are measured: its height and two distances.
const PIXEL_BYTES: usize = size_of::<f64>() + 2;

/// Sources that are tiles of one.
#[derive(Debug)]
pub(super) struct Sheets {
    tiles: Vec<Tile>,
}

#[derive(Debug, Clone, Copy)]
struct Tile {
    /// Index of the sheet's first tile.
    sheet: usize,
    /// Column and row of its first pixel, in pixels of the sheet's first tile.
    at: DVec2,
    size: Size,
}

impl Tile {
    /// Width of its own ramp, pixels.
    fn width(&self) -> f64 {
        f64::from(FEATHER).min(self.quarter())
    }

    /// A quarter of its shorter side, pixels.
    fn quarter(&self) -> f64 {
        0.25 * f64::from(self.size.width.min(self.size.height))
    }

    /// Whether it may lie beside another tile of one sheet. What covers much of another is a picture of its own.
    fn is_beside(&self, other: &Self) -> bool {
        let shared = |a: f64, a_size: u32, b: f64, b_size: u32| {
            (a + f64::from(a_size)).min(b + f64::from(b_size)) - a.max(b)
        };
        let across = shared(self.at.x, self.size.width, other.at.x, other.size.width);
        let down = shared(self.at.y, self.size.height, other.at.y, other.size.height);
        across.min(down) <= self.quarter().min(other.quarter())
    }
}

impl Sheets {
    /// Groups sources by priority, each with its columns and rows, over an area.
    pub fn of<'a>(sources: impl Iterator<Item = (&'a RasterPlacement, Size)>, area: &Grid) -> Self {
        let mut tiles: Vec<Tile> = Vec::new();
        let mut first = None;
        for (index, (placement, size)) in sources.enumerate() {
            let here = marks(placement, area);
            let alike = first.zip(here).and_then(|(first, here)| offset(&first, &here));
            let sheet = tiles.last().map_or(0, |last| last.sheet);
            let tile = alike.map(|at| Tile { sheet, at, size });
            let tile = tile.filter(|tile| tiles[sheet..].iter().all(|other| tile.is_beside(other)));
            tiles.push(tile.unwrap_or_else(|| {
                first = here;
                Tile { sheet: index, at: DVec2::ZERO, size }
            }));
        }
        Self { tiles }
    }

    /// Widens the reach of a source's pixels to what a change of it can reach: towards other sheets tiles of its own end elsewhere without it. West, south, east, north.
    pub fn reach(&self, index: usize, [west, south, east, north]: Bounds, pixel_side: f64) -> Bounds {
        let is_whole = self.mates(index).next().is_none();
        if is_whole || self.tiles.iter().all(|tile| tile.sheet == self.tiles[index].sheet) {
            return [west, south, east, north];
        }
        // Pixels may be longer than they are wide.
        let margin = 2.0 * f64::from(FEATHER) * pixel_side;
        [west - margin, south - margin, east + margin, north + margin]
    }

    /// The other tiles of a source's sheet.
    fn mates(&self, index: usize) -> impl Iterator<Item = usize> + '_ {
        let sheet = self.tiles[index].sheet;
        let members = (sheet..self.tiles.len()).take_while(move |&tile| self.tiles[tile].sheet == sheet);
        members.filter(move |&tile| tile != index)
    }

    /// Width of the ramp of a source's sheet, pixels: narrow tiles of a large one have that of the others.
    pub fn width(&self, index: usize) -> f64 {
        self.mates(index).fold(self.tiles[index].width(), |width, mate| width.max(self.tiles[mate].width()))
    }
}

/// Pixel positions of an area's corners and its middle; `None` if one has none.
fn marks(placement: &RasterPlacement, area: &Grid) -> Option<[DVec2; 5]> {
    let (nx, ny) = (f64::from(area.nx), f64::from(area.ny));
    let places = [(0.0, 0.0), (nx, 0.0), (0.0, ny), (nx, ny), (0.5 * nx, 0.5 * ny)];
    let mut marks = [DVec2::ZERO; 5];
    for (mark, (i, j)) in marks.iter_mut().zip(places) {
        let (x, y) = world(area, i, j);
        *mark = placement.pixel_from_world(x, y)?.into();
    }
    Some(marks)
}

/// Returns the offset from the pixels of one raster to those of another, if it is the same at all marks.
fn offset(from: &[DVec2; 5], to: &[DVec2; 5]) -> Option<DVec2> {
    let mut offsets = from.iter().zip(to).map(|(from, to)| *from - *to);
    let first = offsets.next()?;
    let is_same = |at: DVec2| (at.x - first.x).abs() < TOLERANCE && (at.y - first.y).abs() < TOLERANCE;
    offsets.all(is_same).then_some(first)
}

/// Ramps of a source over a block of voxels, 0…1, row-major.
#[derive(Debug)]
pub(super) struct Ramps {
    sheet: usize,
    /// Towards the source's own ends.
    own: Vec<f64>,
    /// Towards the ends of its sheet.
    whole: Vec<f64>,
}

impl Ramps {
    /// Part of this source's share that a lower one takes over where it has all data, 0…1.
    pub fn ceded(&self, lower: &Self, voxel: usize) -> f64 {
        let (upper, lower) = if self.sheet == lower.sheet {
            (self.own[voxel], lower.own[voxel])
        } else {
            (self.whole[voxel], lower.whole[voxel])
        };
        if lower > upper { (lower - upper) / (upper + lower - upper * lower) } else { 0.0 }
    }

    /// The same if the lower one is of another sheet; else nothing.
    pub fn ceded_by_sheet(&self, lower: &Self, voxel: usize) -> f64 {
        if self.sheet == lower.sheet { 0.0 } else { self.ceded(lower, voxel) }
    }

    /// Whether the voxel lies too far inside for anything to be ceded.
    pub fn is_inside(&self, voxel: usize) -> bool {
        self.own[voxel] >= 1.0 && self.whole[voxel] >= 1.0
    }
}

/// Weight that the tiles of one sheet took of a voxel so far: together they cede to other sheets what each of them does.
#[derive(Debug, Default)]
pub(super) struct SheetShare {
    sheet: Option<usize>,
    taken: f64,
}

impl SheetShare {
    /// Takes no more than what is left of the sheet's share if `ceded` of that goes to lower sheets; sources come by priority.
    pub fn take(&mut self, share: f64, ramps: Option<&Ramps>, ceded: f64) -> f64 {
        let sheet = ramps.map(|ramps| ramps.sheet);
        if sheet != self.sheet {
            *self = Self { sheet, taken: 0.0 };
        }
        let taken = share.min(1.0 - ceded - self.taken).max(0.0);
        self.taken += taken;
        taken
    }
}

/// Measures ramps.
pub(super) struct Feather<'a> {
    pub sheets: &'a Sheets,
    /// The source.
    pub index: usize,
    /// Positions of voxels in it.
    pub field: &'a WarpField,
    /// Samples of each source that tell by NaN where it has no data; `None`: it has data everywhere.
    pub samples: &'a dyn Fn(usize) -> Option<&'a dyn Samples<f64>>,
    /// Most bytes to hold.
    pub window_bytes: usize,
}

impl Feather<'_> {
    /// Ramps over the field. A voxel's depends on its position alone.
    pub fn ramps(&self) -> Result<Ramps> {
        let none = vec![0.0; self.field.rect.len()];
        let sheet = self.sheets.tiles[self.index].sheet;
        let mut ramps = Ramps { sheet, own: none.clone(), whole: none };
        let mut blocks = vec![self.field.rect];
        while let Some(block) = blocks.pop() {
            let Some(frame) = self.frame(block) else { continue };
            let bytes = frame.width.saturating_mul(frame.height).saturating_mul(PIXEL_BYTES);
            if bytes <= self.window_bytes || block.len() == 1 {
                self.measure(block, frame, &mut ramps)?;
            } else {
                blocks.extend(block.halves());
            }
        }
        Ok(ramps)
    }

    /// Voxels of a block whose kernels reach the source, with their columns and rows.
    fn voxels(&self, block: Rect) -> impl Iterator<Item = (usize, f64, f64)> {
        let (field, size) = (self.field, self.sheets.tiles[self.index].size);
        let is_near = |position: f64, size: u32, scale: f64| {
            let reach = scale.max(1.0) + TOLERANCE;
            position > -reach && position < f64::from(size) - 1.0 + reach
        };
        block.rows().flat_map(move |y| {
            (block.x0..block.x1).filter_map(move |x| {
                let voxel = field.rect.index(x, y);
                let (column, row, scale) = (field.columns[voxel], field.rows[voxel], field.scale(x, y));
                let is_near = is_near(column, size.width, scale.0) && is_near(row, size.height, scale.1);
                is_near.then_some((voxel, column, row))
            })
        })
    }

    /// The pixels that a block's ramps depend on; `None`: its voxels lie beside the source.
    fn frame(&self, block: Rect) -> Option<FeatherFrame> {
        let boxes = self.voxels(block).map(|(_, column, row)| {
            let (column, row) = (column.floor() as i64, row.floor() as i64);
            [column, row, column, row]
        });
        let widest = boxes.reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]);
        let [west, north, east, south] = widest?;
        let margin = i64::from(FEATHER);
        // A position lies between its pixel and the next one.
        let count = |first: i64, last: i64| (last - first + 2 + 2 * margin) as usize;
        Some(FeatherFrame {
            column: west - margin,
            row: north - margin,
            width: count(west, east),
            height: count(north, south),
        })
    }

    fn measure(&self, block: Rect, frame: FeatherFrame, ramps: &mut Ramps) -> Result<()> {
        let tile = &self.sheets.tiles[self.index];
        let mut own = vec![0; frame.width * frame.height];
        self.mark(self.index, &frame, &mut own)?;
        let mut whole = own.clone();
        if own.contains(&0) {
            for mate in self.sheets.mates(self.index) {
                self.mark(mate, &frame, &mut whole)?;
            }
            spread(&mut own, frame.width);
            spread(&mut whole, frame.width);
        }
        let ramp = |distance: f64, width: f64| ((distance - 1.0) / width).clamp(0.0, 1.0);
        let (width, sheet_width) = (tile.width(), self.sheets.width(self.index));
        for (voxel, column, row) in self.voxels(block) {
            ramps.own[voxel] = ramp(frame.between(&own, column, row), width);
            ramps.whole[voxel] = ramp(frame.between(&whole, column, row), sheet_width);
        }
        Ok(())
    }

    /// Marks the pixels of a frame where a tile of the source's sheet has data.
    fn mark(&self, index: usize, frame: &FeatherFrame, distances: &mut [u8]) -> Result<()> {
        let (from, tile) = (&self.sheets.tiles[self.index], &self.sheets.tiles[index]);
        let offset = tile.at - from.at;
        let columns = pixels(frame.columns(), offset.x, tile.size.width);
        let rows = pixels(frame.rows(), offset.y, tile.size.height);
        let (Some((x, width)), Some((y, height))) = (bounds(&columns), bounds(&rows)) else { return Ok(()) };
        let mut heights = Vec::new();
        if let Some(samples) = (self.samples)(index) {
            samples.read(Window { x, y, width, height }, &mut heights)?;
        }

        let is_void = |column: u32, row: u32| {
            let at = (row - y) as usize * width as usize + (column - x) as usize;
            heights.get(at).is_some_and(|height| height.is_nan())
        };

        for row in rows {
            let distances = &mut distances[row.place * frame.width..][..frame.width];
            for column in &columns {
                if !is_void(column.pixel, row.pixel) {
                    distances[column.place] = FAR;
                }
            }
        }

        Ok(())
    }
}

/// Pixel of a raster at a place of a frame, along one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct FramePixel {
    /// Number of the place, from the first pixel of the frame on.
    place: usize,
    /// Column or row in the raster.
    pixel: u32,
}

/// The pixels nearest to places along one axis of a frame, of a raster that begins at `offset`; a gap that is narrower than a pixel is none.
fn pixels(frame: Range<i64>, offset: f64, size: u32) -> Vec<FramePixel> {
    let last = f64::from(size) - 1.0;
    let pixel = |(place, at): (usize, i64)| {
        let position = at as f64 - offset;
        let is_near = position > -1.0 + TOLERANCE && position < last + 1.0 - TOLERANCE;
        is_near.then(|| FramePixel { place, pixel: position.round().clamp(0.0, last) as u32 })
    };
    frame.enumerate().filter_map(pixel).collect()
}

/// First of some pixels in their order, and how many there are up to the last.
fn bounds(pixels: &[FramePixel]) -> Option<(u32, u32)> {
    let (first, last) = (pixels.first()?.pixel, pixels.last()?.pixel);
    Some((first, last - first + 1))
}

/// Pixels around voxels, some of which may lie beside the raster.
struct FeatherFrame {
    column: i64,
    row: i64,
    width: usize,
    height: usize,
}

impl FeatherFrame {
    /// Returns the columns.
    fn columns(&self) -> Range<i64> {
        self.column..self.column + self.width as i64
    }

    /// Returns the rows.
    fn rows(&self) -> Range<i64> {
        self.row..self.row + self.height as i64
    }

    /// Distance at a position, bilinear between pixels.
    fn between(&self, distances: &[u8], column: f64, row: f64) -> f64 {
        let (west, north) = (column.floor(), row.floor());
        let (u, v) = (column - west, row - north);
        let start = (north as i64 - self.row) as usize * self.width + (west as i64 - self.column) as usize;
        let distance = |at: usize| f64::from(distances[at]);
        let line = |at: usize| distance(at) + u * (distance(at + 1) - distance(at));
        let (north, south) = (line(start), line(start + self.width));
        north + v * (south - north)
    }
}

/// Turns marks, 0 and [`FAR`], into distances to the nearest 0: Rosenfeld and Pfaltz 1968, two sweeps.
fn spread(distances: &mut [u8], width: usize) {
    for _ in 0..2 {
        for at in 0..distances.len() {
            let (is_first, is_last) = (at % width == 0, at % width == width - 1);
            let mut least = distances[at];
            let mut meet = |neighbour: usize| least = least.min(distances[neighbour] + 1);
            if !is_first {
                meet(at - 1);
            }

            if let Some(above) = at.checked_sub(width) {
                meet(above);
                if !is_first {
                    meet(above - 1);
                }
                if !is_last {
                    meet(above + 1);
                }
            }

            distances[at] = least;
        }

        // The second sweep is the first from the other end, and turns them back.
        distances.reverse();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::warp::locate;
    use hedgehop_geo::{Crs, Transform};

    #[test]
    fn distances_are_those_of_a_king() {
        let (width, height) = (37, 29);
        let is_hole = |x: usize, y: usize| (x * 7 + y * 13) % 301 == 5;
        let holes: Vec<(usize, usize)> = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .filter(|&(x, y)| is_hole(x, y))
            .collect();
        let marks = (0..width * height).map(|at| if is_hole(at % width, at / width) { 0 } else { FAR });
        let mut distances: Vec<u8> = marks.collect();
        spread(&mut distances, width);
        assert!(distances.contains(&1) && distances.iter().max() > Some(&8));
        for (at, distance) in distances.iter().enumerate() {
            let to = |hole: &(usize, usize)| (at % width).abs_diff(hole.0).max((at / width).abs_diff(hole.1));
            let nearest = holes.iter().map(to).min().unwrap();
            assert_eq!(usize::from(*distance), nearest.min(usize::from(FAR)), "pixel {at}");
        }
    }

    /// A raster without turn.
    struct TestTile {
        /// West and north edge, metres.
        corner: [f64; 2],
        /// Side of its pixels, metres.
        side: f64,
        /// Columns and rows.
        size: Size,
    }

    fn sources(tiles: &[TestTile]) -> Vec<(RasterPlacement, Size)> {
        let local = || Transform::new(&Crs::local(), &Crs::local()).unwrap();
        let place = |&TestTile { corner: [x, y], side, size }: &TestTile| {
            (RasterPlacement::new(local(), &[x, side, 0.0, y, 0.0, -side], size).unwrap(), size)
        };
        tiles.iter().map(place).collect()
    }

    const AREA: Grid = Grid { nx: 130, ny: 90, spacing: 7.3, origin: DVec2::new(-20.0, 3.0) };

    fn sheets(sources: &[(RasterPlacement, Size)]) -> Sheets {
        Sheets::of(sources.iter().map(|(placement, size)| (placement, *size)), &AREA)
    }

    #[test]
    fn tiles_lie_beside_each_other_on_like_lattices() {
        let tile = |x: f64| TestTile { corner: [x, 500.0], side: 5.0, size: Size { width: 60, height: 60 } };
        let base = TestTile { size: Size { width: 200, height: 60 }, ..tile(0.0) };
        let finer = TestTile { side: 4.0, ..tile(900.0) };
        let tiles = [tile(0.0), tile(300.0), tile(595.0), tile(800.0), base, finer];
        let sheets = sheets(&sources(&tiles));
        let first: Vec<usize> = sheets.tiles.iter().map(|tile| tile.sheet).collect();
        assert_eq!(first, [0, 0, 0, 3, 4, 5]);
        let (column, row) = sheets.tiles[2].at.into();
        assert!((column - 119.0).abs() < 1e-6 && row.abs() < 1e-6, "{column} {row}");
        assert_eq!(sheets.reach(4, [1.0; 4], 5.0), [1.0; 4]);
        assert_eq!(sheets.reach(1, [0.0; 4], 5.0), [-160.0, -160.0, 160.0, 160.0]);
    }

    /// Of 70 × 70, with a hole.
    struct Holed;

    impl Samples<f64> for Holed {
        fn size(&self) -> Size {
            Size { width: 70, height: 70 }
        }
        fn read(&self, window: Window, samples: &mut Vec<f64>) -> Result<()> {
            samples.clear();
            for row in window.y..window.y + window.height {
                let height =
                    |column: u32| if column.abs_diff(20) + row.abs_diff(40) < 9 { f64::NAN } else { 1.0 };
                samples.extend((window.x..window.x + window.width).map(height));
            }
            Ok(())
        }
    }

    #[test]
    fn ramps_depend_on_neither_blocks_nor_windows() {
        let size = Size { width: 70, height: 70 };
        let corners = [[50.0, 600.0], [540.0, 597.0]];
        let sources = sources(&corners.map(|corner| TestTile { corner, side: 7.0, size }));
        let sheets = sheets(&sources);
        let ramps = |rect: Rect, window_bytes: usize| {
            let field = locate(&sources[0].0, &AREA, rect);
            let samples = |_| Some(&Holed as &dyn Samples<f64>);
            Feather { sheets: &sheets, index: 0, field: &field, samples: &samples, window_bytes }
                .ramps()
                .unwrap()
        };

        let all = Rect { x0: 0, y0: 0, x1: AREA.nx, y1: AREA.ny };
        let whole = ramps(all, usize::MAX);
        assert!(whole.own != whole.whole && (0..all.len()).any(|voxel| whole.is_inside(voxel)));
        for (rect, bytes) in [(all, 1), (all, 20_000), (Rect { x0: 13, y0: 31, x1: 77, y1: 60 }, usize::MAX)]
        {
            let part = ramps(rect, bytes);
            for at in 0..rect.len() {
                let (x, y) = rect.voxel(at);
                let there = all.index(x, y);
                let expected = (whole.own[there], whole.whole[there]);
                assert_eq!((part.own[at], part.whole[at]), expected, "({x}, {y}) of {rect:?}, {bytes} bytes");
            }
        }
    }

    #[test]
    fn gaps_narrower_than_a_pixel_are_none() {
        let pixels = |offset: f64| -> Vec<(usize, u32)> {
            pixels(17..23, offset, 10).iter().map(|found| (found.place, found.pixel)).collect()
        };
        assert_eq!(pixels(20.0), [(3, 0), (4, 1), (5, 2)]);
        assert_eq!(pixels(20.6), [(3, 0), (4, 0), (5, 1)]);
        assert_eq!(pixels(21.0), [(4, 0), (5, 1)]);
        assert_eq!(pixels(8.0), [(0, 9)]);
    }

    #[test]
    fn sources_cede_by_how_much_further_the_lower_one_goes() {
        let ramps = |sheet: usize, own: f64, whole: f64| Ramps { sheet, own: vec![own], whole: vec![whole] };
        let ceded = |a: f64, b: f64| ramps(0, 0.0, a).ceded(&ramps(1, 0.0, b), 0);
        assert_eq!([ceded(0.0, 0.0), ceded(0.3, 0.3), ceded(0.5, 0.25), ceded(1.0, 1.0)], [0.0; 4]);
        assert_eq!([ceded(0.0, 1.0), ceded(0.0, 0.1), ceded(0.25, 1.0)], [1.0, 1.0, 0.75]);
        // Tiles of one sheet by their own ends.
        assert_eq!(ramps(0, 0.0, 1.0).ceded(&ramps(0, 1.0, 1.0), 0), 1.0);
    }
}
