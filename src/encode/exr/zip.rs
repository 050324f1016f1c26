//! Chunks of a file: sixteen lines of all channels, ZIP-compressed as OpenEXR wants it.
//!
//! ```text
//! samples of a chunk    line by line, in a line channel by channel, little-endian
//! separated             bytes at even places, then those at odd places
//! differences           each byte less the one before, plus 128; the first as it is
//! zlib                  or, where that is not shorter, the samples as they are
//! ```
//! Source: OpenEXR, *Technical Introduction* and `ImfZip.cpp` (ASWF).

use std::ops::Range;

use ::exr::prelude::FlatSamples;
use flate2::{Compress, Compression, FlushCompress, Status};

use super::channels::Channels;

/// Effort of deflate: the next one takes almost three times as long, for 6 % less bytes.
const EFFORT: Compression = Compression::fast();

/// Compressor that keeps its memory from chunk to chunk.
#[derive(Debug)]
pub(super) struct Zip {
    separated: Vec<u8>,
    differences: Vec<u8>,
    deflate: Compress,
}

impl Default for Zip {
    fn default() -> Self {
        Self { separated: Vec::new(), differences: Vec::new(), deflate: Compress::new(EFFORT, true) }
    }
}

impl Zip {
    /// The bytes of a chunk: `rows` of channels that are `width` samples wide.
    pub(super) fn compress(&mut self, channels: &Channels, width: usize, rows: Range<usize>) -> Vec<u8> {
        // Samples line by line, the bytes at even places before the others.
        let planes: Vec<_> = channels.list.iter().map(|channel| &channel.sample_data).collect();
        let even_bytes = |plane: &FlatSamples| if matches!(plane, FlatSamples::F16(_)) { 1 } else { 2 };
        let lanes: Vec<usize> = planes.iter().map(|plane| width * even_bytes(plane)).collect();
        let half = rows.len() * lanes.iter().sum::<usize>();
        self.separated.resize(2 * half, 0);
        self.differences.resize(2 * half, 0);

        let (mut even, mut odd) = self.separated.split_at_mut(half);
        for row in rows {
            for (plane, lane) in planes.iter().zip(&lanes) {
                let (even_lane, odd_lane);
                (even_lane, even) = even.split_at_mut(*lane);
                (odd_lane, odd) = odd.split_at_mut(*lane);
                separate(plane, row * width..(row + 1) * width, even_lane, odd_lane);
            }
        }

        differ(&self.separated, &mut self.differences);
        self.shrunk(2 * half).unwrap_or_else(|| {
            let (even, odd) = self.separated.split_at(half);
            even.iter().zip(odd).flat_map(|(even, odd)| [*even, *odd]).collect()
        })
    }

    /// Compresses the differences into fewer than `limit` bytes; `None` if they take more.
    fn shrunk(&mut self, limit: usize) -> Option<Vec<u8>> {
        // Compression stops where this memory ends, and a vector may have more than was asked for.
        let mut out = Vec::with_capacity(limit);
        self.deflate.reset();
        let status = self.deflate.compress_vec(&self.differences, &mut out, FlushCompress::Finish);
        (matches!(status, Ok(Status::StreamEnd)) && out.len() < limit).then_some(out)
    }
}

/// Separates the bytes of samples at even places from those at odd ones.
fn separate(plane: &FlatSamples, samples: Range<usize>, even: &mut [u8], odd: &mut [u8]) {
    match plane {
        FlatSamples::F16(plane) => {
            for ((even, odd), sample) in even.iter_mut().zip(odd).zip(&plane[samples]) {
                [*even, *odd] = sample.to_bits().to_le_bytes();
            }
        }
        FlatSamples::F32(plane) => separate_fours(&plane[samples], f32::to_bits, even, odd),
        FlatSamples::U32(plane) => separate_fours(&plane[samples], |sample| sample, even, odd),
    }
}

/// Separates the bytes of samples of four.
fn separate_fours<T: Copy>(samples: &[T], bits: impl Fn(T) -> u32, even: &mut [u8], odd: &mut [u8]) {
    let (even, _) = even.as_chunks_mut::<2>();
    let (odd, _) = odd.as_chunks_mut::<2>();
    for ((even, odd), sample) in even.iter_mut().zip(odd).zip(samples) {
        [even[0], odd[0], even[1], odd[1]] = bits(*sample).to_le_bytes();
    }
}

/// Differences of neighbouring bytes.
fn differ(bytes: &[u8], differences: &mut [u8]) {
    if let (Some(first), Some(difference)) = (bytes.first(), differences.first_mut()) {
        *difference = *first;
    }
    for ((before, byte), difference) in
        bytes.iter().zip(bytes.iter().skip(1)).zip(differences.iter_mut().skip(1))
    {
        *difference = byte.wrapping_sub(*before).wrapping_add(128);
    }
}
