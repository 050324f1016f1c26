//! Motion JPEG in AVI, which needs no other program: every frame is a JPEG, and most players and editors read it.
//!
//! ```text
//! RIFF "AVI "                     a segment, of 1 GiB at most
//!   LIST hdrl                     the head: see `avi_head.rs`
//!   LIST movi: 00dc 00dc … ix00   JPEGs; where each of them lies
//!   idx1                          the same for players that know one segment only
//! RIFF "AVIX"                     further segments
//!   LIST movi: 00dc 00dc … ix00
//! ```
//!
//! Microsoft, *AVI RIFF File Reference*; segments by the *OpenDML AVI File Format Extensions* 1.02 (1997). JPEGs are
//! JFIF: BT.601 in full range, 4:2:0. The head is written again at the end, when all of it is known.

use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::PathBuf;

use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use tempfile::NamedTempFile;

use super::avi_head::{Head, INDEX_CAPACITY, SegmentIndex, chunk};
use super::footage::Footage;
use super::settings::{VideoQuality, VideoSettings};
use crate::encode::atomic;
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

/// Quality of the JPEGs of films to watch, 1 to 100.
const FINAL_QUALITY: u8 = 92;
/// Quality of the JPEGs of drafts.
const DRAFT_QUALITY: u8 = 75;

/// Bytes of pictures in a segment, at most.
const SEGMENT_BYTES: u64 = 1 << 30;
/// Longest side of a JPEG, pixels.
const LONGEST_SIDE: u32 = 65_500;

/// Kind of a frame's chunk: the first stream, compressed pictures.
const FRAME: &[u8; 4] = b"00dc";
/// Flag of frames that stand by themselves.
const KEY_FRAME: u32 = 0x10;

/// Film that grows in a temporary file. Dropped before it is finished, it leaves nothing.
pub(super) struct AviWriter {
    file: BufWriter<NamedTempFile>,
    out: PathBuf,
    size: Size,
    quality: u8,
    head: Head,
    segment: Segment,
    /// Bytes at which a segment is full.
    segment_bytes: u64,
    /// Bytes written so far.
    position: u64,
    /// The last JPEG, whose memory the next one takes.
    jpeg: Vec<u8>,
}

/// Segment that is being written.
struct Segment {
    /// Place of its RIFF chunk.
    riff: u64,
    /// Place of the word `movi`, which offsets count from.
    movi: u64,
    frames: Vec<FrameChunk>,
}

/// Place of a frame.
#[derive(Clone, Copy)]
struct FrameChunk {
    /// Bytes from the word `movi` to the chunk.
    offset: u32,
    /// Bytes of the JPEG.
    bytes: u32,
}

impl AviWriter {
    /// Begins a film of pictures such as `footage`.
    pub(super) fn start(settings: &VideoSettings, footage: Footage) -> Result<Self> {
        let VideoSettings { out, rate, quality, .. } = settings;
        check(settings)?;
        if footage.size.width.max(footage.size.height) > LONGEST_SIDE {
            let what = format!("a JPEG has {LONGEST_SIDE} pixels a side at most");
            return Err(Error::unsupported(out, what, "ask for a smaller --size"));
        }

        let head = Head::new(footage.size, *rate);
        let bytes = head.bytes();
        let mut writer = Self {
            file: BufWriter::new(atomic::temporary_for(out)?),
            out: out.clone(),
            size: footage.size,
            quality: if *quality == VideoQuality::Draft { DRAFT_QUALITY } else { FINAL_QUALITY },
            head,
            segment: Segment { riff: 0, movi: bytes.len() as u64 - 4, frames: Vec::new() },
            segment_bytes: SEGMENT_BYTES,
            position: 0,
            jpeg: Vec::new(),
        };
        writer.put(&bytes).map_err(|error| atomic::write_error(out, error))?;
        Ok(writer)
    }

    /// Appends a picture, `r g b r g b …`.
    pub(super) fn push(&mut self, rgb: &[u8]) -> Result<()> {
        let mut jpeg = std::mem::take(&mut self.jpeg);
        jpeg.clear();
        let mut encoder = Encoder::new(&mut jpeg, self.quality);
        encoder.set_sampling_factor(SamplingFactor::F_2_2);
        let [width, height] = [self.size.width as u16, self.size.height as u16];
        encoder
            .encode(rgb, width, height, ColorType::Rgb)
            .map_err(|error| Error::invalid(&self.out, format!("a frame cannot become a JPEG: {error}")))?;

        let appended = self.append(&jpeg);
        self.jpeg = jpeg;
        appended.map_err(|error| atomic::write_error(&self.out, error))
    }

    /// Ends the film, and gives it its name.
    pub(super) fn finish(mut self) -> Result<()> {
        self.end().map_err(|error| atomic::write_error(&self.out, error))?;
        let Self { file, out, .. } = self;
        let temporary = file.into_inner().map_err(|error| atomic::write_error(&out, error.into_error()))?;
        temporary.as_file().sync_all().map_err(|source| atomic::write_error(&out, source))?;
        atomic::persist(temporary, &out)
    }

    fn append(&mut self, jpeg: &[u8]) -> io::Result<()> {
        let taken = self.position - self.segment.riff;
        if !self.segment.frames.is_empty() && taken + jpeg.len() as u64 > self.segment_bytes {
            self.end_segment()?;
            self.begin_segment()?;
        }

        let frame =
            FrameChunk { offset: word(self.position - self.segment.movi)?, bytes: word(jpeg.len() as u64)? };
        self.segment.frames.push(frame);
        self.head.largest = self.head.largest.max(frame.bytes);
        self.put(&chunk(FRAME, jpeg))
    }

    fn end(&mut self) -> io::Result<()> {
        self.end_segment()?;
        let head = self.head.bytes();
        self.patch(0, &head)?;
        self.file.flush()
    }

    fn begin_segment(&mut self) -> io::Result<()> {
        if self.head.segments.len() == INDEX_CAPACITY {
            let what = "AVI holds no more; make the film in parts (--frames), or an .mkv";
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, what));
        }
        let riff = self.position;
        self.put(b"RIFF\0\0\0\0AVIXLIST\0\0\0\0movi")?;
        self.segment = Segment { riff, movi: self.position - 4, frames: Vec::new() };
        Ok(())
    }

    /// Writes the segment's indices and lengths.
    fn end_segment(&mut self) -> io::Result<()> {
        let (place, is_first) = (self.position, self.head.segments.is_empty());
        self.put(&chunk(b"ix00", &self.index()))?;
        let index = SegmentIndex {
            place,
            bytes: word(self.position - place)?,
            frame_count: word(self.segment.frames.len() as u64)?,
        };
        self.head.segments.push(index);
        let movi_bytes = word(self.position - self.segment.movi)?;

        if is_first {
            self.put(&chunk(b"idx1", &self.single_segment_index()))?;
        }
        let riff_bytes = word(self.position - self.segment.riff - 8)?;
        if is_first {
            (self.head.riff_bytes, self.head.movi_bytes) = (riff_bytes, movi_bytes);
            return Ok(());
        }
        self.patch(self.segment.riff + 4, &riff_bytes.to_le_bytes())?;
        self.patch(self.segment.movi - 4, &movi_bytes.to_le_bytes())
    }

    /// Index of the segment: places of the JPEGs themselves.
    fn index(&self) -> Vec<u8> {
        let mut index = Vec::new();
        // Two words an entry; no kind below; an index of chunks.
        index.extend([2, 0, 0, 1]);
        index.extend((self.segment.frames.len() as u32).to_le_bytes());
        index.extend(FRAME);
        index.extend(self.segment.movi.to_le_bytes());
        index.extend([0; 4]);
        for frame in &self.segment.frames {
            index.extend((frame.offset + 8).to_le_bytes());
            index.extend(frame.bytes.to_le_bytes());
        }
        index
    }

    /// Index for players that know one segment only: places of the chunks.
    fn single_segment_index(&self) -> Vec<u8> {
        let entry = |frame: &FrameChunk| {
            let [kind, flags] = [*FRAME, KEY_FRAME.to_le_bytes()];
            [kind, flags, frame.offset.to_le_bytes(), frame.bytes.to_le_bytes()]
        };
        self.segment.frames.iter().flat_map(entry).flatten().collect()
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(bytes)?;
        self.position += bytes.len() as u64;
        Ok(())
    }

    /// Replaces bytes that were written before.
    fn patch(&mut self, place: u64, bytes: &[u8]) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(place))?;
        self.file.write_all(bytes)?;
        self.file.seek(SeekFrom::Start(self.position)).map(drop)
    }
}

/// Refuses what such films cannot have.
pub(super) fn check(settings: &VideoSettings) -> Result<()> {
    let refuse = |what: &str| {
        let out = settings.out.display();
        Err(Error::Configuration(format!("--video {out}: an AVI film has {what}; write .mp4 or .mov")))
    };
    match settings {
        _ if settings.sound.is_some() => refuse("no sound here"),
        _ if !settings.chapters.is_empty() => refuse("no chapters"),
        _ if settings.quality == VideoQuality::Mezzanine => refuse("no ProRes"),
        _ => Ok(()),
    }
}

/// A length that fits the file's fields.
fn word(length: u64) -> io::Result<u32> {
    u32::try_from(length).map_err(|_| io::ErrorKind::FileTooLarge.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::testing;

    /// Chunk of a file: its kind and data.
    fn chunks(mut bytes: &[u8]) -> Vec<(String, &[u8])> {
        let mut found = Vec::new();
        while let Some((head, rest)) = bytes.split_at_checked(8) {
            let length = u32::from_le_bytes(head[4..].try_into().unwrap()) as usize;
            found.push((String::from_utf8_lossy(&head[..4]).into_owned(), &rest[..length]));
            bytes = &rest[(length + length % 2).min(rest.len())..];
        }
        found
    }

    fn word_at(bytes: &[u8], place: usize) -> usize {
        u32::from_le_bytes(bytes[place..place + 4].try_into().unwrap()) as usize
    }

    #[test]
    fn films_longer_than_a_segment_are_found_by_their_indices() {
        let (_folder, out) = testing::place("a.avi");
        let settings = VideoSettings::new(out.clone(), "24000/1001".parse().unwrap());
        let footage = Footage { size: Size { width: 33, height: 17 }, frame_count: 7 };
        let mut writer = AviWriter::start(&settings, footage).unwrap();
        writer.segment_bytes = writer.position + 2500;
        for shade in 0..7 {
            writer.push(&vec![shade * 40; 33 * 17 * 3]).unwrap();
        }
        writer.finish().unwrap();

        let file = std::fs::read(&out).unwrap();
        let segments = chunks(&file);
        assert!(segments.len() > 1 && segments.iter().all(|(kind, _)| kind == "RIFF"), "{}", segments.len());

        // The head tells where each segment's index lies, which tells where JPEGs lie.
        let at = |word: &[u8]| file.windows(word.len()).position(|window| window == word).unwrap();
        let indices = at(b"indx") + 8;
        assert_eq!(word_at(&file, indices + 4), segments.len());
        let mut shades = Vec::new();
        for entry in 0..segments.len() {
            let index = word_at(&file, indices + 24 + 16 * entry);
            let (kind, data) = &chunks(&file[index..])[0];
            assert_eq!((kind.as_str(), data.len() + 8), ("ix00", word_at(&file, indices + 32 + 16 * entry)));
            assert_eq!(word_at(data, 4), word_at(&file, indices + 36 + 16 * entry));
            let base = word_at(data, 12);
            for frame in 0..word_at(data, 4) {
                let [place, length] = [24, 28].map(|field| word_at(data, field + 8 * frame));
                let jpeg = &file[base + place..][..length];
                let picture = image::load_from_memory_with_format(jpeg, image::ImageFormat::Jpeg).unwrap();
                assert_eq!((picture.width(), picture.height()), (33, 17));
                shades.push(picture.to_rgb8().get_pixel(16, 8).0[1]);
            }
        }
        assert!(shades.iter().zip(0..).all(|(found, shade)| found.abs_diff(shade * 40) < 3), "{shades:?}");
        assert_eq!(shades.len(), 7);

        // Older players look at the frames of the first segment alone.
        let (_, first) = &segments[0];
        let lists = chunks(&first[4..]);
        let kinds: Vec<&str> = lists.iter().map(|(kind, _)| kind.as_str()).collect();
        assert_eq!(kinds, ["LIST", "LIST", "idx1"]);
        let (movi, idx1) = (lists[1].1, lists[2].1);
        assert_eq!(idx1.len() / 16, word_at(&file, at(b"avih") + 8 + 16));
        let place = word_at(idx1, 8);
        assert_eq!(&movi[place..place + 4], FRAME);
        assert_eq!(word_at(movi, place + 4), word_at(idx1, 12));

        // Exact rate and number of all frames.
        let stream = at(b"strh") + 8;
        assert_eq!([20, 24, 32].map(|field| word_at(&file, stream + field)), [1001, 24000, 7]);
        assert_eq!(word_at(&file, at(b"dmlh") + 8), 7);
    }
}
