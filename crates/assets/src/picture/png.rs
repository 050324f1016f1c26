//! PNG (W3C, *Portable Network Graphics*, third edition, 2025), decoded by the `png` crate with all checks that it has.

use std::io::Cursor;

use png::{BitDepth, ColorType, DecodeOptions, Decoder, Limits, Reader, Transformations};

use crate::picture::{Fault, Format, Header, Transparency};

/// Bytes that the decoder may take besides the picture.
const WORKSPACE: usize = 64 << 20;
/// Bytes before the first chunk.
const SIGNATURE: usize = 8;

type PngReader<'b> = Reader<Cursor<&'b [u8]>>;

/// Reads all chunks before the samples.
pub fn header(bytes: &[u8], transparency: Transparency) -> Result<Header, Fault> {
    reader(bytes, transparency).map(|(_, header)| header)
}

/// Decodes the samples, and checks all that stands behind them.
pub fn decode(bytes: &[u8], transparency: Transparency) -> Result<Vec<u8>, Fault> {
    let (mut reader, header) = reader(bytes, transparency)?;
    let size = reader.output_buffer_size().filter(|size| Some(*size as u64) == header.bytes());
    let size = size.ok_or_else(|| Fault::Damaged("its size exceeds memory".to_owned()))?;

    let mut samples = vec![0; size];
    reader.next_frame(&mut samples).map_err(damaged)?;
    // The decoder stops at the last sample; chunks behind it may be cut off or damaged as well.
    reader.finish().map_err(damaged)?;

    if header.is_wide && cfg!(target_endian = "little") {
        samples.as_chunks_mut::<2>().0.iter_mut().for_each(|sample| sample.reverse());
    }
    Ok(samples)
}

fn reader(bytes: &[u8], transparency: Transparency) -> Result<(PngReader<'_>, Header), Fault> {
    let mut options = DecodeOptions::default();
    options.set_ignore_checksums(false);
    options.set_skip_ancillary_crc_failures(false);
    let mut decoder = Decoder::new_with_options(Cursor::new(bytes), options);
    decoder.set_limits(Limits { bytes: WORKSPACE });

    let info = decoder.read_header_info().map_err(damaged)?;
    let (color, depth) = (info.color_type, info.bit_depth);
    let is_grey = matches!(color, ColorType::Grayscale);
    let keeps_value = is_grey && transparency == Transparency::Value;
    decoder.set_transformations(if keeps_value {
        Transformations::IDENTITY
    } else {
        Transformations::EXPAND
    });

    let reader = decoder.read_info().map_err(damaged)?;
    let info = reader.info();
    if info.trns.is_none() && has_transparency(bytes) {
        // The decoder leaves out a chunk whose checksum holds, but that is none of its kind.
        return Err(Fault::Damaged("its tRNS chunk cannot be understood".to_owned()));
    }

    let value = info.trns.as_deref().filter(|_| keeps_value);
    let (decoded, decoded_depth) = reader.output_color_type();
    let header = Header {
        format: Format::Png,
        width: info.width,
        height: info.height,
        bands: decoded.samples() as u32,
        has_alpha: matches!(decoded, ColorType::GrayscaleAlpha | ColorType::Rgba),
        is_wide: decoded_depth == BitDepth::Sixteen,
        stored_bits: depth as u8,
        is_palette: color == ColorType::Indexed,
        transparent_grey: value.map(|value| value.iter().fold(0, |all, byte| all << 8 | u16::from(*byte))),
    };

    Ok((reader, header))
}

fn damaged(error: png::DecodingError) -> Fault {
    let what = match &error {
        png::DecodingError::IoError(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
            "it is cut short".to_owned()
        }
        other => other.to_string(),
    };
    Fault::Damaged(match wrong_chunk(&what) {
        Some(kind) => format!("the checksum of its {kind} chunk is wrong"),
        None => what.trim_end_matches(['.', '\n']).to_owned(),
    })
}

/// Kind of the chunk of which the decoder's sentence says that its checksum is wrong.
fn wrong_chunk(what: &str) -> Option<&str> {
    let (kind, _) = what.strip_prefix("CRC error")?.split_once("type: ")?.1.split_once(',')?;
    Some(kind)
}

/// Whether a `tRNS` chunk stands before the samples.
fn has_transparency(bytes: &[u8]) -> bool {
    let mut rest = bytes.get(SIGNATURE..).unwrap_or_default();
    while let [a, b, c, d, kind @ ..] = rest {
        match kind.get(..4) {
            Some(b"tRNS") => return true,
            Some(b"IDAT") | None => return false,
            Some(_) => {}
        }
        // Behind the kind, the chunk's own bytes and its checksum.
        let length = u32::from_be_bytes([*a, *b, *c, *d]) as usize;
        rest = kind.get(4..).and_then(|rest| rest.get(length.checked_add(4)?..)).unwrap_or_default();
    }
    false
}
