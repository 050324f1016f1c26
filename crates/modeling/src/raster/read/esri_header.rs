//! Raw samples with an Esri header beside them: `.bil`, `.bip`, `.bsq` (`ULXMAP`, `XDIM`; Esri, *BIL, BIP, and BSQ
//! raster files*) and GridFloat `.flt` (`xllcorner`, `cellsize`), also GTOPO30's `.dem`.
//!
//! `ULXMAP` and `ULYMAP` are the centre of the first pixel. What a header leaves out has the defaults of Esri: one band,
//! band-interleaved by line, 8 bits; 16 bits without `PIXELTYPE` are signed, as in GTOPO30; `.flt` is 32-bit float.

use std::path::Path;

use crate::raster::file::InputFile;
use crate::raster::header_fields::TextFields;
use crate::raster::raw::{RawRaster, RowStarts, SamplePlacement};
use crate::raster::sample::ByteOrder;
use crate::raster::{GeoTransform, Raster, RasterInfo, SampleType, georeference, nodata, side_files};
use hedgehop_base::error::{Error, Result};

/// Opens the samples in `file` that the text of `header` describes.
pub(in crate::raster) fn open(file: InputFile, header: &Path, text: &str) -> Result<Box<dyn Raster>> {
    let fields = parse(header, text);
    let (width, height) = (fields.size("ncols")?, fields.size("nrows")?);
    let bands = fields.whole("nbands")?.unwrap_or(1);
    let float = file.path().extension().is_some_and(|extension| extension.eq_ignore_ascii_case("flt"));
    let sample = sample(&fields, float)?;
    let order = match fields.text("byteorder") {
        None | Some("i" | "lsbfirst" | "vms_ffloat") => ByteOrder::Little,
        Some("m" | "msbfirst") => ByteOrder::Big,
        Some(other) => return Err(fields.wrong("byteorder", other)),
    };
    let nodata = match fields.text("nodata").or_else(|| fields.text("nodata_value")) {
        Some(text) => nodata::parse(text, sample).map_err(|text| fields.wrong("nodata", &text))?,
        None => None,
    };

    let mut info = RasterInfo {
        width,
        height,
        bands,
        sample,
        geo: geo(&fields, height)?,
        nodata,
        ..RasterInfo::blank(file.path(), if float { "GridFloat" } else { "Esri raw raster" })
    };
    let placement = placement(&fields, &info, order)?;

    side_files::complete(&mut info)?;
    Ok(Box::new(RawRaster::new(file, info, placement)?))
}

/// `key value` lines; what stands after the value is no part of it.
fn parse<'a>(path: &'a Path, text: &str) -> TextFields<'a> {
    let pair = |line: &str| {
        let mut words = line.split_whitespace();
        Some((words.next()?.to_ascii_lowercase(), words.next()?.to_ascii_lowercase()))
    };
    TextFields { path, values: text.lines().filter_map(pair).collect() }
}

fn sample(fields: &TextFields<'_>, float: bool) -> Result<SampleType> {
    let bits = fields.whole("nbits")?.unwrap_or(if float { 32 } else { 8 });
    let kind = fields.text("pixeltype").unwrap_or(if float { "float" } else { "" });
    match (bits, kind) {
        (8, "" | "unsignedint") => Ok(SampleType::U8),
        (8, "signedint") => Ok(SampleType::I8),
        (16, "unsignedint") => Ok(SampleType::U16),
        (16, "" | "signedint") => Ok(SampleType::I16),
        (32, "unsignedint") => Ok(SampleType::U32),
        (32, "" | "signedint") => Ok(SampleType::I32),
        (32, "float") => Ok(SampleType::F32),
        (64, "float") => Ok(SampleType::F64),
        _ => Err(Error::unsupported(
            fields.path,
            format!("states samples of {bits} bits, {kind}"),
            "convert it: gdal_translate -ot Float32 IN out.tif",
        )),
    }
}

/// Returns where the samples of a raster lie, of which size, bands and type are known.
fn placement(fields: &TextFields<'_>, info: &RasterInfo, order: ByteOrder) -> Result<SamplePlacement> {
    let (bands, sample_bytes) = (u64::from(info.bands), info.sample.bytes() as u64);
    let first = fields.whole("skipbytes")?.map_or(0, u64::from);
    let (width, height) = (u64::from(info.width), u64::from(info.height));
    let row = width * sample_bytes;
    let total = |default: Option<u64>| match fields.whole("totalrowbytes")? {
        Some(bytes) => Ok(u64::from(bytes)),
        None => default.ok_or_else(|| Error::invalid(fields.path, "states a row that exceeds 64 bits")),
    };

    let (row_bytes, pixel_bytes, band_bytes) = match fields.text("layout") {
        None | Some("bil") => {
            let band = fields.whole("bandrowbytes")?.map_or(row, u64::from);
            (total(band.checked_mul(bands))?, sample_bytes, band)
        }
        Some("bip") => (total(row.checked_mul(bands))?, sample_bytes * bands, sample_bytes),
        Some("bsq") => {
            let gap = fields.whole("bandgapbytes")?.map_or(0, u64::from);
            let band = row.checked_mul(height).and_then(|band| band.checked_add(gap));
            (
                row,
                sample_bytes,
                band.ok_or_else(|| Error::invalid(fields.path, "states bands that exceed 64 bits"))?,
            )
        }
        Some(other) => return Err(fields.wrong("layout", other)),
    };

    Ok(SamplePlacement { rows: RowStarts::Even { first, row_bytes }, pixel_bytes, band_bytes, order })
}

fn geo(fields: &TextFields<'_>, rows: u32) -> Result<Option<GeoTransform>> {
    let cell = fields.number("cellsize")?;
    let step_x = fields.number("xdim")?.or(cell);
    let step_y = fields.number("ydim")?.or(cell);
    let (Some(step_x), Some(step_y)) = (step_x, step_y) else { return Ok(None) };
    let x = match (fields.number("ulxmap")?, fields.number("xllcorner")?, fields.number("xllcenter")?) {
        (Some(centre), _, _) | (_, _, Some(centre)) => centre - step_x / 2.0,
        (_, Some(corner), _) => corner,
        _ => return Ok(None),
    };
    let height = f64::from(rows) * step_y;
    let y = match (fields.number("ulymap")?, fields.number("yllcorner")?, fields.number("yllcenter")?) {
        (Some(centre), _, _) => centre + step_y / 2.0,
        (_, Some(corner), _) => corner + height,
        (_, _, Some(centre)) => centre - step_y / 2.0 + height,
        _ => return Ok(None),
    };
    let geo = [x, step_x, 0.0, y, 0.0, -step_y];
    if georeference::is_sound(&geo) { Ok(Some(geo)) } else { Err(fields.wrong("cellsize", "0")) }
}
