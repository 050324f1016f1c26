//! Radiance along lines, where sixteen planes cross them.

use std::sync::Arc;

use super::RadiancePages;
use super::lines::{LineImage, Weave};
use super::page::{CODE_LIMIT, ROOT_OF_BRIGHTEST};
use crate::error::Result;
use crate::simd::{Floats, Ints, Simd};
use crate::voxel::{Grid, PAGE_SIDE, PageId};

/// Most pages that lie side by side under sixteen planes.
const MOST_PAGES: usize = 4;

/// Spans: 1, 2 and 4 lines.
const SPANS: usize = 3;

/// Footprints across, in voxels, from which texels of two and of four are used.
const WIDER: [f32; 2] = [1.42, 2.84];

/// Sixteen planes, from above.
#[derive(Debug, Clone, Copy)]
pub struct Planes<V: Simd> {
    /// 0: they run along x, 1: along y.
    pub major: usize,
    /// The eye across them, units.
    pub eye: f64,
    /// Units across per unit of major distance.
    pub minor: V::F,
    /// The same of the outermost planes, the lesser first.
    pub ends: [f64; 2],
}

/// A line to look at.
#[derive(Debug, Clone, Copy)]
pub struct Line {
    /// Level index.
    pub level: u8,
    /// Index of the line at the level.
    pub index: i64,
    /// Lines that its colour stands for: 1, 2 or 4.
    pub span: u8,
    /// Major distance, units.
    pub distance: f32,
    /// Width of a pixel's footprint there, voxels of the level.
    pub footprint: f32,
}

/// Looks lines up; the images that were used last stay at hand.
pub struct LineSampler<'a> {
    pages: RadiancePages<'a>,
    grid: Grid,
    level_count: u8,
    /// By log₂ of their span: where slopes change, so do spans from line to line.
    runs: [Option<Run>; SPANS],
}

/// Images side by side, and where they are.
struct Run {
    level: u8,
    weave: Weave,
    /// Page along the major axis; first and last across it, which may lie beside the area.
    page: i64,
    pages: [i64; 2],
    /// Page of the first image.
    first: i64,
    images: [Option<Arc<LineImage>>; MOST_PAGES],
}

impl<'a> LineSampler<'a> {
    /// Over pages.
    pub fn new(pages: RadiancePages<'a>) -> Self {
        let header = pages.source().header();
        Self { grid: header.grid, level_count: header.level_count, pages, runs: [const { None }; SPANS] }
    }

    /// Linear radiance of a line where the planes cross it. Where a page is absent the next coarser level's, or black.
    ///
    /// # Errors
    /// A page that is damaged.
    #[inline(always)]
    pub fn sample<V: Simd>(&mut self, simd: V, planes: &Planes<V>, line: Line) -> Result<[V::F; 3]> {
        let mut line = line;
        while !self.find(planes.major, planes.eye, planes.ends, &line)? {
            if line.level + 1 >= self.level_count {
                return Ok([simd.splat(0.0); 3]);
            }
            line = Line {
                level: line.level + 1,
                index: line.index.div_euclid(4),
                span: 1,
                footprint: line.footprint * 0.25,
                ..line
            };
        }
        let Some(run) = &self.runs[slot(line.span)] else { return Ok([simd.splat(0.0); 3]) };
        let texel = f64::from(Grid::side_units(line.level)) * f64::from(1 << run.weave.shift);
        let side = i64::from(PAGE_SIDE >> run.weave.shift);
        let eye = planes.eye / texel - 0.5 - (run.first * side) as f64;
        let at = planes
            .minor
            .mul_add(simd.splat((f64::from(line.distance) / texel) as f32), simd.splat(eye as f32));
        let within =
            (line.index - run.page * i64::from(PAGE_SIDE)).max(0) as usize / usize::from(run.weave.span);
        let mut colour = [simd.splat(0.0); 3];
        for (part, image) in run.images.iter().flatten().enumerate() {
            let start = simd.splat((part as i64 * side) as f32);
            let row = &image.texels[(within * image.row).min(image.texels.len() - image.row)..][..image.row];
            // The area's edge goes on as its outermost texels.
            let place = (at - start).max(simd.splat(-1.0)).min(simd.splat(image.row as f32 - 2.001));
            let here = between(simd, row, place);
            if part == 0 {
                colour = here;
            } else {
                let later = (start - simd.splat(0.5)).le(at);
                for (colour, here) in colour.iter_mut().zip(here) {
                    *colour = here.select(later, *colour);
                }
            }
        }
        Ok(colour)
    }

    /// Has the processor fetch a line that is looked at soon, if it lies in the images at hand.
    #[inline(always)]
    pub fn prefetch<V: Simd>(&self, simd: V, planes: &Planes<V>, line: Line) {
        let Some(run) = &self.runs[slot(line.span)] else { return };
        let within = line.index - run.page * i64::from(PAGE_SIDE);
        if run.level != line.level || !(0..i64::from(PAGE_SIDE)).contains(&within) {
            return;
        }
        let Some(image) = &run.images[0] else { return };
        let texel = f64::from(Grid::side_units(line.level)) * f64::from(1 << run.weave.shift);
        let side = i64::from(PAGE_SIDE >> run.weave.shift);
        let start = within as usize / usize::from(line.span) * image.row;
        for end in planes.ends {
            let place = (planes.eye + end * f64::from(line.distance)) / texel - (run.first * side) as f64;
            simd.prefetch(&image.texels, start + place.clamp(0.0, image.row as f64) as usize);
        }
    }

    /// Has the images of a line at hand; `false` if one is absent.
    #[inline(always)]
    fn find(&mut self, major: usize, eye: f64, ends: [f64; 2], line: &Line) -> Result<bool> {
        let shift = u8::from(line.footprint >= WIDER[0]) + u8::from(line.footprint >= WIDER[1]);
        let weave = Weave { major: major as u8, shift, span: line.span };
        let side = f64::from(Grid::side_units(line.level)) * f64::from(PAGE_SIDE);
        let distance = f64::from(line.distance);
        let pages = ends.map(|end| ((eye + end * distance) / side).floor() as i64);
        let page = line.index.div_euclid(i64::from(PAGE_SIDE));
        if let Some(run) = &self.runs[slot(line.span)]
            && run.level == line.level
            && run.weave == weave
            && run.page == page
            && run.pages == pages
        {
            return Ok(true);
        }
        self.turn_to(line.level, weave, page, pages)
    }

    #[inline(never)]
    fn turn_to(&mut self, level: u8, weave: Weave, page: i64, pages: [i64; 2]) -> Result<bool> {
        let major = usize::from(weave.major);
        let dims = self.grid.page_dims(level);
        let dims = [i64::from(dims.0), i64::from(dims.1)];
        let along = page.clamp(0, dims[major] - 1);
        let [first, last] = pages.map(|page| page.clamp(0, dims[1 - major] - 1));
        let mut run = Run { level, weave, page, pages, first, images: [const { None }; MOST_PAGES] };
        for part in 0..=(last - first).min(MOST_PAGES as i64 - 1) {
            let (px, py) = if major == 0 { (along, first + part) } else { (first + part, along) };
            let id = PageId { level, px: px as u32, py: py as u32 };
            let Some(image) = self.pages.lines(id, weave)? else { return Ok(false) };
            run.images[part as usize] = Some(image);
        }
        self.runs[slot(weave.span)] = Some(run);
        Ok(true)
    }
}

/// Where the run of a span is kept.
#[inline(always)]
fn slot(span: u8) -> usize {
    (span.trailing_zeros() as usize).min(SPANS - 1)
}

/// Radiance between two texels of a line; place −1 is the first.
#[inline(always)]
fn between<V: Simd>(simd: V, row: &[u32], place: V::F) -> [V::F; 3] {
    let floor = place.floor();
    let share = place - floor;
    let (from, to) = simd.gather_word_pairs(row, floor.to_int() + simd.splat_int(1));
    let low = simd.splat_int(0x3ff);
    let red = mix(simd, from & low, to & low, share);
    let green = mix(simd, from.shr::<10>() & low, to.shr::<10>() & low, share);
    let blue = mix(simd, from.shr::<20>(), to.shr::<20>(), share);
    [red, green, blue]
}

/// Radiance between two codes, which are roots of it.
#[inline(always)]
fn mix<V: Simd>(simd: V, from: V::I, to: V::I, share: V::F) -> V::F {
    let scale = ROOT_OF_BRIGHTEST / CODE_LIMIT;
    let (from, to) = (from.to_float(), to.to_float());
    let from = from * from;
    to.mul_add(to, simd.splat(0.0) - from).mul_add(share, from) * simd.splat(scale * scale)
}
