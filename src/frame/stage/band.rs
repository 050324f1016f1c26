//! A band of rows of the screen.

use std::ops::Range;

use glam::Vec3;

use super::plane_image::{LookUp, PanoramaImage, PlaneSource, UprightImage};
use crate::raymarch::scan::PlaneArray;
use crate::simd::math::srgb8;
use crate::simd::{Floats, Ints, Isa, Kernel, LANES, Mask, Simd, Sixteen};
use hedgehop_base::colour::{linear_from_srgb8, linear_of_codes, srgb8_from_light};

/// Bytes of an 8-bit pixel.
const RGB: usize = 3;

/// Bytes along a row from what is written to what is fetched for it: rows lie too far apart for the processor to foresee.
const AHEAD: usize = 192;

/// Pixels of some rows, from the top.
pub struct Band<'b> {
    /// Light that is seen.
    pub light: Pixels<'b>,
    /// Range, metres, `[rows][width]`; infinite: sky. Empty if nobody asks.
    pub range: &'b mut [f32],
    /// Parts of rows, [`LANES`] pixels wide, whose range is asked for, `[rows][parts of a row]`; the others keep what they hold. Empty: of all.
    pub parts: &'b [bool],
    /// Whether there may be an outline in each pixel, where its range is asked for, `[rows][width]`. Empty if nobody asks.
    pub outlines: &'b mut [bool],
}

/// Pixels, by the form in which they hold light.
pub enum Pixels<'b> {
    /// 8-bit sRGB, `[rows][width][3]`.
    Srgb8(&'b mut [u8]),
    /// Linear Rec. 709 radiance, `[rows][width]`.
    Linear(&'b mut [[f32; 3]]),
}

impl Pixels<'_> {
    /// Light of one, counted from the first.
    pub fn light(&self, pixel: usize) -> Vec3 {
        match self {
            Self::Srgb8(bytes) => linear_from_srgb8(bytes.as_chunks::<RGB>().0[pixel]).into(),
            Self::Linear(colour) => colour[pixel].into(),
        }
    }

    /// Has one show other light.
    pub fn put(&mut self, pixel: usize, light: Vec3) {
        match self {
            Self::Srgb8(bytes) => {
                bytes.as_chunks_mut::<RGB>().0[pixel] = srgb8_from_light(light.to_array());
            }
            Self::Linear(colour) => colour[pixel] = light.to_array(),
        }
    }

    /// Counts the pixels.
    pub fn count(&self) -> usize {
        match self {
            Self::Srgb8(bytes) => bytes.len() / RGB,
            Self::Linear(colour) => colour.len(),
        }
    }

    /// Light of up to [`LANES`] that follow each other, by channel; lanes beyond them are of no particular value.
    #[inline(always)]
    pub fn load<V: Simd>(&self, simd: V, pixels: Range<usize>) -> [V::F; 3] {
        match self {
            Self::Srgb8(bytes) => {
                let mut all = [0; RGB * LANES];
                let own = &bytes[pixels.start * RGB..pixels.end * RGB];
                all[..own.len()].copy_from_slice(own);
                let (codes, byte) = (simd.load_triples(&all), simd.splat_int(255));
                let table = linear_of_codes();
                [
                    simd.gather(table, codes & byte),
                    simd.gather(table, codes.shr::<8>() & byte),
                    simd.gather(table, codes.shr::<16>() & byte),
                ]
            }
            Self::Linear(colour) => {
                let mut parts = [[0.0; LANES]; 3];
                for (lane, pixel) in colour[pixels].iter().enumerate() {
                    for (part, value) in parts.iter_mut().zip(pixel) {
                        part[lane] = *value;
                    }
                }
                [simd.load(&parts[0]), simd.load(&parts[1]), simd.load(&parts[2])]
            }
        }
    }

    /// Has up to [`LANES`] that follow each other show other light.
    #[inline(always)]
    pub fn store<V: Simd>(&mut self, simd: V, pixels: Range<usize>, light: [V::F; 3]) {
        match self {
            Self::Srgb8(bytes) => {
                put_rgb(simd, light, [1.0; 3], &mut bytes[pixels.start * RGB..pixels.end * RGB])
            }
            Self::Linear(colour) => put_light(simd, light, [1.0; 3], &mut colour[pixels]),
        }
    }
}

impl Band<'_> {
    /// Fills the band, whose first row is the screen's row `first`, with what `planes` saw.
    pub fn fill(self, isa: Isa, planes: PlaneSource<'_>, width: usize, first: usize) {
        isa.run(Filling { band: self, planes, width, first });
    }

    /// Whether ranges are asked for.
    pub fn has_range(&self) -> bool {
        !self.range.is_empty()
    }

    /// Whether the range of a part of a row is asked for, if any is.
    fn asks(&self, part: usize) -> bool {
        self.parts.get(part).is_none_or(|asked| *asked)
    }

    fn rows(&self, width: usize) -> usize {
        self.light.count() / width.max(1)
    }
}

struct Filling<'b, 'a> {
    band: Band<'b>,
    planes: PlaneSource<'a>,
    width: usize,
    first: usize,
}

impl Kernel for Filling<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let rows = self.first..self.first + self.band.rows(self.width);
        let PlaneSource { shape, cells, depths, .. } = self.planes;
        match shape {
            PlaneArray::Upright(upright) => {
                self.fill(simd, &UprightImage::new(simd, upright, cells, depths, rows))
            }
            PlaneArray::Panorama(panorama) => {
                self.fill(simd, &PanoramaImage { simd, panorama, cells, depths })
            }
        }
    }
}

impl Filling<'_, '_> {
    #[inline(always)]
    fn fill<V: Simd>(self, simd: V, plane_image: &impl LookUp<V>) {
        let Self { mut band, planes, width, first } = self;
        let mut units = planes.scale.units();
        units.iter_mut().zip(planes.tint).for_each(|(unit, tint)| *unit *= tint);
        let count = band.rows(width);

        // Strip by strip: rows of one group of planes follow each other in memory.
        for column in (0..width).step_by(LANES) {
            for row in 0..count {
                let place = plane_image.place(column, first + row);
                let light = plane_image.light(&place);
                let (start, end) = (row * width + column, row * width + (column + LANES).min(width));
                match &mut band.light {
                    Pixels::Srgb8(bytes) => {
                        simd.prefetch(bytes, start * RGB + AHEAD);
                        put_rgb(simd, light, units, &mut bytes[start * RGB..end * RGB]);
                    }
                    Pixels::Linear(colour) => put_light(simd, light, units, &mut colour[start..end]),
                }

                if band.has_range() && band.asks(row * width.div_ceil(LANES) + column / LANES) {
                    let mut lanes = Sixteen::default();
                    let (range, outlines) = plane_image.range(&place);
                    range.store(&mut lanes.0);
                    band.range[start..end].copy_from_slice(&lanes.0[..end - start]);
                    if let Some(marks) = band.outlines.get_mut(start..end) {
                        let bits = outlines.bits();
                        marks.iter_mut().enumerate().for_each(|(lane, mark)| *mark = bits >> lane & 1 != 0);
                    }
                }
            }
        }
    }
}

/// Writes light of up to sixteen pixels as 8-bit sRGB.
#[inline(always)]
fn put_rgb<V: Simd>(simd: V, [red, green, blue]: [V::F; 3], units: [f32; 3], target: &mut [u8]) {
    let (red, green) = (srgb8(simd, red, 1.0 / units[0]), srgb8(simd, green, 1.0 / units[1]));
    let packed = red | green.shl::<8>() | srgb8(simd, blue, 1.0 / units[2]).shl::<16>();
    match target.first_chunk_mut() {
        Some(all) => simd.store_triples(packed, all),
        None => {
            let mut all = [0; RGB * LANES];
            simd.store_triples(packed, &mut all);
            target.copy_from_slice(&all[..target.len()]);
        }
    }
}

/// Writes light of up to sixteen pixels as it is.
#[inline(always)]
fn put_light<V: Simd>(simd: V, light: [V::F; 3], units: [f32; 3], target: &mut [[f32; 3]]) {
    let mut lanes = [Sixteen::default(); 3];
    for ((lanes, light), unit) in lanes.iter_mut().zip(light).zip(units) {
        (light * simd.splat(unit)).store(&mut lanes.0);
    }
    for (lane, pixel) in target.iter_mut().enumerate() {
        *pixel = [lanes[0].0[lane], lanes[1].0[lane], lanes[2].0[lane]];
    }
}
