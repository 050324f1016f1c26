//! Head of an AVI film: size, rate, and where its segments lie.
//!
//! ```text
//! RIFF "AVI " LIST hdrl
//!   avih                    size, rate, frames of the first segment
//!   LIST strl
//!     strh, strf            the stream: Motion JPEG
//!     indx                  where the index of each segment lies
//!   LIST odml: dmlh         frames of the whole film
//! LIST movi
//! ```
//!
//! It is as long whatever it tells, so that it can be written twice. All numbers are little-endian.

use crate::flight::FrameRate;
use hedgehop_base::Size;

/// Segments that the head has room for.
pub(super) const INDEX_CAPACITY: usize = 256;

/// Bytes of an entry of the index of segments.
const INDEX_ENTRY: usize = 16;
/// Flags: an index is there, and its marks of key frames hold.
const FLAGS: u32 = 0x10 | 0x800;

/// Head of a film.
#[derive(Debug)]
pub(super) struct Head {
    size: Size,
    rate: FrameRate,
    /// Bytes of the largest frame.
    pub largest: u32,
    /// Length of the first segment's RIFF chunk.
    pub riff_bytes: u32,
    /// Length of its list of frames.
    pub movi_bytes: u32,
    /// Indices of segments that are whole.
    pub segments: Vec<SegmentIndex>,
}

/// Place of a segment's index.
#[derive(Debug, Clone, Copy)]
pub(super) struct SegmentIndex {
    /// Byte of the file.
    pub place: u64,
    /// Bytes of the index, head included.
    pub bytes: u32,
    /// Frames of the segment.
    pub frame_count: u32,
}

impl Head {
    /// The head of a film without frames.
    pub(super) fn new(size: Size, rate: FrameRate) -> Self {
        Self { size, rate, largest: 0, riff_bytes: 0, movi_bytes: 0, segments: Vec::new() }
    }

    /// All bytes of the file before the first frame.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let stream =
            [chunk(b"strh", &self.stream()), chunk(b"strf", &self.format()), chunk(b"indx", &self.index())];
        let total = chunk(b"dmlh", &self.frame_count().to_le_bytes());
        let lists = [chunk(b"avih", &self.main()), list(b"strl", &stream.concat()), list(b"odml", &total)];

        let mut bytes = b"RIFF".to_vec();
        bytes.extend(self.riff_bytes.to_le_bytes());
        bytes.extend(b"AVI ");
        bytes.extend(list(b"hdrl", &lists.concat()));
        bytes.extend(b"LIST");
        bytes.extend(self.movi_bytes.to_le_bytes());
        bytes.extend(b"movi");
        bytes
    }

    fn frame_count(&self) -> u32 {
        self.segments.iter().map(|segment| segment.frame_count).sum()
    }

    /// `avih`: the film as old players see it.
    fn main(&self) -> Vec<u8> {
        let per_second = self.rate.per_second();
        let first_frames = self.segments.first().map_or(0, |segment| segment.frame_count);
        let most_bytes = (f64::from(self.largest) * per_second) as u32;
        let Size { width, height } = self.size;
        words(&[
            (1.0e6 / per_second).round() as u32,
            most_bytes,
            0,
            FLAGS,
            first_frames,
            0,
            1,
            self.largest,
            width,
            height,
            0,
            0,
            0,
            0,
        ])
    }

    /// `strh`: pictures of Motion JPEG, at their exact rate.
    fn stream(&self) -> Vec<u8> {
        let mut bytes = b"vidsMJPG".to_vec();
        let [scale, rate] = [self.rate.denominator(), self.rate.numerator()];
        let unknown_quality = u32::MAX;
        bytes.extend(words(&[0, 0, 0, scale, rate, 0, self.frame_count(), self.largest, unknown_quality, 0]));
        let sides = [0, 0, self.size.width as u16, self.size.height as u16];
        bytes.extend(sides.into_iter().flat_map(u16::to_le_bytes));
        bytes
    }

    /// `strf`: a bitmap's head, 24 bits a pixel.
    fn format(&self) -> Vec<u8> {
        let Size { width, height } = self.size;
        let (planes, bits) = (1_u32, 24_u32);
        let codec = u32::from_le_bytes(*b"MJPG");
        let raw_bytes = width.wrapping_mul(height).wrapping_mul(3);
        words(&[40, width, height, planes | bits << 16, codec, raw_bytes, 0, 0, 0, 0])
    }

    /// `indx`: an index of indices.
    fn index(&self) -> Vec<u8> {
        // Four words an entry; no kind below; an index of indices.
        let mut bytes = vec![4, 0, 0, 0];
        bytes.extend((self.segments.len() as u32).to_le_bytes());
        bytes.extend(b"00dc");
        bytes.extend([0; 12]);
        for SegmentIndex { place, bytes: length, frame_count } in &self.segments {
            bytes.extend(place.to_le_bytes());
            bytes.extend(words(&[*length, *frame_count]));
        }
        bytes.resize(24 + INDEX_CAPACITY * INDEX_ENTRY, 0);
        bytes
    }
}

/// A chunk, padded to an even length.
pub(super) fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(data.len() + 9);
    bytes.extend(kind);
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(2), 0);
    bytes
}

/// A list of chunks.
fn list(kind: &[u8; 4], chunks: &[u8]) -> Vec<u8> {
    chunk(b"LIST", &[kind, chunks].concat())
}

fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
