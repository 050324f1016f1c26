//! A band of rows of the screen.

use super::plane_image::{LookUp, PanoramaImage, PlaneSource, UprightImage};
use crate::pixels::{Pixels, RGB, put_light_of_roots, put_rgb_of_roots};
use crate::raymarch::scan::PlaneArray;
use crate::simd::{Floats, Isa, Kernel, LANES, Mask, Simd, Sixteen};

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
                let plane_image = UprightImage::new(simd, upright, cells, depths, rows);
                simd.call(FillingFrom { filling: self, simd, plane_image });
            }
            PlaneArray::Panorama(panorama) => {
                let plane_image = PanoramaImage { simd, panorama, cells, depths };
                simd.call(FillingFrom { filling: self, simd, plane_image });
            }
        }
    }
}

/// Filling of a band from one kind of plane image.
struct FillingFrom<'b, 'a, V, I> {
    filling: Filling<'b, 'a>,
    simd: V,
    plane_image: I,
}

impl<V: Simd, I: LookUp<V>> Kernel for FillingFrom<'_, '_, V, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        self.filling.fill(self.simd, &self.plane_image);
    }
}

impl Filling<'_, '_> {
    #[inline(always)]
    fn fill<V: Simd>(self, simd: V, plane_image: &impl LookUp<V>) {
        let Self { mut band, planes, width, first } = self;
        let steps = planes.tint.map(|tint| planes.scale.step() * tint.sqrt());
        let count = band.rows(width);

        // Strip by strip: rows of one group of planes follow each other in memory.
        let mut strip = plane_image.strip();
        for column in (0..width).step_by(LANES) {
            plane_image.begin(&mut strip, column);
            for row in 0..count {
                let place = plane_image.place(column, first + row);
                let roots = plane_image.roots(&mut strip, &place);
                let (start, end) = (row * width + column, row * width + (column + LANES).min(width));
                match &mut band.light {
                    Pixels::Srgb8(bytes) => {
                        simd.prefetch(bytes, start * RGB + AHEAD);
                        put_rgb_of_roots(simd, roots, steps, &mut bytes[start * RGB..end * RGB]);
                    }
                    Pixels::Linear(colour) => {
                        put_light_of_roots(simd, roots, steps, &mut colour[start..end]);
                    }
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
