//! `FILE.aux.xml`: what GDAL and GIS programs say of a raster beside it (GDAL's persistent auxiliary metadata).
//!
//! Read are colours, scale, offset, unit and no data of bands, and place and reference system where the raster has none.
//! Statistics, histograms, overviews and tables of attributes change no value and are passed over.

use std::fs;
use std::path::{Path, PathBuf};

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::band::{Statement, Subject};
use super::georeference;
use crate::raster::{GeoTransform, RasterInfo};
use hedgehop_base::document::unmarked;
use hedgehop_base::error::{Error, Result};

/// Tables of attributes may be long; what is longer is no metadata.
const LONGEST: u64 = 64 << 20;

/// Position of an element's text.
#[derive(Default)]
struct TextPlace {
    /// Names of the elements around it.
    path: Vec<String>,
    /// The band, counted from 1, within one.
    band: Option<u32>,
    text: String,
}

/// Takes what the file beside a raster says of it, if there is one.
///
/// # Errors
/// A file that cannot be read or understood.
pub(super) fn apply(info: &mut RasterInfo) -> Result<()> {
    let mut name = info.path.as_os_str().to_owned();
    name.push(".aux.xml");
    let path = PathBuf::from(name);
    let Ok(found) = fs::metadata(&path) else { return Ok(()) };
    if found.len() > LONGEST {
        return Err(Error::invalid(&path, "is too long to describe a raster; remove it, or write it anew"));
    }
    let bytes = fs::read(&path).map_err(|source| Error::io(&path, "read", source))?;
    read(info, &path, &String::from_utf8_lossy(unmarked(&path, &bytes)?))
}

fn read(info: &mut RasterInfo, path: &Path, text: &str) -> Result<()> {
    let broken = |what: String| {
        Error::invalid(path, format!("is no metadata that can be read ({what}); remove it, or write it anew"))
    };
    let mut reader = Reader::from_str(text);
    let mut place = TextPlace::default();

    loop {
        match reader.read_event().map_err(|error| broken(error.to_string()))? {
            Event::Start(element) => place.enter(&element).map_err(broken)?,
            Event::Text(text) => place.text += &text.decode().map_err(|error| broken(error.to_string()))?,
            Event::CData(data) => place.text += &String::from_utf8_lossy(&data),
            Event::GeneralRef(name) => place.text += character(&name).map_err(broken)?.as_str(),
            Event::End(_) => {
                place.tell(info, path)?;
                place.leave();
            }
            Event::Eof if place.path.is_empty() => return Ok(()),
            Event::Eof => return Err(broken("it is cut short".to_owned())),
            _ => {}
        }
    }
}

/// The character that an entity stands for.
fn character(name: &quick_xml::events::BytesRef<'_>) -> std::result::Result<String, String> {
    if let Some(character) = name.resolve_char_ref().map_err(|error| error.to_string())? {
        return Ok(character.to_string());
    }
    let name = name.decode().map_err(|error| error.to_string())?;
    let known = quick_xml::escape::resolve_predefined_entity(&name);
    known.map(str::to_owned).ok_or_else(|| format!("&{name}; is not known"))
}

impl TextPlace {
    fn enter(&mut self, element: &BytesStart<'_>) -> std::result::Result<(), String> {
        let name = String::from_utf8_lossy(element.name().as_ref()).into_owned();
        if name == "PAMRasterBand" {
            let band = element.try_get_attribute("band").map_err(|error| error.to_string())?;
            let number = band.and_then(|band| String::from_utf8_lossy(&band.value).trim().parse().ok());
            self.band = Some(number.filter(|number| *number > 0).ok_or("a band has no number")?);
        }
        self.path.push(name);
        self.text.clear();
        Ok(())
    }

    fn leave(&mut self) {
        if self.path.pop().as_deref() == Some("PAMRasterBand") {
            self.band = None;
        }
        self.text.clear();
    }

    /// Takes what the element says that ends here.
    fn tell(&self, info: &mut RasterInfo, path: &Path) -> Result<()> {
        let names: Vec<&str> = self.path.iter().map(String::as_str).collect();
        let subject = match names[..] {
            ["PAMDataset", "PAMRasterBand", name] => match name {
                "ColorInterp" => Subject::Role,
                "Scale" => Subject::Scale,
                "Offset" => Subject::Offset,
                "UnitType" => Subject::Unit,
                "NoDataValue" => Subject::Nodata,
                _ => return Ok(()),
            },
            ["PAMDataset", "GeoTransform"] => return self.transform(info, path),
            ["PAMDataset", "SRS"] => {
                if info.crs.is_none() && info.crs_problem.is_none() && !self.text.trim().is_empty() {
                    georeference::set_crs(info, path, self.text.trim());
                }
                return Ok(());
            }
            _ => return Ok(()),
        };

        let Some(band) = self.band else { return Ok(()) };
        info.state(&path.display().to_string(), &Statement { band: band - 1, subject, text: &self.text })
    }

    fn transform(&self, info: &mut RasterInfo, path: &Path) -> Result<()> {
        let numbers: Option<Vec<f64>> =
            self.text.split(',').map(|number| number.trim().parse().ok()).collect();
        let geo =
            numbers.and_then(|numbers| GeoTransform::try_from(numbers).ok()).filter(georeference::is_sound);
        let geo =
            geo.ok_or_else(|| Error::invalid(path, "states a GeoTransform that is none; mend or remove it"))?;
        match info.geo {
            None => info.geo = Some(geo),
            Some(own) if !is_near(&own, &geo) => info.notes.push(format!(
                "{}: states another place than the raster itself, whose own counts",
                path.file_name().unwrap_or_default().to_string_lossy()
            )),
            Some(_) => {}
        }
        Ok(())
    }
}

/// Whether two transforms agree within a hundredth of a pixel at the first one.
fn is_near(a: &GeoTransform, b: &GeoTransform) -> bool {
    let pixel = a[1].hypot(a[4]).min(a[2].hypot(a[5]));
    let differs = |index: usize, bound: f64| (a[index] - b[index]).abs() > bound;
    let is_moved = [0, 3].into_iter().any(|index| differs(index, 0.01 * pixel));
    !is_moved && ![1, 2, 4, 5].into_iter().any(|index| differs(index, 1.0e-6 * pixel))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(xml: &str) -> Result<RasterInfo> {
        let mut info = RasterInfo { bands: 3, ..RasterInfo::blank(Path::new("a.tif"), "GeoTIFF") };
        read(&mut info, Path::new("a.tif.aux.xml"), xml)?;
        info.settle_bands();
        Ok(info)
    }

    #[test]
    fn bands_and_place_are_read() {
        let info = told(
            r#"<?xml version="1.0"?><PAMDataset>
            <SRS dataAxisToSRSAxisMapping="1,2">LOCAL_CS[&quot;a&quot;]</SRS>
            <GeoTransform>  1.0e+02,  2.0,  0.0,  5.0e+02,  0.0, -2.0</GeoTransform>
            <PAMRasterBand band="1"><NoDataValue le_hex_equiv="00">-9999</NoDataValue><Scale>2</Scale>
            <UnitType>ft</UnitType><ColorInterp>Blue</ColorInterp><Histograms><HistItem/></Histograms></PAMRasterBand>
            <PAMRasterBand band="2"><ColorInterp>Green</ColorInterp></PAMRasterBand>
            <PAMRasterBand band="3"><ColorInterp>Red</ColorInterp></PAMRasterBand>
            <Metadata><MDI key="Scale">9</MDI></Metadata></PAMDataset>"#,
        )
        .unwrap();
        assert_eq!(
            (info.nodata, info.scale, info.vertical.metres_per_unit),
            (Some(-9999.0), 2.0, Some(0.3048))
        );
        assert_eq!(info.stated_colours(), Some([2, 1, 0]));
        assert_eq!(info.geo, Some([100.0, 2.0, 0.0, 500.0, 0.0, -2.0]));
        assert!(info.crs.is_some() || info.crs_problem.is_some());
    }

    #[test]
    fn what_is_not_meant_for_it_is_passed_over() {
        let info = told("<other><PAMRasterBand band='1'><Scale>9</Scale></PAMRasterBand></other>").unwrap();
        assert_eq!((info.scale, info.described.len()), (1.0, 0));
    }

    #[test]
    fn broken_ones_are_refused() {
        let band = |inside: &str| {
            format!("<PAMDataset><PAMRasterBand band=\"1\">{inside}</PAMRasterBand></PAMDataset>")
        };
        for xml in [
            "<PAMDataset><PAMRasterBand band=\"1\"><Scale>2</Scale>".to_owned(),
            "<PAMDataset></PAMRasterBand>".to_owned(),
            "<PAMDataset><PAMRasterBand><Scale>2</Scale></PAMRasterBand></PAMDataset>".to_owned(),
            "<PAMDataset><GeoTransform>1,2,3</GeoTransform></PAMDataset>".to_owned(),
            band("<Scale>much</Scale>"),
            band("<NoDataValue>void</NoDataValue>"),
        ] {
            let error = told(&xml).unwrap_err().to_string();
            assert!(error.contains("aux.xml"), "{xml}: {error}");
        }
    }
}
