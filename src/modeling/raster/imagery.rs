//! Colours from a raster of samples: 8-bit sRGB with alpha.
//!
//! ```text
//! bands   those that the user gave, else 1, 2, 3; one or two bands are grey
//! 8 bits  as stored (MinIsWhite inverted)
//! others  stretched: the 2nd percentile of a sparse scan becomes 0, the 98th 255, for all bands alike, so
//!         that hues stay; chosen once, at opening, so that pixels do not depend on their window. What is scanned depends
//!         on the picture's size alone (see elevation.rs), so that strips and tiles give the same colours
//! alpha   0 where the alpha band is 0, where ALL bands used hold the nodata value, or where a sample is NaN; else 255
//! ```

use super::elevation::sparse_windows;
use super::nodata::matches;
use super::{Raster, RasterInfo, SampleType, Window};
use crate::error::{Error, Result};

/// Percentiles that become black and white.
const LOW_PERCENTILE: f64 = 0.02;
const HIGH_PERCENTILE: f64 = 0.98;

/// A raster of colours.
pub struct ImageryRaster {
    raster: Box<dyn Raster>,
    /// Colour bands (1 or 3), then the alpha band if there is one.
    bands: Vec<u32>,
    colours: usize,
    nodata: Option<f64>,
    white_is_zero: bool,
    /// Alpha is stored in 8 bits and taken as it is.
    byte_alpha: bool,
    /// What becomes 0 and what 255.
    black_white: (f64, f64),
    notes: Vec<String>,
}

impl ImageryRaster {
    /// Takes `bands` (one-based red, green, blue) of `raster`, or chooses.
    ///
    /// # Errors
    /// If the raster lacks one of `bands`, or cannot be read.
    pub fn new(raster: Box<dyn Raster>, bands: Option<[u32; 3]>) -> Result<Self> {
        let info = raster.info();
        let mut notes = Vec::new();
        let mut chosen = choose(info, bands, &mut notes)?;
        let colours = chosen.len();
        chosen.extend(info.alpha_band);
        let (nodata, white_is_zero, byte_alpha) =
            (info.nodata, info.white_is_zero, info.sample == SampleType::U8);
        let black_white = (0.0, 255.0);
        let mut this =
            Self { raster, bands: chosen, colours, nodata, white_is_zero, byte_alpha, black_white, notes };
        if this.info().sample != SampleType::U8 {
            this.black_white = this.stretch()?;
            let (black, white) = this.black_white;
            let note = format!(
                "{}: {} samples are stretched to 8 bits: {black} becomes black and {white} white (2nd and 98th percentile)",
                this.info().path.display(),
                this.info().sample.name()
            );
            this.notes.push(note);
        }
        Ok(this)
    }

    /// What the raster is.
    pub fn info(&self) -> &RasterInfo {
        self.raster.info()
    }

    /// What was chosen for the user, one sentence each.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// sRGB and alpha (0 or 255, or what the alpha band says): `[window.height][window.width]`, replacing what `pixels` held.
    pub fn read(&self, window: Window, pixels: &mut Vec<[u8; 4]>) -> Result<()> {
        let mut samples = Vec::new();
        self.raster.read(window, &self.bands, &mut samples)?;
        pixels.clear();
        // Most images are three bands of bytes that are what they say.
        let is_plain = self.info().sample == SampleType::U8 && !self.white_is_zero && self.nodata.is_none();
        if is_plain && self.colours == 3 && self.bands.len() == 3 {
            pixels.extend(samples.chunks_exact(3).map(|pixel| {
                let byte = |index: usize| pixel[index] as u8;
                [byte(0), byte(1), byte(2), u8::MAX]
            }));
        } else {
            pixels.extend(samples.chunks_exact(self.bands.len()).map(|pixel| self.pixel(pixel)));
        }
        Ok(())
    }

    fn pixel(&self, samples: &[f64]) -> [u8; 4] {
        let (colours, alpha) = samples.split_at(self.colours);
        if self.is_void(colours) {
            return [0; 4];
        }
        let alpha = alpha.first().map_or(255, |alpha| self.alpha(*alpha));
        let byte = |index: usize| self.byte(colours[index.min(self.colours - 1)]);
        [byte(0), byte(1), byte(2), alpha]
    }

    fn is_void(&self, colours: &[f64]) -> bool {
        colours.iter().any(|sample| sample.is_nan())
            || colours.iter().all(|sample| matches(*sample, self.nodata))
    }

    fn byte(&self, sample: f64) -> u8 {
        let (black, white) = self.black_white;
        let share = ((sample - black) / (white - black)).clamp(0.0, 1.0);
        let byte = (share * 255.0).round() as u8;
        if self.white_is_zero { 255 - byte } else { byte }
    }

    /// Alpha of 16 bits and more is scaled; files that use 0 and 1, or 0 and 255, in wide samples mean opaque by any value above 0.
    fn alpha(&self, sample: f64) -> u8 {
        match self.byte_alpha {
            true => sample as u8,
            false if sample > 0.0 => 255,
            false => 0,
        }
    }

    fn stretch(&self) -> Result<(f64, f64)> {
        let mut found = Vec::new();
        let mut samples = Vec::new();
        for window in sparse_windows((self.info().width, self.info().height)) {
            self.raster.read(window, &self.bands, &mut samples)?;
            for pixel in samples.chunks_exact(self.bands.len()) {
                let (colours, alpha) = pixel.split_at(self.colours);
                if alpha.first() != Some(&0.0)
                    && !self.is_void(colours)
                    && colours.iter().all(|c| c.is_finite())
                {
                    found.extend_from_slice(colours);
                }
            }
        }
        found.sort_unstable_by(f64::total_cmp);
        let percentile =
            |share: f64| found.get((share * found.len().saturating_sub(1) as f64).round() as usize).copied();
        match (percentile(LOW_PERCENTILE), percentile(HIGH_PERCENTILE)) {
            (Some(black), Some(white)) if white > black => Ok((black, white)),
            // One value, or nothing but voids: white at and above it.
            (Some(value), _) => Ok((value - 1.0, value)),
            _ => Ok((0.0, 1.0)),
        }
    }
}

/// Zero-based colour bands.
fn choose(info: &RasterInfo, bands: Option<[u32; 3]>, notes: &mut Vec<String>) -> Result<Vec<u32>> {
    if let Some(bands) = bands {
        if let Some(band) = bands.iter().find(|band| **band == 0 || **band > info.bands) {
            let what = format!("{} has bands 1 to {}, not {band} (--bands)", info.path.display(), info.bands);
            return Err(Error::Configuration(what));
        }
        return Ok(bands.iter().map(|band| band - 1).collect());
    }
    let colours: Vec<u32> = (0..info.bands).filter(|band| Some(*band) != info.alpha_band).collect();
    match colours.as_slice() {
        [] => Err(Error::invalid(&info.path, "holds an alpha band only, no colours")),
        [grey] | [grey, _] => Ok(vec![*grey]),
        [red, green, blue, others @ ..] => {
            if !others.is_empty() {
                notes.push(format!(
                    "{}: of {} bands, {}, {} and {} are taken as red, green and blue; --bands R,G,B chooses others",
                    info.path.display(),
                    info.bands,
                    red + 1,
                    green + 1,
                    blue + 1
                ));
            }
            Ok(vec![*red, *green, *blue])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Fixed, raster};
    use super::*;

    fn pixels(raster: Fixed, bands: Option<[u32; 3]>) -> (Vec<[u8; 4]>, Vec<String>) {
        let width = raster.0.width;
        let imagery = ImageryRaster::new(Box::new(raster), bands).unwrap();
        let mut pixels = Vec::new();
        imagery.read(Window { x: 0, y: 0, width, height: 1 }, &mut pixels).unwrap();
        (pixels, imagery.notes().to_vec())
    }

    #[test]
    fn nodata_must_fill_all_bands() {
        let mut rgb = raster(SampleType::U8, 3, &[0.0, 0.0, 0.0, 0.0, 7.0, 0.0]);
        rgb.0.nodata = Some(0.0);
        assert_eq!(pixels(rgb, None).0, [[0, 0, 0, 0], [0, 7, 0, 255]]);
    }

    #[test]
    fn grey_alpha_and_white_is_zero() {
        let mut grey = raster(SampleType::U8, 2, &[10.0, 255.0, 20.0, 0.0]);
        grey.0.alpha_band = Some(1);
        assert_eq!(pixels(grey, None).0, [[10, 10, 10, 255], [20, 20, 20, 0]]);
        let mut inverse = raster(SampleType::U8, 1, &[10.0]);
        inverse.0.white_is_zero = true;
        assert_eq!(pixels(inverse, None).0, [[245, 245, 245, 255]]);
    }

    #[test]
    fn six_bands() {
        let six = || raster(SampleType::U8, 6, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let (first, notes) = pixels(six(), None);
        assert_eq!(first, [[1, 2, 3, 255]]);
        assert!(notes[0].contains("--bands"), "{notes:?}");
        assert_eq!(pixels(six(), Some([3, 2, 1])).0, [[3, 2, 1, 255]]);
        let error = ImageryRaster::new(Box::new(six()), Some([7, 1, 1])).err().unwrap().to_string();
        assert!(error.contains("1 to 6"), "{error}");
    }

    #[test]
    fn wide_samples_are_stretched_alike() {
        let samples: Vec<f64> = (0..64).flat_map(|i| [f64::from(i) * 100.0 + 1000.0; 3]).collect();
        let (pixels, notes) = pixels(raster(SampleType::U16, 3, &samples), None);
        assert_eq!((pixels[0][0], pixels[63][2]), (0, 255));
        assert!((i16::from(pixels[32][1]) - 128).abs() < 8);
        assert!(notes[0].contains("stretched"), "{notes:?}");
    }
}
