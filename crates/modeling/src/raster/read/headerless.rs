//! Raw samples without any header: little-endian 32-bit floats, rows from the north.

use crate::raster::file::InputFile;
use crate::raster::raw::{RawRaster, RowStarts, SamplePlacement};
use crate::raster::sample::ByteOrder;
use crate::raster::{OpenOptions, Raster, RasterInfo, SampleType};
use hedgehop_base::error::{Error, Result};

/// Opens a file of the size that the options state, or of a square.
pub(in crate::raster) fn open(file: InputFile, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    let samples = file.length() / 4;
    let side = samples.isqrt();
    let (width, height) = match options.raw {
        Some(layout) => (layout.width, layout.height),
        None if file.length() > 0 && side * side * 4 == file.length() => {
            let side = u32::try_from(side)
                .map_err(|_| Error::invalid(file.path(), "is too large to be a square of 32-bit floats"))?;
            (side, side)
        }
        None => {
            return Err(Error::unsupported(
                file.path(),
                "is of no format that is known here, and not a square of headerless 32-bit floats either",
                "convert it: gdal_translate IN out.tif",
            ));
        }
    };

    let expected = u64::from(width).checked_mul(u64::from(height)).and_then(|count| count.checked_mul(4));
    if width == 0 || height == 0 || expected != Some(file.length()) {
        let what = format!(
            "holds {} bytes, not {width} × {height} 32-bit floats; state its true size",
            file.length()
        );
        return Err(Error::invalid(file.path(), what));
    }

    let info = RasterInfo { width, height, sample: SampleType::F32, ..RasterInfo::blank(file.path(), "raw") };
    let placement = SamplePlacement {
        rows: RowStarts::Even { first: 0, row_bytes: u64::from(width) * 4 },
        pixel_bytes: 4,
        band_bytes: 0,
        order: ByteOrder::Little,
    };

    Ok(Box::new(RawRaster::new(file, info, placement)?))
}
