//! Every byte of a PNG counts.

use super::{decode, header};
use crate::picture::{Fault, Format, Transparency};

/// A PNG of 9 × 7 pixels, with a palette and a transparent value where it may have them.
fn png(color: png::ColorType, depth: png::BitDepth, transparency: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 9, 7);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if color == png::ColorType::Indexed {
        encoder.set_palette((0..48).map(|i| i * 5).collect::<Vec<u8>>());
    }
    if !transparency.is_empty() {
        encoder.set_trns(transparency.to_vec());
    }
    let row = (9 * color.samples() * depth as usize).div_ceil(8);
    let samples: Vec<u8> = (0..row * 7).map(|i| (i * 37) as u8).collect();
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&samples).unwrap();
    writer.finish().unwrap();
    bytes
}

fn all() -> Vec<Vec<u8>> {
    use png::{BitDepth, ColorType};
    vec![
        png(ColorType::Grayscale, BitDepth::Sixteen, &[0, 37]),
        png(ColorType::Grayscale, BitDepth::Eight, &[0, 74]),
        png(ColorType::Rgb, BitDepth::Eight, &[0, 0, 0, 37, 0, 74]),
        png(ColorType::Rgba, BitDepth::Sixteen, &[]),
        png(ColorType::Indexed, BitDepth::Four, &[0, 99]),
    ]
}

#[test]
fn each_kind_is_what_it_was_written_as() {
    let headers: Vec<_> = all().iter().map(|bytes| header(bytes, Transparency::Value).unwrap()).collect();
    let told: Vec<_> = headers
        .iter()
        .map(|header| {
            (header.bands, header.has_alpha, header.is_wide, header.is_palette, header.transparent_grey)
        })
        .collect();

    assert_eq!(
        told,
        [
            (1, false, true, false, Some(37)),
            (1, false, false, false, Some(74)),
            (4, true, false, false, None),
            (4, true, true, false, None),
            (4, true, false, true, None),
        ]
    );

    assert!(headers.iter().all(|header| (header.width, header.height, header.format) == (9, 7, Format::Png)));

    let grey = &all()[1];
    assert_eq!(decode(grey, Transparency::Value).unwrap()[..3], [0, 37, 74]);
    assert_eq!(decode(grey, Transparency::Alpha).unwrap()[..6], [0, 255, 37, 255, 74, 0]);
    let colours = decode(&all()[2], Transparency::Value).unwrap();
    assert_eq!(colours[..8], [0, 37, 74, 0, 111, 148, 185, 255]);
    let wide = decode(&all()[0], Transparency::Value).unwrap();
    assert_eq!(u16::from_ne_bytes([wide[0], wide[1]]), 37);
}

#[test]
fn no_byte_of_a_png_may_change_or_be_missing() {
    for (kind, bytes) in all().iter().enumerate() {
        for transparency in [Transparency::Value, Transparency::Alpha] {
            let read = |bytes: &[u8]| match (header(bytes, transparency), decode(bytes, transparency)) {
                (Ok(header), Ok(samples)) => Ok((header, samples)),
                (Err(fault), _) | (_, Err(fault)) => Err(fault),
            };
            let sound = read(bytes).unwrap();

            for at in 0..bytes.len() {
                for bit in [0x01, 0x20, 0x80] {
                    let mut flipped = bytes.clone();
                    flipped[at] ^= bit;
                    match read(&flipped) {
                        Ok(read) => assert!(read == sound, "{kind}: byte {at}"),
                        Err(Fault::Damaged(_)) => {}
                        Err(fault) => panic!("{kind}: byte {at}: {fault}"),
                    }
                }
                assert!(read(&bytes[..at]).is_err(), "{kind} to {at}");
            }
        }
    }
}

#[test]
fn a_transparent_value_that_is_none_is_damage() {
    // Of one byte, where a grey takes two; its checksum holds.
    let chunk = b"tRNS\x05";
    let checksum = crc32fast::hash(chunk);
    let mut bytes = png(png::ColorType::Grayscale, png::BitDepth::Eight, &[]);
    let odd = [&[0, 0, 0, 1][..], chunk, &checksum.to_be_bytes()].concat();
    bytes.splice(33..33, odd);
    let fault = decode(&bytes, Transparency::Value).unwrap_err().to_string();
    assert!(fault.contains("tRNS"), "{fault}");
}

#[test]
fn a_wrong_checksum_is_told_by_its_chunk() {
    let mut bytes = png(png::ColorType::Grayscale, png::BitDepth::Sixteen, &[0, 37]);
    let at = bytes.windows(4).position(|kind| kind == b"tRNS").unwrap();
    bytes[at + 4] ^= 1;
    let fault = decode(&bytes, Transparency::Value).unwrap_err().to_string();
    assert!(fault.starts_with("the checksum of its tRNS chunk is wrong; it is damaged"), "{fault}");
}
