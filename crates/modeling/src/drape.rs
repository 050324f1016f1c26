//! Imagery over the surface: which colour each voxel has.
//!
//! Filtered in linear light with premultiplied alpha (Porter and Duff 1984). Sources by priority; where one is
//! transparent, the next shows; where one ends and a lower one goes on, it fades into that ([`super::feather`]). Sums at the edges of rasters complete each other as in the mosaic of heights.
//! Imagery coarser than the voxels is sharpened by the Catmull–Rom cubic, held within the range of the four
//! nearest pixels so that it cannot ring, and only where its sixteen pixels are all there and opaque.

use super::feather::{FEATHER, Feather, Ramps, SheetShare, Sheets};
use super::kernel::{Accumulate, Gather, KernelShape, Tap};
use super::placed::ImageryInput;
use super::warp::{self, LevelGrid, Rect, TOLERANCE, WarpField};
use hedgehop::Size;
use hedgehop_base::colour::linear_from_srgb8;
use hedgehop_base::error::Result;

/// Colour of a voxel in linear light, premultiplied by `alpha` (0…1).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Pigment {
    pub linear: [f32; 3],
    pub alpha: f32,
}

/// Drapes imagery; one per worker, since it keeps scratch memory.
pub(super) struct Drape<'a> {
    pub sources: &'a [ImageryInput],
    /// Sheets: sources that are tiles of one.
    pub sheets: Sheets,
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
            let layers = self.layers(band)?;
            pigments.extend((0..band.len()).map(|voxel| blended(&layers, voxel)));
        }
        Ok(pigments)
    }

    /// Colours over `rect` where voxels are opaque pixels of the first image there: what [`Self::pigments`] come to as well.
    pub fn pixels(&mut self, rect: Rect) -> Result<Option<Vec<[u8; 3]>>> {
        let grid = self.level.grid;
        let mut near = self.sources.iter().filter(|source| rect.meets(&source.reach, &grid));
        let Some(source) = near.next() else { return Ok(None) };
        // Where another one lies below, this one fades out towards its edge.
        let margin = if near.next().is_some() { FEATHER } else { 0 };
        let pixels = source.placement.pixels(&grid, rect);
        let window = pixels.and_then(|pixels| pixels.window(rect, source.samples.size(), margin));
        let Some(window) = window.filter(|_| rect.len() * size_of::<[u8; 4]>() <= self.window_bytes) else {
            return Ok(None);
        };
        source.samples.read(window, &mut self.window)?;
        let is_opaque = self.window.iter().all(|[.., alpha]| *alpha == u8::MAX);
        Ok(is_opaque.then(|| {
            let pixels = warp::northward(rect, &self.window);
            pixels.into_iter().map(|[red, green, blue, _]| [red, green, blue]).collect()
        }))
    }

    /// Reads the layers of the images that matter in a band: down to where all voxels are opaque and nothing fades.
    fn layers(&mut self, band: Rect) -> Result<Vec<DrapeLayer>> {
        let (sources, grid) = (self.sources, self.level.grid);
        let is_near = |source: &&ImageryInput| band.meets(&source.reach, &grid);
        let is_alone = sources.iter().filter(is_near).nth(1).is_none();
        let mut layers = Vec::new();
        let mut settled = vec![false; band.len()];

        for (index, source) in sources.iter().enumerate().filter(|(_, source)| is_near(source)) {
            let field = warp::locate(&source.placement, &grid, band);
            if !field.touches(source.samples.size()) {
                continue;
            }

            let paints = self.paints(source, &field)?;
            let ramps = if is_alone { None } else { Some(self.ramps(index, &field)?) };
            let layer = DrapeLayer { paints, ramps };
            settled.iter_mut().enumerate().for_each(|(voxel, settled)| *settled |= layer.settles(voxel));
            layers.push(layer);
            if settled.iter().all(|settled| *settled) {
                break;
            }
        }

        Ok(layers)
    }

    fn paints(&mut self, source: &ImageryInput, field: &WarpField) -> Result<Vec<ImageColour>> {
        // Pixels are coarser than voxels.
        let is_magnified = source.pixel_side > self.level.grid.spacing;
        let shape = if is_magnified { KernelShape::Cubic } else { KernelShape::Tent };
        let mut sums = vec![Sums::default(); field.rect.len()];
        let (samples, window) = (source.samples.as_ref(), &mut self.window);
        let window_bytes = self.window_bytes;
        Gather { samples, field, shape, window_bytes, window }.run(&mut Painter { sums: &mut sums })?;
        let paint = |(voxel, sums): (usize, &Sums)| ImageColour {
            linear: sums.colour(shape),
            alpha: sums.alpha,
            inside: sums.inside,
            is_covered: covered(field, voxel, samples.size()),
        };
        Ok(sums.iter().enumerate().map(paint).collect())
    }

    /// Returns how far inside an image voxels lie; where it is transparent it does not end.
    fn ramps(&self, index: usize, field: &WarpField) -> Result<Ramps> {
        let (sheets, window_bytes) = (&self.sheets, self.window_bytes);
        Feather { sheets, index, field, samples: &|_| None, window_bytes }.ramps()
    }
}

fn covered(field: &WarpField, voxel: usize, size: Size) -> bool {
    let within =
        |position: f64, size: u32| position.min(f64::from(size) - 1.0 - position) >= -0.5 - TOLERANCE;
    within(field.columns[voxel], size.width) && within(field.rows[voxel], size.height)
}

/// Sums of one source at a voxel.
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
    fn colour(&self, shape: KernelShape) -> [f32; 3] {
        // Fewer than 16 where the position meets pixel centres: the cubic is 0 at the others, and so the tent is it.
        if shape == KernelShape::Tent || self.opaque < 16 {
            return self.tent;
        }
        std::array::from_fn(|channel| self.sharp[channel].clamp(self.least[channel], self.most[channel]))
    }
}

/// One image over a band.
struct DrapeLayer {
    paints: Vec<ImageColour>,
    /// `None` where no other one is near.
    ramps: Option<Ramps>,
}

/// Colour of one image at a voxel.
struct ImageColour {
    /// Linear light, premultiplied by `alpha`.
    linear: [f32; 3],
    alpha: f32,
    /// Weight of the kernel within the image.
    inside: f32,
    is_covered: bool,
}

impl DrapeLayer {
    /// Nothing of a lower image shows, up to the rounding of a byte.
    fn settles(&self, voxel: usize) -> bool {
        let is_opaque = self.paints[voxel].alpha > 1.0 - 0.5 / 255.0;
        is_opaque && self.ramps.as_ref().is_none_or(|ramps| ramps.is_inside(voxel))
    }

    /// Part of this image's share that lower ones take over, 0…1.
    fn ceded(&self, lower: &[Self], voxel: usize) -> f32 {
        self.taken_over(lower, voxel, Ramps::ceded) as f32
    }

    /// Part of its sheet's share that lower sheets take over, 0…1.
    fn ceded_by_sheet(&self, lower: &[Self], voxel: usize) -> f64 {
        self.taken_over(lower, voxel, Ramps::ceded_by_sheet)
    }

    fn taken_over(&self, lower: &[Self], voxel: usize, ceded: impl Fn(&Ramps, &Ramps, usize) -> f64) -> f64 {
        let take_over = |below: &Self| {
            let (own, lower) = self.ramps.as_ref().zip(below.ramps.as_ref())?;
            Some(ceded(own, lower, voxel) * f64::from(below.paints[voxel].alpha))
        };
        lower.iter().filter_map(take_over).fold(0.0, f64::max).min(1.0)
    }
}

/// Colour of a voxel from the layers, highest priority first.
fn blended(layers: &[DrapeLayer], voxel: usize) -> Pigment {
    let (mut blend, mut sheet) = (Blend::default(), SheetShare::default());
    for (index, layer) in layers.iter().enumerate() {
        let (paint, lower) = (&layer.paints[voxel], &layers[index + 1..]);
        let share = (paint.alpha * (1.0 - layer.ceded(lower, voxel))).min(1.0 - blend.alpha);
        let ceded = layer.ceded_by_sheet(lower, voxel);
        blend.add(paint, sheet.take(f64::from(share), layer.ramps.as_ref(), ceded) as f32);
    }
    blend.pigment()
}

/// Blend of all sources so far at a voxel.
#[derive(Default)]
struct Blend {
    linear: [f32; 3],
    alpha: f32,
    inside: f32,
    is_covered: bool,
}

impl Blend {
    /// Adds an image of which so much shows.
    fn add(&mut self, paint: &ImageColour, taken: f32) {
        self.is_covered |= paint.is_covered;
        self.inside += paint.inside;
        if paint.alpha <= 0.0 {
            return;
        }
        let share = taken / paint.alpha;
        for (sum, part) in self.linear.iter_mut().zip(paint.linear) {
            *sum += share * part;
        }
        self.alpha += share * paint.alpha;
    }

    /// Beyond the outermost pixel centres of all rasters the kernel's missing part repeats them.
    fn pigment(&self) -> Pigment {
        if !self.is_covered || self.inside <= 0.0 {
            return Pigment::default();
        }
        let whole = self.inside.min(1.0);
        Pigment { linear: self.linear.map(|sum| sum / whole), alpha: (self.alpha / whole).min(1.0) }
    }
}
