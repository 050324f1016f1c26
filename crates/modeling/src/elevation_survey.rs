//! Survey of elevation: one look at every sample that the build may use, before the first page.
//!
//! The code of heights must span all of them, and voids that are wider than the fill's reach need the broad shape
//! of the terrain around: per source a surface of at most [`COARSE`]² cell means, whose empty cells are
//! filled by pull and push (Gortler et al. 1996, §3.4: average what is known upward, then complete downward).

use super::build_cache::{BuildCache, Keyer};
use super::placed::ElevationInput;
use super::plan::Plan;
use super::synthetic::Energies;
use super::warp;
use super::workers::in_order;
use crate::page_keys::SourceKeys;
use crate::raster::Window;
use crate::survey_result::{Coarse, Survey};
use hedgehop::Size;
use hedgehop::voxel::Grid;
use hedgehop_base::error::Result;
use hedgehop_base::progress::Observer;

/// Cells along the longer side of a coarse surface.
const COARSE: u32 = 64;
/// Samples read at once, unless one block of the file holds more.
const CHUNK_SAMPLES: u64 = 1 << 18;

/// Looks at the part of each source that the grid may need, at its curvatures too if `measure`.
pub(super) fn survey(
    sources: &[ElevationInput],
    plan: &Plan,
    cache: Option<(&BuildCache, &SourceKeys)>,
    measure: bool,
    threads: usize,
    observer: &dyn Observer,
) -> Result<Vec<Survey>> {
    let plans: Vec<Chunks> = sources.iter().map(|source| Chunks::of(source, plan)).collect();
    observer.begin("scan", plans.iter().map(Chunks::count).sum(), "blocks");
    let surveys = sources
        .iter()
        .zip(&plans)
        .enumerate()
        .map(|(index, (source, plan))| {
            let step = cache.map(|(cache, keys)| {
                (
                    cache,
                    Keyer::of("survey")
                        .with_key(keys.elevation[index])
                        .with(&plan.window)
                        .with(&measure)
                        .key(),
                )
            });

            if let Some(known) = step.and_then(|(cache, key)| cache.survey(key)) {
                step.iter().for_each(|(cache, key)| cache.surveyed(*key, &known));
                observer.advance(plan.count());
                return Ok(known);
            }

            let mut total = SurveyTally::new(source.samples.size());
            in_order(
                plan.count(),
                threads,
                observer,
                Vec::new,
                |samples, chunk| SurveyTally::of(source, plan.window(chunk), measure, samples),
                |_, tally| {
                    total.add(&tally);
                    observer.advance(1);
                    Ok(())
                },
            )?;

            let survey = Survey { notes: source.samples.notes(), ..total.finish() };
            step.iter().for_each(|(cache, key)| cache.surveyed(*key, &survey));
            Ok(survey)
        })
        .collect();

    observer.end();
    surveys
}

/// Chunks into which a source's window is cut for reading: along the file's blocks.
struct Chunks {
    window: Window,
    step: (u32, u32),
}

impl Chunks {
    fn of(source: &ElevationInput, plan: &Plan) -> Self {
        let size = source.samples.size();
        let window =
            needed(source, plan).unwrap_or(Window { x: 0, y: 0, width: size.width, height: size.height });
        let block_width = source.block.width.clamp(1, size.width);
        let block_height = source.block.height.clamp(1, size.height);
        let fit = |limit: u64, block: u32, size: u32| {
            (limit / u64::from(block)).max(1).saturating_mul(u64::from(block)).min(u64::from(size)) as u32
        };
        let columns = fit(CHUNK_SAMPLES / u64::from(block_height), block_width, size.width);
        let rows = fit(CHUNK_SAMPLES / u64::from(columns), block_height, size.height);
        // Chunks start at multiples of their size, so that none cuts a block.
        let (x, y) = (window.x / block_width * block_width, window.y / block_height * block_height);
        let window =
            Window { x, y, width: window.x + window.width - x, height: window.y + window.height - y };
        Self { window, step: (columns, rows) }
    }

    fn count(&self) -> u64 {
        u64::from(self.window.width.div_ceil(self.step.0))
            * u64::from(self.window.height.div_ceil(self.step.1))
    }

    fn window(&self, chunk: u64) -> Window {
        let across = u64::from(self.window.width.div_ceil(self.step.0));
        let (column, row) = ((chunk % across) as u32 * self.step.0, (chunk / across) as u32 * self.step.1);
        Window {
            x: self.window.x + column,
            y: self.window.y + row,
            width: self.step.0.min(self.window.width - column),
            height: self.step.1.min(self.window.height - row),
        }
    }
}

/// The pixels that the grid may need, from a lattice of positions; `None`: all of them.
fn needed(source: &ElevationInput, plan: &Plan) -> Option<Window> {
    const LATTICE: u32 = 32;

    let grid = &plan.grid;
    let size = source.samples.size();
    let (mut x, mut y) = ((f64::MAX, f64::MIN), (f64::MAX, f64::MIN));
    for j in 0..=LATTICE {
        for i in 0..=LATTICE {
            let part = |step: u32, voxels: u32| f64::from(step) / f64::from(LATTICE) * f64::from(voxels);
            let (east, north) = warp::world(grid, part(i, grid.nx), part(j, grid.ny));
            let (column, row) = source.placement.pixel_from_world(east, north)?;
            x = (x.0.min(column), x.1.max(column));
            y = (y.0.min(row), y.1.max(row));
        }
    }

    // Room for the curve between lattice points, for kernels and for the fill's reach.
    let reach = f64::from(crate::void_fill::REACH + 2) * f64::from(Grid::side_units(plan.stored.outside()));
    let clip = |(low, high): (f64, f64), voxels: u32, size: u32| {
        let margin = (high - low) * (1.0 / f64::from(LATTICE) + reach / f64::from(voxels)) + 4.0;
        let first = (low - margin).floor().clamp(0.0, f64::from(size) - 1.0) as u32;
        let last = (high + margin).ceil().clamp(0.0, f64::from(size) - 1.0) as u32;
        (first, last - first + 1)
    };

    // A turned raster's rows run along the grid's columns; the smaller count serves both.
    let voxels = grid.nx.min(grid.ny);
    let ((x, width), (y, height)) = (clip(x, voxels, size.width), clip(y, voxels, size.height));

    Some(Window { x, y, width, height })
}

/// Extremes and cell sums of some samples.
struct SurveyTally {
    range: (f64, f64),
    energies: Energies,
    layout: ChunkLayout,
    /// First cell row of `cells`.
    first_row: usize,
    /// Sums per cell, whole rows of cells.
    cells: Vec<CellSum>,
}

/// Sum of the samples of a cell.
#[derive(Debug, Clone, Copy, Default)]
struct CellSum {
    /// Sum of the known samples, metres.
    sum: f64,
    /// Number of known samples.
    count: u64,
}

impl CellSum {
    #[inline]
    fn plus(self, other: Self) -> Self {
        Self { sum: self.sum + other.sum, count: self.count + other.count }
    }
}

#[derive(Clone, Copy)]
struct ChunkLayout {
    columns: usize,
    rows: usize,
    pixels: (f64, f64),
}

impl ChunkLayout {
    fn new(size: Size) -> Self {
        let Size { width, height } = size;
        let pixels = (f64::from(width.max(height)) / f64::from(COARSE)).max(1.0);
        let count = |size: u32| (f64::from(size) / pixels).ceil().max(1.0) as usize;
        Self { columns: count(width), rows: count(height), pixels: (pixels, pixels) }
    }
    fn column(&self, pixel: u32) -> usize {
        ((f64::from(pixel) / self.pixels.0) as usize).min(self.columns - 1)
    }
    fn row(&self, pixel: u32) -> usize {
        ((f64::from(pixel) / self.pixels.1) as usize).min(self.rows - 1)
    }
}

impl SurveyTally {
    fn empty(layout: ChunkLayout, first_row: usize, rows: usize) -> Self {
        Self {
            range: (f64::INFINITY, f64::NEG_INFINITY),
            energies: Energies::default(),
            layout,
            first_row,
            cells: vec![CellSum::default(); rows * layout.columns],
        }
    }

    fn new(size: Size) -> Self {
        let layout = ChunkLayout::new(size);
        Self::empty(layout, 0, layout.rows)
    }

    fn of(source: &ElevationInput, window: Window, measure: bool, samples: &mut Vec<f64>) -> Result<Self> {
        source.samples.read(window, samples)?;
        let layout = ChunkLayout::new(source.samples.size());
        let first_row = layout.row(window.y);
        let rows = layout.row(window.y + window.height - 1) - first_row + 1;
        let mut tally = Self::empty(layout, first_row, rows);
        let columns: Vec<usize> = (window.x..window.x + window.width).map(|x| layout.column(x)).collect();
        let cells: Vec<(usize, usize)> =
            columns.chunk_by(|a, b| a == b).map(|cell| (cell[0], cell.len())).collect();

        for (y, line) in (window.y..).zip(samples.chunks_exact(window.width as usize)) {
            if measure {
                tally.energies.meet(line);
            }
            let start = (layout.row(y) - first_row) * layout.columns;
            let mut line = line;
            for &(cell, pixels) in &cells {
                let (heights, others) = line.split_at(pixels);
                line = others;
                tally.meet_all(heights, start + cell);
            }
        }

        Ok(tally)
    }

    /// Samples of one cell. Sums of every fourth are apart: none waits for the one before it.
    fn meet_all(&mut self, heights: &[f64], cell: usize) {
        let mut sums = [CellSum::default(); 4];
        let (mut low, mut high) = ([f64::INFINITY; 4], [f64::NEG_INFINITY; 4]);
        let mut meet = |(lane, &height): (usize, &f64)| {
            // A void is NaN, and no extreme of anything.
            let is_known = !height.is_nan();
            sums[lane].sum += if is_known { height } else { 0.0 };
            sums[lane].count += u64::from(is_known);
            low[lane] = low[lane].min(height);
            high[lane] = high[lane].max(height);
        };
        let (fours, rest) = heights.as_chunks::<4>();
        fours.iter().for_each(|four| four.iter().enumerate().for_each(&mut meet));
        rest.iter().enumerate().for_each(&mut meet);
        low.into_iter().for_each(|low| self.range.0 = self.range.0.min(low));
        high.into_iter().for_each(|high| self.range.1 = self.range.1.max(high));
        let cell = &mut self.cells[cell];
        *cell = sums.into_iter().fold(*cell, CellSum::plus);
    }

    fn meet(&mut self, height: f64) {
        self.range = (self.range.0.min(height), self.range.1.max(height));
    }

    fn add(&mut self, part: &Self) {
        if part.range.0 <= part.range.1 {
            self.meet(part.range.0);
            self.meet(part.range.1);
        }
        self.energies.add(&part.energies);
        let start = part.first_row * self.layout.columns;
        for (cell, more) in self.cells[start..].iter_mut().zip(&part.cells) {
            *cell = cell.plus(*more);
        }
    }

    fn finish(self) -> Survey {
        let (low, high) = self.range;
        if low > high {
            return Survey::default();
        }
        let layout = self.layout;
        let means = pull_push(layout.columns, layout.rows, &self.cells);
        let coarse = Coarse { columns: layout.columns, rows: layout.rows, pixels: layout.pixels, means };
        Survey { range: Some((low, high)), coarse: Some(coarse), notes: Vec::new(), energies: self.energies }
    }
}

/// Means of cells; empty ones take those of the next coarser grid of cells, as often as needed.
fn pull_push(columns: usize, rows: usize, cells: &[CellSum]) -> Vec<f64> {
    let (half_columns, half_rows) = (columns.div_ceil(2), rows.div_ceil(2));
    let coarser = if columns * rows > 1 && cells.iter().any(|cell| cell.count == 0) {
        let mut pulled = vec![CellSum::default(); half_columns * half_rows];
        for (index, cell) in cells.iter().enumerate() {
            let (column, row) = (index % columns / 2, index / columns / 2);
            let sum = &mut pulled[row * half_columns + column];
            *sum = sum.plus(*cell);
        }

        Coarse {
            columns: half_columns,
            rows: half_rows,
            pixels: (2.0, 2.0),
            means: pull_push(half_columns, half_rows, &pulled),
        }
    } else {
        Coarse { columns: 1, rows: 1, pixels: (1.0, 1.0), means: vec![0.0] }
    };

    cells
        .iter()
        .enumerate()
        .map(|(index, cell)| match cell.count {
            0 => coarser.at((index % columns) as f64, (index / columns) as f64),
            count => cell.sum / count as f64,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_cells_take_the_shape_around() {
        // A plane of 8 × 8 cells, four of them known.
        let plane = |index: usize| 10.0 * (index % 8) as f64 + 3.0 * (index / 8) as f64;
        let cells: Vec<CellSum> = (0..64)
            .map(|index| match index {
                0 | 7 | 56 | 63 => CellSum { sum: plane(index) * 2.0, count: 2 },
                _ => CellSum::default(),
            })
            .collect();
        let means = pull_push(8, 8, &cells);
        for (index, mean) in means.iter().enumerate() {
            assert!((mean - plane(index)).abs() < 30.0, "cell {index}: {mean}");
        }
        assert_eq!((means[0], means[63]), (plane(0), plane(63)));
    }

    #[test]
    fn one_known_cell_is_enough() {
        let mut cells = vec![CellSum::default(); 5 * 3];
        cells[7] = CellSum { sum: 84.0, count: 2 };
        assert!(pull_push(5, 3, &cells).iter().all(|mean| *mean == 42.0));
    }

    #[test]
    fn coarse_surfaces_are_interpolated_and_clamped() {
        let coarse = Coarse { columns: 2, rows: 1, pixels: (10.0, 10.0), means: vec![0.0, 100.0] };
        assert_eq!(coarse.at(4.5, 3.0), 0.0);
        assert_eq!(coarse.at(9.5, 3.0), 50.0);
        assert_eq!(coarse.at(400.0, -3.0), 100.0);
    }
}
