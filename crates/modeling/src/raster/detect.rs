//! Detection of a file's format: by its first bytes, else by its extension.

use std::path::{Path, PathBuf};

use super::file::InputFile;
use super::{ascii, bt, dted, ehdr, envi, hgt, mask, picture, raw, side, tiff};
use crate::raster::{OpenOptions, Raster};
use hedgehop_base::error::{Error, Result};

/// Bytes that decide.
const HEAD: u64 = 4096;

/// Formats that are recognised only to be refused: first bytes, name.
const FOREIGN: [(&[u8], &str); 19] = [
    (b"\x89HDF", "HDF5 or netCDF-4"),
    (b"\x0e\x03\x13\x01", "HDF4"),
    (b"CDF\x01", "netCDF"),
    (b"CDF\x02", "netCDF"),
    (b"\0\0\0\x0cjP  ", "JPEG 2000"),
    (b"\xff\x4f\xff\x51", "JPEG 2000"),
    (b"EHFA_HEADER_TAG", "ERDAS Imagine"),
    (b"LASF", "LAS/LAZ"),
    (b"<VRT", "a GDAL virtual raster"),
    (b"SQLite format 3", "a GeoPackage or MBTiles"),
    (b"NITF", "NITF"),
    (b"DSAA", "a Surfer grid"),
    (b"DSBB", "a Surfer grid"),
    (b"DSRB", "a Surfer grid"),
    (b"GRIB", "GRIB"),
    (b"GIF8", "GIF"),
    (b"BM", "BMP"),
    (b"RIFF", "WebP"),
    (b"Lerc2 ", "LERC"),
];

/// Opens a raster of any supported format, with the mask beside it.
pub(super) fn open(path: &Path, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    mask::with_file(open_alone(path, options)?, options)
}

fn open_alone(path: &Path, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    let file = InputFile::open(path)?;
    let head = file.head(HEAD)?;
    if head.is_empty() {
        return Err(Error::invalid(path, "is empty"));
    }

    match head.as_slice() {
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => return tiff::open(file, options),
        head if hedgehop_assets::picture::format(head).is_some() => return picture::open(file, options),
        [b'b', b'i', b'n', b't', b'e', b'r', b'r', ..] => return bt::open(file, options),
        [b'U' | b'V' | b'H', b'H' | b'O' | b'D', b'L' | b'R', b'1', ..] => return dted::open(file, options),
        _ => {}
    }

    if ascii::recognises(&head) {
        return ascii::open(file, options);
    }

    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    if extension == "hgt" {
        return hgt::open(file);
    }

    refuse_foreign(path, &head, &extension)?;
    open_with_header(file, options)
}

/// Raw samples with a `.hdr` beside them, or none at all.
fn open_with_header(file: InputFile, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    let mut appended = file.path().as_os_str().to_owned();
    appended.push(".hdr");
    let appended = PathBuf::from(appended);
    let header = if appended.is_file() { Some(appended) } else { side::beside(file.path(), "hdr") };
    let Some(header) = header.filter(|_| options.raw.is_none()) else {
        return raw::open_headerless(file, options);
    };
    let text = side::text(&header)?;
    if text.trim_start().starts_with("ENVI") {
        envi::open(file, &header, &text)
    } else {
        ehdr::open(file, &header, &text)
    }
}

fn refuse_foreign(path: &Path, head: &[u8], extension: &str) -> Result<()> {
    let unzip =
        |tool: &str| Err(Error::unsupported(path, "is compressed as a whole", format!("unpack it: {tool}")));
    if head.starts_with(b"PK\x03\x04") {
        return unzip("unzip IN");
    }
    if head.starts_with(b"\x1f\x8b") {
        return unzip("gunzip IN");
    }

    let known = FOREIGN.iter().find(|(magic, _)| head.starts_with(magic)).map(|(_, name)| *name);
    let format = known.or(match extension {
        "hdr" | "prj" | "tfw" | "pgw" | "jgw" | "wld" => {
            return Err(Error::invalid(path, "is a side file; name the raster beside it"));
        }
        "msk" => return Err(Error::invalid(path, "is a mask; name the raster beside it")),
        "png" | "jpg" | "jpeg" | "tif" | "tiff" | "bt" | "dt0" | "dt1" | "dt2" => {
            let what = format!(
                "does not begin as a .{extension} does; it is damaged or no such file, fetch it again"
            );
            return Err(Error::invalid(path, what));
        }
        "e00" => Some("an Arc/Info export"),
        "adf" => Some("an Arc/Info grid"),
        "nc" => Some("netCDF"),
        "jp2" | "j2k" => Some("JPEG 2000"),
        "grd" => Some("a grid"),
        "ddf" => Some("SDTS"),
        "ter" => Some("Terragen"),
        "vrt" => Some("a GDAL virtual raster"),
        "xyz" | "csv" => Some("a list of points"),
        "dem" if side::beside(path, "hdr").is_none() => Some("a USGS DEM"),
        _ => None,
    });

    match format {
        Some(format) => Err(Error::unsupported(
            path,
            format!("is {format}, which is not read here"),
            "convert it: gdal_translate IN out.tif",
        )),
        None => Ok(()),
    }
}
