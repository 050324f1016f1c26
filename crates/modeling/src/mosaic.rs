//! Several elevation rasters as one surface.
//!
//! ```text
//! for each voxel, sources by priority:
//!     valid, inside = weights of the kernel's valid taps, of its taps within the raster (both ≤ 1)
//!     share = valid, less near where the source ends if a lower one goes on there (feathering, [`super::feather`]),
//!             less where it is incomplete and a lower source holds what it has as well as what it lacks
//!     take min(share, what is still missing to 1) of the source's mean
//! height = taken sum / taken weight, if half of what lay inside any raster was valid: else a void
//! ```
//!
//! Because shares add up to one instead of covering each other, a kernel that hangs over the edge of a tile is
//! completed by the neighbouring tile: tiles of one lattice join as if they were one raster. Where there is no neighbour,
//! dividing by the taken weight repeats the outermost pixels, half a pixel wide. The same sums let a lower source fill
//! the voids of a higher. Where voxels are finer than posts, heights may be rounded between these instead of straight, and detail be added; kernels that meet
//! no void then have the weights of the rounded one.

use super::feather::{FEATHER, Feather, Ramps, SheetShare, Sheets};
use super::kernel::{Accumulate, Gather, KernelShape, Samples, Tap};
use super::options::Interpolation;
use super::placed::ElevationInput;
use super::synthetic::{Detail, Refinement};
use super::warp::{self, LevelGrid, Rect, TOLERANCE, WarpField};
use crate::raster::Window;
use crate::survey_result::Survey;
use hedgehop::Size;
use hedgehop_base::error::Result;

/// Marks a voxel outside of all rasters.
const NOWHERE: u16 = u16::MAX;
/// Part of the range of a source's heights by which rounding may leave it.
const OVERSHOOT: f64 = 0.02;

/// Heights of a block of voxels.
#[derive(Debug)]
pub(super) struct Surface {
    pub rect: Rect,
    /// Metres above the database's datum; NaN where nothing is valid.
    pub heights: Vec<f64>,
    /// Index of the source that says most, or of the first that lies here if all are void.
    sources: Vec<u16>,
}

impl Surface {
    /// Index of the elevation source of a voxel; `None` outside of all rasters.
    pub fn source(&self, index: usize) -> Option<u16> {
        Some(self.sources[index]).filter(|&source| source != NOWHERE)
    }
    /// Voxels within a raster that says nothing there.
    pub fn voids(&self) -> Vec<bool> {
        let is_void = |(height, source): (&f64, &u16)| height.is_nan() && *source != NOWHERE;
        self.heights.iter().zip(&self.sources).map(is_void).collect()
    }
}

/// Merges sources; one per worker, since it keeps scratch memory.
pub(super) struct Mosaic<'a> {
    pub sources: &'a [ElevationInput],
    /// Surveys of each of them.
    pub surveys: &'a [Survey],
    /// Sheets: sources that are tiles of one.
    pub sheets: Sheets,
    pub interpolation: Interpolation,
    pub detail: Option<Detail>,
    pub level: LevelGrid,
    /// Largest window, bytes.
    pub window_bytes: usize,
    pub window: Vec<f64>,
}

/// One source's sums over a band of voxels.
struct MosaicLayer {
    source: u16,
    sums: Vec<f64>,
    valid: Vec<f64>,
    inside: Vec<f64>,
    /// Sum and weight under the rounded kernel, if that is not the tent; the sum is NaN where it meets a void.
    rounded: Option<Vec<(f64, f64)>>,
    /// Distances inside the source at voxels; `None` where no other one is near.
    ramps: Option<Ramps>,
    /// Whether the voxel lies on the raster's area.
    covered: Vec<bool>,
}

impl Accumulate<f64> for MosaicLayer {
    fn tap(&mut self, voxel: usize, tap: Tap, height: f64) {
        self.inside[voxel] += tap.tent;
        if !height.is_nan() {
            self.valid[voxel] += tap.tent;
            self.sums[voxel] += tap.tent * height;
        }
        if let Some(rounded) = &mut self.rounded {
            let (sum, weight) = rounded[voxel];
            rounded[voxel] = (sum + tap.sharp * height, weight + tap.sharp);
        }
    }
}

impl Mosaic<'_> {
    /// The surface over `rect`, with its voids.
    pub fn surface(&mut self, rect: Rect) -> Result<Surface> {
        match self.copied(rect)? {
            Some(surface) => Ok(surface),
            None => self.merged(rect),
        }
    }

    /// The surface where voxels are pixels of one raster, of which none is missing, and to which no other one has anything to add: what [`Self::merged`] comes to
    /// as well.
    fn copied(&mut self, rect: Rect) -> Result<Option<Surface>> {
        let grid = self.level.grid;
        let mut near = (0_u16..).zip(self.sources).filter(|(_, source)| rect.meets(&source.reach, &grid));
        let Some((index, source)) = near.next() else { return Ok(None) };
        let is_plain = self.shape(source) == KernelShape::Tent && self.refinement(index).is_none();

        // Where another one lies below, this one fades out towards where it ends.
        let margin = if near.next().is_some() { FEATHER } else { 0 };
        let Some(pixels) = source.placement.pixels(&grid, rect).filter(|_| is_plain) else { return Ok(None) };
        let Some(window) = pixels.window(rect, source.samples.size(), margin) else { return Ok(None) };
        if !self.is_whole(source, grown(window, margin))? {
            return Ok(None);
        }

        if margin > 0 {
            source.samples.read(window, &mut self.window)?;
        }
        let mut heights = warp::northward(rect, &self.window);

        if !source.shift.is_zero() {
            for (voxel, height) in heights.iter_mut().enumerate() {
                let (x, y) = rect.voxel(voxel);
                *height += source.shift.at(self.level.units(x, y));
            }
        }

        Ok(Some(Surface { rect, sources: vec![index; heights.len()], heights }))
    }

    /// Whether a source has data all over a window that may be held; it then is.
    fn is_whole(&mut self, source: &ElevationInput, window: Window) -> Result<bool> {
        if window.width as usize * window.height as usize * size_of::<f64>() > self.window_bytes {
            return Ok(false);
        }
        source.samples.read(window, &mut self.window)?;
        Ok(!self.window.iter().any(|height| height.is_nan()))
    }

    /// The surface over `rect` from all rasters.
    fn merged(&mut self, rect: Rect) -> Result<Surface> {
        let (mut heights, mut sources) = (Vec::with_capacity(rect.len()), Vec::with_capacity(rect.len()));
        for band in rect.bands() {
            let layers = self.layers(band)?;
            for voxel in 0..band.len() {
                let (height, source) = merge(&layers, voxel);
                heights.push(height);
                sources.push(source);
            }
        }
        Ok(Surface { rect, heights, sources })
    }

    /// Sums of the sources that matter in a band: down to where nothing is missing and nothing fades.
    fn layers(&mut self, band: Rect) -> Result<Vec<MosaicLayer>> {
        let mut layers = Vec::new();
        let is_near = |source: &&ElevationInput| band.meets(&source.reach, &self.level.grid);
        let is_alone = self.sources.iter().filter(is_near).nth(1).is_none();
        for (index, source) in self.sources.iter().enumerate() {
            if !band.meets(&source.reach, &self.level.grid) {
                continue;
            }

            let field = warp::locate(&source.placement, &self.level.grid, band);
            if !field.touches(source.samples.size()) {
                continue;
            }

            let mut layer = self.layer(index as u16, source, &field)?;
            layer.ramps = if is_alone { None } else { Some(self.ramps(index, &field)?) };
            let suffices = layer.suffices();
            layers.push(layer);
            if suffices {
                break;
            }
        }

        Ok(layers)
    }

    /// Returns how far inside a source voxels lie.
    fn ramps(&self, index: usize, field: &WarpField) -> Result<Ramps> {
        let sources = self.sources;
        let samples = |index: usize| Some(sources[index].samples.as_ref());
        let (sheets, window_bytes) = (&self.sheets, self.window_bytes);
        Feather { sheets, index, field, samples: &samples, window_bytes }.ramps()
    }

    /// Sums of one source, rounded and with detail where these are asked for and voxels are finer than its posts.
    fn layer(&mut self, index: u16, source: &ElevationInput, field: &WarpField) -> Result<MosaicLayer> {
        let (shape, refinement) = (self.shape(source), self.refinement(index));
        let posts = source.samples.as_ref();
        let mut layer = MosaicLayer::new(index, field, posts.size(), shape != KernelShape::Tent);
        if let Some(refinement) = &refinement {
            self.gather(&refinement.posts(posts), field, shape, &mut layer)?;
            layer.finish(source, &self.level, field);
            let mut waves = MosaicLayer::new(index, field, posts.size(), false);
            self.gather(&refinement.amplitudes(posts), field, KernelShape::Tent, &mut waves)?;
            layer.refine(refinement, &waves, field);
        } else {
            self.gather(posts, field, shape, &mut layer)?;
            layer.finish(source, &self.level, field);
        }

        let range = self.surveys.get(usize::from(index)).and_then(|survey| survey.range);
        if let Some((low, high)) = range.filter(|_| shape != KernelShape::Tent || refinement.is_some()) {
            let room = room(source, low, high, self.interpolation, self.detail.as_ref());
            layer.confine(source, low - room, high + room);
        }

        Ok(layer)
    }

    fn gather(
        &mut self,
        samples: &dyn Samples<f64>,
        field: &WarpField,
        shape: KernelShape,
        layer: &mut MosaicLayer,
    ) -> Result<()> {
        Gather { samples, field, shape, window_bytes: self.window_bytes, window: &mut self.window }.run(layer)
    }

    /// Kernel for a source's heights.
    fn shape(&self, source: &ElevationInput) -> KernelShape {
        match self.interpolation {
            _ if self.level.grid.spacing >= source.pixel_side => KernelShape::Tent,
            Interpolation::Linear => KernelShape::Tent,
            Interpolation::Bicubic => KernelShape::Bicubic,
            Interpolation::Spline => KernelShape::Spline,
        }
    }

    /// Detail of a source at the level, if it gets any.
    fn refinement(&self, index: u16) -> Option<Refinement> {
        let (source, survey) = (self.sources.get(usize::from(index))?, self.surveys.get(usize::from(index))?);
        Refinement::of(self.detail.as_ref()?, source, survey.energies.roughness(), self.level.grid.spacing)
    }
}

/// Returns by how much heights may leave the range of a source's posts, `low..=high`, metres.
pub(super) fn room(
    source: &ElevationInput,
    low: f64,
    high: f64,
    interpolation: Interpolation,
    detail: Option<&Detail>,
) -> f64 {
    let overshoot = if interpolation == Interpolation::Linear { 0.0 } else { OVERSHOOT * (high - low) };
    overshoot + detail.map_or(0.0, |detail| detail.most(source.pixel_side))
}

impl MosaicLayer {
    fn new(source: u16, field: &WarpField, size: Size, is_rounded: bool) -> Self {
        let none = vec![0.0; field.rect.len()];
        let places = field.columns.iter().zip(&field.rows);
        let on_area =
            |position: f64, size: u32| position.min(f64::from(size) - 1.0 - position) >= -0.5 - TOLERANCE;
        Self {
            source,
            ramps: None,
            covered: places.map(|(&c, &r)| on_area(c, size.width) && on_area(r, size.height)).collect(),
            sums: none.clone(),
            valid: none.clone(),
            inside: none,
            rounded: is_rounded.then(|| vec![(0.0, 0.0); field.rect.len()]),
        }
    }

    /// Turns sums into means above the database's datum.
    fn finish(&mut self, source: &ElevationInput, level: &LevelGrid, field: &WarpField) {
        for (voxel, (sum, weight)) in self.rounded.iter().flatten().enumerate() {
            if sum.is_finite() && *weight > 0.0 {
                self.sums[voxel] = *sum;
                self.valid[voxel] = *weight;
                self.inside[voxel] = *weight;
            }
        }
        for (voxel, sum) in self.sums.iter_mut().enumerate() {
            if self.valid[voxel] > 0.0 {
                let (x, y) = field.rect.voxel(voxel);
                let shift = source.shift.at(level.units(x, y));
                *sum = *sum / self.valid[voxel] + shift;
            }
        }
    }

    /// Adds detail to heights, `waves` being the height of its waves.
    fn refine(&mut self, refinement: &Refinement, waves: &Self, field: &WarpField) {
        for (voxel, height) in self.sums.iter_mut().enumerate() {
            if self.valid[voxel] > 0.0 && waves.valid[voxel] > 0.0 {
                let amplitude = waves.sums[voxel] / waves.valid[voxel];
                *height += refinement.at(field.columns[voxel], field.rows[voxel], amplitude);
            }
        }
    }

    /// Keeps heights within `low..=high`, metres above the source's datum.
    fn confine(&mut self, source: &ElevationInput, low: f64, high: f64) {
        let shift = source.shift.range();
        self.sums.iter_mut().for_each(|height| *height = height.clamp(low + shift.0, high + shift.1));
    }

    /// Part of this source's share that lower ones take over, 0…1.
    fn ceded(&self, lower: &[Self], voxel: usize) -> f64 {
        let valid = self.valid[voxel];
        let take_over = |below: &Self| {
            let ramps = self.ramps.as_ref().zip(below.ramps.as_ref());
            let faded = ramps.map_or(0.0, |(own, lower)| own.ceded(lower, voxel)) * below.valid[voxel];
            // The mean of some taps lies beside the position; what both kernels hold is better said by the fuller.
            let common =
                if valid > 0.0 && valid < WHOLE { (valid + below.valid[voxel] - 1.0) / valid } else { 0.0 };
            faded.max(common)
        };
        lower.iter().map(take_over).fold(0.0, f64::max).min(1.0)
    }

    /// Part of its sheet's share that lower sheets take over where it fades, 0…1.
    fn ceded_by_sheet(&self, lower: &[Self], voxel: usize) -> f64 {
        let take_over = |below: &Self| {
            let (own, lower) = self.ramps.as_ref().zip(below.ramps.as_ref())?;
            Some(own.ceded_by_sheet(lower, voxel) * below.valid[voxel])
        };
        lower.iter().filter_map(take_over).fold(0.0, f64::max).min(1.0)
    }

    /// No lower source can change anything.
    fn suffices(&self) -> bool {
        let is_inside = |voxel: usize| self.ramps.as_ref().is_none_or(|ramps| ramps.is_inside(voxel));
        self.valid.iter().enumerate().all(|(voxel, &valid)| valid >= WHOLE && is_inside(voxel))
    }
}

/// A window with a margin that lies within the raster as well.
fn grown(window: Window, margin: u32) -> Window {
    let (x, y) = (window.x - margin, window.y - margin);
    Window { x, y, width: window.width + 2 * margin, height: window.height + 2 * margin }
}

/// A weight that is 1 but for rounding: the largest relative error of a sum of some ten million weights.
const WHOLE: f64 = 1.0 - 1.0e-9;

/// Height and source of a voxel from the layers, highest priority first.
fn merge(layers: &[MosaicLayer], voxel: usize) -> (f64, u16) {
    let (mut sum, mut taken, mut inside) = (0.0, 0.0, 0.0_f64);
    let (mut source, mut most) = (NOWHERE, 0.0);
    let (mut covered, mut sheet) = (false, SheetShare::default());
    for (index, layer) in layers.iter().enumerate() {
        if layer.covered[voxel] && !covered {
            covered = true;
            source = layer.source;
        }

        inside += layer.inside[voxel];
        let lower = &layers[index + 1..];
        let share = layer.valid[voxel] * (1.0 - layer.ceded(lower, voxel));
        let ceded = layer.ceded_by_sheet(lower, voxel);
        let take = sheet.take(share.min(1.0 - taken), layer.ramps.as_ref(), ceded);
        if take > 0.0 {
            sum += take * layer.sums[voxel];
            taken += take;
        }

        if take > most && covered {
            (source, most) = (layer.source, take);
        }
    }

    let valid = covered && taken > 0.0 && taken >= 0.5 * inside.min(1.0) * WHOLE;
    (if valid { sum / taken } else { f64::NAN }, source)
}
