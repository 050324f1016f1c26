//! The small map: shaded relief of a coarse level, the path, the own position.

use glam::{DVec2, DVec3};

use super::canvas::{Canvas, Ink};
use crate::raymarch::PageCursor;
use crate::voxel::PageSource;
use hedgehop_base::error::Result;

/// Samples of the relief along its longer side.
const SAMPLES: f64 = 256.0;

/// Voxels along the longer side that a level must have to be drawn; the finest is, if none has.
const ENOUGH: i64 = 96;

/// Factor by which slopes are drawn steeper than they are: those of coarse voxels are gentle.
const STEEPER: f64 = 3.0;

/// Light from the north-west, as maps have it.
const LIGHT: DVec3 = DVec3::new(-0.5, 0.5, 0.707);

/// 8-bit sRGB of low and of high ground, and of where there is none.
const LOW: [f64; 3] = [96.0, 120.0, 88.0];
const HIGH: [f64; 3] = [216.0, 206.0, 190.0];
const NOTHING: [u8; 3] = [24, 26, 30];

/// Places of the path at most.
const MOST_PLACES: usize = 2000;

/// Shaded relief of an area, and a path through it.
#[derive(Debug, Clone)]
pub struct MiniMap {
    /// South-west corner and sides of the area, metres.
    origin: DVec2,
    extent: DVec2,
    /// Columns and rows of the relief.
    pub(super) size: [usize; 2],
    /// 8-bit sRGB, `[row][column]`, row 0 in the north.
    pub(super) relief: Vec<[u8; 3]>,
    path: Vec<DVec2>,
}

impl MiniMap {
    /// Draws the map of a database, with a path of places in its reference system, metres; the coarsest level that has enough voxels for a map is read.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn new(source: &dyn PageSource, path: &[DVec2]) -> Result<Self> {
        let header = source.header();
        let units = DVec2::new(f64::from(header.grid.nx), f64::from(header.grid.ny));
        let extent = units * header.grid.spacing;
        let size =
            [0, 1].map(|axis| (SAMPLES * extent[axis] / extent.max_element()).ceil().max(1.0) as usize);
        let step = units / DVec2::new(size[0] as f64, size[1] as f64);
        let mut cursor = PageCursor::new(source);
        let has_enough = |level: &u8| cursor.dims(*level).into_iter().max() >= Some(ENOUGH);
        let level = (0..header.level_count).rev().find(has_enough).unwrap_or(0);
        let mut heights = Vec::with_capacity(size[0] * size[1]);

        for row in (0..size[1]).rev() {
            for column in 0..size[0] {
                let place = DVec2::new(column as f64 + 0.5, row as f64 + 0.5) * step;
                heights.push(cursor.height_from(level, place)?);
            }
        }

        let every = path.len().div_ceil(MOST_PLACES).max(1);
        let relief = relief(&heights, size, step * header.grid.spacing);
        Ok(Self {
            origin: header.grid.origin,
            extent,
            size,
            relief,
            path: path.iter().copied().step_by(every).collect(),
        })
    }

    /// Draws it so high, in pixels, with its lower right corner at a place; `own` is where the eye is, `heading` degrees clockwise from grid north.
    pub fn draw(
        &self,
        canvas: &mut Canvas<'_>,
        corner: DVec2,
        height: f64,
        own: DVec2,
        heading: f64,
        ink: Ink,
    ) {
        let scale = height / self.extent.max_element();
        let size = self.extent * scale;
        let first = corner - size;
        let [columns, rows] = [0, 1].map(|axis| (first[axis].floor() as i64, corner[axis].floor() as i64));

        for row in rows.0..rows.1 {
            for column in columns.0..columns.1 {
                let share = (DVec2::new(column as f64 + 0.5, row as f64 + 0.5) - first) / size;
                let at =
                    |axis: usize| ((share[axis] * self.size[axis] as f64) as usize).min(self.size[axis] - 1);
                canvas.mix(column, row, self.relief[at(1) * self.size[0] + at(0)], 0.85);
            }
        }

        let place = |at: DVec2| {
            let share = ((at - self.origin) / self.extent).clamp(DVec2::ZERO, DVec2::ONE);
            first + DVec2::new(share.x, 1.0 - share.y) * size
        };
        let path = Ink { colour: [235, 60, 40], halo: 0.0 };
        for pair in self.path.windows(2) {
            canvas.line([place(pair[0]), place(pair[1])], path);
        }

        let (sine, cosine) = heading.to_radians().sin_cos();
        let (ahead, aside) = (DVec2::new(sine, -cosine), DVec2::new(cosine, sine));
        let (nose, long) = (place(own), 4.0 * canvas.dot as f64);
        let tail = nose - ahead * 2.0 * long;
        for wing in [-1.0, 1.0] {
            canvas.line([nose, tail + aside * wing * long], ink);
        }

        let corners = [first, DVec2::new(corner.x, first.y), corner, DVec2::new(first.x, corner.y)];
        for side in 0..4 {
            canvas.line([corners[side], corners[(side + 1) % 4]], Ink { halo: 0.0, ..ink });
        }
    }
}

/// Ground lit by [`LIGHT`], brighter the higher it is; `step` is the width of a sample, metres.
fn relief(heights: &[Option<f64>], [columns, rows]: [usize; 2], step: DVec2) -> Vec<[u8; 3]> {
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
