//! Pyramid of levels: from each to the next coarser one.
//!
//! ```text
//! coarse page ← finer voxels of its own voxels, of its apron, and a ring around its own ones
//!   mean   of a voxel: over its 4×4 finer voxels that have a surface
//!   colour of a voxel: the same, in linear light
//!   bounds of a voxel: least low, greatest high over 6×6 (4×4 and the ring), empty ones ignored
//!   attributes       : majorities over 4×4
//!   relief of a voxel: moments of the slopes of its finer posts, see [`Relief`]
//! where finer pages are absent: what a [`StandIn`] gives, see [`super::window`]
//!   bounds           : of finer voxels that are stored, and of the level's own heights over 3×3, since its surface is seen
//! ```
//!
//! Maximum mipmaps after Tevs, Ihrke and Seidel (I3D 2008); FORMAT.md says why
//! the bounds are dilated, and what they do not bound. The apron is several coarse voxels wide and so contains the ring. Sums are of integers, so that no
//! result depends on threads or order.

use std::ops::Range;

use super::relief::{Moments, Relief, half_steps};
use super::srgb::Averager;
use super::window::{FinerPages, FinerWindow, StandIn, VoxelBlock, WindowFootprint};
use super::{APRON, Attributes, Grid, HeightCode, PageBuffer, PageId, RADIX, RELIEF_APRON, SpanTable};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

/// Page `id` (level index ≥ 1) from the up to 36 pages of the next finer level that it depends on. All of
/// them must be there. `heights` says what their codes mean.
pub fn coarse_page(
    finer: &impl FinerPages,
    grid: &Grid,
    heights: HeightCode,
    id: PageId,
) -> Result<PageBuffer> {
    sparse_page(finer, &mut Nothing { grid }, grid, heights, id)
}

/// The same where some of the finer pages are absent, or all: `stand_in` says what is there instead.
pub fn sparse_page(
    finer: &impl FinerPages,
    stand_in: &mut impl StandIn,
    grid: &Grid,
    heights: HeightCode,
    id: PageId,
) -> Result<PageBuffer> {
    let footprint = WindowFootprint::new(grid, id)
        .ok_or_else(|| Error::Configuration(format!("{id}: not made from a finer level of this grid")))?;
    if let Some(attributes) = footprint.known_empty(finer) {
        let size = Size { width: footprint.own_x.len() as u32, height: footprint.own_y.len() as u32 };
        return Ok(PageBuffer::empty(id, size, attributes));
    }
    let window = FinerWindow::collect(footprint, grid, id, finer, stand_in)?;
    let rise = heights.scale / grid.side(window.footprint.finer_level);
    Ok(coarsen(&window, rise))
}

/// Stands in for no page.
struct Nothing<'g> {
    grid: &'g Grid,
}

impl Nothing<'_> {
    fn missing<T>(&self, id: PageId) -> Result<T> {
        let Grid { nx, ny, .. } = self.grid;
        Err(Error::Configuration(format!("{id} is missing in a {nx} x {ny} grid")))
    }
}

impl StandIn for Nothing<'_> {
    fn finer(&mut self, id: PageId, _: Range<u32>, _: Range<u32>) -> Result<Option<VoxelBlock>> {
        self.missing(id)
    }

    fn page(&mut self, id: PageId) -> Result<PageBuffer> {
        self.missing(id)
    }
}

/// The coarse page from the finer voxels; `rise` is the slope of one step of height from one finer post to the next.
fn coarsen(window: &FinerWindow, rise: f64) -> PageBuffer {
    let WindowFootprint { own_x, own_y, .. } = &window.footprint;
    let (width, height) = (own_x.len() as u32, own_y.len() as u32);
    let (heights, colours) = means_with_apron(window);
    let relief = reliefs(window, &heights, rise);
    let (low, high) = window.bounds();
    PageBuffer {
        width,
        height,
        // Negated in wrapping arithmetic, the least code is the greatest, and the empty one, 0, still
        // loses against every other.
        low: extremes(window, low, &heights, u16::wrapping_neg),
        high: extremes(window, high, &heights, |code| code),
        heights,
        colours,
        relief,
        attributes: majorities(window),
        spans: SpanTable::default(),
    }
}

/// Mean heights and colours of the page's voxels and apron.
fn means_with_apron(window: &FinerWindow) -> (Vec<u16>, Vec<[u8; 3]>) {
    let WindowFootprint { own_x, own_y, coarse_x, coarse_y, finer_x, .. } = &window.footprint;
    let averager = Averager::new();
    let mut means = Vec::with_capacity(coarse_x.len() * coarse_y.len());
    for y in coarse_y.clone() {
        let heights = window.rows(&window.heights, y, 0);
        let colours = window.rows(&window.colours, y, 0);
        for x in coarse_x.clone() {
            if let Some((own, at)) = window.own_at(x, y, APRON) {
                means.push((own.heights[at], own.colours[at]));
                continue;
            }
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
    let WindowFootprint { own_x, own_y, coarse_x, coarse_y, finer_x, finer_y, .. } = &window.footprint;
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
            if let Some((own, at)) = window.own_at(x, y, RELIEF_APRON) {
                reliefs.push(own.relief.get(at).copied().unwrap_or_default());
                continue;
            }

            let mut moments = Moments::new(0.5 * rise);
            let posts = FinerWindow::span(x, 0, finer_x);
            for row in FinerWindow::span(y, 0, finer_y) {
                let posts = row * window.width + posts.start..row * window.width + posts.end;
                // Where there is no surface there are no slopes.
                let codes = window.heights[posts.clone()].iter();
                moments.count(codes.filter(|code| **code != HeightCode::EMPTY).count());
                steps[posts].iter().for_each(|steps| moments.add(*steps));
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

/// The code of the greatest `key`, which is its own inverse, over each of the page's voxels: of a plane of the finer ones and the
/// ring around them, and, near what is absent, of the page's own `heights` (with apron).
fn extremes(window: &FinerWindow, plane: &[u16], heights: &[u16], key: impl Fn(u16) -> u16) -> Vec<u16> {
    let mut extremes = dilated_extremes(window, plane, &key);
    if !window.is_whole() {
        let WindowFootprint { own_x, own_y, coarse_x, coarse_y, .. } = &window.footprint;
        let stride = own_x.len() + 2 * APRON as usize;
        let around =
            |at: u32, coarse: &Range<u32>| at.saturating_sub(1).max(coarse.start)..(at + 2).min(coarse.end);
        let place = |at: u32, own: &Range<u32>| (at + APRON - own.start) as usize;
        let voxels = own_y.clone().flat_map(|y| own_x.clone().map(move |x| (x, y)));

        for ((x, y), extreme) in voxels.zip(&mut extremes) {
            let (columns, rows) = (around(x, coarse_x), around(y, coarse_y));
            let is_absent = |y: u32| columns.clone().any(|x| !window.is_stored(x, y));
            if !rows.clone().any(is_absent) {
                continue;
            }
            for y in rows {
                let row = place(y, own_y) * stride;
                let codes = &heights[row + place(columns.start, own_x)..row + place(columns.end, own_x)];
                codes.iter().for_each(|&code| *extreme = key(code).max(*extreme));
            }
        }
    }

    extremes.into_iter().map(key).collect()
}

/// The greatest `key` of a plane over each of the page's voxels and the ring of finer ones around it.
fn dilated_extremes(window: &FinerWindow, plane: &[u16], key: impl Fn(u16) -> u16) -> Vec<u16> {
    let WindowFootprint { own_x, own_y, finer_x, .. } = &window.footprint;
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
    let WindowFootprint { own_x, own_y, finer_x, .. } = &window.footprint;
    let first = window.attributes[0];
    if window.is_whole() && window.attributes.iter().all(|attributes| *attributes == first) {
        return vec![first; own_x.len() * own_y.len()];
    }

    let mut result = Vec::with_capacity(own_x.len() * own_y.len());
    let mut finer = Vec::with_capacity((RADIX * RADIX) as usize);
    for y in own_y.clone() {
        for x in own_x.clone() {
            if let Some((own, at)) = window.own_at(x, y, 0) {
                result.push(own.attributes[at]);
                continue;
            }
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
