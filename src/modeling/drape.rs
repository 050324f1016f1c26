//! Imagery over the surface: which colour each voxel has.
//!
//! Filtered in linear light with premultiplied alpha (Porter and Duff 1984). Sources by priority; where one is
//! transparent, the next shows. Sums at the edges of rasters complete each other as in the mosaic of heights.
//! Imagery coarser than the voxels is sharpened by the Catmull–Rom cubic, held within the range of the four
//! nearest pixels so that it cannot ring, and only where its sixteen pixels are all there and opaque.

use super::kernel::{Accumulate, Gather, Shape, Tap};
use super::placed::ImageryInput;
use super::warp::{self, Field, LevelGrid, Rect, TOLERANCE};
use crate::colour::linear_from_srgb8;
use crate::error::Result;

/// Colour of a voxel in linear light, premultiplied by `alpha` (0…1).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Pigment {
    pub linear: [f32; 3],
    pub alpha: f32,
}

/// Drapes imagery; one per worker, since it keeps scratch memory.
pub(super) struct Drape<'a> {
    pub sources: &'a [ImageryInput],
    pub level: LevelGrid,
    /// Largest window, bytes.
    pub window_bytes: usize,
    pub window: Vec<[u8; 4]>,
}

impl Drape<'_> {
    /// Colours over `rect`, row-major.
    pub fn pigments(&mut self, rect: Rect) -> Result<Vec<Pigment>> {
        let mut pigments = Vec::with_capacity(rect.len());
        for band in rect.bands() {
            let mut blends = vec![Blend::default(); band.len()];
            for source in self.sources {
                self.add(source, band, &mut blends)?;
                if blends.iter().all(Blend::is_opaque) {
                    break;
                }
            }
            pigments.extend(blends.iter().map(Blend::pigment));
        }
        Ok(pigments)
    }

    /// Colours over `rect` where voxels are opaque pixels of the first image there: what [`Self::pigments`] come to as well.
    pub fn pixels(&mut self, rect: Rect) -> Result<Option<Vec<[u8; 3]>>> {
        let grid = self.level.grid;
        let Some(source) = self.sources.iter().find(|source| rect.meets(&source.reach, &grid)) else {
            return Ok(None);
        };
        let pixels = source.placement.pixels(&grid, rect);
        let window = pixels.and_then(|pixels| pixels.window(rect, source.samples.size(), 0));
        let Some(window) = window.filter(|_| rect.len() * size_of::<[u8; 4]>() <= self.window_bytes) else {
            return Ok(None);
        };
        source.samples.read(window, &mut self.window)?;
        let is_opaque = self.window.iter().all(|[.., alpha]| *alpha == u8::MAX);
        Ok(is_opaque.then(|| {
            warp::northward(rect, &self.window).map(|[red, green, blue, _]| [red, green, blue]).collect()
        }))
    }

    fn add(&mut self, source: &ImageryInput, band: Rect, blends: &mut [Blend]) -> Result<()> {
        if !band.meets(&source.reach, &self.level.grid) {
            return Ok(());
        }
        let field = warp::locate(&source.placement, &self.level.grid, band);
        let size = source.samples.size();
        if !field.touches(size) {
            return Ok(());
        }
        // Pixels are coarser than voxels.
        let is_magnified = source.pixel_side > self.level.grid.spacing;
        let shape = if is_magnified { Shape::Cubic } else { Shape::Tent };
        let mut sums = vec![Sums::default(); band.len()];
        let (samples, window) = (source.samples.as_ref(), &mut self.window);
        let window_bytes = self.window_bytes;
        Gather { samples, field: &field, shape, window_bytes, window }
            .run(&mut Painter { sums: &mut sums })?;
        for (voxel, (blend, sums)) in blends.iter_mut().zip(&sums).enumerate() {
            blend.add(sums, shape, covered(&field, voxel, size));
        }
        Ok(())
    }
}

fn covered(field: &Field, voxel: usize, size: (u32, u32)) -> bool {
    let within =
        |position: f64, size: u32| position.min(f64::from(size) - 1.0 - position) >= -0.5 - TOLERANCE;
    within(field.columns[voxel], size.0) && within(field.rows[voxel], size.1)
}

/// What one source adds up to at a voxel.
#[derive(Clone)]
struct Sums {
    /// Premultiplied linear colour under the tent.
    tent: [f32; 3],
    alpha: f32,
    inside: f32,
    /// Under the cubic.
    sharp: [f32; 3],
    /// Range of the pixels under the tent.
    least: [f32; 3],
    most: [f32; 3],
    /// Opaque pixels met.
    opaque: u32,
}

impl Default for Sums {
    fn default() -> Self {
        Self {
            tent: [0.0; 3],
            alpha: 0.0,
            inside: 0.0,
            sharp: [0.0; 3],
            least: [f32::INFINITY; 3],
            most: [f32::NEG_INFINITY; 3],
            opaque: 0,
        }
    }
}

struct Painter<'a> {
    sums: &'a mut [Sums],
}

impl Accumulate<[u8; 4]> for Painter<'_> {
    fn tap(&mut self, voxel: usize, tap: Tap, [red, green, blue, alpha]: [u8; 4]) {
        let sums = &mut self.sums[voxel];
        let (tent, sharp) = (tap.tent as f32, tap.sharp as f32);
        sums.inside += tent;
        if alpha == 0 {
            return;
        }
        let opacity = f32::from(alpha) / 255.0;
        sums.alpha += tent * opacity;
        sums.opaque += u32::from(alpha == 255);
        for (channel, linear) in linear_from_srgb8([red, green, blue]).into_iter().enumerate() {
            sums.tent[channel] += tent * opacity * linear;
            sums.sharp[channel] += sharp * linear;
            if tent > 0.0 {
                sums.least[channel] = sums.least[channel].min(linear);
                sums.most[channel] = sums.most[channel].max(linear);
            }
        }
    }
}

impl Sums {
    fn colour(&self, shape: Shape) -> [f32; 3] {
        // Fewer than 16 where the position meets pixel centres: the cubic is 0 at the others, and so the tent is it.
        if shape == Shape::Tent || self.opaque < 16 {
            return self.tent;
        }
        std::array::from_fn(|channel| self.sharp[channel].clamp(self.least[channel], self.most[channel]))
    }
}

/// What all sources so far add up to at a voxel.
#[derive(Clone, Default)]
struct Blend {
    linear: [f32; 3],
    alpha: f32,
    inside: f32,
    covered: bool,
}

impl Blend {
    fn add(&mut self, sums: &Sums, shape: Shape, covered: bool) {
        self.covered |= covered;
        self.inside += sums.inside;
        if sums.alpha <= 0.0 {
            return;
        }
        let share = sums.alpha.min(1.0 - self.alpha).max(0.0) / sums.alpha;
        for (sum, part) in self.linear.iter_mut().zip(sums.colour(shape)) {
            *sum += share * part;
        }
        self.alpha += share * sums.alpha;
    }

    /// Nothing shows through, up to the rounding of a byte.
    fn is_opaque(&self) -> bool {
        self.alpha > 1.0 - 0.5 / 255.0
    }

    /// Beyond the outermost pixel centres of all rasters the kernel's missing part repeats them.
    fn pigment(&self) -> Pigment {
        if !self.covered || self.inside <= 0.0 {
            return Pigment::default();
        }
        let whole = self.inside.min(1.0);
        Pigment { linear: self.linear.map(|sum| sum / whole), alpha: (self.alpha / whole).min(1.0) }
    }
}
