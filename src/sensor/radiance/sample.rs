//! Radiance where sixteen pixels look, filtered over their footprints.

use std::sync::Arc;

use glam::DVec2;

use super::page::{CODE_LIMIT, ROOT_OF_BRIGHTEST};
use super::{RadiancePage, RadiancePages};
use crate::error::Result;
use crate::simd::{Floats, Ints, LANES, Mask, Simd};
use crate::voxel::{Grid, PAGE_SIDE, PageId};

/// Images per level: full and half resolution.
const IMAGES: i32 = 2;

/// Most images: sixteen levels.
const MOST_IMAGES: usize = 32;

/// One image of the pyramid: how its texels lie seen from the eye, and the page of it that was used last.
#[derive(Debug, Clone, Default)]
struct Spot {
    /// Texels per unit.
    per_unit: f32,
    /// The eye, texels from the centre of the first texel of the page that it is over.
    eye: [f32; 2],
    /// That page, counted from the area's first; it may lie outside the area.
    home: [i64; 2],
    /// Texels along a whole page.
    side: f32,
    /// Between which texels, counted from `home`, `page` is the one to use; no pixel is, before the first.
    from: [f32; 2],
    to: [f32; 2],
    /// First texel of `page`, counted from `home`, and the least and greatest place in it: the area's edge goes
    /// on as its outermost texels.
    first: [f32; 2],
    least: [f32; 2],
    greatest: [f32; 2],
    /// `None`: absent.
    page: Option<Arc<RadiancePage>>,
}

/// Samples radiance for an eye.
pub struct Sampler<'a> {
    pages: RadiancePages<'a>,
    spots: [Spot; MOST_IMAGES],
    coarsest: i32,
    /// Image that was used last.
    current: i32,
    grid: Grid,
}

impl<'a> Sampler<'a> {
    /// For an eye at `eye`, units.
    pub fn new(pages: RadiancePages<'a>, eye: DVec2) -> Self {
        let header = pages.source().header();
        let coarsest = (i32::from(header.level_count) * IMAGES - 1).min(MOST_IMAGES as i32 - 1);
        let mut spots: [Spot; MOST_IMAGES] = Default::default();
        for (index, spot) in spots.iter_mut().enumerate().take(coarsest as usize + 1) {
            let texel = f64::from(Grid::side_units(index as u8 / IMAGES as u8)) * f64::from(1 << (index % 2));
            let side = f64::from(PAGE_SIDE >> (index % 2));
            let texels = eye / texel - 0.5;
            let home = (texels / side).floor();
            let within = texels - home * side;
            *spot = Spot {
                per_unit: (1.0 / texel) as f32,
                side: side as f32,
                eye: [within.x as f32, within.y as f32],
                home: [home.x as i64, home.y as i64],
                ..Spot::default()
            };
        }
        Self { pages, spots, coarsest, current: 0, grid: header.grid }
    }

    /// Linear radiance of `wanted` lanes at `east` and `north` of the eye (units) over footprints whose
    /// log₂ in units is `detail`: bilinear in the image that is nearest to it. Zero in other lanes.
    #[inline(always)]
    pub fn sample<V: Simd>(
        &mut self,
        simd: V,
        place: [V::F; 2],
        detail: V::F,
        wanted: V::M,
    ) -> Result<[V::F; 3]> {
        let nearest = (detail + simd.splat(0.5)).max(simd.splat(0.0)).to_int();
        self.image(simd, place, nearest.min(simd.splat_int(self.coarsest)), wanted)
    }

    /// Bilinear in one image per lane; zero in lanes that are not wanted.
    #[inline(always)]
    fn image<V: Simd>(
        &mut self,
        simd: V,
        [east, north]: [V::F; 2],
        image: V::I,
        wanted: V::M,
    ) -> Result<[V::F; 3]> {
        let mut image = image;
        let mut sum = [simd.splat(0.0); 3];
        let mut left = wanted;
        // Usually all lanes look into the page that was used last.
        loop {
            let current = self.current;
            let spot = &self.spots[current as usize % MOST_IMAGES];
            let per_unit = simd.splat(spot.per_unit);
            let x = east.mul_add(per_unit, simd.splat(spot.eye[0]));
            let y = north.mul_add(per_unit, simd.splat(spot.eye[1]));
            let across = simd.splat(spot.from[0]).le(x) & x.lt(simd.splat(spot.to[0]));
            let along = simd.splat(spot.from[1]).le(y) & y.lt(simd.splat(spot.to[1]));
            let here = left & image.eq(simd.splat_int(current)) & across & along;
            match &spot.page {
                Some(page) => {
                    let texels = &page.images[(current % IMAGES) as usize];
                    let x = (x - simd.splat(spot.first[0])).max(simd.splat(spot.least[0]));
                    let y = (y - simd.splat(spot.first[1])).max(simd.splat(spot.least[1]));
                    let x = x.min(simd.splat(spot.greatest[0]));
                    let y = y.min(simd.splat(spot.greatest[1]));
                    let colour = bilinear(simd, &texels.texels, texels.size[0] + 2, x, y);
                    for channel in 0..3 {
                        sum[channel] = colour[channel].select(here, sum[channel]);
                    }
                    left = left & !here;
                }
                None if current + IMAGES <= self.coarsest => {
                    image = (image + simd.splat_int(IMAGES)).select(here, image);
                }
                None => left = left & !here,
            }
            if !left.any() {
                return Ok(sum);
            }
            let lane = left.bits().trailing_zeros() as usize;
            let mut images = [0; LANES];
            image.store(&mut images);
            self.current = images[lane];
            if images[lane] == current {
                let mut places = [[0.0; LANES]; 2];
                east.store(&mut places[0]);
                north.store(&mut places[1]);
                self.turn_to(current, [places[0][lane], places[1][lane]])?;
            }
        }
    }

    /// Makes the page of an image at a place (units from the eye) the one that is used.
    #[inline(never)]
    fn turn_to(&mut self, image: i32, place: [f32; 2]) -> Result<()> {
        let level = (image / IMAGES) as u8;
        let dims = self.grid.page_dims(level);
        let last = [i64::from(dims.0) - 1, i64::from(dims.1) - 1];
        let spot = &mut self.spots[image as usize % MOST_IMAGES];
        let mut page = [0; 2];
        for axis in 0..2 {
            let texel = place[axis].mul_add(spot.per_unit, spot.eye[axis]);
            let at = spot.home[axis] + (texel / spot.side).floor() as i64;
            page[axis] = at.clamp(0, last[axis]);
            let first = (page[axis] - spot.home[axis]) as f32 * spot.side;
            spot.first[axis] = first;
            // What lies beyond the area's edge belongs to the outermost pages.
            spot.from[axis] = if page[axis] == 0 { f32::NEG_INFINITY } else { first };
            spot.to[axis] = if page[axis] == last[axis] { f32::INFINITY } else { first + spot.side };
            // Rounding may put a place on the border into the other page.
            spot.from[axis] = spot.from[axis].min(texel);
            spot.to[axis] = spot.to[axis].max(texel.next_up());
        }
        spot.page = self.pages.get(PageId { level, px: page[0] as u32, py: page[1] as u32 })?;
        if let Some(found) = &spot.page {
            let size = found.images[(image % IMAGES) as usize].size;
            for axis in 0..2 {
                spot.least[axis] = if page[axis] == 0 { 0.0 } else { -0.5 };
                spot.greatest[axis] = (size[axis] - i32::from(page[axis] == last[axis])) as f32;
            }
        }
        Ok(())
    }
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
    let (low, scale) = (simd.splat_int(0x3ff), simd.splat(ROOT_OF_BRIGHTEST / CODE_LIMIT));
    let red = between::<V>([sw & low, se & low, nw & low, ne & low], u, v);
    let green = between::<V>(
        [sw.shr::<10>() & low, se.shr::<10>() & low, nw.shr::<10>() & low, ne.shr::<10>() & low],
        u,
        v,
    );
    let blue = between::<V>([sw.shr::<20>(), se.shr::<20>(), nw.shr::<20>(), ne.shr::<20>()], u, v);
    let (red, green, blue) = (red * scale, green * scale, blue * scale);
    [red * red, green * green, blue * blue]
}

/// Bilinear between four codes.
#[inline(always)]
fn between<V: Simd>([sw, se, nw, ne]: [V::I; 4], u: V::F, v: V::F) -> V::F {
    let (sw, se, nw, ne) = (sw.to_float(), se.to_float(), nw.to_float(), ne.to_float());
    let south = (se - sw).mul_add(u, sw);
    let north = (ne - nw).mul_add(u, nw);
    (north - south).mul_add(v, south)
}
