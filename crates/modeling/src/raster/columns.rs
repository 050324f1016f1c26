//! Rasters that store columns, each from south to north (DTED, `.bt`), decoded in groups of columns.

use super::blocks::{Block, BlockIndex, BlockSource};
use super::file::InputFile;
use super::sample::ByteOrder;
use crate::raster::{RasterInfo, SampleType};
use hedgehop_base::error::{Error, Result};

/// Columns per block.
pub(super) const GROUP: u32 = 64;

/// Checks and decodes one stored column in place, leaving its samples in native byte order at the beginning.
pub(super) type DecodeColumn = fn(column: u32, record: &mut [u8]) -> std::result::Result<(), String>;

/// A file of columns.
#[derive(Debug)]
pub(super) struct RasterColumns {
    pub file: InputFile,
    pub info: RasterInfo,
    /// Begin of the first column, bytes.
    pub first: u64,
    /// Bytes of a stored column.
    pub record_bytes: u64,
    pub decode: DecodeColumn,
}

impl RasterColumns {
    /// Refuses files that do not hold all columns.
    pub fn checked(self) -> Result<Self> {
        let total = self.record_bytes.checked_mul(u64::from(self.info.width));
        let end = total.and_then(|total| total.checked_add(self.first));
        if end.is_none_or(|end| end > self.file.length()) {
            let what = format!(
                "is said to hold {} columns of {} bytes, but ends at byte {}; it is cut short or its header is wrong",
                self.info.width,
                self.record_bytes,
                self.file.length()
            );
            return Err(Error::invalid(self.file.path(), what));
        }
        Ok(self)
    }
}

impl BlockSource for RasterColumns {
    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn decode(&self, index: BlockIndex) -> Result<Block> {
        let size = self.info.sample.bytes();
        let begin = index.column * self.info.block.width;
        let columns = self.info.block.width.min(self.info.width - begin) as usize;
        let height = self.info.height as usize;
        let mut bytes = vec![0; columns * height * size];
        for column in 0..columns {
            let number = begin + column as u32;
            let offset = self.first + self.record_bytes * u64::from(number);
            let mut record = self.file.bytes_at(offset, self.record_bytes)?;
            (self.decode)(number, &mut record).map_err(|what| Error::invalid(self.file.path(), what))?;
            for (post, value) in record.chunks_exact(size).take(height).enumerate() {
                let at = ((height - 1 - post) * columns + column) * size;
                bytes[at..at + size].copy_from_slice(value);
            }
        }
        Ok(Block::Samples { bytes, stride: columns as u32 })
    }
}

/// Little-endian samples of `sample` without anything around them.
pub(super) fn plain_little_endian(sample: SampleType) -> DecodeColumn {
    match sample.bytes() {
        2 => |_, record| {
            ByteOrder::Little.make_native(record, 2);
            Ok(())
        },
        _ => |_, record| {
            ByteOrder::Little.make_native(record, 4);
            Ok(())
        },
    }
}
