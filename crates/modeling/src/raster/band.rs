//! Bands as GDAL describes them: which colour each is, its scale, offset, unit, and value for no data.
//!
//! They stand in a TIFF's tag 42112 and in `FILE.aux.xml` beside a raster of any format, which counts where both speak, as in GDAL.

use super::nodata;
use crate::raster::{Band, RasterInfo, Role};
use hedgehop_base::error::{Error, Result};

impl Default for Band {
    fn default() -> Self {
        Self { role: Role::Unknown, scale: 1.0, offset: 0.0, nodata: None }
    }
}

impl Role {
    /// Finds the role of GDAL's name of a colour interpretation.
    pub(super) fn of(name: &str) -> Self {
        match name.trim().to_ascii_lowercase().as_str() {
            "red" => Self::Red,
            "green" => Self::Green,
            "blue" => Self::Blue,
            "alpha" => Self::Alpha,
            "palette" => Self::Palette,
            "hue" | "saturation" | "lightness" | "cyan" | "magenta" | "yellow" | "black" | "ycbcr_y"
            | "ycbcr_cb" | "ycbcr_cr" => Self::OtherColour,
            _ => Self::Other,
        }
    }
}

/// A statement on a band: what it is about, and its text.
pub(super) struct Statement<'t> {
    /// Zero-based.
    pub band: u32,
    pub subject: Subject,
    pub text: &'t str,
}

/// Subject of a statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Subject {
    Role,
    Scale,
    Offset,
    Unit,
    Nodata,
}

impl RasterInfo {
    /// Takes a statement; what is said of bands that are not there means nothing.
    ///
    /// # Errors
    /// What should be a number and is none; `source` names where it stands.
    pub(super) fn state(&mut self, source: &str, statement: &Statement<'_>) -> Result<()> {
        let Statement { band: number, subject, text } = *statement;
        if number >= self.bands {
            return Ok(());
        }

        if self.described.is_empty() {
            self.described = vec![Band::default(); self.bands as usize];
        }

        let wrong = || {
            let what = format!(
                "states {text:?} as the {subject:?} of band {} in {source}, which is no number",
                number + 1
            );
            Error::invalid(
                &self.path,
                what.replace("Nodata", "value for no data")
                    .replace("Scale", "scale")
                    .replace("Offset", "offset"),
            )
        };

        let finite = || text.trim().parse::<f64>().ok().filter(|number| number.is_finite()).ok_or_else(wrong);
        let mut band = self.described[number as usize];
        match subject {
            Subject::Role => band.role = Role::of(text),
            Subject::Scale => band.scale = finite()?,
            Subject::Offset => band.offset = finite()?,
            Subject::Nodata => band.nodata = nodata::parse(text, self.sample).map_err(|_| wrong())?,
            Subject::Unit if number == 0 && !text.trim().is_empty() => match metres_per_unit(text) {
                Some(metres) => {
                    let is_down = self.vertical.metres_per_unit.is_some_and(|stated| stated < 0.0);
                    self.vertical.metres_per_unit = Some(if is_down { -metres } else { metres });
                }
                None => self.unknown_unit = Some(text.trim().to_owned()),
            },
            Subject::Unit => {}
        }

        self.described[number as usize] = band;
        Ok(())
    }

    /// Takes what is said of bands for what the raster is.
    pub(super) fn settle_bands(&mut self) {
        let Some(first) = self.described.first().copied() else { return };
        (self.scale, self.offset) = (first.scale, first.offset);
        self.nodata = first.nodata.or(self.nodata);
        let alpha = self.described.iter().position(|band| band.role == Role::Alpha);
        self.alpha_band = alpha.map(|band| band as u32);
    }

    /// Returns the value that means no data in a zero-based band.
    pub(crate) fn nodata_of(&self, band: u32) -> Option<f64> {
        let own = self.described.get(band as usize).and_then(|band| band.nodata);
        own.or(self.nodata)
    }

    /// Zero-based bands that are no alpha.
    pub(crate) fn seen_bands(&self) -> impl Iterator<Item = u32> + '_ {
        let is_alpha = |band: u32| {
            let described = self.described.get(band as usize).is_some_and(|band| band.role == Role::Alpha);
            described || Some(band) == self.alpha_band
        };
        (0..self.bands).filter(move |band| !is_alpha(*band))
    }

    /// The bands that are said to be red, green and blue, zero-based.
    pub(super) fn stated_colours(&self) -> Option<[u32; 3]> {
        let band =
            |role: Role| self.described.iter().position(|band| band.role == role).map(|band| band as u32);
        Some([band(Role::Red)?, band(Role::Green)?, band(Role::Blue)?])
    }
}

/// Metres of a vertical unit by its usual names.
fn metres_per_unit(name: &str) -> Option<f64> {
    match name.trim().to_ascii_lowercase().as_str() {
        "m" | "metre" | "meter" | "metres" | "meters" => Some(1.0),
        "ft" | "foot" | "feet" | "foot_international" | "international foot" => Some(0.3048),
        "us-ft" | "ft us" | "us survey foot" | "us survey feet" | "foot_us" | "ftus" => Some(1200.0 / 3937.0),
        "km" => Some(1000.0),
        "dm" => Some(0.1),
        "cm" => Some(0.01),
        "mm" => Some(0.001),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn stated(bands: u32, statements: &[(u32, Subject, &str)]) -> Result<RasterInfo> {
        let mut info = RasterInfo { bands, ..RasterInfo::blank(Path::new("a.tif"), "GeoTIFF") };
        for (band, subject, text) in statements {
            info.state("its metadata", &Statement { band: *band, subject: *subject, text })?;
        }
        info.settle_bands();
        Ok(info)
    }

    #[test]
    fn colours_and_alpha_are_where_they_are_said_to_be() {
        let roles = ["Alpha", "blue", "GREEN", "Red", "Undefined"];
        let statements: Vec<_> = (0..).zip(roles).map(|(band, role)| (band, Subject::Role, role)).collect();
        let info = stated(5, &statements).unwrap();
        assert_eq!((info.stated_colours(), info.alpha_band), (Some([3, 2, 1]), Some(0)));
        assert_eq!(info.seen_bands().collect::<Vec<_>>(), [1, 2, 3, 4]);
        assert_eq!(stated(2, &statements).unwrap().stated_colours(), None);
    }

    #[test]
    fn the_first_band_is_that_of_heights() {
        let info = stated(
            2,
            &[
                (0, Subject::Scale, " 0.1 "),
                (1, Subject::Scale, "9"),
                (0, Subject::Offset, "-5"),
                (0, Subject::Nodata, "-32768"),
                (1, Subject::Nodata, "7"),
                (0, Subject::Unit, "ft"),
            ],
        )
        .unwrap();
        assert_eq!((info.scale, info.offset, info.vertical.metres_per_unit), (0.1, -5.0, Some(0.3048)));
        assert_eq!((info.nodata_of(0), info.nodata_of(1)), (Some(-32768.0), Some(7.0)));
        let error = stated(1, &[(0, Subject::Scale, "much")]).unwrap_err().to_string();
        assert!(error.contains("\"much\" as the scale of band 1"), "{error}");
    }
}
