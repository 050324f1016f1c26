//! Codecs of chunks: all samples of a chunk, and nothing behind them.
//!
//! Whoever stops at the last sample never sees that a checksum is wrong, or that damaged codes gave other bytes than were
//! stored, which most often are more or fewer.

use std::io::{Read, copy};

use flate2::read::ZlibDecoder;
use ruzstd::decoding::StreamingDecoder;
use weezl::decode::Configuration;
use weezl::{BitOrder, LzwStatus};

use super::tags::compression;

/// Bytes of a chunk's samples.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChunkSize {
    /// Bytes that are needed.
    pub needed: usize,
    /// Most bytes that there may be: some programs store the last strip with rows beyond the image.
    pub most: usize,
}

/// Unpacks a chunk that is stored under a compression; its predictor is still to be undone.
pub(super) fn unpack(code: u32, stored: &[u8], size: ChunkSize) -> Result<Vec<u8>, String> {
    match code {
        compression::DEFLATE | compression::OLD_DEFLATE => whole(ZlibDecoder::new(stored), size),
        compression::ZSTD => zstandard(stored, size),
        compression::LZW => exact(lzw(stored, size.most)?, size),
        compression::PACK_BITS => exact(pack_bits(stored, size.most)?, size),
        _ => stored.get(..size.needed).map(<[u8]>::to_vec).ok_or_else(|| "it is too short".to_owned()),
    }
}

/// All of a stream, whose end is where its checksum is compared.
fn whole(mut stream: impl Read, size: ChunkSize) -> Result<Vec<u8>, String> {
    let mut bytes = vec![0; size.needed];
    stream.read_exact(&mut bytes).map_err(|error| error.to_string())?;
    let room = (size.most - size.needed) as u64;
    let behind = copy(&mut stream.take(room + 1), &mut std::io::sink()).map_err(|error| error.to_string())?;
    if behind > room { Err(surplus()) } else { Ok(bytes) }
}

/// Returns all of a Zstandard frame, whose checksum is compared if it has one (RFC 8878, §3.1.1).
fn zstandard(stored: &[u8], size: ChunkSize) -> Result<Vec<u8>, String> {
    let mut stream = StreamingDecoder::new(stored).map_err(|error| error.to_string())?;
    let bytes = whole(&mut stream, size)?;
    let frame = &stream.decoder;
    match frame.get_checksum_from_data() {
        Some(stated) if Some(stated) != frame.get_calculated_checksum() => {
            Err("its checksum is another one".to_owned())
        }
        _ => Ok(bytes),
    }
}

fn exact(mut bytes: Vec<u8>, size: ChunkSize) -> Result<Vec<u8>, String> {
    match bytes.len() {
        length if length < size.needed => Err(format!("it holds {length} of {} bytes", size.needed)),
        length if length > size.most => Err(surplus()),
        _ => {
            bytes.truncate(size.needed);
            Ok(bytes)
        }
    }
}

fn surplus() -> String {
    "it holds more than its samples".to_owned()
}

/// At most one byte more than `most`.
fn lzw(stored: &[u8], most: usize) -> Result<Vec<u8>, String> {
    let configuration =
        Configuration::with_tiff_size_switch(BitOrder::Msb, 8).with_yield_on_full_buffer(true);
    let mut decoder = configuration.build();
    let (mut bytes, mut from, mut to) = (vec![0; most + 1], 0, 0);
    while to < bytes.len() {
        let step = decoder.decode_bytes(&stored[from..], &mut bytes[to..]);
        from += step.consumed_in;
        to += step.consumed_out;
        match step.status {
            Ok(LzwStatus::Ok) => {}
            // Some programs leave out the code that ends the data.
            Ok(LzwStatus::Done | LzwStatus::NoProgress) => break,
            Err(error) => return Err(error.to_string()),
        }
    }
    bytes.truncate(to);
    Ok(bytes)
}

/// TIFF 6.0, section 9; likewise.
fn pack_bits(stored: &[u8], most: usize) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::with_capacity(most + 1);
    let mut rest = stored;
    while bytes.len() <= most {
        let Some((head, after)) = rest.split_first() else { break };
        let head = isize::from(*head as i8);
        rest = match head {
            -128 => after,
            0.. => {
                let (literal, rest) =
                    after.split_at_checked(head as usize + 1).ok_or("it ends within a run")?;
                bytes.extend_from_slice(literal);
                rest
            }
            _ => {
                let (repeated, rest) = after.split_first().ok_or("it ends within a run")?;
                bytes.extend(std::iter::repeat_n(*repeated, (1 - head) as usize));
                rest
            }
        };
    }

    bytes.truncate(most + 1);
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn size(needed: usize, most: usize) -> ChunkSize {
        ChunkSize { needed, most }
    }

    #[test]
    fn pack_bits_are_those_of_the_specification() {
        // The example of section 9 of the Macintosh technical note that TIFF 6.0 names.
        let packed =
            [0xfe, 0xaa, 0x02, 0x80, 0x00, 0x2a, 0xfd, 0xaa, 0x03, 0x80, 0x00, 0x2a, 0x22, 0xf7, 0xaa];
        let plain = [
            0xaa, 0xaa, 0xaa, 0x80, 0x00, 0x2a, 0xaa, 0xaa, 0xaa, 0xaa, 0x80, 0x00, 0x2a, 0x22, 0xaa, 0xaa,
            0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa,
        ];
        let unpacked = |size| unpack(compression::PACK_BITS, &packed, size);
        assert_eq!(unpacked(size(24, 24)).unwrap(), plain);
        assert_eq!(unpacked(size(20, 24)).unwrap(), plain[..20]);
        assert!(unpacked(size(25, 25)).is_err() && unpacked(size(20, 23)).is_err());
        assert!(unpack(compression::PACK_BITS, &packed[..14], size(24, 24)).is_err());
    }

    fn zstandard_of(plain: &[u8]) -> Vec<u8> {
        ruzstd::encoding::compress_to_vec(plain, ruzstd::encoding::CompressionLevel::Fastest)
    }

    #[test]
    fn a_wrong_checksum_of_zstandard_is_told() {
        let plain: Vec<u8> = (0..5_000_u32).map(|i| (i * i / 7) as u8).collect();
        let mut frame = zstandard_of(&plain);
        assert_eq!(unpack(compression::ZSTD, &frame, size(5_000, 5_000)).unwrap(), plain);
        *frame.last_mut().unwrap() ^= 1;
        let refusal = unpack(compression::ZSTD, &frame, size(5_000, 5_000)).unwrap_err();
        assert!(refusal.contains("checksum"), "{refusal}");
    }

    #[test]
    fn nothing_may_be_missing_or_left() {
        let plain: Vec<u8> = (0..200_u32).map(|i| (i * i / 7) as u8).collect();
        let mut deflated = flate2::read::ZlibEncoder::new(&plain[..], flate2::Compression::best());
        let mut packed = Vec::new();
        deflated.read_to_end(&mut packed).unwrap();
        let zstd = zstandard_of(&plain);
        let lzw = weezl::encode::Encoder::with_tiff_size_switch(BitOrder::Msb, 8).encode(&plain).unwrap();
        for (code, packed) in
            [(compression::DEFLATE, packed), (compression::ZSTD, zstd), (compression::LZW, lzw)]
        {
            assert_eq!(unpack(code, &packed, size(200, 200)).unwrap(), plain, "{code}");
            assert_eq!(unpack(code, &packed, size(150, 200)).unwrap(), plain[..150], "{code}");
            assert!(unpack(code, &packed, size(199, 199)).is_err(), "{code}");
            assert!(unpack(code, &packed, size(201, 201)).is_err(), "{code}");
            assert!(unpack(code, &packed[..packed.len() / 2], size(200, 200)).is_err(), "{code}");
        }
    }
}
