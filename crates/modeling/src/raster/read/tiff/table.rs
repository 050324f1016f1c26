//! Table of chunks, held against what they must hold: samples that are not compressed have no other check.

use super::layout::TiffLayout;
use super::tags::compression;
use crate::raster::blocks::block_bytes;
use crate::raster::file::InputFile;
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

/// Size of one stored chunk.
#[derive(Debug, Clone, Copy)]
pub(super) struct TableShape {
    pub width: u32,
    pub rows: u32,
    pub bands: u32,
}

impl TiffLayout {
    /// The chunks of a row of them: strips end at the last row of the image, tiles are always whole.
    pub(super) fn shape(&self, row: u32) -> TableShape {
        let Size { width, height: rows } = self.chunk;
        let rows = if self.tiled { rows } else { rows.min(self.height - row * rows) };
        TableShape { width, rows, bands: if self.planar { 1 } else { self.bands } }
    }

    /// The shape in bytes if samples are bits, which come eight to a byte, each row from a byte on.
    pub(super) fn stored(&self, shape: TableShape) -> TableShape {
        TableShape { width: if self.packed { shape.width.div_ceil(8) } else { shape.width }, ..shape }
    }

    /// Bytes of a chunk's samples.
    pub(super) fn bytes(&self, shape: TableShape) -> u64 {
        let size = Size { width: shape.width, height: shape.rows };
        block_bytes(size, shape.bands, self.sample).unwrap_or(u64::MAX)
    }

    /// Refuses chunks that cannot be where they are said to be.
    pub(super) fn check_table(&self, file: &InputFile) -> Result<()> {
        let wrong = |chunk: usize, what: String| {
            Error::invalid(file.path(), format!("its chunk {chunk} {what}; it is damaged, fetch it again"))
        };
        let (across, down) = self.grid();
        let needed = |chunk: usize| {
            let row = chunk as u64 / u64::from(across) % u64::from(down);
            self.bytes(self.stored(self.shape(row as u32)))
        };
        let is_plain = self.compression == compression::NONE;

        let mut extents = Vec::with_capacity(self.offsets.len());
        for (chunk, offset) in self.offsets.iter().enumerate() {
            let count = self.byte_counts.get(chunk).copied();
            // Absent chunks have neither place nor length.
            match (*offset, count) {
                (0, Some(0) | None) => continue,
                (0, Some(_)) => {
                    return Err(wrong(chunk, "is said to have a length, but no place".to_owned()));
                }
                (_, Some(0)) => {
                    return Err(wrong(chunk, "is said to have a place, but no length".to_owned()));
                }
                _ => {}
            }

            let needed = needed(chunk);
            let length = match count {
                Some(count) if is_plain && count < needed => {
                    return Err(wrong(chunk, format!("is said to hold {count} bytes and needs {needed}")));
                }
                Some(count) if !is_plain => count,
                _ => needed,
            };

            extents.push((*offset, length, chunk));
        }

        // Equal chunks may be stored once; no others share bytes.
        extents.sort_unstable();
        for pair in extents.windows(2) {
            let ((before, length, _), (after, other, chunk)) = (pair[0], pair[1]);
            if before.saturating_add(length) > after && (before, length) != (after, other) {
                return Err(wrong(chunk, format!("is said to lie at byte {after}, within another one")));
            }
        }

        Ok(())
    }
}
