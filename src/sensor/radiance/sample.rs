//! Radiance along lines, where sixteen planes cross them.

use std::sync::Arc;

use super::RadiancePages;
use super::cache::LineStrip;
use super::facing::{Facing, STEEPER};
use super::lines::{LineFilter, LineImage, NO_WALL};
use super::texels::{
    Deviations, clipped, code_between, codes_near, over_ground, over_walls, radiance, words, words_near,
};
use crate::simd::{Each, Floats, LANES, Simd};
use crate::voxel::{BARE, Grid, PAGE_SIDE, PageId};
use hedgehop_base::error::Result;

/// Most pages that lie side by side under sixteen planes.
const MOST_PAGES: usize = 4;

/// Spans: 1, 2 and 4 lines.
const SPANS: usize = 3;

/// Footprints across, in voxels, from which texels of two and of four are used.
const WIDER: [f64; 2] = [1.42, 2.84];

/// Begin of registers that do not hold all texels.
const FAR: u32 = u32::MAX;

/// Texels under sixteen planes up to which two registers hold them, what rounding takes on either side, and a neighbour.
const NARROW: f64 = 2.0 * LANES as f64 - 5.0;

/// Sixteen planes, from above.
#[derive(Debug, Clone, Copy)]
pub struct PlanesAbove {
    /// 0: they run along x, 1: along y.
    pub major: usize,
    /// Up that axis.
    pub forward: bool,
    /// Height of the eye above the ground about, units of major distance.
    pub height: f64,
    /// The eye across them, units.
    pub eye: f64,
    /// Units across per unit of major distance.
    pub minor: [f32; LANES],
    /// Width of a pixel's footprint per unit of major distance, units.
    pub pixel: f64,
}

/// A line to look at.
#[derive(Debug, Clone, Copy)]
pub struct ImageLine {
    /// Level index.
    pub level: u8,
    /// Index of the line at the level.
    pub index: i64,
    /// Lines that its colour stands for: 1, 2 or 4.
    pub span: u8,
    /// Major distance, units.
    pub distance: f32,
}

/// Looks lines up.
pub struct LineSampler<'a> {
    pages: RadiancePages<'a>,
    grid: Grid,
    level_count: u8,
}

/// Lines where planes cross them.
pub struct Crossings<'s, 'a, V: Simd> {
    simd: V,
    minor: V::F,
    search: ImageSearch<'s, 'a>,
    runs: Vec<TexelRun>,
    /// Index of the run that was used last, by log₂ of its span: where slopes change, so do spans from line to line.
    latest: [usize; SPANS],
}

/// Position of a line's texels.
#[derive(Debug, Clone, Copy, Default)]
pub struct TexelPlace {
    /// Index of the run; beyond the last one: black.
    run: u32,
    /// Line within the images.
    within: u32,
    /// Begin of two registers that hold all texels; [`FAR`] if they do not.
    start: u32,
    /// Begin of the line from there.
    origin: i32,
    distance: f32,
}

/// Search of the images under planes.
struct ImageSearch<'s, 'a> {
    sampler: &'s mut LineSampler<'a>,
    major: usize,
    forward: bool,
    height: f64,
    eye: f64,
    /// `minor` of the outermost planes, the lesser first.
    ends: [f64; 2],
    pixel: f64,
}

/// Images side by side, where they are, and which lines they serve.
struct TexelRun {
    level: u8,
    /// The first of the lines, and how many there are.
    first_line: i64,
    lines: u64,
    /// Major distances between which these images serve, units.
    from: f32,
    to: f32,
    /// Major distance up to which two registers hold the texels under all planes; 0 if there are several images.
    narrow_to: f32,
    /// log₂ of the span.
    span: u32,
    /// Texels per unit; the eye, in texels of the first image.
    per_unit: f32,
    eye: f32,
    /// Texels from the eye to the lesser end per unit of major distance, and the last texel at which two registers
    /// begin.
    low: f32,
    last: f32,
    /// Texels from the start of an image to the next one's.
    side: f32,
    images: [Option<Arc<LineImage>>; MOST_PAGES],
    /// Whether texels have detail below the voxel, and whether some of it lies over walls.
    has_detail: bool,
    has_walls: bool,
}

impl<'a> LineSampler<'a> {
    /// Over pages.
    pub fn new(pages: RadiancePages<'a>) -> Self {
        let header = pages.source().header();
        Self { grid: header.grid, level_count: header.level_count, pages }
    }

    /// Takes the pages that were missing, as [`RadiancePages::take_missing`] does.
    pub fn take_missing(&mut self) -> Vec<PageId> {
        self.pages.take_missing()
    }

    /// Finds where planes cross lines.
    #[inline(always)]
    pub fn under<V: Simd>(&mut self, simd: V, planes: &PlanesAbove) -> Crossings<'_, 'a, V> {
        let ends = planes.minor.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &minor| {
            [low.min(f64::from(minor)), high.max(f64::from(minor))]
        });
        let PlanesAbove { major, forward, height, eye, pixel, .. } = *planes;
        Crossings {
            simd,
            minor: simd.load(&planes.minor),
            search: ImageSearch { sampler: self, major, forward, height, eye, ends, pixel },
            runs: Vec::new(),
            latest: [usize::MAX; SPANS],
        }
    }
}

impl<V: Simd> Crossings<'_, '_, V> {
    /// Finds a line, and has the processor fetch it while it does other work. Where a page is absent it is the next
    /// coarser level's.
    ///
    /// # Errors
    /// A page that is damaged.
    #[inline(always)]
    pub fn seek(&mut self, line: ImageLine) -> Result<TexelPlace> {
        let mut line = line;
        loop {
            if let Some(run) = self.runs.get(self.latest[slot(line.span)])
                && run.serves(&line)
            {
                return Ok(self.place(self.latest[slot(line.span)], run, &line));
            }

            match self.search.run(&line)? {
                Some(run) => {
                    let index = self.runs.len();
                    self.latest[slot(line.span)] = index;
                    let place = self.place(index, &run, &line);
                    self.runs.push(run);
                    return Ok(place);
                }
                None if coarser(line.level) < self.search.sampler.level_count => {
                    line = ImageLine {
                        level: coarser(line.level),
                        index: line.index.div_euclid(4),
                        span: 1,
                        ..line
                    };
                }
                None => return Ok(TexelPlace { run: u32::MAX, ..TexelPlace::default() }),
            }
        }
    }

    /// Finds the line `step` (1 or −1) lines after one that is at a place, where the same images hold both and registers their texels; `None`: it is to be
    /// [sought](Self::seek).
    #[inline(always)]
    pub fn beside(&self, place: &TexelPlace, line: &ImageLine, step: i64) -> Option<TexelPlace> {
        let run = self.runs.get(place.run as usize).filter(|run| run.span == 0 && place.start != FAR)?;
        let image = run.images[0].as_ref()?;
        let here = line.index - run.first_line;
        let within = here + step;
        // Beside what stands in for a line lies none of those beside it.
        let is_own = run.level == line.level && here == i64::from(place.within);
        let [begin, beside] = [here, within].each(|line| image.start_of(line as usize) as i64);
        let start = i64::from(place.start) + beside - begin;
        let last = image.texels.len() as i64 - 2 * LANES as i64;
        let is_there = is_own && (0..run.lines as i64).contains(&within) && (0..=last).contains(&start);
        is_there.then_some(TexelPlace { within: within as u32, start: start as u32, ..*place })
    }

    #[inline(always)]
    fn place(&self, index: usize, run: &TexelRun, line: &ImageLine) -> TexelPlace {
        // A line before the area is lit as its first one.
        let within = line.index.saturating_sub(run.first_line).max(0) as usize >> run.span;
        let mut place = TexelPlace {
            run: index as u32,
            within: within as u32,
            start: FAR,
            origin: 0,
            distance: line.distance,
        };

        let [first, beside @ ..] = &run.images;
        if let Some(image) = first {
            let row = image.start_of(within);
            let start = row + run.start(line.distance);
            for texel in [0, LANES, 2 * LANES - 1] {
                self.simd.prefetch(&image.texels, start + texel);
            }
            if run.has_detail {
                self.simd.prefetch(&image.deviations, start);
                self.simd.prefetch(&image.deviations, start + 2 * LANES - 1);
                if run.has_walls {
                    self.simd.prefetch(&image.walls, start);
                }
            }
            if line.distance <= run.narrow_to {
                let start = start.min(image.texels.len().saturating_sub(2 * LANES));
                (place.start, place.origin) = (start as u32, row as i32 - start as i32);
            }
        }
        for image in beside.iter().map_while(Option::as_ref) {
            let row = image.start_of(within);
            for texel in [0, LANES] {
                self.simd.prefetch(&image.texels, row + texel);
            }
        }

        place
    }

    /// Radiance where the planes cross a line, in [`UNITS`](crate::pixels::UNITS).
    #[inline(always)]
    pub fn sample(&self, place: &TexelPlace) -> [V::F; 3] {
        self.sample_at(place, self.simd.splat(place.distance))
    }

    /// Whether a line's texels have detail below the voxel.
    #[inline(always)]
    pub fn has_detail(&self, place: &TexelPlace) -> bool {
        self.runs.get(place.run as usize).is_some_and(|run| run.has_detail)
    }

    /// The run of a place, and places of the planes among its texels.
    #[inline(always)]
    fn texels(&self, place: &TexelPlace, distance: V::F) -> Option<(&TexelRun, V::F)> {
        let run = self.runs.get(place.run as usize)?;
        let simd = self.simd;
        Some((run, self.minor.mul_add(distance * simd.splat(run.per_unit), simd.splat(run.eye))))
    }

    /// Radiance of a line beside which planes are at major distances, a voxel from the line's at most.
    #[inline(always)]
    pub fn sample_at(&self, place: &TexelPlace, distance: V::F) -> [V::F; 3] {
        let simd = self.simd;
        let Some((run, at)) = self.texels(place, distance) else { return [simd.splat(0.0); 3] };
        match run.near(place) {
            Some((near, limit)) => {
                radiance(simd, words_near(simd, near, clipped(simd, at, limit), place.origin))
            }
            None => run.wide(simd, at, place.within as usize),
        }
    }

    /// The same radiance, and its relative deviations below the voxel, of a line that has detail.
    #[inline(always)]
    pub fn sample_detail_at(&self, place: &TexelPlace, distance: V::F) -> ([V::F; 3], Deviations<V>) {
        let simd = self.simd;
        let mut deviations = Deviations::none(simd);
        let Some((run, at)) = self.texels(place, distance) else {
            return ([simd.splat(0.0); 3], deviations);
        };
        let Some((near, limit)) = run.near(place) else {
            let within = place.within as usize;
            deviations.ground = run.wide_deviation::<V, false>(simd, at, within);
            deviations.has_walls = run.has_walls;
            if run.has_walls {
                deviations.wall = run.wide_deviation::<V, true>(simd, at, within);
            }
            return (run.wide(simd, at, within), deviations);
        };

        let at = clipped(simd, at, limit);
        if let Some(codes) = run.near_codes::<false>(place) {
            deviations.ground = over_ground(simd, codes_near(simd, codes, at, place.origin));
        }
        if run.has_walls
            && let Some(codes) = run.near_codes::<true>(place)
            && codes != &[NO_WALL; 2 * LANES]
        {
            deviations.has_walls = true;
            deviations.wall = over_walls(simd, codes_near(simd, codes, at, place.origin));
        }
        (radiance(simd, words_near(simd, near, at, place.origin)), deviations)
    }
}

impl TexelRun {
    #[inline(always)]
    fn serves(&self, line: &ImageLine) -> bool {
        self.level == line.level
            && (line.index.wrapping_sub(self.first_line) as u64) < self.lines
            && self.from <= line.distance
            && line.distance < self.to
    }

    /// Texels from a line's begin to no more than the least under the planes.
    #[inline(always)]
    fn start(&self, distance: f32) -> usize {
        // The first texel is at place −1: what is cut off here leaves the one to spare.
        (distance * self.low + self.eye).max(0.0).min(self.last) as u32 as usize
    }

    /// Texels under all planes, if two registers hold them, and those of the line.
    #[inline(always)]
    fn near(&self, place: &TexelPlace) -> Option<(&[u32; 2 * LANES], usize)> {
        let image = self.images[0].as_ref().filter(|_| place.start != FAR)?;
        Some((image.texels.get(place.start as usize..)?.first_chunk()?, image.row))
    }

    /// Codes of deviations under all planes, where [`Self::near`] has their texels: over the ground, or over `WALLS`.
    #[inline(always)]
    fn near_codes<const WALLS: bool>(&self, place: &TexelPlace) -> Option<&[u16; 2 * LANES]> {
        let image = self.images[0].as_ref()?;
        let codes = if WALLS { &image.walls } else { &image.deviations };
        codes.get(place.start as usize..)?.first_chunk()
    }

    /// Reads colours where planes lie over several images, or far apart.
    #[inline(always)]
    fn wide<V: Simd>(&self, simd: V, at: V::F, within: usize) -> [V::F; 3] {
        let mut colour = [simd.splat(0.0); 3];
        for (part, image) in self.images.iter().flatten().enumerate() {
            let start = simd.splat(part as f32 * self.side);
            let row = &image.texels[image.start_of(within)..][..image.row];
            let here = radiance(simd, words(simd, row, clipped(simd, at - start, image.row)));
            if part == 0 {
                colour = here;
            } else {
                let later = (start - simd.splat(0.5)).le(at);
                for (channel, colour) in colour.iter_mut().enumerate() {
                    let here = here[channel];
                    *colour = here.select(later, *colour);
                }
            }
        }
        colour
    }

    /// Reads deviations in the same places: over the ground, or over `WALLS`.
    #[inline(always)]
    fn wide_deviation<V: Simd, const WALLS: bool>(&self, simd: V, at: V::F, within: usize) -> V::F {
        let mut found = simd.splat(0.0);
        for (part, image) in self.images.iter().flatten().enumerate() {
            let start = simd.splat(part as f32 * self.side);
            let codes = if WALLS { &image.walls } else { &image.deviations };
            let row = codes.get(image.start_of(within)..).unwrap_or_default();
            let mut here = simd.splat(0.0);
            if row.len() > 1 {
                let place = clipped(simd, at - start, image.row);
                let floor = place.floor();
                let pairs = simd.gather_pairs(row, floor.to_int() + simd.splat_int(1));
                let code = code_between(simd, pairs, place - floor);
                here = if WALLS { over_walls(simd, code) } else { over_ground(simd, code) };
            }
            let later = (start - simd.splat(0.5)).le(at);
            found = if part == 0 { here } else { here.select(later, found) };
        }
        found
    }
}

impl ImageSearch<'_, '_> {
    /// Images for a line and those near it; `None` if one is absent.
    #[inline(never)]
    fn run(&mut self, line: &ImageLine) -> Result<Option<TexelRun>> {
        let (level, distance) = (line.level, f64::from(line.distance));
        let voxel = f64::from(Grid::side_units(level));

        // Where a footprint is so wide that the next texels serve.
        let wider = WIDER.each(|voxels| voxels * voxel / self.pixel);
        let shift = wider.iter().filter(|&&from| from <= distance).count();
        let mut near = if shift > 0 { wider[shift - 1] } else { 0.0 };
        let mut far = wider.get(shift).copied().unwrap_or(f64::INFINITY);

        // And where the eye looks down at another incline.
        let inclines = STEEPER.each(|steeper| self.height / steeper);
        let incline = inclines.iter().filter(|&&until| distance < until).count();
        near = inclines.iter().filter(|&&until| distance >= until).fold(near, |near, &until| near.max(until));
        far = inclines.iter().filter(|&&until| distance < until).fold(far, |far, &until| far.min(until));
        let facing = Facing { major: self.major as u8, forward: self.forward, incline: incline as u8 };
        let mut filter = LineFilter { facing, shift: shift as u8, span: line.span };
        if filter.shows_posts(level) {
            filter.facing = Facing::down(facing.major);
        }

        // And where an outermost plane crosses to the next page.
        let side = voxel * f64::from(PAGE_SIDE);
        let pages = self.ends.each(|end| {
            let page = ((self.eye + end * distance) / side).floor();
            let edges = [page, page + 1.0].each(|edge| (edge * side - self.eye) / end);
            near = near.max(edges[0].min(edges[1]));
            far = far.min(edges[0].max(edges[1]));
            page as i64
        });

        let dims = self.sampler.grid.page_dims(level);
        let dims = [i64::from(dims.0), i64::from(dims.1)];
        let along = line.index.div_euclid(i64::from(PAGE_SIDE)).clamp(0, dims[self.major] - 1);
        let first_line = along * i64::from(PAGE_SIDE);
        let post = (line.index - first_line).clamp(0, i64::from(PAGE_SIDE) - 1) as u32;
        let [first, last] = pages.each(|page| page.clamp(0, dims[1 - self.major] - 1));
        let strip = LineStrip::with(PageId { level, px: 0, py: 0 }, filter, post);
        let mut images = [const { None }; MOST_PAGES];

        for part in 0..=(last - first).min(MOST_PAGES as i64 - 1) {
            let (px, py) = if self.major == 0 { (along, first + part) } else { (first + part, along) };
            let id = self.sampler.pages.source().ground_of(PageId { level, px: px as u32, py: py as u32 });
            let Some(image) = self.sampler.pages.lines(LineStrip { page: id, ..strip })? else {
                return Ok(None);
            };
            images[part as usize] = Some(image);
        }

        let texel = voxel * f64::from(1 << shift);
        let texels = f64::from(PAGE_SIDE >> shift);
        let narrow = |image: &LineImage| last == first && image.texels.len() >= 2 * LANES;
        let is_narrow = images[0].as_deref().is_some_and(narrow);
        let row = images[0].as_ref().map_or(0, |image| image.row);
        let has_walls = images.iter().flatten().any(|image: &Arc<LineImage>| !image.walls.is_empty());

        Ok(Some(TexelRun {
            level,
            first_line: first_line + i64::from(strip.first()),
            lines: u64::from(strip.posts()),
            from: near as f32,
            to: far as f32,
            narrow_to: if is_narrow { (NARROW * texel / (self.ends[1] - self.ends[0])) as f32 } else { 0.0 },
            span: line.span.trailing_zeros(),
            per_unit: (1.0 / texel) as f32,
            eye: (self.eye / texel - 0.5 - first as f64 * texels) as f32,
            low: (self.ends[0] / texel) as f32,
            last: row.saturating_sub(3) as f32,
            side: texels as f32,
            images,
            has_detail: filter.has_detail(level),
            has_walls,
        }))
    }
}

/// The level that stands in for one of which a page is absent.
fn coarser(level: u8) -> u8 {
    if level == BARE { 1 } else { level + 1 }
}

/// Returns the slot in which the run of a span is kept.
#[inline(always)]
fn slot(span: u8) -> usize {
    (span.trailing_zeros() as usize).min(SPANS - 1)
}
