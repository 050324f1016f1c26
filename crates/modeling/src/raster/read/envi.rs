//! ENVI: raw samples with a `.hdr` of `key = value` entries beside them, values in braces may span lines (Harris/NV5, *ENVI
//! header files*).
//!
//! `map info = {projection, column, row, x, y, width, height, …}` ties a pixel position, counted from 1 at the outer
//! corner of the first pixel, to a place. The CRS is taken from `coordinate system string`, else from UTM or geographic
//! WGS 84 in `map info`.

use std::collections::HashMap;
use std::path::Path;

use crate::raster::file::InputFile;
use crate::raster::header_fields::TextFields;
use crate::raster::raw::{RawRaster, RowStarts, SamplePlacement};
use crate::raster::sample::ByteOrder;
use crate::raster::{GeoTransform, Raster, RasterInfo, SampleType, georeference, nodata, side_files};
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// Opens the samples in `file` that the text of `header` describes.
pub(in crate::raster) fn open(file: InputFile, header: &Path, text: &str) -> Result<Box<dyn Raster>> {
    let fields = parse(header, text);
    let (width, height) = (fields.size("samples")?, fields.size("lines")?);
    let bands = fields.whole("bands")?.unwrap_or(1);
    let sample = sample(&fields)?;
    let order =
        if fields.whole("byte order")?.unwrap_or(0) == 0 { ByteOrder::Little } else { ByteOrder::Big };
    let nodata = match fields.text("data ignore value") {
        Some(text) => nodata::parse(text, sample).map_err(|text| fields.wrong("data ignore value", &text))?,
        None => None,
    };

    let mut info = RasterInfo {
        width,
        height,
        bands,
        sample,
        geo: geo(&fields)?,
        nodata,
        ..RasterInfo::blank(file.path(), "ENVI")
    };
    let placement = placement(&fields, &info, order)?;

    set_crs(&fields, &mut info)?;
    side_files::complete(&mut info)?;
    Ok(Box::new(RawRaster::new(file, info, placement)?))
}

/// `key = value` entries.
fn parse<'a>(path: &'a Path, text: &str) -> TextFields<'a> {
    let mut values = HashMap::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let Some((key, value)) = line.split_once('=') else { continue };
        let mut value = value.trim().to_owned();
        while value.starts_with('{') && !value.ends_with('}') {
            let Some(more) = lines.next() else { break };
            value.push(' ');
            value.push_str(more.trim());
        }
        let value = value.trim_matches(|c: char| c == '{' || c == '}' || c.is_whitespace()).to_owned();
        values.insert(key.trim().to_ascii_lowercase(), value);
    }
    TextFields { path, values }
}

fn sample(fields: &TextFields<'_>) -> Result<SampleType> {
    match fields.whole("data type")? {
        Some(1) => Ok(SampleType::U8),
        Some(2) => Ok(SampleType::I16),
        Some(3) => Ok(SampleType::I32),
        Some(4) => Ok(SampleType::F32),
        Some(5) => Ok(SampleType::F64),
        Some(12) => Ok(SampleType::U16),
        Some(13) => Ok(SampleType::U32),
        other => Err(Error::unsupported(
            fields.path,
            format!(
                "states data type {}",
                other.map_or_else(|| "nothing".to_owned(), |code| code.to_string())
            ),
            "convert it: gdal_translate -ot Float32 IN out.tif",
        )),
    }
}

/// Returns where the samples of a raster lie, of which size, bands and type are known.
fn placement(fields: &TextFields<'_>, info: &RasterInfo, order: ByteOrder) -> Result<SamplePlacement> {
    let (bands, sample_bytes) = (u64::from(info.bands), info.sample.bytes() as u64);
    let first = fields.whole("header offset")?.map_or(0, u64::from);
    let row = u64::from(info.width) * sample_bytes;
    let huge = || Error::invalid(fields.path, "states a size that exceeds 64 bits");
    let all_bands = row.checked_mul(bands).ok_or_else(huge)?;
    let (row_bytes, pixel_bytes, band_bytes) =
        match fields.text("interleave").map(str::to_ascii_lowercase).as_deref() {
            None | Some("bsq") => {
                (row, sample_bytes, row.checked_mul(u64::from(info.height)).ok_or_else(huge)?)
            }
            Some("bil") => (all_bands, sample_bytes, row),
            Some("bip") => (all_bands, sample_bytes * bands, sample_bytes),
            Some(other) => return Err(fields.wrong("interleave", other)),
        };
    Ok(SamplePlacement { rows: RowStarts::Even { first, row_bytes }, pixel_bytes, band_bytes, order })
}

fn map_info<'f>(fields: &'f TextFields<'_>) -> Vec<&'f str> {
    fields.text("map info").map(|text| text.split(',').map(str::trim).collect()).unwrap_or_default()
}

fn geo(fields: &TextFields<'_>) -> Result<Option<GeoTransform>> {
    let map_info = map_info(fields);
    if map_info.is_empty() {
        return Ok(None);
    }
    let wrong = || fields.wrong("map info", &map_info.join(", "));
    let numbers: Option<Vec<f64>> = map_info.iter().skip(1).take(6).map(|text| text.parse().ok()).collect();
    let numbers = numbers.and_then(|numbers| <[f64; 6]>::try_from(numbers).ok()).ok_or_else(wrong)?;
    let [column, row, x, y, width, height] = numbers;
    let rotation = map_info.iter().find_map(|text| text.strip_prefix("rotation=")).map(str::parse::<f64>);
    if rotation.is_some_and(|rotation| rotation != Ok(0.0)) {
        let remedy = "straighten it: gdalwarp IN out.tif";
        return Err(Error::unsupported(fields.path, "states a rotation in map info", remedy));
    }
    let geo = [x - (column - 1.0) * width, width, 0.0, y + (row - 1.0) * height, 0.0, -height];
    if georeference::is_sound(&geo) { Ok(Some(geo)) } else { Err(wrong()) }
}

fn set_crs(fields: &TextFields<'_>, info: &mut RasterInfo) -> Result<()> {
    if let Some(wkt) = fields.text("coordinate system string").filter(|wkt| !wkt.is_empty()) {
        georeference::set_crs(info, fields.path, wkt);
        return Ok(());
    }

    let map_info = map_info(fields);
    let zone = match map_info.first().copied() {
        Some("Geographic Lat/Lon") => None,
        Some("UTM") => {
            let zone =
                map_info.get(7).and_then(|zone| zone.parse::<i64>().ok()).filter(|z| (1..=60).contains(z));
            let Some(zone) = zone else { return Err(fields.wrong("map info", &map_info.join(", "))) };
            let is_north = map_info.get(8).is_some_and(|half| half.eq_ignore_ascii_case("North"));
            Some(if is_north { zone } else { -zone })
        }
        Some("Arbitrary") | None => return Ok(()),
        Some(other) => {
            info.crs_problem = Some(format!("the projection '{other}' of map info is not read"));
            return Ok(());
        }
    };

    // The datum comes after the zone, or after the pixel sizes of degrees; units and rotation have an equals sign.
    let after = if zone.is_some() { 9 } else { 7 };
    match map_info.get(after).filter(|word| !word.is_empty() && !word.contains('=')) {
        None => info.crs_problem = Some("map info names no datum".to_owned()),
        Some(datum) => match Crs::on_named_datum(datum, zone) {
            Ok(crs) => info.crs = Some(crs),
            Err(problem) => info.crs_problem = Some(problem),
        },
    }

    Ok(())
}
