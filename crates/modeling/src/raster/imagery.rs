//! Colours from a raster of samples: 8-bit sRGB with alpha.
//!
//! ```text
//! bands   those that the user gave, else those that the file calls red, green and blue, else 1, 2, 3; one or two are grey
//! 8 bits  as stored (MinIsWhite inverted)
//! others  stretched: the 2nd percentile of a sparse scan becomes 0, the 98th 255, for all bands alike, so
//!         that hues stay; chosen once, at opening, so that pixels do not depend on their window. What is scanned depends
//!         on the picture's size alone (see elevation.rs), so that strips and tiles give the same colours
//! alpha   0 where the alpha band is 0, where ALL bands used hold the nodata value, or where a sample is NaN; else 255
//! ```
//! Colours that are multiplied by alpha (TIFF's associated alpha) are divided by it before anything else, since they are
//! filtered with alpha later on; where alpha is 0 they are none.

use super::Role;
use super::elevation::sparse_windows;
use super::nodata::matches;
use crate::raster::{Raster, RasterInfo, SampleType, Window};
use hedgehop_base::error::{Error, Result};

/// Percentiles that become black and white.
const LOW_PERCENTILE: f64 = 0.02;
const HIGH_PERCENTILE: f64 = 0.98;

/// A raster of colours.
pub struct ImageryRaster {
    raster: Box<dyn Raster>,
    /// Colour bands (1 or 3), then the alpha band if there is one.
    bands: Vec<u32>,
    colours: usize,
    /// Values that mean no data, for each colour band.
    nodata: Vec<Option<f64>>,
    white_is_zero: bool,
    /// Colours are multiplied by alpha.
    is_premultiplied: bool,
    /// Alpha of what is opaque.
    opaque: f64,
    /// Samples that become 0 and 255.
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
        let nodata = chosen[..colours].iter().map(|band| info.nodata_of(*band)).collect();
        notes.extend(unused_scale(info, &chosen[..colours]));

        let mut this = Self {
            nodata,
            white_is_zero: info.white_is_zero,
            is_premultiplied: info.is_premultiplied,
            opaque: 255.0,
            black_white: (0.0, 255.0),
            raster,
            bands: chosen,
            colours,
            notes,
        };

        if this.info().sample != SampleType::U8 {
            this.fit()?;
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

    /// Returns the raster's properties.
    pub fn info(&self) -> &RasterInfo {
        self.raster.info()
    }

    /// Returns what was chosen for the user, one sentence each.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// sRGB and alpha (0 or 255, or what the alpha band says): `[window.height][window.width]`, replacing what `pixels` held.
    pub fn read(&self, window: Window, pixels: &mut Vec<[u8; 4]>) -> Result<()> {
        let mut samples = Vec::new();
        self.raster.read(window, &self.bands, &mut samples)?;
        pixels.clear();
        // Most images are three bands of bytes that are what they say.
        let is_plain = self.info().sample == SampleType::U8
            && !self.white_is_zero
            && self.nodata.iter().all(Option::is_none);
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
        let share = alpha.first().map_or(1.0, |alpha| self.share(*alpha));
        if self.is_premultiplied && share == 0.0 {
            return [0; 4];
        }
        let byte = |index: usize| self.byte(self.own(colours[index.min(self.colours - 1)], share));
        // What is there at all does not vanish by rounding.
        let alpha = if share > 0.0 { ((255.0 * share).round() as u8).max(1) } else { 0 };
        [byte(0), byte(1), byte(2), alpha]
    }

    fn is_void(&self, colours: &[f64]) -> bool {
        colours.iter().any(|sample| sample.is_nan())
            || colours.iter().zip(&self.nodata).all(|(sample, nodata)| matches(*sample, *nodata))
    }

    /// A colour without its share of alpha.
    fn own(&self, sample: f64, share: f64) -> f64 {
        if self.is_premultiplied && share > 0.0 { sample / share } else { sample }
    }

    fn byte(&self, sample: f64) -> u8 {
        let (black, white) = self.black_white;
        let share = ((sample - black) / (white - black)).clamp(0.0, 1.0);
        let byte = (share * 255.0).round() as u8;
        if self.white_is_zero { 255 - byte } else { byte }
    }

    /// Alpha, 0…1; what is no number is transparent.
    fn share(&self, sample: f64) -> f64 {
        let share = sample / self.opaque;
        if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) }
    }

    /// Finds what is opaque, black and white in samples of more than 8 bits, by some of the pixels.
    fn fit(&mut self) -> Result<()> {
        let (mut seen, mut samples) = (Vec::new(), Vec::new());
        for window in sparse_windows(self.info().size()) {
            self.raster.read(window, &self.bands, &mut samples)?;
            seen.extend_from_slice(&samples);
        }
        let alphas = seen.chunks_exact(self.bands.len()).filter_map(|pixel| pixel.get(self.colours));
        self.opaque = opaque(self.info(), alphas.copied().fold(0.0, f64::max));
        self.black_white = self.stretch(&seen);
        Ok(())
    }

    /// Percentiles of all that is seen of some pixels.
    fn stretch(&self, seen: &[f64]) -> (f64, f64) {
        let mut found = Vec::new();
        for pixel in seen.chunks_exact(self.bands.len()) {
            let (colours, alpha) = pixel.split_at(self.colours);
            let share = alpha.first().map_or(1.0, |alpha| self.share(*alpha));
            if share > 0.0 && !self.is_void(colours) && colours.iter().all(|c| c.is_finite()) {
                found.extend(colours.iter().map(|sample| self.own(*sample, share)));
            }
        }
        found.sort_unstable_by(f64::total_cmp);
        let percentile =
            |share: f64| found.get((share * found.len().saturating_sub(1) as f64).round() as usize).copied();
        match (percentile(LOW_PERCENTILE), percentile(HIGH_PERCENTILE)) {
            (Some(black), Some(white)) if white > black => (black, white),
            // One value, or nothing but voids: white at and above it.
            (Some(value), _) => (value - 1.0, value),
            _ => (0.0, 1.0),
        }
    }
}

/// Alpha of what is opaque: files use 0 and 1, or 0 to 255, in wide samples too; `most` is the largest that was seen.
fn opaque(info: &RasterInfo, most: f64) -> f64 {
    let largest = match info.sample {
        SampleType::U8 => 255.0,
        SampleType::I8 => 127.0,
        SampleType::U16 => f64::from(u16::MAX),
        SampleType::I16 => f64::from(i16::MAX),
        SampleType::U32 => f64::from(u32::MAX),
        SampleType::I32 => f64::from(i32::MAX),
        SampleType::F32 | SampleType::F64 => 1.0,
    };
    // Colours are multiplied by a share of the largest sample, however little of it is seen.
    if info.is_premultiplied || most <= 1.0 {
        return if info.is_premultiplied { largest } else { 1.0 };
    }
    if most <= 255.0 { largest.clamp(127.0, 255.0) } else { largest.max(most.min(f64::from(u16::MAX))) }
}

/// Says what scales colours do not use. Where samples are stretched, the same one for all changes nothing.
fn unused_scale(info: &RasterInfo, bands: &[u32]) -> Option<String> {
    let scale = |band: &u32| {
        let described = info.described.get(*band as usize).copied();
        described.map_or((info.scale, info.offset), |band| (band.scale, band.offset))
    };
    let first = scale(bands.first()?);
    let is_even = bands.iter().all(|band| scale(band) == first) && first.0 > 0.0;
    let is_used = if info.sample == SampleType::U8 { first == (1.0, 0.0) && is_even } else { is_even };
    (!is_used).then(|| {
        format!(
            "{}: states scales or offsets of its bands; colours are taken as they are stored",
            info.path.display()
        )
    })
}

/// Refuses bands that are said to tell colours otherwise than by grey, or red, green and blue.
fn refuse_other_colours(info: &RasterInfo) -> Result<()> {
    let has = |role: Role| info.described.iter().any(|band| band.role == role);
    let (what, remedy) = if has(Role::Palette) {
        ("has a colour palette", "convert it: gdal_translate -expand rgb IN out.tif")
    } else if has(Role::OtherColour) && info.stated_colours().is_none() {
        (
            "has bands that are said to be hues, inks or differences of colours",
            "convert it to red, green and blue, or say with --bands R,G,B which bands they are",
        )
    } else {
        return Ok(());
    };
    Err(Error::unsupported(&info.path, what, remedy))
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

    refuse_other_colours(info)?;
    let seen: Vec<u32> = info.seen_bands().collect();
    if let ([], _) | ([_] | [_, _], None) = (&seen[..], info.stated_colours()) {
        let grey = seen.first().copied();
        return grey
            .map(|grey| vec![grey])
            .ok_or_else(|| Error::invalid(&info.path, "holds an alpha band only, no colours"));
    }

    let stated = info.stated_colours();
    let chosen = stated.unwrap_or_else(|| [seen[0], seen[1], seen[2]]);

    // Three bands of which a file says nothing are what everybody takes them for.
    let is_said = info.described.iter().any(|band| band.role == Role::Other);
    if seen.len() > 3 || stated.is_none() && is_said {
        let [red, green, blue] = chosen.map(|band| band + 1);
        let because = match stated {
            Some(_) => ", as the file says",
            None if is_said => ", since the file names none so",
            None => "",
        };

        notes.push(format!(
            "{}: of {} bands, {red}, {green} and {blue} are taken as red, green and blue{because}; --bands R,G,B \
             chooses others",
            info.path.display(),
            info.bands,
        ));
    }

    Ok(chosen.to_vec())
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Fixed, raster};
    use super::*;
    use crate::raster::Band;

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
    fn colours_are_those_that_the_file_names() {
        let named = |roles: &[Role]| {
            let samples: Vec<f64> = (1..=roles.len()).map(|band| band as f64).collect();
            let mut raster = raster(SampleType::U8, roles.len() as u32, &samples);
            raster.0.described = roles.iter().map(|role| Band { role: *role, ..Band::default() }).collect();
            raster.0.settle_bands();
            raster
        };

        let (blue_first, other) = ([Role::Blue, Role::Green, Role::Red], Role::Other);
        let (found, notes) = pixels(named(&blue_first), None);
        assert_eq!((found, notes.len()), (vec![[3, 2, 1, 255]], 0));
        assert_eq!(pixels(named(&blue_first), Some([1, 2, 3])).0, [[1, 2, 3, 255]]);

        // As of satellites: the fourth is infrared light.
        let (found, notes) = pixels(named(&[Role::Blue, Role::Green, Role::Red, other]), None);
        assert_eq!(found, [[3, 2, 1, 255]]);
        assert!(
            notes[0].contains("3, 2 and 1 are taken") && notes[0].contains("as the file says"),
            "{notes:?}"
        );

        for (roles, what) in [
            (&[Role::Palette][..], "palette"),
            (&[Role::OtherColour, Role::OtherColour, Role::OtherColour], "hues, inks"),
        ] {
            let error =
                ImageryRaster::new(Box::new(named(roles)), None).err().expect("no colours").to_string();
            assert!(error.contains(what), "{error}");
        }

        let hues = named(&[Role::OtherColour, Role::OtherColour, Role::OtherColour]);
        assert_eq!(pixels(hues, Some([1, 2, 3])).0, [[1, 2, 3, 255]]);

        let alpha_first = named(&[Role::Alpha, Role::Red, Role::Green, Role::Blue]);
        assert_eq!(pixels(alpha_first, None).0, [[2, 3, 4, 1]]);
        let (found, notes) = pixels(named(&[other, other, other]), None);
        assert_eq!(found, [[1, 2, 3, 255]]);
        assert!(notes[0].contains("names none"), "{notes:?}");
    }

    #[test]
    fn associated_alpha_is_divided_out() {
        let mut own =
            raster(SampleType::U8, 4, &[50.0, 100.0, 128.0, 128.0, 9.0, 9.0, 9.0, 0.0, 1.0, 2.0, 3.0, 255.0]);
        (own.0.alpha_band, own.0.is_premultiplied) = (Some(3), true);
        assert_eq!(pixels(own, None).0, [[100, 199, 255, 128], [0; 4], [1, 2, 3, 255]]);

        // Of 16 bits: the same colour under every alpha, however little of it is seen.
        let samples: Vec<f64> = (0..=64)
            .flat_map(|i| {
                let alpha = f64::from(i) * 4.0;
                let colour = if i % 2 == 0 { 10_000.0 } else { 30_000.0 };
                [colour * alpha / 65_535.0, colour * alpha / 65_535.0, colour * alpha / 65_535.0, alpha]
            })
            .collect();

        let mut own = raster(SampleType::U16, 4, &samples);
        (own.0.alpha_band, own.0.is_premultiplied) = (Some(3), true);
        let found = pixels(own, None).0;
        assert_eq!(found[0], [0; 4]);
        for (index, pixel) in found.iter().enumerate().skip(1) {
            let colour = if index % 2 == 0 { 0 } else { 255 };
            assert_eq!(*pixel, [colour, colour, colour, 1], "{index}");
        }
    }

    #[test]
    fn alpha_of_wide_samples_is_a_share() {
        let alphas = |full: f64| {
            let samples: Vec<f64> =
                [0.0, 0.5, 1.0].into_iter().flat_map(|a| [7.0, (a * full).floor()]).collect();
            let mut grey = raster(SampleType::U16, 2, &samples);
            grey.0.alpha_band = Some(1);
            pixels(grey, None).0.iter().map(|pixel| pixel[3]).collect::<Vec<_>>()
        };
        assert_eq!(alphas(65_535.0), [0, 127, 255]);
        assert_eq!(alphas(255.0), [0, 127, 255]);
        assert_eq!(alphas(1.0), [0, 0, 255]);
    }

    #[test]
    fn scales_that_colours_do_not_use_are_told() {
        let told = |sample, scales: [f64; 3]| {
            let mut rgb = raster(sample, 3, &[1.0, 2.0, 3.0]);
            rgb.0.described = scales.iter().map(|scale| Band { scale: *scale, ..Band::default() }).collect();
            pixels(rgb, None).1.iter().any(|note| note.contains("as they are stored"))
        };
        assert!(!told(SampleType::U8, [1.0; 3]) && told(SampleType::U8, [0.1; 3]));
        assert!(!told(SampleType::U16, [0.1; 3]) && told(SampleType::U16, [0.1, 0.1, 0.2]));
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
