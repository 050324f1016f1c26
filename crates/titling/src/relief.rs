//! Shaded relief of a part of a database, for small maps.

use glam::{DVec2, DVec3};

use hedgehop::raymarch::PageCursor;
use hedgehop::voxel::PageSource;
use hedgehop_base::error::Result;

/// Samples of the relief along its longer side.
const SAMPLES: f64 = 256.0;

/// Voxels along the longer side that a level must have to be drawn; the finest is, if none has.
const ENOUGH: f64 = 96.0;

/// Factor by which slopes are drawn steeper than they are: those of coarse voxels are gentle.
const STEEPER: f64 = 3.0;

/// Light from the north-west, as maps have it.
const LIGHT: DVec3 = DVec3::new(-0.5, 0.5, 0.707);

/// 8-bit sRGB of low and of high ground, and of where there is none.
const LOW: [f64; 3] = [96.0, 120.0, 88.0];
const HIGH: [f64; 3] = [216.0, 206.0, 190.0];
const NOTHING: [u8; 3] = [24, 26, 30];

/// Rectangle of the map, metres of the database's reference system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// South-west corner.
    pub origin: DVec2,
    /// Sides.
    pub extent: DVec2,
    /// Whether it repeats without end.
    pub is_endless: bool,
}

impl Window {
    /// Returns all of a database's area.
    pub fn whole(source: &dyn PageSource) -> Self {
        let grid = &source.header().grid;
        Self { origin: grid.origin, extent: grid.far_corner() - grid.origin, is_endless: false }
    }

    /// Returns where a place lies in it: 0…1 from west to east, and from north to south; the nearest such, if it lies beside it, or that of the copy which it lies in.
    pub fn share(&self, place: DVec2) -> DVec2 {
        let share = (place - self.origin) / self.extent;
        let share =
            if self.is_endless { share - share.floor() } else { share.clamp(DVec2::ZERO, DVec2::ONE) };
        DVec2::new(share.x, 1.0 - share.y)
    }

    /// Returns a line through places as parts that do not cross the window's border, by their shares.
    pub fn parts(&self, places: impl IntoIterator<Item = DVec2>) -> Vec<Vec<DVec2>> {
        let mut parts: Vec<Vec<DVec2>> = vec![Vec::new()];
        for share in places.into_iter().map(|place| self.share(place)) {
            let last = parts.last().and_then(|part| part.last());
            let jumps = last.is_some_and(|last: &DVec2| (*last - share).abs().max_element() > 0.5);
            if jumps && self.is_endless {
                parts.push(Vec::new());
            }
            parts.last_mut().expect("a part").push(share);
        }
        parts
    }
}

/// Shaded relief of a window.
#[derive(Debug, Clone)]
pub struct Relief {
    /// Part of the area that is drawn.
    pub window: Window,
    /// Columns and rows.
    pub size: [usize; 2],
    /// 8-bit sRGB, `[row][column]`, row 0 in the north.
    pub pixels: Vec<[u8; 3]>,
}

impl Relief {
    /// Draws a window of a database; the coarsest level that has enough voxels for a map is read.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn new(source: &dyn PageSource, window: Window) -> Result<Self> {
        let header = source.header();
        let extent = window.extent;
        let size =
            [0, 1].map(|axis| (SAMPLES * extent[axis] / extent.max_element()).ceil().max(1.0) as usize);
        let step = extent / DVec2::new(size[0] as f64, size[1] as f64);

        let mut cursor = PageCursor::new(source);
        let whole = header.grid.far_corner() - header.grid.origin;
        let share = extent.max_element() / whole.max_element();
        let voxels = |level: u8| cursor.dims(level).into_iter().max().unwrap_or_default() as f64 * share;
        let level = (0..header.level_count).rev().find(|level| voxels(*level) >= ENOUGH).unwrap_or(0);

        let first = (window.origin - header.grid.origin) / header.grid.spacing;
        let unit_step = step / header.grid.spacing;
        let mut heights = Vec::with_capacity(size[0] * size[1]);
        for row in (0..size[1]).rev() {
            for column in 0..size[0] {
                let place = first + DVec2::new(column as f64 + 0.5, row as f64 + 0.5) * unit_step;
                heights.push(cursor.height_from(level, place)?);
            }
        }
        Ok(Self { window, size, pixels: shaded(&heights, size, step) })
    }

    /// Returns the colour of the sample at a share of the window's sides, from the north-west.
    pub fn nearest(&self, share: DVec2) -> [u8; 3] {
        let at = |axis: usize| ((share[axis] * self.size[axis] as f64) as usize).min(self.size[axis] - 1);
        self.pixels[at(1) * self.size[0] + at(0)]
    }

    /// Returns the colour between samples at a share of the window's sides, from the north-west.
    pub fn between(&self, share: DVec2) -> [u8; 3] {
        let size = DVec2::new(self.size[0] as f64, self.size[1] as f64);
        let at = (share * size - 0.5).clamp(DVec2::ZERO, size - 1.0);
        let (low, part) = (at.floor(), at.fract());
        let pixel = |right: usize, down: usize| {
            let column = (low.x as usize + right).min(self.size[0] - 1);
            let row = (low.y as usize + down).min(self.size[1] - 1);
            self.pixels[row * self.size[0] + column].map(f64::from)
        };
        let corners = [pixel(0, 0), pixel(1, 0), pixel(0, 1), pixel(1, 1)];
        [0, 1, 2].map(|channel| {
            let [a, b, c, d] = corners.map(|corner| corner[channel]);
            let (upper, lower) = (a + (b - a) * part.x, c + (d - c) * part.x);
            (upper + (lower - upper) * part.y).round() as u8
        })
    }
}

/// Ground lit by [`LIGHT`], brighter the higher it is; `step` is the width of a sample, metres.
fn shaded(heights: &[Option<f64>], [columns, rows]: [usize; 2], step: DVec2) -> Vec<[u8; 3]> {
    let known = || heights.iter().flatten().copied();
    let (least, most) = (known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max));
    let shade = |(index, height): (usize, &Option<f64>)| {
        let Some(height) = *height else { return NOTHING };
        let (column, row) = (index % columns, index / columns);
        let at = |column: usize, row: usize| heights[row * columns + column].unwrap_or(height);
        let (west, east) = (column.saturating_sub(1), (column + 1).min(columns - 1));
        let (north, south) = (row.saturating_sub(1), (row + 1).min(rows - 1));
        let slope = DVec2::new(
            (at(east, row) - at(west, row)) / (step.x * (east - west).max(1) as f64),
            (at(column, north) - at(column, south)) / (step.y * (south - north).max(1) as f64),
        );
        let normal = (-STEEPER * slope).extend(1.0).normalize();
        let lit = 0.45 + 0.75 * normal.dot(LIGHT).max(0.0);
        let high = (height - least) / (most - least).max(1.0);

        [0, 1, 2]
            .map(|channel| (lit * (LOW[channel] + (HIGH[channel] - LOW[channel]) * high)).min(255.0) as u8)
    };

    heights.iter().enumerate().map(shade).collect()
}
