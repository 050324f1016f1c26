//! Detection of a file's format: by its first bytes, else by the ending of its name, else by a header beside it.

use std::path::{Path, PathBuf};

use super::file::InputFile;
use super::read::{bt, dted, envi, esri_ascii, esri_header, headerless, hgt, picture, tiff};
use super::{mask_file, side_files};
use crate::raster::{OpenOptions, Raster};
use hedgehop_base::error::{Error, Result};

/// Bytes from the beginning that detection looks at.
const HEAD: u64 = 4096;

/// Function that opens a file of one format.
type OpenRaster = fn(InputFile, &OpenOptions) -> Result<Box<dyn Raster>>;

/// Endings of formats that are told by their first bytes: a file so named that begins otherwise is damaged.
const ENDINGS_TOLD_BY_BYTES: [&str; 9] = ["png", "jpg", "jpeg", "tif", "tiff", "bt", "dt0", "dt1", "dt2"];

/// Endings of files that stand beside a raster and state its place or its samples.
const SIDE_FILE_ENDINGS: [&str; 6] = ["hdr", "prj", "tfw", "pgw", "jgw", "wld"];

/// Formats that are recognised by their first bytes only to be refused: these bytes, name.
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

/// Formats that are recognised by their endings only to be refused: ending, name.
const FOREIGN_ENDINGS: [(&str, &str); 12] = [
    ("e00", "an Arc/Info export"),
    ("adf", "an Arc/Info grid"),
    ("nc", "netCDF"),
    ("jp2", "JPEG 2000"),
    ("j2k", "JPEG 2000"),
    ("grd", "a grid"),
    ("ddf", "SDTS"),
    ("ter", "Terragen"),
    ("vrt", "a GDAL virtual raster"),
    ("xyz", "a list of points"),
    ("csv", "a list of points"),
    ("dem", "a USGS DEM"),
];

/// Opens a raster of any supported format, with the mask beside it.
pub(super) fn open(path: &Path, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    mask_file::with_mask(open_alone(path, options)?, options)
}

/// Opens a raster without regard to a mask beside it.
fn open_alone(path: &Path, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    let file = InputFile::open(path)?;
    let head = file.head(HEAD)?;
    if head.is_empty() {
        return Err(Error::invalid(path, "is empty"));
    }

    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    if let Some(open) = by_first_bytes(&head).or_else(|| by_ending(&ending)) {
        return open(file, options);
    }

    refuse_compressed(path, &head)?;
    refuse_side_files(path, &ending)?;
    refuse_unlike_ending(path, &ending)?;
    refuse_foreign(path, &head, &ending)?;
    open_with_header(file, options)
}

/// Finds the reader of a format that its first bytes tell.
fn by_first_bytes(head: &[u8]) -> Option<OpenRaster> {
    let open: OpenRaster = match head {
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => tiff::open,
        _ if hedgehop_assets::picture::format(head).is_some() => picture::open,
        [b'b', b'i', b'n', b't', b'e', b'r', b'r', ..] => bt::open,
        [b'U' | b'V' | b'H', b'H' | b'O' | b'D', b'L' | b'R', b'1', ..] => dted::open,
        _ if esri_ascii::recognises(head) => esri_ascii::open,
        _ => return None,
    };
    Some(open)
}

/// Finds the reader of a format that only the ending of its name tells, in lower case.
fn by_ending(ending: &str) -> Option<OpenRaster> {
    let open: OpenRaster = match ending {
        "hgt" => |file, _| hgt::open(file),
        _ => return None,
    };
    Some(open)
}

/// Opens raw samples with a `.hdr` beside them, or with none at all.
fn open_with_header(file: InputFile, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    let mut appended = file.path().as_os_str().to_owned();
    appended.push(".hdr");
    let appended = PathBuf::from(appended);
    let header = if appended.is_file() { Some(appended) } else { side_files::beside(file.path(), "hdr") };
    let Some(header) = header.filter(|_| options.raw.is_none()) else {
        return headerless::open(file, options);
    };
    let text = side_files::text(&header)?;
    if text.trim_start().starts_with("ENVI") {
        envi::open(file, &header, &text)
    } else {
        esri_header::open(file, &header, &text)
    }
}

/// Refuses files that are compressed as a whole.
fn refuse_compressed(path: &Path, head: &[u8]) -> Result<()> {
    let tool = match head {
        [b'P', b'K', 3, 4, ..] => "unzip IN",
        [0x1f, 0x8b, ..] => "gunzip IN",
        _ => return Ok(()),
    };
    Err(Error::unsupported(path, "is compressed as a whole", format!("unpack it: {tool}")))
}

/// Refuses files that belong to the raster beside them.
fn refuse_side_files(path: &Path, ending: &str) -> Result<()> {
    if SIDE_FILE_ENDINGS.contains(&ending) {
        return Err(Error::invalid(path, "is a side file; name the raster beside it"));
    }
    if ending == "msk" {
        return Err(Error::invalid(path, "is a mask; name the raster beside it"));
    }
    Ok(())
}

/// Refuses files whose ending is that of a format that they do not begin like.
fn refuse_unlike_ending(path: &Path, ending: &str) -> Result<()> {
    if !ENDINGS_TOLD_BY_BYTES.contains(&ending) {
        return Ok(());
    }
    let what = format!("does not begin as a .{ending} does; it is damaged or no such file, fetch it again");
    Err(Error::invalid(path, what))
}

/// Refuses files of formats that are known, but not read.
fn refuse_foreign(path: &Path, head: &[u8], ending: &str) -> Result<()> {
    match foreign_name(path, head, ending) {
        Some(format) => Err(Error::unsupported(
            path,
            format!("is {format}, which is not read here"),
            "convert it: gdal_translate IN out.tif",
        )),
        None => Ok(()),
    }
}

/// Returns the name of the format that a file has, if it is one of those that are not read.
fn foreign_name(path: &Path, head: &[u8], ending: &str) -> Option<&'static str> {
    if let Some((_, name)) = FOREIGN.iter().find(|(bytes, _)| head.starts_with(bytes)) {
        return Some(name);
    }
    // GTOPO30 has the ending of a USGS DEM too, and a header beside it.
    if ending == "dem" && side_files::beside(path, "hdr").is_some() {
        return None;
    }
    FOREIGN_ENDINGS.iter().find(|(foreign, _)| *foreign == ending).map(|(_, name)| *name)
}
