//! Positions of voxels in a raster: exact transforms on a lattice, bilinear between.
//!
//! ```text
//! for each cell of 16 × 16 voxels, counted from the grid's origin (never from a page):
//!     transform its corners, its centre and the middles of its sides exactly
//!     if the bilinear patch through the corners meets the other five within TOLERANCE: use it
//!     else: the same for each quarter, down to single voxels, which are exact
//! ```
//!
//! This is how GDAL's warper and most others save transforms (its "approximating transformer" works on
//! scan lines). Cells hang on the grid, so that a voxel's position does not depend on the page that asks.

use glam::DVec2;

use crate::raster::{GeoTransform, Window};
use hedgehop::Size;
use hedgehop::voxel::Grid;
use hedgehop_geo::Transform;

/// Largest error of an interpolated position, in pixels (or in voxels, where those are larger).
pub(super) const TOLERANCE: f64 = 0.05;
/// Voxels along a cell of the lattice; a power of two.
const CELL: i64 = 16;
/// Distance, in pixels, within which a position is taken for a pixel's centre.
const ROUNDING: f64 = 1.0e-6;

/// A level's voxels as a grid of their own.
#[derive(Debug, Clone, Copy)]
pub(super) struct LevelGrid {
    pub grid: Grid,
    pub level: u8,
}

impl LevelGrid {
    pub fn of(grid: &Grid, level: u8) -> Self {
        let (nx, ny) = grid.dims(level);
        Self { grid: Grid { nx, ny, spacing: grid.side(level), origin: grid.origin }, level }
    }
    /// Centre of a voxel, units from the south-west corner.
    pub fn units(&self, x: u32, y: u32) -> DVec2 {
        let side = f64::from(Grid::side_units(self.level));
        DVec2::new((f64::from(x) + 0.5) * side, (f64::from(y) + 0.5) * side)
    }
}

/// A block of voxels of one level, half-open: columns `x0..x1` eastward, rows `y0..y1` northward.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rect {
    pub x0: u32,
    pub y0: u32,
    pub x1: u32,
    pub y1: u32,
}

impl Rect {
    pub fn width(&self) -> usize {
        (self.x1 - self.x0) as usize
    }
    pub fn height(&self) -> usize {
        (self.y1 - self.y0) as usize
    }
    pub fn len(&self) -> usize {
        self.width() * self.height()
    }
    /// Returns the rows.
    pub fn rows(&self) -> std::ops::Range<u32> {
        self.y0..self.y1
    }
    /// Returns where its rows lie among the voxels of one that holds it.
    pub fn rows_in(self, whole: Self) -> impl Iterator<Item = std::ops::Range<usize>> + Clone {
        self.rows().map(move |y| whole.index(self.x0, y)).map(move |first| first..first + self.width())
    }
    /// Row-major index of voxel (x, y), which must lie within.
    pub fn index(&self, x: u32, y: u32) -> usize {
        (y - self.y0) as usize * self.width() + (x - self.x0) as usize
    }
    /// Voxel (x, y) of a row-major index.
    pub fn voxel(&self, index: usize) -> (u32, u32) {
        (self.x0 + (index % self.width()) as u32, self.y0 + (index / self.width()) as u32)
    }
    /// Grown by `margin` voxels on all sides, clipped to the grid.
    pub fn grown(&self, margin: u32, grid: &Grid) -> Self {
        Self {
            x0: self.x0.saturating_sub(margin),
            y0: self.y0.saturating_sub(margin),
            x1: self.x1.saturating_add(margin).min(grid.nx),
            y1: self.y1.saturating_add(margin).min(grid.ny),
        }
    }
    /// Two halves of it, across its longer side; it has two voxels at least.
    pub fn halves(self) -> [Self; 2] {
        if self.width() >= self.height() {
            let x = self.x0 + self.width() as u32 / 2;
            [Self { x1: x, ..self }, Self { x0: x, ..self }]
        } else {
            let y = self.y0 + self.height() as u32 / 2;
            [Self { y1: y, ..self }, Self { y0: y, ..self }]
        }
    }
    /// Whether the block may touch an area: west, south, east, north in world space.
    pub fn meets(&self, [west, south, east, north]: &[f64; 4], grid: &Grid) -> bool {
        let (x0, y0) = world(grid, f64::from(self.x0), f64::from(self.y0));
        let (x1, y1) = world(grid, f64::from(self.x1), f64::from(self.y1));
        x0 <= *east && x1 >= *west && y0 <= *north && y1 >= *south
    }
    /// Horizontal bands of the lattice's cell height, southernmost first.
    pub fn bands(&self) -> impl Iterator<Item = Self> + use<> {
        let (rect, cell) = (*self, CELL as u32);
        (rect.y0 / cell..rect.y1.div_ceil(cell)).map(move |band| Self {
            y0: rect.y0.max(band * cell),
            y1: rect.y1.min((band + 1).saturating_mul(cell)),
            ..rect
        })
    }
}

/// Placement of a raster in the database's reference system.
#[derive(Debug)]
pub(super) struct RasterPlacement {
    /// Positions in the raster's system from those in the database's; `None` if they are the same.
    source_from_world: Option<Transform>,
    pixel_from_source: GeoTransform,
}

impl RasterPlacement {
    /// Places a raster of `size` pixels in the transform's target system; `None` if its geotransform is singular.
    pub fn new(source_from_world: Transform, source_from_pixel: &GeoTransform, size: Size) -> Option<Self> {
        let (longitude, _) =
            apply(source_from_pixel, 0.5 * f64::from(size.width), 0.5 * f64::from(size.height));
        let source_from_world = source_from_world.centred_on(longitude);
        Some(Self {
            source_from_world: (!source_from_world.is_identity()).then_some(source_from_world),
            pixel_from_source: invert(source_from_pixel)?,
        })
    }

    /// Column and row of a world position, whole numbers at pixel centres; `None` where there is none.
    pub fn pixel_from_world(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        let (x, y) = match &self.source_from_world {
            Some(transform) => transform.apply(x, y)?,
            None => (x, y),
        };
        let (column, row) = apply(&self.pixel_from_source, x, y);
        let place = |at: f64| {
            let (at, whole) = (at - 0.5, (at - 0.5).round());
            if self.is_affine() && (at - whole).abs() < ROUNDING { whole } else { at }
        };
        (column.is_finite() && row.is_finite()).then_some((place(column), place(row)))
    }

    /// The pixels that the voxels of a block are, if each of them is one but for rounding: rows of pixels run southward. They may lie
    /// beside a raster.
    pub fn pixels(&self, grid: &Grid, rect: Rect) -> Option<PixelBlock> {
        let c = &self.pixel_from_source;
        let (across, down) = (c[1] * grid.spacing, -c[5] * grid.spacing);
        // Far from the first voxel as well.
        let voxels = f64::from(grid.nx.max(grid.ny));
        let is_one = |scale: f64| ((scale - 1.0) * voxels).abs() < ROUNDING;
        if !(self.is_affine() && c[2] == 0.0 && c[4] == 0.0 && is_one(across) && is_one(down)) {
            return None;
        }
        let (x, y) = world(grid, f64::from(rect.x0) + 0.5, f64::from(rect.y1) - 0.5);
        let (column, row) = self.pixel_from_world(x, y)?;
        let is_whole = column.fract() == 0.0 && row.fract() == 0.0;
        is_whole.then_some(PixelBlock { column: column as i64, row: row as i64 })
    }

    fn is_affine(&self) -> bool {
        self.source_from_world.is_none()
    }
}

/// Pixels that are the voxels of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PixelBlock {
    /// Column and row of the north-west voxel's.
    pub column: i64,
    pub row: i64,
}

impl PixelBlock {
    /// Returns the window of a raster of `size` pixels that holds them; `None` unless all of them, and `margin` around, lie within.
    pub fn window(&self, rect: Rect, size: Size, margin: u32) -> Option<Window> {
        let start = |first: i64, count: usize, size: u32| {
            let margin = i64::from(margin);
            let fits = first >= margin && first + count as i64 + margin <= i64::from(size);
            fits.then_some(first as u32)
        };
        let (width, height) = (rect.width() as u32, rect.height() as u32);
        let x = start(self.column, rect.width(), size.width)?;
        let y = start(self.row, rect.height(), size.height)?;
        Some(Window { x, y, width, height })
    }
}

/// Samples of a block's voxels, row-major northward, from those of its pixels, rows southward.
pub(super) fn northward<T: Copy>(rect: Rect, samples: &[T]) -> Vec<T> {
    samples.chunks_exact(rect.width().max(1)).rev().collect::<Vec<_>>().concat()
}

/// Applies a geotransform (or the inverse of one).
pub(super) fn apply(c: &GeoTransform, u: f64, v: f64) -> (f64, f64) {
    (c[0] + c[1] * u + c[2] * v, c[3] + c[4] * u + c[5] * v)
}

/// Column and row from position; `None` if the geotransform is singular.
pub(super) fn invert(c: &GeoTransform) -> Option<GeoTransform> {
    let determinant = c[1] * c[5] - c[2] * c[4];
    if !determinant.is_normal() {
        return None;
    }
    let (a, b, d, e) = (c[5] / determinant, -c[2] / determinant, -c[4] / determinant, c[1] / determinant);
    let inverse = [-(a * c[0] + b * c[3]), a, b, -(d * c[0] + e * c[3]), d, e];
    inverse.iter().all(|term| term.is_finite()).then_some(inverse)
}

/// Positions of a block's voxel centres in a raster.
#[derive(Debug)]
pub(super) struct WarpField {
    pub rect: Rect,
    /// Columns, whole numbers at pixel centres, row-major over `rect`; NaN where there is no position.
    pub columns: Vec<f64>,
    /// Rows, likewise.
    pub rows: Vec<f64>,
    /// Pixels per voxel along the raster's columns and rows, per cell.
    scales: Vec<DVec2>,
}

impl WarpField {
    /// Pixels per voxel (along columns, along rows) around voxel (x, y).
    pub fn scale(&self, x: u32, y: u32) -> (f64, f64) {
        let cell = CELL as u32;
        let across = (self.rect.x1.div_ceil(cell) - self.rect.x0 / cell) as usize;
        let index =
            (y / cell - self.rect.y0 / cell) as usize * across + (x / cell - self.rect.x0 / cell) as usize;
        self.scales[index].into()
    }

    /// Whether any voxel's kernel, which is a pixel or a voxel wide to either side, reaches a raster of this size.
    pub fn touches(&self, size: Size) -> bool {
        let is_near = |position: f64, size: u32, scale: f64| {
            let reach = scale.max(1.0) + TOLERANCE;
            position > -reach && position < f64::from(size) - 1.0 + reach
        };
        self.columns.iter().zip(&self.rows).enumerate().any(|(voxel, (&column, &row))| {
            let (x, y) = self.rect.voxel(voxel);
            let scale = self.scale(x, y);
            is_near(column, size.width, scale.0) && is_near(row, size.height, scale.1)
        })
    }
}

/// Locates the voxels of `rect` in the raster that lies at `placement`.
pub(super) fn locate(placement: &RasterPlacement, grid: &Grid, rect: Rect) -> WarpField {
    let cell = CELL as u32;
    let unknown = vec![f64::NAN; rect.len()];
    let field = WarpField { rect, columns: unknown.clone(), rows: unknown, scales: Vec::new() };
    let mut locator = Locator { placement, grid, field };
    for cell_y in rect.y0 / cell..rect.y1.div_ceil(cell) {
        for cell_x in rect.x0 / cell..rect.x1.div_ceil(cell) {
            let (west, south) = (i64::from(cell_x) * CELL, i64::from(cell_y) * CELL);
            let scale = locator.scale_at(west, south);
            locator.field.scales.push(scale);
            locator.place(west, south, CELL, scale);
        }
    }
    locator.field
}

struct Locator<'a> {
    placement: &'a RasterPlacement,
    grid: &'a Grid,
    field: WarpField,
}

type WarpPoint = (f64, f64);

impl Locator<'_> {
    /// Exact position of the centre of a voxel, which may lie beyond the grid.
    fn exact(&self, i: i64, j: i64) -> Option<WarpPoint> {
        let (x, y) = world(self.grid, i as f64 + 0.5, j as f64 + 0.5);
        self.placement.pixel_from_world(x, y)
    }

    /// Pixels per voxel (along columns, along rows) around the middle of a cell whose south-west voxel is (i, j). Of several differences the least counts, so that a jump
    /// (the ±180° meridian) within the cell does not pass for a scale.
    fn scale_at(&self, i: i64, j: i64) -> DVec2 {
        let middle = CELL / 2;
        [(0, 0), (middle, middle), (CELL, CELL)]
            .into_iter()
            .filter_map(|(di, dj)| {
                let here = self.exact(i + di, j + dj)?;
                let east = self.exact(i + di + 1, j + dj)?;
                let north = self.exact(i + di, j + dj + 1)?;
                Some(DVec2::new(
                    (east.0 - here.0).hypot(north.0 - here.0),
                    (east.1 - here.1).hypot(north.1 - here.1),
                ))
            })
            .reduce(|a, b| DVec2::new(a.x.min(b.x), a.y.min(b.y)))
            .unwrap_or(DVec2::ONE)
    }

    /// Places the voxels of a square whose south-west one is (west, south).
    fn place(&mut self, west: i64, south: i64, side: i64, scale: DVec2) {
        let rect = self.field.rect;
        let (x0, x1) = (west.max(i64::from(rect.x0)), (west + side).min(i64::from(rect.x1)));
        let (y0, y1) = (south.max(i64::from(rect.y0)), (south + side).min(i64::from(rect.y1)));
        if x0 >= x1 || y0 >= y1 {
            return;
        }
        if side == 1 || self.placement.is_affine() {
            self.fill(x0..x1, y0..y1, Self::exact);
        } else if let Some(patch) = self.patch(west, south, side, scale) {
            self.fill(x0..x1, y0..y1, |_, i, j| Some(patch.at((i - west) as f64, (j - south) as f64)));
        } else {
            let half = side / 2;
            for (di, dj) in [(0, 0), (half, 0), (0, half), (half, half)] {
                self.place(west + di, south + dj, half, scale);
            }
        }
    }

    fn fill(
        &mut self,
        columns: std::ops::Range<i64>,
        rows: std::ops::Range<i64>,
        position: impl Fn(&Self, i64, i64) -> Option<WarpPoint>,
    ) {
        for j in rows {
            for i in columns.clone() {
                if let Some((column, row)) = position(self, i, j) {
                    let index = self.field.rect.index(i as u32, j as u32);
                    self.field.columns[index] = column;
                    self.field.rows[index] = row;
                }
            }
        }
    }

    /// The bilinear patch over a square of voxels whose south-west one is (i, j), if it is good enough.
    fn patch(&self, i: i64, j: i64, side: i64, scale: DVec2) -> Option<WarpPatch> {
        let corner = |di, dj| self.exact(i + di, j + dj);
        let patch = WarpPatch {
            corners: [corner(0, 0)?, corner(side, 0)?, corner(0, side)?, corner(side, side)?],
            side: side as f64,
        };
        let half = side / 2;
        for (di, dj) in [(half, half), (half, 0), (0, half), (half, side), (side, half)] {
            let (exact, near) = (corner(di, dj)?, patch.at(di as f64, dj as f64));
            if (exact.0 - near.0).abs() > TOLERANCE * scale.x.max(1.0)
                || (exact.1 - near.1).abs() > TOLERANCE * scale.y.max(1.0)
            {
                return None;
            }
        }
        Some(patch)
    }
}

/// World position of a place in the grid, in voxels from its south-west corner.
pub(super) fn world(grid: &Grid, i: f64, j: f64) -> (f64, f64) {
    (grid.origin.x + grid.spacing * i, grid.origin.y + grid.spacing * j)
}

/// Bilinear between four corners: south-west, south-east, north-west, north-east.
struct WarpPatch {
    corners: [WarpPoint; 4],
    side: f64,
}

impl WarpPatch {
    fn at(&self, di: f64, dj: f64) -> WarpPoint {
        let (u, v) = (di / self.side, dj / self.side);
        let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
        self.corners
            .iter()
            .zip(weights)
            .fold((0.0, 0.0), |sum, (corner, weight)| (sum.0 + corner.0 * weight, sum.1 + corner.1 * weight))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop_geo::Crs;

    /// One-degree tile in UTM, three arc seconds.
    fn tile() -> (RasterPlacement, Grid) {
        let transform = Transform::new(&Crs::from_epsg(32633).unwrap(), &Crs::wgs84()).unwrap();
        let pixel = 1.0 / 1200.0;
        let placement = RasterPlacement::new(
            transform,
            &[15.0, pixel, 0.0, 71.0, 0.0, -pixel],
            Size { width: 1200, height: 1200 },
        )
        .unwrap();
        (placement, Grid { nx: 700, ny: 1300, spacing: 90.0, origin: DVec2::new(500_000.0, 7_760_000.0) })
    }

    #[test]
    fn positions_are_near_the_exact_ones() {
        let (placement, grid) = tile();
        let rect = Rect { x0: 250, y0: 117, x1: 520, y1: 300 };
        let field = locate(&placement, &grid, rect);
        for index in 0..rect.len() {
            let (i, j) = rect.voxel(index);
            let (x, y) = world(&grid, f64::from(i) + 0.5, f64::from(j) + 0.5);
            let (column, row) = placement.pixel_from_world(x, y).unwrap();
            let error = (field.columns[index] - column).abs().max((field.rows[index] - row).abs());
            assert!(error < 1.5 * TOLERANCE, "voxel {i}, {j}: {error} pixels");
        }
        let (across, down) = field.scale(300, 200);
        // 90 m of longitude at 70° north are 2.9 pixels of 3 arc seconds, of latitude almost 1.
        assert!((across - 2.83).abs() < 0.1 && (down - 0.97).abs() < 0.03, "{across} {down}");
    }

    #[test]
    fn positions_do_not_depend_on_the_block() {
        let (placement, grid) = tile();
        let whole = locate(&placement, &grid, Rect { x0: 200, y0: 200, x1: 300, y1: 290 });
        let part = Rect { x0: 233, y0: 251, x1: 270, y1: 254 };
        let field = locate(&placement, &grid, part);
        for index in 0..part.len() {
            let (x, y) = part.voxel(index);
            let there = whole.rect.index(x, y);
            assert_eq!((field.columns[index], field.rows[index]), (whole.columns[there], whole.rows[there]));
            assert_eq!(field.scale(x, y), whole.scale(x, y));
        }
    }

    #[test]
    fn geotransforms_invert() {
        let c = [500.0, 3.0, 0.5, 900.0, 0.25, -4.0];
        let (x, y) = apply(&c, 12.25, 7.5);
        let (column, row) = apply(&invert(&c).unwrap(), x, y);
        assert!((column - 12.25).abs() < 1e-9 && (row - 7.5).abs() < 1e-9);
        for singular in
            [[0.0; 6], [0.0, 1.0, 2.0, 0.0, 2.0, 4.0], [f64::NAN; 6], [0.0, 1e300, 0.0, 0.0, 0.0, 1e300]]
        {
            assert_eq!(invert(&singular), None);
        }
    }
}
