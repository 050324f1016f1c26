//! Raw samples with an Esri header beside them: `.bil`, `.bip`, `.bsq` (`ULXMAP`, `XDIM`; Esri, *BIL, BIP, and BSQ
//! raster files*) and GridFloat `.flt` (`xllcorner`, `cellsize`), also GTOPO30's `.dem`.
//!
//! `ULXMAP` and `ULYMAP` are the centre of the first pixel. What a header leaves out has the defaults of Esri: one band,
//! band-interleaved by line, 8 bits; 16 bits without `PIXELTYPE` are signed, as in GTOPO30; `.flt` is 32-bit float.

use std::collections::HashMap;
use std::path::Path;

use super::file::InputFile;
use super::raw::{Placement, RawRaster, RowStarts};
use super::sample::ByteOrder;
use super::{GeoTransform, Raster, RasterInfo, SampleType, nodata, side};
use crate::error::{Error, Result};

/// Opens the samples in `file` that the text of `header` describes.
pub(super) fn open(file: InputFile, header: &Path, text: &str) -> Result<Box<dyn Raster>> {
    let fields = Fields::parse(header, text);
    let (width, height) = (fields.size("ncols")?, fields.size("nrows")?);
    let bands = fields.whole("nbands")?.unwrap_or(1);
    let float = file.path().extension().is_some_and(|extension| extension.eq_ignore_ascii_case("flt"));
    let sample = fields.sample(float)?;
    let order = match fields.word("byteorder").as_deref() {
        None | Some("i" | "lsbfirst" | "vms_ffloat") => ByteOrder::Little,
        Some("m" | "msbfirst") => ByteOrder::Big,
        Some(other) => return Err(fields.wrong("byteorder", other)),
    };
    let placement = fields.placement((width, height, bands), sample.bytes() as u64, order)?;
    let nodata = match fields.word("nodata").or_else(|| fields.word("nodata_value")) {
        Some(text) => nodata::parse(&text, sample).map_err(|text| fields.wrong("nodata", &text))?,
        None => None,
    };
    let mut info = RasterInfo {
        width,
        height,
        bands,
        sample,
        geo: fields.geo(height)?,
        nodata,
        ..RasterInfo::blank(file.path(), if float { "GridFloat" } else { "Esri raw raster" })
    };
    side::complete(&mut info)?;
    Ok(Box::new(RawRaster::new(file, info, placement)?))
}

/// `key value` lines, keys in lower case.
struct Fields<'a> {
    path: &'a Path,
    values: HashMap<String, String>,
}

impl<'a> Fields<'a> {
    fn parse(path: &'a Path, text: &str) -> Self {
        let pair = |line: &str| {
            let mut words = line.split_whitespace();
            Some((words.next()?.to_ascii_lowercase(), words.next()?.to_ascii_lowercase()))
        };
        Self { path, values: text.lines().filter_map(pair).collect() }
    }

    fn word(&self, key: &str) -> Option<String> {
        self.values.get(key).cloned()
    }

    fn wrong(&self, key: &str, value: &str) -> Error {
        Error::invalid(
            self.path,
            format!("states {} {value}, which is not understood", key.to_ascii_uppercase()),
        )
    }

    fn number(&self, key: &str) -> Result<Option<f64>> {
        let Some(text) = self.values.get(key) else { return Ok(None) };
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.map(Some).ok_or_else(|| self.wrong(key, text))
    }

    fn whole(&self, key: &str) -> Result<Option<u32>> {
        let Some(text) = self.values.get(key) else { return Ok(None) };
        text.parse().map(Some).map_err(|_| self.wrong(key, text))
    }

    fn size(&self, key: &str) -> Result<u32> {
        match self.whole(key)? {
            Some(size) if size > 0 => Ok(size),
            _ => Err(Error::invalid(self.path, format!("states no {} above zero", key.to_ascii_uppercase()))),
        }
    }

    fn sample(&self, float: bool) -> Result<SampleType> {
        let bits = self.whole("nbits")?.unwrap_or(if float { 32 } else { 8 });
        let kind =
            self.word("pixeltype").unwrap_or_else(|| if float { "float".into() } else { String::new() });
        match (bits, kind.as_str()) {
            (8, "" | "unsignedint") => Ok(SampleType::U8),
            (8, "signedint") => Ok(SampleType::I8),
            (16, "unsignedint") => Ok(SampleType::U16),
            (16, "" | "signedint") => Ok(SampleType::I16),
            (32, "unsignedint") => Ok(SampleType::U32),
            (32, "" | "signedint") => Ok(SampleType::I32),
            (32, "float") => Ok(SampleType::F32),
            (64, "float") => Ok(SampleType::F64),
            _ => Err(Error::unsupported(
                self.path,
                format!("states samples of {bits} bits, {kind}"),
                "convert it: gdal_translate -ot Float32 IN out.tif",
            )),
        }
    }

    fn placement(
        &self,
        (width, height, bands): (u32, u32, u32),
        size: u64,
        order: ByteOrder,
    ) -> Result<Placement> {
        let first = self.whole("skipbytes")?.map_or(0, u64::from);
        let (width, height) = (u64::from(width), u64::from(height));
        let row = width * size;
        let total = |default: Option<u64>| match self.whole("totalrowbytes")? {
            Some(bytes) => Ok(u64::from(bytes)),
            None => default.ok_or_else(|| Error::invalid(self.path, "states a row that exceeds 64 bits")),
        };
        let (row_bytes, pixel_bytes, band_bytes) = match self.word("layout").as_deref() {
            None | Some("bil") => {
                let band = self.whole("bandrowbytes")?.map_or(row, u64::from);
                (total(band.checked_mul(u64::from(bands)))?, size, band)
            }
            Some("bip") => (total(row.checked_mul(u64::from(bands)))?, size * u64::from(bands), size),
            Some("bsq") => {
                let gap = self.whole("bandgapbytes")?.map_or(0, u64::from);
                let band = row.checked_mul(height).and_then(|band| band.checked_add(gap));
                (
                    row,
                    size,
                    band.ok_or_else(|| Error::invalid(self.path, "states bands that exceed 64 bits"))?,
                )
            }
            Some(other) => return Err(self.wrong("layout", other)),
        };
        Ok(Placement { rows: RowStarts::Even { first, row_bytes }, pixel_bytes, band_bytes, order })
    }

    fn geo(&self, rows: u32) -> Result<Option<GeoTransform>> {
        let cell = self.number("cellsize")?;
        let step_x = self.number("xdim")?.or(cell);
        let step_y = self.number("ydim")?.or(cell);
        let (Some(step_x), Some(step_y)) = (step_x, step_y) else { return Ok(None) };
        let x = match (self.number("ulxmap")?, self.number("xllcorner")?, self.number("xllcenter")?) {
            (Some(centre), _, _) | (_, _, Some(centre)) => centre - step_x / 2.0,
            (_, Some(corner), _) => corner,
            _ => return Ok(None),
        };
        let height = f64::from(rows) * step_y;
        let y = match (self.number("ulymap")?, self.number("yllcorner")?, self.number("yllcenter")?) {
            (Some(centre), _, _) => centre + step_y / 2.0,
            (_, Some(corner), _) => corner + height,
            (_, _, Some(centre)) => centre - step_y / 2.0 + height,
            _ => return Ok(None),
        };
        let geo = [x, step_x, 0.0, y, 0.0, -step_y];
        if side::is_sound(&geo) { Ok(Some(geo)) } else { Err(self.wrong("cellsize", "0")) }
    }
}
