//! Radiance where sixteen pixels look, filtered over their footprints.

use glam::DVec2;

use super::RadiancePages;
use super::page::{BRIGHTEST, CODE_LIMIT};
use crate::error::Result;
use crate::simd::{Floats, Ints, LANES, Mask, Simd};
use crate::voxel::{Grid, PAGE_SIDE, PageId, PageSource};

/// Images per level: full and half resolution.
const IMAGES: i32 = 2;

/// Part of the way between two images over which they are blended; the rest belongs to the nearer one alone.
const BLEND: f32 = 0.6;

/// Most images: sixteen levels.
const MOST_IMAGES: usize = 32;

/// Where an image's texels lie, seen from the eye.
#[derive(Debug, Clone, Copy, Default)]
struct Frame {
    /// Texels per unit.
    per_unit: f32,
    /// Texels along a whole page.
    side: f32,
    /// The eye's position in the page that holds it, texels from its first one's centre.
    eye: [f32; 2],
    /// That page; may lie outside the area.
    page: [i64; 2],
}

/// Samples radiance for an eye.
pub struct Sampler<'a, S: PageSource> {
    pages: RadiancePages<'a, S>,
    frames: [Frame; MOST_IMAGES],
    coarsest: i32,
    grid: Grid,
}

impl<'a, S: PageSource> Sampler<'a, S> {
    /// For an eye at `eye`, units.
    pub fn new(pages: RadiancePages<'a, S>, eye: DVec2) -> Self {
        let header = pages.source().header();
        let coarsest = (i32::from(header.level_count) * IMAGES - 1).min(MOST_IMAGES as i32 - 1);
        let mut frames = [Frame::default(); MOST_IMAGES];
        for (index, frame) in frames.iter_mut().enumerate().take(coarsest as usize + 1) {
            let texel = f64::from(Grid::side_units(index as u8 / IMAGES as u8)) * f64::from(1 << (index % 2));
            let side = f64::from(PAGE_SIDE >> (index % 2));
            let texels = eye / texel - 0.5;
            let page = (texels / side).floor();
            let within = texels - page * side;
            *frame = Frame {
                per_unit: (1.0 / texel) as f32,
                side: side as f32,
                eye: [within.x as f32, within.y as f32],
                page: [page.x as i64, page.y as i64],
            };
        }
        Self { pages, frames, coarsest, grid: header.grid }
    }

    /// Linear radiance of `wanted` lanes at `east` and `north` of the eye (units) over footprints whose
    /// log₂ in units is `detail`.
    #[inline(always)]
    pub fn sample<V: Simd>(
        &mut self,
        simd: V,
        [east, north]: [V::F; 2],
        detail: V::F,
        wanted: V::M,
    ) -> Result<[V::F; 3]> {
        let detail = detail.max(simd.splat(0.0)).min(simd.splat(self.coarsest as f32));
        let fine = detail.floor();
        let share = (detail - fine - simd.splat(0.5)).mul_add(simd.splat(1.0 / BLEND), simd.splat(0.5));
        let share = share.max(simd.splat(0.0)).min(simd.splat(1.0));
        let image = fine.to_int();
        let next = (image + simd.splat_int(1)).min(simd.splat_int(self.coarsest));
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let needs_fine = wanted & share.lt(one);
        let needs_next = wanted & zero.lt(share);
        let mut sum = [zero; 3];
        if needs_fine.any() {
            let colour = self.image(simd, [east, north], image, needs_fine)?;
            sum = colour.map(|channel| channel * (one - share));
        }
        if needs_next.any() {
            let colour = self.image(simd, [east, north], next, needs_next)?;
            for channel in 0..3 {
                sum[channel] = colour[channel].mul_add(share, sum[channel]);
            }
        }
        Ok(sum)
    }

    /// Bilinear in one image per lane; zero in lanes that are not wanted.
    #[inline(always)]
    fn image<V: Simd>(
        &mut self,
        simd: V,
        [east, north]: [V::F; 2],
        mut image: V::I,
        wanted: V::M,
    ) -> Result<[V::F; 3]> {
        let mut sum = [simd.splat(0.0); 3];
        let mut left = wanted;
        // Usually all lanes look into the same page.
        while left.any() {
            let lane = left.bits().trailing_zeros() as usize;
            let index = of_lane(image, lane);
            let frame = self.frames[index as usize % MOST_IMAGES];
            let per_unit = simd.splat(frame.per_unit);
            let x = east.mul_add(per_unit, simd.splat(frame.eye[0]));
            let y = north.mul_add(per_unit, simd.splat(frame.eye[1]));
            let per_page = simd.splat(1.0 / frame.side);
            let (px, py) = ((x * per_page).floor().to_int(), (y * per_page).floor().to_int());
            let page = [of_lane(px, lane), of_lane(py, lane)];
            let here = left
                & image.eq(simd.splat_int(index))
                & px.eq(simd.splat_int(page[0]))
                & py.eq(simd.splat_int(page[1]));
            let level = (index / IMAGES) as u8;
            let (id, shift) =
                self.page_at(level, [0, 1].map(|axis| frame.page[axis] + i64::from(page[axis])));
            match self.pages.get(id)? {
                Some(found) => {
                    let texels = &found.images[(index % IMAGES) as usize];
                    let place = |position: V::F, axis: usize| {
                        let first = (page[axis] - shift[axis]) as f32 * frame.side;
                        let limit = texels.size[axis] as f32 - 0.5;
                        (position - simd.splat(first)).max(simd.splat(-0.5)).min(simd.splat(limit))
                    };
                    let colour = bilinear(simd, &texels.texels, texels.size[0] + 2, place(x, 0), place(y, 1));
                    sum = [0, 1, 2].map(|channel| colour[channel].select(here, sum[channel]));
                    left = left & !here;
                }
                None if index + IMAGES <= self.coarsest => {
                    image = (image + simd.splat_int(IMAGES)).select(here, image);
                }
                None => left = left & !here,
            }
        }
        Ok(sum)
    }

    /// The page at a place (clamped into the area), and how many pages from there it lies.
    fn page_at(&self, level: u8, page: [i64; 2]) -> (PageId, [i32; 2]) {
        let dims = self.grid.page_dims(level);
        let inside = [page[0].clamp(0, i64::from(dims.0) - 1), page[1].clamp(0, i64::from(dims.1) - 1)];
        let shift = [0, 1].map(|axis| (page[axis] - inside[axis]) as i32);
        (PageId { level, px: inside[0] as u32, py: inside[1] as u32 }, shift)
    }
}

#[inline(always)]
fn of_lane<I: Ints>(lanes: I, lane: usize) -> i32 {
    let mut all = [0; LANES];
    lanes.store(&mut all);
    all[lane]
}

/// Radiance between four texels of rows of `row` texels.
#[inline(always)]
fn bilinear<V: Simd>(simd: V, texels: &[u32], row: i32, x: V::F, y: V::F) -> [V::F; 3] {
    let (west, south) = (x.floor(), y.floor());
    let (u, v) = (x - west, y - south);
    let index =
        (south.to_int() + simd.splat_int(1)).mul(simd.splat_int(row)) + west.to_int() + simd.splat_int(1);
    let (sw, se) = simd.gather_word_pairs(texels, index);
    let (nw, ne) = simd.gather_word_pairs(texels, index + simd.splat_int(row));
    let mask = simd.splat_int(0x3ff);
    let scale = simd.splat(BRIGHTEST / (CODE_LIMIT * CODE_LIMIT));
    let channel = |part: fn(V::I) -> V::I| {
        let light = |texel: V::I| {
            let root = (part(texel) & mask).to_float();
            root * root
        };
        let (sw, se, nw, ne) = (light(sw), light(se), light(nw), light(ne));
        let south = (se - sw).mul_add(u, sw);
        let north = (ne - nw).mul_add(u, nw);
        (north - south).mul_add(v, south) * scale
    };
    [channel(|texel| texel), channel(|texel| texel.shr::<10>()), channel(|texel| texel.shr::<20>())]
}
