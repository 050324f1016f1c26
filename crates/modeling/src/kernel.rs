//! Weighted sums of a raster's pixels around each voxel.
//!
//! A voxel that is finer than the pixels is interpolated: between 2 × 2 of them (a tent of radius one), for
//! imagery also between 4 × 4 (Catmull and Rom 1974, the cubic of Keys 1981 with a = −½). A voxel that is coarser
//! averages the pixels that it covers under a tent as wide as two voxels, so that no pixel is skipped and
//! none counts more than its area. Both are the same tent, of radius max(1, pixels per voxel).
//!
//! Heights may also be rounded between 4 × 4 posts (the same cubic) or 6 × 6 (the cubic of fourth order of Keys 1981, §7). Within the raster these kernels are
//! completed by pixels that go on straight beyond its edge.
//!
//! Weights sum to 1 over the *unclipped* kernel. What falls off the raster is missing from the sums, so that the
//! next raster can supply it: two tiles of one lattice join as if they were one raster.
//!
//! ```text
//! gather(block):
//!     window = bounding box of all taps of the block's voxels, clipped to the raster
//!     if it is larger than the budget: halve the block, or read a single voxel's window in strips
//!     for each voxel, each tap row by row: accumulate(weight, sample)
//! ```
//! Each voxel meets its taps in the same order whatever the split, so results do not depend on it.

use super::warp::{Rect, WarpField};
use crate::raster::Window;
use hedgehop::Size;
use hedgehop_base::error::Result;

/// A raster of samples that is read window by window.
pub(super) trait Samples<T>: Send + Sync {
    /// Columns and rows.
    fn size(&self) -> Size;
    /// Rows from the north, `[window.height][window.width]`, replacing what `samples` held.
    fn read(&self, window: Window, samples: &mut Vec<T>) -> Result<()>;
    /// Returns notes on what was assumed or repaired in what has been read so far, one sentence each.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Takes the taps of one voxel after the other.
pub(super) trait Accumulate<T> {
    /// `voxel` is an index into the field's block; weights as in [`Tap`].
    fn tap(&mut self, voxel: usize, tap: Tap, sample: T);
}

/// Weights of one pixel in a voxel's sums.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tap {
    /// Weight of the tent, ≥ 0.
    pub tent: f64,
    /// Weight of the cubic (the tent's again where no cubic was asked for); may be negative.
    pub sharp: f64,
}

/// Shape of the weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum KernelShape {
    /// Tent alone.
    Tent,
    /// Tent and, where pixels are coarser than voxels, cubic.
    Cubic,
    /// The same, completed at the raster's edge.
    Bicubic,
    /// Tent, and the cubic of fourth order.
    Spline,
}

/// Reads, splits and weighs.
pub(super) struct Gather<'a, T> {
    pub samples: &'a dyn Samples<T>,
    pub field: &'a WarpField,
    pub shape: KernelShape,
    /// Largest window, bytes.
    pub window_bytes: usize,
    /// Holds the window; grows up to `window_bytes`.
    pub window: &'a mut Vec<T>,
}

impl<T: Copy> Gather<'_, T> {
    /// Sums over the whole field.
    pub fn run(&mut self, sums: &mut impl Accumulate<T>) -> Result<()> {
        let mut weights = TapWeights::default();
        let mut blocks = vec![self.field.rect];
        while let Some(block) = blocks.pop() {
            let Some(window) = self.bounds(block) else { continue };
            let row_bytes = window.width as usize * size_of::<T>();
            if row_bytes * window.height as usize <= self.window_bytes {
                self.sum(block, window, &mut weights, sums)?;
            } else if block.len() > 1 {
                blocks.extend(block.halves());
            } else {
                let strip = (self.window_bytes / row_bytes).max(1) as u32;
                for y in (window.y..window.y + window.height).step_by(strip as usize) {
                    let height = strip.min(window.y + window.height - y);
                    self.sum(block, Window { y, height, ..window }, &mut weights, sums)?;
                }
            }
        }
        Ok(())
    }

    fn voxels(&self, block: Rect) -> impl Iterator<Item = (usize, f64, f64, (f64, f64))> {
        let field = self.field;
        (block.y0..block.y1).flat_map(move |y| {
            (block.x0..block.x1).filter_map(move |x| {
                let voxel = field.rect.index(x, y);
                let (column, row) = (field.columns[voxel], field.rows[voxel]);
                (!column.is_nan()).then(|| (voxel, column, row, field.scale(x, y)))
            })
        })
    }

    /// Box that holds all taps of a block, clipped to the raster.
    fn bounds(&self, block: Rect) -> Option<Window> {
        let size = self.samples.size();
        let nothing = (f64::INFINITY, f64::NEG_INFINITY);
        let widened = |range: (f64, f64), value: f64| (range.0.min(value), range.1.max(value));
        let (mut columns, mut rows, mut reach) = (nothing, nothing, (0.0_f64, 0.0_f64));
        for (_, column, row, scale) in self.voxels(block) {
            (columns, rows) = (widened(columns, column), widened(rows, row));
            reach = (reach.0.max(self.shape.reach(scale.0)), reach.1.max(self.shape.reach(scale.1)));
        }
        let across = tap_range(columns.0, columns.1, reach.0, size.width)?;
        let down = tap_range(rows.0, rows.1, reach.1, size.height)?;
        Some(Window {
            x: across.0 as u32,
            y: down.0 as u32,
            width: (across.1 - across.0 + 1) as u32,
            height: (down.1 - down.0 + 1) as u32,
        })
    }

    fn sum(
        &mut self,
        block: Rect,
        window: Window,
        weights: &mut TapWeights,
        sums: &mut impl Accumulate<T>,
    ) -> Result<()> {
        let mut samples = std::mem::take(self.window);
        self.samples.read(window, &mut samples)?;
        let (stride, size) = (window.width as usize, self.samples.size());
        let columns = AxisPixels { start: window.x, count: window.width, size: size.width };
        let rows = AxisPixels { start: window.y, count: window.height, size: size.height };
        for (voxel, column, row, scale) in self.voxels(block) {
            if !weights.across.weigh(column, scale.0, self.shape, columns)
                || !weights.down.weigh(row, scale.1, self.shape, rows)
            {
                continue;
            }

            for (line, down) in weights.down.taps() {
                let line = &samples[line * stride..][..stride];
                for (at, across) in weights.across.taps() {
                    let tap = Tap { tent: across.tent * down.tent, sharp: across.sharp * down.sharp };
                    sums.tap(voxel, tap, line[at]);
                }
            }
        }

        *self.window = samples;
        Ok(())
    }
}

impl KernelShape {
    /// Taps lie closer than this to the position, in pixels.
    fn reach(self, scale: f64) -> f64 {
        match self {
            Self::Cubic | Self::Bicubic if scale < 1.0 => 2.0,
            Self::Spline if scale < 1.0 => 3.0,
            _ => scale.max(1.0),
        }
    }

    /// Weight of its sharp kernel at a distance in pixels that lies within its reach.
    fn sharp(self, distance: f64) -> f64 {
        match self {
            Self::Spline => fourth_order(distance),
            _ => catmull_rom(distance),
        }
    }

    /// Whether it is completed at the raster's edge.
    fn is_completed(self) -> bool {
        matches!(self, Self::Bicubic | Self::Spline)
    }
}

/// First and last pixel strictly within `reach` of positions from `low` to `high`, clipped to `0..size`.
fn tap_range(low: f64, high: f64, reach: f64, size: u32) -> Option<(i64, i64)> {
    let first = ((low - reach).floor() + 1.0).max(0.0);
    let last = ((high + reach).ceil() - 1.0).min(f64::from(size) - 1.0);
    (first <= last).then_some((first as i64, last as i64))
}

/// Weights along both axes.
#[derive(Default)]
struct TapWeights {
    /// Weights along rows.
    across: Axis,
    /// Weights along columns.
    down: Axis,
}

/// Pixels of a window along one axis.
#[derive(Clone, Copy)]
struct AxisPixels {
    /// First pixel.
    start: u32,
    /// Number of pixels.
    count: u32,
    /// Pixels of the whole raster.
    size: u32,
}

/// Weights along one axis.
#[derive(Default)]
struct Axis {
    first: usize,
    taps: Vec<Tap>,
}

impl Axis {
    /// Weighs pixels around `position`; false if none of them counts.
    fn weigh(&mut self, position: f64, scale: f64, shape: KernelShape, pixels: AxisPixels) -> bool {
        let AxisPixels { start, count, size } = pixels;
        self.taps.clear();
        let (reach, radius) = (shape.reach(scale), scale.max(1.0));
        if reach <= 1.0 {
            return self.weigh_two(position - f64::from(start), count);
        }

        let relative = position - f64::from(start);
        let Some((first, last)) = tap_range(relative, relative, reach, count) else { return false };
        self.first = first as usize;
        let norm = if radius > 1.0 { tent_sum(position, radius) } else { 1.0 };

        for pixel in first..=last {
            let distance = (pixel as f64 + f64::from(start) - position).abs();
            let tent = (1.0 - distance / radius).max(0.0) / norm;
            let sharp = if reach > radius { shape.sharp(distance) } else { tent };
            self.taps.push(Tap { tent, sharp });
        }

        if reach > radius && shape.is_completed() {
            self.complete(position, shape, start, size);
        }

        true
    }

    /// Gives the weights of pixels beyond the raster's edge to the last two within, as if heights went on straight. Beyond the outermost posts the
    /// kernel stays clipped, for the neighbouring tile to complete it.
    fn complete(&mut self, position: f64, shape: KernelShape, start: u32, size: u32) {
        let last = i64::from(size) - 1;
        if !(position >= 0.0 && position <= last as f64) {
            return;
        }
        let reach = shape.reach(0.0);
        let (low, high) = ((position - reach).floor() as i64 + 1, (position + reach).ceil() as i64 - 1);
        for pixel in (low..0).chain(last + 1..=high) {
            let weight = shape.sharp((pixel as f64 - position).abs());
            let (edge, inner, beyond) =
                if pixel < 0 { (0, 1.min(last), -pixel) } else { (last, 0.max(last - 1), pixel - last) };
            self.give(edge, start, weight * (1.0 + beyond as f64));
            self.give(inner, start, -weight * beyond as f64);
        }
    }

    /// Adds to a pixel's weight if it is among the taps.
    fn give(&mut self, pixel: i64, start: u32, weight: f64) {
        let tap =
            usize::try_from(pixel - i64::from(start)).ok().and_then(|index| index.checked_sub(self.first));
        if let Some(tap) = tap.and_then(|tap| self.taps.get_mut(tap)) {
            tap.sharp += weight;
        }
    }

    /// The tent of radius one, for pixels `0..count`: the commonest case, without calls into the maths library.
    fn weigh_two(&mut self, position: f64, count: u32) -> bool {
        if !(position > -1.0 && position < f64::from(count)) {
            return false;
        }
        // Truncation is the floor of what is not negative.
        let before = (position + 1.0) as i64 - 1;
        let after_weight = position - before as f64;
        let mut push = |weight: f64| self.taps.push(Tap { tent: weight, sharp: weight });
        if before >= 0 {
            push(1.0 - after_weight);
        }
        if after_weight > 0.0 && before + 1 < i64::from(count) {
            push(after_weight);
        }
        self.first = before.max(0) as usize;
        !self.taps.is_empty()
    }

    fn taps(&self) -> impl Iterator<Item = (usize, Tap)> {
        self.taps.iter().enumerate().map(|(index, tap)| (self.first + index, *tap))
    }
}

/// Sum of an unclipped tent's weights at the whole numbers around `position`.
fn tent_sum(position: f64, radius: f64) -> f64 {
    let first = ((position - radius).floor() + 1.0) as i64;
    let last = ((position + radius).ceil() - 1.0) as i64;
    (first..=last).map(|pixel| 1.0 - (pixel as f64 - position).abs() / radius).sum()
}

/// The cubic's weight at `distance` pixels, 0 ≤ distance < 2.
fn catmull_rom(distance: f64) -> f64 {
    let d = distance;
    if d < 1.0 { (1.5 * d - 2.5) * d * d + 1.0 } else { ((2.5 - 0.5 * d) * d - 4.0) * d + 2.0 }
}

/// The weight of the cubic of fourth order at `distance` pixels, 0 ≤ distance < 3.
fn fourth_order(distance: f64) -> f64 {
    let d = distance;
    if d < 1.0 {
        (16.0 * d - 28.0) * d * d / 12.0 + 1.0
    } else if d < 2.0 {
        (((36.0 - 7.0 * d) * d - 59.0) * d + 30.0) / 12.0
    } else {
        (((d - 8.0) * d + 21.0) * d - 18.0) / 12.0
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::warp::{RasterPlacement, locate};
    use hedgehop::voxel::Grid;
    use hedgehop_geo::{Crs, Transform};

    struct Ones(u32, u32);

    impl Samples<u8> for Ones {
        fn size(&self) -> Size {
            Size { width: self.0, height: self.1 }
        }
        fn read(&self, window: Window, samples: &mut Vec<u8>) -> Result<()> {
            assert!(window.x + window.width <= self.0 && window.y + window.height <= self.1);
            samples.clear();
            samples.resize(window.width as usize * window.height as usize, 1);
            Ok(())
        }
    }

    #[derive(Clone, PartialEq, Debug)]
    struct Totals(Vec<(f64, f64)>);

    impl Accumulate<u8> for Totals {
        fn tap(&mut self, voxel: usize, tap: Tap, _: u8) {
            self.0[voxel] = (self.0[voxel].0 + tap.tent, self.0[voxel].1 + tap.sharp);
        }
    }

    fn totals(pixel: f64, shape: KernelShape, window_bytes: usize) -> Totals {
        let local = Transform::new(&Crs::local(), &Crs::local()).unwrap();
        let size = Size { width: (400.0 / pixel) as u32, height: (300.0 / pixel) as u32 };
        let placement = RasterPlacement::new(local, &[0.0, pixel, 0.0, 300.0, 0.0, -pixel], size).unwrap();
        let grid = Grid { nx: 40, ny: 30, spacing: 9.7, origin: DVec2::new(3.0, 2.0) };
        let field = locate(&placement, &grid, Rect { x0: 0, y0: 0, x1: 40, y1: 30 });
        let mut totals = Totals(vec![(0.0, 0.0); field.rect.len()]);
        let samples = Ones(size.width, size.height);
        Gather { samples: &samples, field: &field, shape, window_bytes, window: &mut Vec::new() }
            .run(&mut totals)
            .unwrap();
        totals
    }

    #[test]
    fn weights_sum_to_one_within_the_raster() {
        for pixel in [0.7, 4.0, 9.7, 20.0, 50.0] {
            for shape in [KernelShape::Tent, KernelShape::Cubic, KernelShape::Bicubic, KernelShape::Spline] {
                let totals = totals(pixel, shape, usize::MAX);
                let middle = totals.0[15 * 40 + 20];
                assert!((middle.0 - 1.0).abs() < 1e-9 && (middle.1 - 1.0).abs() < 1e-9, "{pixel} {middle:?}");
                assert!(totals.0.iter().all(|total| total.0 <= 1.0 + 1e-9));
            }
        }
    }

    #[test]
    fn windows_of_any_size_give_the_same_sums() {
        for pixel in [0.3, 9.7, 50.0] {
            let whole = totals(pixel, KernelShape::Tent, usize::MAX);
            for bytes in [1, 64, 4096] {
                assert!(totals(pixel, KernelShape::Tent, bytes) == whole, "{pixel} m, {bytes} bytes");
            }
        }
    }
}
