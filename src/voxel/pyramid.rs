//! From a level to the next coarser one.
//!
//! ```text
//! coarse page ← finer voxels of its own voxels, of its apron, and a ring around its own ones
//!   mean   of a voxel: over its 4×4 finer voxels that have a surface
//!   colour of a voxel: the same, in linear light
//!   bounds of a voxel: least low, greatest high over 6×6 (4×4 and the ring), empty ones ignored
//!   attributes       : majorities over 4×4
//!   relief of a voxel: moments of the slopes of its finer posts, see [`Relief`]
//! ```
//!
//! Maximum mipmaps after Tevs, Ihrke and Seidel (I3D 2008); FORMAT.md says why
//! the bounds are dilated, and what they do not bound. The apron is several coarse voxels wide and so contains the ring. Sums are of integers, so that no
//! result depends on threads or order.

use std::ops::Range;

use super::relief::{Moments, Relief, half_steps};
use super::srgb::Averager;
use super::{
    APRON, AlignedBytes, Attributes, Grid, HeightCode, PAGE_SIDE, PageBuffer, PageId, PageReadback,
    PageSource, PageView, RADIX, RELIEF_APRON,
};
use crate::error::{Error, Result};

/// Where pages of finer levels are found while coarser ones are made.
pub trait FinerPages {
    /// The page, in place or read into `scratch`; `None` if it is absent.
    fn finer_page<'a>(&'a self, id: PageId, scratch: &'a mut AlignedBytes) -> Result<Option<PageView<'a>>>;
}

impl FinerPages for PageReadback {
    fn finer_page<'a>(&'a self, id: PageId, scratch: &'a mut AlignedBytes) -> Result<Option<PageView<'a>>> {
        self.page_into(id, scratch)
    }
}

impl<S: PageSource> FinerPages for S {
    fn finer_page<'a>(&'a self, id: PageId, _: &'a mut AlignedBytes) -> Result<Option<PageView<'a>>> {
        self.page(id)
    }
}

/// Page `id` (level index ≥ 1) from the up to 36 pages of the next finer level that it depends on. All of
/// them must be there. `heights` says what their codes mean.
pub fn coarse_page(
    finer: &impl FinerPages,
    grid: &Grid,
    heights: HeightCode,
    id: PageId,
) -> Result<PageBuffer> {
    let footprint = Footprint::new(grid, id)
        .ok_or_else(|| Error::Configuration(format!("{id}: not made from a finer level of this grid")))?;
    let window = footprint.collect(finer, grid)?;
    let rise = heights.scale / grid.side(window.footprint.finer_level);
    Ok(coarsen(&window, rise))
}

/// Which coarse and which finer voxels a coarse page is made from and of. Ranges count over the whole level.
#[derive(Debug, Clone)]
struct Footprint {
    finer_level: u8,
    /// The page's own voxels.
    own_x: Range<u32>,
    own_y: Range<u32>,
    /// They and their apron, clamped to the area.
    coarse_x: Range<u32>,
    coarse_y: Range<u32>,
    /// The finer voxels of these.
    finer_x: Range<u32>,
    finer_y: Range<u32>,
}

impl Footprint {
    fn new(grid: &Grid, id: PageId) -> Option<Self> {
        let finer_level = id.level.checked_sub(1)?;
        let (width, height) = grid.page_size(id)?;
        let own = |page: u32, size: u32| page * PAGE_SIDE..page * PAGE_SIDE + size;
        let with_apron =
            |own: &Range<u32>, limit: u32| own.start.saturating_sub(APRON)..(own.end + APRON).min(limit);
        let finer = |coarse: &Range<u32>, limit: u32| {
            coarse.start * RADIX..coarse.end.saturating_mul(RADIX).min(limit)
        };
        let (nx, ny) = grid.dims(id.level);
        let (finer_nx, finer_ny) = grid.dims(finer_level);
        let (own_x, own_y) = (own(id.px, width), own(id.py, height));
        let (coarse_x, coarse_y) = (with_apron(&own_x, nx), with_apron(&own_y, ny));
        let (finer_x, finer_y) = (finer(&coarse_x, finer_nx), finer(&coarse_y, finer_ny));
        Some(Self { finer_level, own_x, own_y, coarse_x, coarse_y, finer_x, finer_y })
    }

    fn collect(self, finer: &impl FinerPages, grid: &Grid) -> Result<FinerWindow> {
        let mut window = FinerWindow::empty(self);
        let Footprint { finer_level: level, finer_x, finer_y, .. } = window.footprint.clone();
        let mut scratch = AlignedBytes::default();
        for py in finer_y.start / PAGE_SIDE..finer_y.end.div_ceil(PAGE_SIDE) {
            for px in finer_x.start / PAGE_SIDE..finer_x.end.div_ceil(PAGE_SIDE) {
                let id = PageId { level, px, py };
                let missing =
                    || Error::Configuration(format!("{id} is missing in a {} x {} grid", grid.nx, grid.ny));
                let view = finer.finer_page(id, &mut scratch)?.ok_or_else(missing)?;
                window.copy_page(id, &view);
            }
        }
        Ok(window)
    }
}

/// The finer voxels that a coarse page is made from; planes `[rows][columns]` without apron.
#[derive(Debug, Clone)]
pub struct FinerWindow {
    footprint: Footprint,
    width: usize,
    heights: Vec<u16>,
    /// Empty where the finer level is level index 0, which is bounded by its heights.
    low: Vec<u16>,
    high: Vec<u16>,
    colours: Vec<[u8; 3]>,
    attributes: Vec<Attributes>,
}

impl FinerWindow {
    fn empty(footprint: Footprint) -> Self {
        let width = footprint.finer_x.len();
        let voxels = width * footprint.finer_y.len();
        let bounds = if footprint.finer_level > 0 { voxels } else { 0 };
        Self {
            footprint,
            width,
            heights: vec![HeightCode::EMPTY; voxels],
            low: vec![HeightCode::EMPTY; bounds],
            high: vec![HeightCode::EMPTY; bounds],
            colours: vec![[0; 3]; voxels],
            attributes: vec![Attributes::default(); voxels],
        }
    }

    /// Copies the part of a finer page that lies in the window, row by row.
    fn copy_page(&mut self, id: PageId, view: &PageView<'_>) {
        let (page_x, page_y) = (id.px * PAGE_SIDE, id.py * PAGE_SIDE);
        let Footprint { finer_x, finer_y, .. } = &self.footprint;
        let columns = finer_x.start.max(page_x)..finer_x.end.min(page_x + view.width);
        let rows = finer_y.start.max(page_y)..finer_y.end.min(page_y + view.height);
        let count = columns.len();
        for y in rows {
            let to = (y - finer_y.start) as usize * self.width + (columns.start - finer_x.start) as usize;
            let to = to..to + count;
            let (row, column) = ((y - page_y) as usize, (columns.start - page_x) as usize);
            let from = row * view.width as usize + column;
            let from = from..from + count;
            let aproned =
                (row + APRON as usize) * (view.width + 2 * APRON) as usize + column + APRON as usize;
            let aproned = aproned..aproned + count;
            self.heights[to.clone()].copy_from_slice(&view.heights[aproned.clone()]);
            self.colours[to.clone()].copy_from_slice(&view.colours[aproned]);
            if !self.low.is_empty() {
                self.low[to.clone()].copy_from_slice(&view.low[from.clone()]);
                self.high[to.clone()].copy_from_slice(&view.high[from.clone()]);
            }
            match view.attributes {
                [uniform] => self.attributes[to].fill(*uniform),
                plane => self.attributes[to].copy_from_slice(&plane[from]),
            }
        }
    }

    /// Half steps of height eastward and northward at each post; the window's outermost repeat themselves beyond it, which is
    /// right where the area ends.
    fn steps(&self) -> Vec<[i32; 2]> {
        let (width, rows) = (self.width, self.heights.len() / self.width);
        let mut steps = Vec::with_capacity(self.heights.len());
        for y in 0..rows {
            let row = |y: usize| &self.heights[y * width..(y + 1) * width];
            let (south, here, north) = (row(y.saturating_sub(1)), row(y), row((y + 1).min(rows - 1)));
            let at_end = i32::from(y == 0 || y + 1 == rows);
            for x in 0..width {
                let (west, east) = (here[x.saturating_sub(1)], here[(x + 1).min(width - 1)]);
                let at_side = i32::from(x == 0 || x + 1 == width);
                steps.push([
                    half_steps(here[x], west, east) << at_side,
                    half_steps(here[x], south[x], north[x]) << at_end,
                ]);
            }
        }
        steps
    }

    /// Positions in the planes of the finer voxels of coarse column or row `coarse`, `ring` more to each
    /// side, as far as the window goes; `finer` is the window's extent that way.
    fn span(coarse: u32, ring: u32, finer: &Range<u32>) -> Range<usize> {
        let start = (coarse * RADIX).saturating_sub(ring).max(finer.start);
        let end = (coarse * RADIX).saturating_add(RADIX + ring).min(finer.end);
        (start - finer.start) as usize..(end - finer.start) as usize
    }

    /// The window's rows that coarse row `y` is made from, `ring` more to each side, of a plane.
    fn rows<'a, T>(
        &self,
        plane: &'a [T],
        y: u32,
        ring: u32,
    ) -> impl Iterator<Item = &'a [T]> + Clone + use<'a, T> {
        let rows = Self::span(y, ring, &self.footprint.finer_y);
        plane[rows.start * self.width..rows.end * self.width].chunks_exact(self.width)
    }
}

/// The coarse page from the finer voxels; `rise` is the slope of one step of height from one finer post to the next.
pub fn coarsen(window: &FinerWindow, rise: f64) -> PageBuffer {
    let Footprint { own_x, own_y, .. } = &window.footprint;
    let (width, height) = (own_x.len() as u32, own_y.len() as u32);
    let (heights, colours) = means_with_apron(window);
    let relief = reliefs(window, &heights, rise);
    let finest = window.footprint.finer_level == 0;
    let (low, high) = if finest { (&window.heights, &window.heights) } else { (&window.low, &window.high) };
    // Negated in wrapping arithmetic, the least code is the greatest, and the empty one, 0, still
    // loses against every other.
    let negated_low = dilated_extremes(window, low, u16::wrapping_neg);
    PageBuffer {
        width,
        height,
        heights,
        low: negated_low.into_iter().map(u16::wrapping_neg).collect(),
        high: dilated_extremes(window, high, |code| code),
        colours,
        relief,
        attributes: majorities(window),
    }
}

/// Mean heights and colours of the page's voxels and apron.
fn means_with_apron(window: &FinerWindow) -> (Vec<u16>, Vec<[u8; 3]>) {
    let Footprint { own_x, own_y, coarse_x, coarse_y, finer_x, .. } = &window.footprint;
    let averager = Averager::new();
    let mut means = Vec::with_capacity(coarse_x.len() * coarse_y.len());
    for y in coarse_y.clone() {
        let heights = window.rows(&window.heights, y, 0);
        let colours = window.rows(&window.colours, y, 0);
        for x in coarse_x.clone() {
            let columns = FinerWindow::span(x, 0, finer_x);
            let rows = heights.clone().zip(colours.clone());
            means.push(mean(&averager, rows.map(|(h, c)| (&h[columns.clone()], &c[columns.clone()]))));
        }
    }
    let clamped = |own: &Range<u32>, coarse: &Range<u32>| -> Vec<usize> {
        let (first, last) = (coarse.start, coarse.end - 1);
        let with_apron = 0..own.len() as u32 + 2 * APRON;
        with_apron
            .map(|k| ((own.start + k).saturating_sub(APRON).clamp(first, last) - first) as usize)
            .collect()
    };
    let (columns, rows) = (clamped(own_x, coarse_x), clamped(own_y, coarse_y));
    let stride = coarse_x.len();
    let replicated = rows.iter().flat_map(|row| columns.iter().map(move |column| row * stride + column));
    replicated.map(|index| means[index]).unzip()
}

/// Relief of the page's voxels and of those around it, `heights` (with apron) being the page's own.
fn reliefs(window: &FinerWindow, heights: &[u16], rise: f64) -> Vec<Relief> {
    let Footprint { own_x, own_y, coarse_x, coarse_y, finer_x, finer_y, .. } = &window.footprint;
    let stride = own_x.len() + 2 * APRON as usize;
    // Beside the area lies what lies at its edge.
    let around = |own: &Range<u32>, coarse: &Range<u32>| -> Vec<u32> {
        let margin = i64::from(RELIEF_APRON);
        let (first, last) = (i64::from(coarse.start), i64::from(coarse.end) - 1);
        let voxels = i64::from(own.start) - margin..i64::from(own.end) + margin;
        voxels.map(|voxel| voxel.clamp(first, last) as u32).collect()
    };
    let (columns, rows) = (around(own_x, coarse_x), around(own_y, coarse_y));
    let steps = window.steps();
    let half_step = (0.5 * rise / f64::from(RADIX)) as f32;
    // Of voxels whose neighbours the window holds; it ends further out, or with the area.
    let at_edge = |voxel: u32, coarse: &Range<u32>| voxel == coarse.start || voxel + 1 == coarse.end;
    let place = |voxel: u32, own: &Range<u32>| (voxel + APRON - own.start) as usize;
    let mut reliefs = Vec::with_capacity(columns.len() * rows.len());
    for &y in &rows {
        for &x in &columns {
            let mut moments = Moments::new(0.5 * rise);
            let posts = FinerWindow::span(x, 0, finer_x);
            for row in FinerWindow::span(y, 0, finer_y) {
                let posts = row * window.width + posts.start..row * window.width + posts.end;
                let row = steps[posts.clone()].iter().zip(&window.heights[posts]);
                row.filter(|(_, code)| **code != HeightCode::EMPTY)
                    .for_each(|(steps, _)| moments.add(*steps));
            }
            let here = place(y, own_y) * stride + place(x, own_x);
            let own = [(1, at_edge(x, coarse_x)), (stride, at_edge(y, coarse_y))].map(|(next, at_edge)| {
                let steps = half_steps(heights[here], heights[here - next], heights[here + next]);
                (steps << i32::from(at_edge)) as f32 * half_step
            });
            reliefs.push(Relief::new(&moments, own));
        }
    }
    reliefs
}

/// Mean height code and colour over rows of voxels, those without a surface left out.
fn mean<'a>(averager: &Averager, rows: impl Iterator<Item = (&'a [u16], &'a [[u8; 3]])>) -> (u16, [u8; 3]) {
    let (mut count, mut sum, mut light) = (0, 0, [0; 3]);
    for (heights, colours) in rows {
        for (&code, &colour) in heights.iter().zip(colours) {
            if code != HeightCode::EMPTY {
                count += 1;
                sum += u32::from(code);
                averager.add(&mut light, colour);
            }
        }
    }
    if count == 0 {
        return (HeightCode::EMPTY, [0; 3]);
    }
    (((sum + count / 2) / count) as u16, averager.mean(light, count))
}

/// The greatest `key` of a plane over each of the page's voxels and the ring of finer ones around it.
fn dilated_extremes(window: &FinerWindow, plane: &[u16], key: impl Fn(u16) -> u16) -> Vec<u16> {
    let Footprint { own_x, own_y, finer_x, .. } = &window.footprint;
    let mut column_extremes = vec![0; window.width];
    let mut extremes = Vec::with_capacity(own_x.len() * own_y.len());
    for y in own_y.clone() {
        column_extremes.fill(0);
        for row in window.rows(plane, y, 1) {
            column_extremes
                .iter_mut()
                .zip(row)
                .for_each(|(extreme, &code)| *extreme = key(code).max(*extreme));
        }
        let over = |x| column_extremes[FinerWindow::span(x, 1, finer_x)].iter().copied().max().unwrap_or(0);
        extremes.extend(own_x.clone().map(over));
    }
    extremes
}

/// Attributes of the page's voxels.
fn majorities(window: &FinerWindow) -> Vec<Attributes> {
    let Footprint { own_x, own_y, finer_x, .. } = &window.footprint;
    let mut result = Vec::with_capacity(own_x.len() * own_y.len());
    let mut finer = Vec::with_capacity((RADIX * RADIX) as usize);
    for y in own_y.clone() {
        for x in own_x.clone() {
            let columns = FinerWindow::span(x, 0, finer_x);
            finer.clear();
            window
                .rows(&window.attributes, y, 0)
                .for_each(|row| finer.extend_from_slice(&row[columns.clone()]));
            result.push(majority(&finer));
        }
    }
    result
}

/// Attributes that stand for up to 16 voxels, at least one.
fn majority(voxels: &[Attributes]) -> Attributes {
    if voxels.iter().all(|attributes| *attributes == voxels[0]) {
        return voxels[0];
    }
    let flagged = |flag: u8| {
        let count = voxels.iter().filter(|attributes| attributes.flags & flag != 0).count();
        if 2 * count >= voxels.len() { flag } else { 0 }
    };
    Attributes {
        source: most_frequent(voxels.iter().map(|attributes| attributes.source)),
        material: most_frequent(voxels.iter().map(|attributes| attributes.material)),
        flags: (0..u8::BITS).map(|bit| flagged(1 << bit)).fold(0, std::ops::BitOr::bitor),
    }
}

/// The value that occurs most often, the least of them on a tie.
fn most_frequent<T: Ord + Copy + Default>(values: impl Iterator<Item = T> + Clone) -> T {
    let count = |value| values.clone().filter(|other| *other == value).count();
    values.clone().max_by_key(|value| (count(*value), std::cmp::Reverse(*value))).unwrap_or_default()
}
