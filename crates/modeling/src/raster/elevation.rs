//! Heights in metres from a raster of samples, voids as NaN.
//!
//! ```text
//! void    if the sample is NaN or infinite, equals the declared nodata value or one that the user gave,
//!         lies where the alpha band is 0, is -9999 in a raster that is no deep sea (below),
//!         or is no height on Earth once converted (below −12 000 m or above 9 000 m)
//! height  = (offset + scale · sample) · metres per unit
//! ```
//! Voids that are not declared are counted, and [`ElevationRaster::notes`] tells them once. −9999 m is a depth that occurs;
//! so a sparse scan at opening decides whether the raster holds other depths below −8000 m, in which case −9999 is a depth too. The
//! decision is taken once, so that a post does not depend on the window it is read through, and by the same pixels whatever the
//! file's blocks: 8 × 8 cells of 64 × 16 pixels, evenly spread, first and last included. That is some 64 tiles, or 128 rows.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use super::nodata::matches;
use crate::raster::{Raster, RasterInfo, SampleType, Window};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

/// Heights on Earth, metres: the deepest sea is at −10 935 m, the highest summit at 8849 m.
const PLAUSIBLE: std::ops::RangeInclusive<f64> = -12_000.0..=9_000.0;
/// The sentinel that is also a depth.
const AMBIGUOUS: f64 = -9999.0;
/// Depths around [`AMBIGUOUS`] that show that a raster covers the deep sea, metres.
const DEEP_SEA: std::ops::Range<f64> = -12_000.0..-8_000.0;
/// Cells that the sparse scan looks at, along each axis.
const SCAN: u32 = 8;
/// Columns and rows of a cell. Tiles as they are usual hold such cells whole, and strips are decoded in few rows.
const CELL: Size = Size { width: 64, height: 16 };
/// Undeclared void values that are told apart; further ones are counted together.
const TOLD_APART: usize = 4;

/// A raster of heights.
pub struct ElevationRaster {
    raster: Box<dyn Raster>,
    /// The band, and the alpha band if there is one.
    bands: Vec<u32>,
    conversion: Conversion,
    undeclared: Mutex<BTreeMap<HeightValue, u64>>,
}

/// Conversion of samples to heights.
struct Conversion {
    /// Declared by the file or given by the user.
    nodata: Vec<f64>,
    scale: f64,
    offset: f64,
    metres_per_unit: f64,
    /// [`AMBIGUOUS`] is a depth.
    deep_sea: bool,
}

impl Conversion {
    fn metres(&self, sample: f64) -> f64 {
        (self.offset + self.scale * sample) * self.metres_per_unit
    }

    fn is_nodata(&self, sample: f64) -> bool {
        sample.is_nan() || self.nodata.iter().any(|value| matches(sample, Some(*value)))
    }

    /// Whether none of the samples is void: looked at many at a time, since that is so nearly everywhere.
    fn are_heights(&self, samples: &[f64]) -> bool {
        let none_is = |value: f64| samples.iter().fold(true, |none, sample| none & (*sample != value));
        let is_plausible = |sample: &f64| {
            let height = self.metres(*sample);
            (height >= *PLAUSIBLE.start()) & (height <= *PLAUSIBLE.end())
        };
        samples.iter().fold(true, |all, sample| all & is_plausible(sample))
            && self.nodata.iter().all(|value| none_is(*value))
            && (self.deep_sea || none_is(AMBIGUOUS))
    }

    /// The height, NaN if void.
    fn height(&self, sample: f64) -> f64 {
        if self.is_nodata(sample) || sample == AMBIGUOUS && !self.deep_sea {
            return f64::NAN;
        }
        let height = self.metres(sample);
        if PLAUSIBLE.contains(&height) { height } else { f64::NAN }
    }
}

/// A sample by its bits, for counting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct HeightValue(u64);

/// Returns the windows of the sparse scans. They depend on the size of a raster alone: the same pixels in other blocks must come to the same.
pub(super) fn sparse_windows(size: Size) -> impl Iterator<Item = Window> {
    let axis = |size: u32, side: u32| {
        let cells = size.div_ceil(side);
        let count = cells.min(SCAN);
        // Evenly spread cells, first and last included.
        (0..count).map(move |i| {
            let number = u64::from(i) * u64::from(cells - 1) / u64::from((count - 1).max(1));
            let begin = number as u32 * side;
            (begin, side.min(size - begin))
        })
    };
    // Row by row, so that a strip is decoded once.
    axis(size.height, CELL.height).flat_map(move |(y, height)| {
        axis(size.width, CELL.width).map(move |(x, width)| Window { x, y, width, height })
    })
}

impl ElevationRaster {
    /// Takes the first band of `raster` that is no alpha for heights; `nodata` are raw samples that mean void besides
    /// what the file declares; heights count in `metres_per_unit`, below 0 for depths.
    ///
    /// # Errors
    /// If the raster looks like imagery, or cannot be read.
    pub fn new(raster: Box<dyn Raster>, nodata: &[f64], metres_per_unit: f64) -> Result<Self> {
        let info = raster.info();
        let seen: Vec<u32> = info.seen_bands().collect();
        if seen.len() >= 3 && info.sample == SampleType::U8 {
            let what =
                format!("holds {} bands of bytes and looks like imagery, not like heights", seen.len());
            let remedy = "give it to --imagery, or take one band: gdal_translate -b 1 IN out.tif";
            return Err(Error::unsupported(&info.path, what, remedy));
        }
        let Some(band) = seen.first() else {
            return Err(Error::invalid(&info.path, "holds an alpha band only, no heights"));
        };

        let bands = std::iter::once(*band).chain(info.alpha_band).collect();
        let given = nodata.iter().map(|value| info.sample.round(*value));
        let mut conversion = Conversion {
            nodata: info.nodata_of(*band).into_iter().chain(given).collect(),
            scale: info.scale,
            offset: info.offset,
            metres_per_unit,
            deep_sea: false,
        };

        conversion.deep_sea = covers_deep_sea(raster.as_ref(), *band, &conversion)?;
        Ok(Self { raster, bands, conversion, undeclared: Mutex::new(BTreeMap::new()) })
    }

    /// Returns the raster's properties.
    pub fn info(&self) -> &RasterInfo {
        self.raster.info()
    }

    /// Heights in metres above the raster's vertical datum, NaN where void: `[window.height][window.width]`, replacing
    /// what `heights` held.
    pub fn read(&self, window: Window, heights: &mut Vec<f64>) -> Result<()> {
        self.raster.read(window, &self.bands, heights)?;
        let mut undeclared: BTreeMap<HeightValue, u64> = BTreeMap::new();
        if self.bands.len() == 2 {
            for pixel in 0..heights.len() / 2 {
                let (sample, alpha) = (heights[2 * pixel], heights[2 * pixel + 1]);
                heights[pixel] = if alpha == 0.0 { f64::NAN } else { sample };
            }
            heights.truncate(heights.len() / 2);
        }

        if self.conversion.are_heights(heights) {
            heights.iter_mut().for_each(|sample| *sample = self.conversion.metres(*sample));
            return Ok(());
        }

        for sample in heights.iter_mut() {
            let height = self.conversion.height(*sample);
            if height.is_nan() && !self.conversion.is_nodata(*sample) {
                *undeclared.entry(HeightValue(sample.to_bits())).or_default() += 1;
            }
            *sample = height;
        }

        if !undeclared.is_empty() {
            self.count(undeclared);
        }

        Ok(())
    }

    /// Undeclared void values that were met so far, one sentence for each.
    pub fn notes(&self) -> Vec<String> {
        let info = self.info();
        let mut notes = Vec::new();
        if info.seen_bands().nth(1).is_some() {
            let band = self.bands[0] + 1;
            notes.push(format!(
                "{}: heights are taken from band {band} of {}",
                info.path.display(),
                info.bands
            ));
        }

        if let Some(unit) = &info.unknown_unit {
            let taken = match self.conversion.metres_per_unit {
                1.0 => "metres".to_owned(),
                metres => format!("{metres} m each"),
            };
            notes.push(format!(
                "{}: states {unit:?} as the unit of its heights, which is not known here; they are taken as {taken}",
                info.path.display()
            ));
        }

        let undeclared = self.undeclared.lock().unwrap_or_else(PoisonError::into_inner);
        let mut values: Vec<_> =
            undeclared.iter().map(|(value, count)| (f64::from_bits(value.0), *count)).collect();
        values.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.total_cmp(&b.0)));

        for (value, count) in values.iter().take(TOLD_APART) {
            let remedy =
                if value.is_finite() { format!("; --nodata {value} says the same") } else { String::new() };
            notes.push(format!(
                "{}: {count} samples of {value} are no heights and are taken as voids, though the file does not declare \
                 them{remedy}",
                info.path.display()
            ));
        }

        let others: u64 = values.iter().skip(TOLD_APART).map(|(_, count)| count).sum();
        if others > 0 {
            let path = info.path.display();
            notes.push(format!(
                "{path}: {others} further samples of other values are no heights and are taken as voids"
            ));
        }

        notes
    }

    fn count(&self, found: BTreeMap<HeightValue, u64>) {
        /// A file full of noise must not fill the memory with its values.
        const MOST: usize = 4096;
        let mut undeclared = self.undeclared.lock().unwrap_or_else(PoisonError::into_inner);
        for (value, count) in found {
            let value = if undeclared.len() < MOST || undeclared.contains_key(&value) {
                value
            } else {
                HeightValue(f64::INFINITY.to_bits())
            };
            *undeclared.entry(value).or_default() += count;
        }
    }
}

/// Whether a sparse scan finds depths around [`AMBIGUOUS`].
fn covers_deep_sea(raster: &dyn Raster, band: u32, conversion: &Conversion) -> Result<bool> {
    if conversion.is_nodata(AMBIGUOUS) {
        return Ok(false);
    }
    let is_deep = |sample: &f64| {
        let sample = *sample;
        sample != AMBIGUOUS && !conversion.is_nodata(sample) && DEEP_SEA.contains(&conversion.metres(sample))
    };
    let mut samples = Vec::new();
    for window in sparse_windows(raster.info().size()) {
        raster.read(window, &[band], &mut samples)?;
        if samples.iter().any(is_deep) {
            return Ok(true);
        }
    }
    Ok(false)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Fixed, raster};
    use super::*;

    fn heights(raster: Fixed, nodata: &[f64]) -> (Vec<f64>, Vec<String>) {
        heights_in(1.0, raster, nodata)
    }

    fn heights_in(metres_per_unit: f64, raster: Fixed, nodata: &[f64]) -> (Vec<f64>, Vec<String>) {
        let width = raster.0.width;
        let elevation = ElevationRaster::new(Box::new(raster), nodata, metres_per_unit).unwrap();
        let mut heights = Vec::new();
        elevation.read(Window { x: 0, y: 0, width, height: 1 }, &mut heights).unwrap();
        (heights, elevation.notes())
    }

    fn voids(heights: &[f64]) -> Vec<bool> {
        heights.iter().map(|height| height.is_nan()).collect()
    }

    #[test]
    fn undeclared_sentinels_are_voids_and_told() {
        let (heights, notes) =
            heights(raster(SampleType::I16, 1, &[5.0, -32767.0, -9999.0, 32767.0, -3.0]), &[]);
        assert_eq!(voids(&heights), [false, true, true, true, false]);
        assert_eq!(notes.len(), 3);
        assert!(notes.iter().any(|note| note.contains("1 samples of -32767")), "{notes:?}");
    }

    #[test]
    fn declared_and_given_values_are_not_told() {
        let mut given = raster(SampleType::F32, 1, &[0.0, f64::from(-3.4e38f32), 7.0, f64::NAN]);
        given.0.nodata = Some(f64::from(-3.4e38f32));
        let (heights, notes) = heights(given, &[7.0]);
        assert_eq!(voids(&heights), [false, true, true, true]);
        assert!(notes.is_empty(), "{notes:?}");
    }

    #[test]
    fn a_deep_sea_keeps_its_depths() {
        let (heights, _) = heights(raster(SampleType::I16, 1, &[-9998.0, -9999.0, -10_000.0]), &[]);
        assert_eq!(heights, [-9998.0, -9999.0, -10_000.0]);
    }

    #[test]
    fn feet_scale_and_offset() {
        let mut feet = raster(SampleType::I16, 1, &[10.0, 20_000.0]);
        (feet.0.scale, feet.0.offset) = (2.0, 80.0);
        let (heights, _) = heights_in(0.3048, feet, &[]);
        assert!((heights[0] - 30.48).abs() < 1e-12);
        assert!(heights[1].is_nan(), "12 km");
    }

    #[test]
    fn alpha_makes_voids() {
        let mut with_alpha = raster(SampleType::U16, 2, &[5.0, 0.0, 6.0, 255.0]);
        with_alpha.0.alpha_band = Some(1);
        assert_eq!(voids(&heights(with_alpha, &[]).0), [true, false]);
    }

    #[test]
    fn imagery_is_refused() {
        let error = ElevationRaster::new(Box::new(raster(SampleType::U8, 3, &[1.0, 2.0, 3.0])), &[], 1.0)
            .err()
            .unwrap();
        assert!(error.to_string().contains("--imagery"), "{error}");
    }

    #[test]
    fn voids_do_not_depend_on_blocks() {
        // Depths that are seen if whole blocks of 64 or of 100 pixels are looked at, and a sentinel.
        let voids_in = |width: u32, height: u32| {
            let mut sea = raster(SampleType::I16, 1, &[0.0]);
            (sea.0.width, sea.0.height, sea.0.block) = (1024, 1024, Size { width, height });
            sea.1 = vec![0.0; 1024 * 1024];
            (100..128).for_each(|x| (0..64).for_each(|y| sea.1[y * 1024 + x] = -9000.0));
            sea.1[0] = AMBIGUOUS;
            voids(&heights(sea, &[]).0)
        };
        let expected = voids_in(64, 64);
        for (width, height) in [(100, 64), (128, 128), (1024, 1), (1024, 1024)] {
            assert_eq!(voids_in(width, height), expected, "{width} × {height}");
        }
    }

    #[test]
    fn sparse_windows_lie_within_and_are_few() {
        for (width, height) in [(1, 1), (63, 17), (4000, 3000), (17, 5000), (9, 9), (1 << 30, 1 << 30)] {
            let windows: Vec<_> = sparse_windows(Size { width, height }).collect();
            let rows: u32 = windows.iter().filter(|w| w.x == 0).map(|w| w.height).sum();
            assert!(!windows.is_empty() && windows.len() <= 64 && rows <= 128);
            let is_at = |x: u32, y: u32| windows.iter().any(|w| w.x + w.width == x && w.y + w.height == y);
            assert!(windows[0].x == 0 && windows[0].y == 0 && is_at(width, height), "{windows:?}");
            for (index, w) in windows.iter().enumerate() {
                let is_inside = w.x + w.width <= width && w.y + w.height <= height;
                assert!(w.width > 0 && w.height > 0 && is_inside && !windows[..index].contains(w), "{w:?}");
            }
        }
    }
}
