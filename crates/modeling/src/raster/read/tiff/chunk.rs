//! Chunks of a TIFF (tiles, strips), decompressed by `codec` and turned into samples by the `tiff` crate.
//!
//! ```text
//! decode(chunk): absent (offset or length 0) → nodata, or 0
//!                else bytes of the chunk, decompressed, behind a directory that describes this chunk alone as an
//!                image of one strip of plain grey or multi-band samples → tiff::decoder → native samples
//! ```
//! Handing over one chunk at a time keeps decoding free of state, so threads need no decoders of their own; it bounds
//! memory by the chunk; and since each image that the crate sees is plain samples, it neither inverts, drops nor recombines
//! bands: with more than four RGB bands and a predictor it would answer wrong values, with YCbCr luma as red.

use std::io::Cursor;

use tiff::decoder::{Decoder, Limits};

use super::codec::{self, ChunkSize};
use super::layout::TiffLayout;
use super::table::TableShape;
use super::tags::{compression, tag};
use crate::raster::blocks::{Block, BlockIndex, BlockSource};
use crate::raster::file::InputFile;
use crate::raster::sample::ByteOrder;
use crate::raster::{RasterInfo, SampleType};
use hedgehop_base::error::{Error, Result};

/// A window that a Zstandard frame may always claim, bytes (what every decoder must support; RFC 8878, §3.1.1.1.2).
const ZSTD_WINDOW: u64 = 8 << 20;

/// A TIFF that is decoded chunk by chunk.
#[derive(Debug)]
pub(super) struct ChunkedTiff {
    pub file: InputFile,
    pub info: RasterInfo,
    pub layout: TiffLayout,
    pub order: ByteOrder,
}

impl BlockSource for ChunkedTiff {
    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn planar(&self) -> bool {
        self.layout.planar
    }

    fn decode(&self, index: BlockIndex) -> Result<Block> {
        let (across, down) = self.layout.grid();
        let chunk = (index.plane as usize * down as usize + index.row as usize) * across as usize
            + index.column as usize;
        let (offset, length) = self.place(chunk, index)?;
        if offset == 0 || length == 0 {
            return Ok(Block::Constant(self.info.nodata.unwrap_or(0.0)));
        }
        let shape = self.layout.shape(index.row);
        let bytes = self.decompress(offset, length, shape).map_err(|what| {
            let place = format!("chunk {chunk} (column {}, row {}, byte {offset})", index.column, index.row);
            Error::invalid(
                self.file.path(),
                format!("its {place} cannot be decoded ({what}); it is damaged, fetch it again"),
            )
        })?;
        Ok(Block::Samples { bytes, stride: shape.width })
    }
}

impl ChunkedTiff {
    /// Offset and length of a chunk, bytes.
    fn place(&self, chunk: usize, index: BlockIndex) -> Result<(u64, u64)> {
        let missing = || Error::invalid(self.file.path(), format!("has no chunk {chunk}"));
        let offset = *self.layout.offsets.get(chunk).ok_or_else(missing)?;
        let decoded = self.layout.bytes(self.layout.stored(self.layout.shape(index.row)));
        let stored = match self.layout.byte_counts.get(chunk) {
            Some(length) => *length,
            None if self.layout.byte_counts.is_empty() => decoded,
            None => return Err(missing()),
        };
        if self.layout.compression == compression::NONE && stored != 0 {
            return Ok((offset, decoded));
        }

        // No codec here makes incompressible samples twice as long.
        if stored > decoded.saturating_mul(2).saturating_add(1 << 16) {
            let what = format!(
                "its chunk {chunk} is said to take {stored} bytes for {decoded} bytes of samples; it is damaged"
            );
            return Err(Error::invalid(self.file.path(), what));
        }

        Ok((offset, stored))
    }

    fn decompress(
        &self,
        offset: u64,
        length: u64,
        shape: TableShape,
    ) -> std::result::Result<Vec<u8>, String> {
        let (pixels, shape) = (shape, self.layout.stored(shape));
        let bytes = |shape: TableShape| usize::try_from(self.layout.bytes(shape)).map_err(|e| e.to_string());
        let needed = bytes(shape)?;
        let size = ChunkSize { needed, most: bytes(TableShape { rows: self.layout.chunk.height, ..shape })? };
        let mut stored = vec![0; usize::try_from(length).map_err(|e| e.to_string())?];
        self.file.read_at(&mut stored, offset).map_err(|e| e.to_string())?;
        if self.layout.compression == compression::ZSTD {
            check_zstd_window(&stored, size.most as u64)?;
        }

        let mut stored = codec::unpack(self.layout.compression, &stored, size)?;

        // What is left is the predictor's, and the order of bytes.
        let mut image = self.directory(shape, stored.len())?;
        image.append(&mut stored);
        let mut limits = Limits::default();
        limits.decoding_buffer_size = needed;
        limits.intermediate_buffer_size = image.len();
        let decoder = Decoder::new(Cursor::new(image)).map_err(|e| e.to_string())?;
        let mut bytes = vec![0; needed];
        decoder.with_limits(limits).read_chunk_bytes(0, &mut bytes).map_err(|e| e.to_string())?;

        Ok(if self.layout.packed { unpack(&bytes, pixels.width, shape.width) } else { bytes })
    }

    /// A classic TIFF header and directory in front of one chunk of `length` bytes.
    fn directory(&self, shape: TableShape, length: usize) -> std::result::Result<Vec<u8>, String> {
        const ENTRIES: u32 = 11;

        let data = 8 + 2 + ENTRIES * 12 + 4;
        let format = match self.layout.sample {
            SampleType::U8 | SampleType::U16 | SampleType::U32 => 1,
            SampleType::I8 | SampleType::I16 | SampleType::I32 => 2,
            SampleType::F32 | SampleType::F64 => 3,
        };
        let length = u32::try_from(length).map_err(|_| "it exceeds 4 GiB".to_owned())?;

        let values: [(u16, u32); ENTRIES as usize] = [
            (tag::IMAGE_WIDTH, shape.width),
            (tag::IMAGE_LENGTH, shape.rows),
            (tag::BITS_PER_SAMPLE, self.layout.sample.bytes() as u32 * 8),
            (tag::COMPRESSION, compression::NONE),
            (tag::PHOTOMETRIC, 1),
            (tag::STRIP_OFFSETS, data),
            (tag::SAMPLES_PER_PIXEL, shape.bands),
            (tag::ROWS_PER_STRIP, shape.rows),
            (tag::STRIP_BYTE_COUNTS, length),
            (tag::PREDICTOR, self.layout.predictor),
            (tag::SAMPLE_FORMAT, format),
        ];

        let mut image =
            Writer { bytes: Vec::with_capacity(data as usize + length as usize), order: self.order };
        image.bytes.extend(if self.order == ByteOrder::Little { b"II" } else { b"MM" });
        image.short(42);
        image.long(8);
        image.short(ENTRIES as u16);

        for (tag, value) in values {
            const LONG: u16 = 4;
            image.short(tag);
            image.short(LONG);
            image.long(1);
            image.long(value);
        }

        image.long(0);
        Ok(image.bytes)
    }
}

/// One byte, 0 or 255, per bit; the first pixel is the highest bit.
fn unpack(bytes: &[u8], width: u32, row_bytes: u32) -> Vec<u8> {
    let row = |row: &[u8]| -> Vec<u8> {
        (0..width as usize).map(|x| if row[x / 8] >> (7 - x % 8) & 1 == 1 { 255 } else { 0 }).collect()
    };
    bytes.chunks_exact(row_bytes as usize).flat_map(row).collect()
}

struct Writer {
    bytes: Vec<u8>,
    order: ByteOrder,
}

impl Writer {
    fn short(&mut self, value: u16) {
        let little = self.order == ByteOrder::Little;
        self.bytes.extend(if little { value.to_le_bytes() } else { value.to_be_bytes() });
    }

    fn long(&mut self, value: u32) {
        let little = self.order == ByteOrder::Little;
        self.bytes.extend(if little { value.to_le_bytes() } else { value.to_be_bytes() });
    }
}

/// Refuses frames whose header claims a window far beyond the chunk, since the decoder allocates it
/// (RFC 8878, §3.1.1.1).
fn check_zstd_window(frame: &[u8], size: u64) -> std::result::Result<(), String> {
    let (Some(descriptor), Some(window)) = (frame.get(4), frame.get(5)) else {
        return Err("it is too short for Zstandard".to_owned());
    };
    let single_segment = descriptor & 0x20 != 0;
    let window = if single_segment {
        let dictionary = [0, 1, 2, 4][usize::from(descriptor & 3)];
        let length = [1, 2, 4, 8][usize::from(descriptor >> 6)];
        let content =
            frame.get(5 + dictionary..5 + dictionary + length).map(|b| ByteOrder::Little.unsigned(b));
        content.unwrap_or(u64::MAX).saturating_add(if length == 2 { 256 } else { 0 })
    } else {
        let base = 1u64 << (10 + (window >> 3));
        base + base / 8 * u64::from(window & 7)
    };
    if window > size.saturating_mul(2).max(ZSTD_WINDOW) {
        return Err(format!("its Zstandard window of {window} bytes exceeds the chunk"));
    }
    Ok(())
}
