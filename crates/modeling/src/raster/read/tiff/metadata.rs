//! Metadata of a GeoTIFF besides the layout of its samples: place, CRS, nodata, scale, units.

use super::ifd::Directory;
use super::tags::tag;
use crate::raster::band::{Statement, Subject};
use crate::raster::{GeoTransform, RasterInfo, georeference, nodata};
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::parse_geokeys;

/// GDAL writes statistics and lineage into its metadata, seldom more than some KiB.
const LONGEST_METADATA: u64 = 16 << 20;
/// Tie points beyond the first are control points, of which a file may hold many.
const MOST_TIEPOINTS: u64 = 6 << 16;

/// GTRasterTypeGeoKey with the value RasterPixelIsPoint.
const PIXEL_IS_POINT: [u16; 4] = [1025, 0, 1, 2];

/// Fills in what tags say.
pub(super) fn fill(info: &mut RasterInfo, directory: &Directory<'_>) -> Result<()> {
    if let Some(keys) = directory.unsigneds(tag::GEO_KEY_DIRECTORY, 65_535)? {
        let keys: Vec<u16> = keys.into_iter().map(|key| key as u16).collect();
        let doubles = directory.doubles(tag::GEO_DOUBLES, 65_535)?.unwrap_or_default();
        let ascii = directory.text(tag::GEO_ASCII, 1 << 20)?.unwrap_or_default();

        // Whether pixels are points matters for the place even if the rest is not understood.
        info.pixel_is_point =
            keys.get(4..).unwrap_or_default().chunks_exact(4).any(|key| *key == PIXEL_IS_POINT);
        match parse_geokeys(&keys, &doubles, &ascii) {
            Ok(keys) => {
                info.crs = keys.crs;
                info.local = keys.local;
                info.vertical = keys.vertical;
            }
            Err(problem) => info.crs_problem = Some(problem),
        }
    }

    info.geo = geo(info, directory)?;
    if let Some(text) = directory.text(tag::GDAL_NODATA, 4096)? {
        info.nodata = nodata::parse(&text, info.sample).map_err(|text| {
            directory.wrong(tag::GDAL_NODATA, format!("states {text:?}, which is no number"))
        })?;
    }

    if let Some(xml) = directory.text(tag::GDAL_METADATA, LONGEST_METADATA)? {
        apply_items(info, &xml)?;
    }

    Ok(())
}

/// Pixel scale and tie point, or a matrix; none if neither is there.
fn geo(info: &RasterInfo, directory: &Directory<'_>) -> Result<Option<GeoTransform>> {
    let scale = directory.doubles(tag::MODEL_PIXEL_SCALE, 65_535)?;
    let tiepoints = directory.doubles(tag::MODEL_TIEPOINT, MOST_TIEPOINTS)?;
    let matrix = directory.doubles(tag::MODEL_TRANSFORMATION, 65_535)?;

    let mut geo = match (scale.as_deref(), tiepoints.as_deref(), matrix.as_deref()) {
        // A negative scale in y means north up all the same, as in GDAL.
        (Some([sx, sy, ..]), Some([i, j, _, x, y, ..]), _) if *sx != 0.0 && *sy != 0.0 => {
            [x - i * sx, *sx, 0.0, y + j * sy.abs(), 0.0, -sy.abs()]
        }
        (_, _, Some(m)) if m.len() == 16 => [m[3], m[0], m[1], m[7], m[4], m[5]],
        (None, Some(tiepoints), None) if tiepoints.len() > 6 => {
            let remedy = "warp it: gdalwarp IN out.tif";
            return Err(Error::unsupported(&info.path, "is placed by control points only", remedy));
        }
        _ => return Ok(None),
    };

    if info.pixel_is_point {
        geo[0] -= (geo[1] + geo[2]) / 2.0;
        geo[3] -= (geo[4] + geo[5]) / 2.0;
    }

    if georeference::is_sound(&geo) {
        Ok(Some(geo))
    } else {
        Err(directory.wrong(tag::MODEL_PIXEL_SCALE, "and its tie point state no sound place"))
    }
}

/// Applies what GDAL's metadata say of bands: `<Item name="SCALE" sample="0" role="scale">0.1</Item>`.
fn apply_items(info: &mut RasterInfo, xml: &str) -> Result<()> {
    for item in xml.split("<Item").skip(1) {
        let Some((attributes, rest)) = item.split_once('>') else { continue };
        let text = rest.split("</Item>").next().unwrap_or_default().trim();
        let subject = match attribute(attributes, "role") {
            Some("scale") => Subject::Scale,
            Some("offset") => Subject::Offset,
            Some("unittype") => Subject::Unit,
            Some("colorinterp") => Subject::Role,
            _ => continue,
        };

        let sample = attribute(attributes, "sample").map_or(Some(0), |sample| sample.trim().parse().ok());
        let Some(band) = sample else {
            return Err(Error::invalid(
                &info.path,
                "its GDAL metadata (TIFF tag 42112) name a band that is no number",
            ));
        };

        info.state("its GDAL metadata", &Statement { band, subject, text })?;
    }

    Ok(())
}

fn attribute<'a>(attributes: &'a str, name: &str) -> Option<&'a str> {
    let mut rest = attributes;
    loop {
        let (key, after) = rest.split_once('=')?;
        let quote = after.chars().next().filter(|c| *c == '"' || *c == '\'')?;
        let (value, next) = after.get(1..)?.split_once(quote)?;
        if key.trim() == name {
            return Some(value);
        }
        rest = next;
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn items() {
        let mut info = RasterInfo { bands: 2, ..RasterInfo::blank(Path::new("a.tif"), "GeoTIFF") };
        let xml = r#"<GDALMetadata><Item name="SCALE" sample="0" role="scale">0.1</Item>
            <Item name='SCALE' sample='1' role='scale'>9</Item><Item name="OFFSET" sample="0" role="offset">-5</Item>
            <Item name="UNITTYPE" sample="0" role="unittype">ft</Item></GDALMetadata>"#;
        apply_items(&mut info, xml).unwrap();
        info.settle_bands();
        assert_eq!((info.scale, info.offset, info.vertical.metres_per_unit), (0.1, -5.0, Some(0.3048)));
        assert!(apply_items(&mut info, r#"<Item role="scale">much</Item>"#).is_err());
    }
}
