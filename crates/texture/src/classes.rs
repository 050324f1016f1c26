//! Classes of land and their textures, in a table that people can edit.
//!
//! ```text
//! class → polynomial, side of a cell, lines and slip of subterrains, gain and offset in each band
//! ```
//!
//! The study of cyclic codes (AFHRL on ACTES) recommends textures of classes such as forest, field and grass;
//! their values are ours.

use std::collections::BTreeMap;

use hedgehop_base::error::{Error, Result};
use serde::{Deserialize, Serialize};

use crate::bands::{BandTone, BandTones, SensorBand};
use crate::cell_box::CellBox;
use crate::code::CyclicCode;
use crate::subterrain::{Subterrain, SubterrainCode};
use crate::table_text;

/// Name in errors.
const WHAT: &str = "classes of textures";

/// Subterrains to either side of the origin; the last go on.
const SUBTERRAINS: i64 = 2048;

/// Texture of a class of land.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TextureClass {
    /// Primitive polynomial of degree 8, a bit for each power.
    pub polynomial: u64,
    /// Side of a cell, metres, above 0: finer than the finest voxel.
    pub cell_m: f64,
    /// Lines of cells of a subterrain.
    pub lines: u32,
    /// Places along the code from the start of a subterrain to that of the next.
    pub slip: i64,
    /// Gains and offsets.
    pub bands: BandTones,
}

/// Textures by the names of classes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct TextureClasses(BTreeMap<String, TextureClass>);

/// Texture of a class over the ground.
#[derive(Debug, Clone)]
pub struct ClassTexture {
    code: SubterrainCode,
    cell_m: f64,
    bands: BandTones,
}

impl TextureClasses {
    /// Reads classes from TOML, a table for each.
    ///
    /// # Errors
    ///
    /// The text is no TOML of classes, or a class has no texture; the sentence names it.
    pub fn from_text(text: &str) -> Result<Self> {
        let classes: Self = table_text::from_text(text, WHAT)?;
        for (name, class) in &classes.0 {
            ClassTexture::new(class)
                .map_err(|error| Error::Configuration(format!("class \"{name}\": {error}")))?;
        }
        Ok(classes)
    }

    /// Writes classes as TOML, from which they come back as they are.
    ///
    /// # Errors
    ///
    /// Never, as classes hold what tables can.
    pub fn to_text(&self) -> Result<String> {
        table_text::to_text(self)
    }

    /// Names of classes, in the order of the alphabet.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// Class of a name.
    pub fn get(&self, name: &str) -> Option<&TextureClass> {
        self.0.get(name)
    }
}

impl Default for TextureClasses {
    /// Forest, field, grass and sea.
    fn default() -> Self {
        let tone = |offset: f64, gain: f64| BandTone { offset, gain };
        let class =
            |polynomial, cell_m, [lines, slip]: [u32; 2], [visual, low_light, infrared]: [BandTone; 3]| {
                let bands = BandTones { visual, low_light, infrared };
                TextureClass { polynomial, cell_m, lines, slip: slip.into(), bands }
            };
        let forest = [tone(70.0, 0.36), tone(120.0, 0.5), tone(90.0, -0.2)];
        let field = [tone(140.0, 0.12), tone(130.0, 0.15), tone(150.0, 0.2)];
        let grass = [tone(110.0, 0.2), tone(160.0, 0.3), tone(120.0, -0.1)];
        let sea = [tone(60.0, 0.06), tone(40.0, 0.05), tone(70.0, 0.02)];
        let classes = [
            ("forest", class(0x12B, 1.5, [3, 40], forest)),
            ("field", class(0x11D, 0.5, [1, 1], field)),
            ("grass", class(0x14D, 0.25, [2, 87], grass)),
            ("sea", class(0x165, 2.0, [9, 10], sea)),
        ];
        Self(classes.into_iter().map(|(name, class)| (name.to_owned(), class)).collect())
    }
}

impl ClassTexture {
    /// Lays a class over the ground.
    ///
    /// # Errors
    ///
    /// The polynomial is not primitive or of another degree than 8, or the side of a cell is not above 0.
    pub fn new(class: &TextureClass) -> Result<Self> {
        let code = CyclicCode::new(class.polynomial)?;
        if code.degree() != 8 {
            return Err(Error::Configuration(format!(
                "the polynomial {:#x} is of degree {}, whose tones are no greys; want degree 8, such as 0x12b",
                class.polynomial,
                code.degree()
            )));
        }
        if !(class.cell_m > 0.0 && class.cell_m.is_finite()) {
            return Err(Error::Configuration(format!(
                "cells are {} m wide; want a side above 0",
                class.cell_m
            )));
        }
        let lines = i64::from(class.lines.max(1));
        let subterrain =
            |number: i64| Subterrain { first_line: number * lines, start: number.wrapping_mul(class.slip) };
        let subterrains = (-SUBTERRAINS..SUBTERRAINS).map(subterrain).collect();
        Ok(Self { code: SubterrainCode::new(code, subterrains)?, cell_m: class.cell_m, bands: class.bands })
    }

    /// Grey in a band at a place, metres: of 256, not rounded.
    pub fn grey(&self, band: SensorBand, x: f64, y: f64) -> f64 {
        let [column, line] = [x, y].map(|metres| (metres / self.cell_m).floor() as i64);
        self.bands.of(band).grey(f64::from(self.code.tone(column, line)) - 128.0)
    }

    /// Mean grey in a band over a box in metres, exact.
    pub fn mean(&self, band: SensorBand, over: CellBox) -> f64 {
        let [x0, x1, y0, y1] = [over.x0, over.x1, over.y0, over.y1].map(|metres| metres / self.cell_m);
        self.bands.of(band).grey(self.code.mean(CellBox { x0, x1, y0, y1 }) - 128.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Greys of a class in a band at places without order.
    fn greys(class: &TextureClass, band: SensorBand) -> Vec<f64> {
        let texture = ClassTexture::new(class).unwrap();
        let place = |number: u32| (f64::from(number) * 1.618 % 900.0, f64::from(number) * 0.755 % 700.0);
        (0..20_000).map(place).map(|(x, y)| texture.grey(band, x, y)).collect()
    }

    fn moments(greys: &[f64]) -> [f64; 2] {
        let mean = greys.iter().sum::<f64>() / greys.len() as f64;
        let squares: f64 = greys.iter().map(|grey| (grey - mean).powi(2)).sum();
        [mean, (squares / greys.len() as f64).sqrt()]
    }

    fn correlation(a: &[f64], b: &[f64]) -> f64 {
        let ([mean_a, deviation_a], [mean_b, deviation_b]) = (moments(a), moments(b));
        let products = a.iter().zip(b).map(|(a, b)| (a - mean_a) * (b - mean_b));
        products.sum::<f64>() / a.len() as f64 / (deviation_a * deviation_b)
    }

    #[test]
    fn classes_come_back_from_their_text() {
        let classes = TextureClasses::default();
        let text = classes.to_text().unwrap();
        assert_eq!(TextureClasses::from_text(&text).unwrap(), classes);
        assert_eq!(classes.names().collect::<Vec<_>>(), ["field", "forest", "grass", "sea"]);

        let error = |from: &str, to: &str| {
            assert!(text.contains(from), "{text}");
            TextureClasses::from_text(&text.replace(from, to)).unwrap_err().to_string()
        };
        let composite = error("polynomial = 299", "polynomial = 300");
        assert!(composite.contains("\"forest\"") && composite.contains("not primitive"), "{composite}");
        assert!(error("polynomial = 299", "polynomial = 0x409").contains("degree 10"));
        assert!(error("cell_m = 0.5", "cell_m = 0").contains("above 0"));
        assert!(error("slip = 40", "slop = 40").contains("slop"));
    }

    #[test]
    fn classes_differ_in_contrast() {
        let classes = TextureClasses::default();
        let mut deviations = Vec::new();
        for name in classes.names() {
            let class = classes.get(name).unwrap();
            let [mean, deviation] = moments(&greys(class, SensorBand::Visual));
            let visual = class.bands.visual;
            assert!((mean - visual.offset).abs() < 1.5, "{name}: {mean}");
            assert!((deviation / (73.6 * visual.gain) - 1.0).abs() < 0.03, "{name}: {deviation}");
            deviations.push(deviation);
        }
        deviations.sort_by(f64::total_cmp);
        // Sea 4, field 9, grass 15, forest 26 greys.
        assert!(deviations.windows(2).all(|pair| pair[1] > 1.5 * pair[0]), "{deviations:?}");
    }

    #[test]
    fn bands_show_one_pattern_at_other_gains_and_offsets() {
        let classes = TextureClasses::default();
        for name in classes.names() {
            let class = classes.get(name).unwrap();
            let [visual, low_light, infrared] = SensorBand::ALL.map(|band| greys(class, band));
            assert!((correlation(&visual, &low_light) - 1.0).abs() < 1e-9, "{name}");
            let sign = (class.bands.visual.gain * class.bands.infrared.gain).signum();
            assert!((correlation(&visual, &infrared) - sign).abs() < 1e-9, "{name}");

            // Nothing but gain and offset lies between two bands.
            let (from, to) = (class.bands.visual, class.bands.infrared);
            for (visual, infrared) in visual.iter().zip(&infrared) {
                assert!((to.grey((visual - from.offset) / from.gain) - infrared).abs() < 1e-9, "{name}");
            }

            // As 256 greys of a display, too.
            let shown =
                |greys: &[f64]| greys.iter().map(|grey| grey.round().clamp(0.0, 255.0)).collect::<Vec<_>>();
            let found = correlation(&shown(&visual), &shown(&infrared));
            assert!((found - sign).abs() < 0.05, "{name}: {found}");
        }
    }

    #[test]
    fn means_over_boxes_are_those_of_greys() {
        let classes = TextureClasses::default();
        let texture = ClassTexture::new(classes.get("forest").unwrap()).unwrap();
        let over = CellBox { x0: 30.0, x1: 45.0, y0: -6.0, y1: 9.0 };
        let cells = (0..100).map(|number| {
            let (x, y) = (30.75 + 1.5 * f64::from(number % 10), -5.25 + 1.5 * f64::from(number / 10));
            texture.grey(SensorBand::Infrared, x, y)
        });
        assert!((texture.mean(SensorBand::Infrared, over) - cells.sum::<f64>() / 100.0).abs() < 1e-9);
    }
}
