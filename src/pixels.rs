//! Light of pixels: linear, or 8-bit codes.

use std::ops::Range;

use glam::Vec3;

use crate::simd::math::{srgb8, srgb8_of_roots};
use crate::simd::{Floats, Ints, LANES, Simd, Sixteen};
use hedgehop_base::colour::{linear_from_srgb8, linear_of_codes, srgb8_from_light};

/// Bytes of an 8-bit pixel.
pub(crate) const RGB: usize = 3;

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
                    for (channel, part) in parts.iter_mut().enumerate() {
                        part[lane] = pixel[channel];
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
            Self::Srgb8(bytes) => put_rgb(simd, light, &mut bytes[pixels.start * RGB..pixels.end * RGB]),
            Self::Linear(colour) => put_light::<V>(light, &mut colour[pixels]),
        }
    }
}

/// Writes light of up to sixteen pixels as 8-bit sRGB.
#[inline(always)]
fn put_rgb<V: Simd>(simd: V, [red, green, blue]: [V::F; 3], target: &mut [u8]) {
    put_codes(simd, [srgb8(simd, red, 1.0), srgb8(simd, green, 1.0), srgb8(simd, blue, 1.0)], target);
}

/// Writes roots of the light of up to sixteen pixels, in steps by channel, as 8-bit sRGB.
#[inline(always)]
pub(crate) fn put_rgb_of_roots<V: Simd>(simd: V, roots: [V::F; 3], steps: [f32; 3], target: &mut [u8]) {
    let mut shown = roots;
    for (channel, root) in shown.iter_mut().enumerate() {
        *root = *root * simd.splat(steps[channel]);
    }
    let codes = srgb8_of_roots(simd, shown);
    put_codes(simd, codes, target);
}

/// Writes 8-bit codes of up to sixteen pixels.
#[inline(always)]
fn put_codes<V: Simd>(simd: V, [red, green, blue]: [V::I; 3], target: &mut [u8]) {
    let packed = red | green.shl::<8>() | blue.shl::<16>();
    match target.first_chunk_mut() {
        Some(all) => simd.store_triples(packed, all),
        None => {
            let mut all = [0; RGB * LANES];
            simd.store_triples(packed, &mut all);
            target.copy_from_slice(&all[..target.len()]);
        }
    }
}

/// Writes light of up to sixteen pixels, of which roots are given, in steps by channel, as it is.
#[inline(always)]
pub(crate) fn put_light_of_roots<V: Simd>(
    simd: V,
    roots: [V::F; 3],
    steps: [f32; 3],
    target: &mut [[f32; 3]],
) {
    let mut light = roots;
    for (channel, light) in light.iter_mut().enumerate() {
        let root = *light * simd.splat(steps[channel]);
        *light = root * root;
    }
    put_light::<V>(light, target);
}

/// Writes light of up to sixteen pixels as it is.
#[inline(always)]
fn put_light<V: Simd>(light: [V::F; 3], target: &mut [[f32; 3]]) {
    let mut lanes = [Sixteen::default(); 3];
    for (channel, lanes) in lanes.iter_mut().enumerate() {
        light[channel].store(&mut lanes.0);
    }
    for (lane, pixel) in target.iter_mut().enumerate() {
        *pixel = [lanes[0].0[lane], lanes[1].0[lane], lanes[2].0[lane]];
    }
}

/// Linear radiance of the units in which lines are sampled, by channel: the square of a texel's code, which green
/// keeps in its place.
pub const UNITS: [f32; 3] = {
    let unit = (ROOT_OF_BRIGHTEST / CODE_LIMIT) * (ROOT_OF_BRIGHTEST / CODE_LIMIT);
    [unit, unit / (GREEN * GREEN), unit]
};

/// Begin of green in a texel.
const GREEN: f32 = 1024.0;

/// Root of the radiance of the greatest code.
pub const ROOT_OF_BRIGHTEST: f32 = 1.5;

/// Greatest code of a channel.
pub const CODE_LIMIT: f32 = 1023.0;
