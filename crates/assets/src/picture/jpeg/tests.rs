//! Sound JPEGs are read, and damage that shows in their codes is told.

use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;

use super::super::{decode, header};
use crate::picture::{Fault, Transparency};

const PROGRESSIVE: &[u8] = include_bytes!("../../../tests/data/pictures/progressive.jpg");
const RESTARTS: &[u8] = include_bytes!("../../../tests/data/pictures/restarts.jpg");
const SUBSAMPLED: &[u8] = include_bytes!("../../../tests/data/pictures/subsampled.jpg");

/// Speckles, which take many codes.
fn speckled(size: (u16, u16), kind: ExtendedColorType) -> Vec<u8> {
    let bands = if kind == ExtendedColorType::L8 { 1 } else { 3 };
    let count = usize::from(size.0) * usize::from(size.1) * bands;
    let samples: Vec<u8> = (0..count).map(|i| (i * i / 7 + i / 90 * 31) as u8).collect();
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, 80)
        .encode(&samples, size.0.into(), size.1.into(), kind)
        .unwrap();
    bytes
}

fn sound() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("progressive", PROGRESSIVE.to_vec()),
        ("restarts", RESTARTS.to_vec()),
        ("subsampled", SUBSAMPLED.to_vec()),
        ("grey", speckled((33, 50), ExtendedColorType::L8)),
        ("colours", speckled((41, 30), ExtendedColorType::Rgb8)),
    ]
}

fn read(bytes: &[u8]) -> Result<Vec<u8>, Fault> {
    decode(bytes, Transparency::Value)
}

#[test]
fn sound_ones_are_read_whole() {
    for (name, bytes) in sound() {
        let header = header(&bytes, Transparency::Value).unwrap();
        let samples = read(&bytes).unwrap_or_else(|fault| panic!("{name}: {fault}"));
        assert_eq!(Some(samples.len() as u64), header.bytes(), "{name}");
        assert_eq!(header.bands, if name == "grey" { 1 } else { 3 });
        // What stands behind a picture is none of it.
        assert_eq!(read(&[&bytes[..], b"behind it"].concat()).unwrap(), samples, "{name}");
    }
}

#[test]
fn no_part_of_one_is_taken_for_all() {
    for (name, bytes) in sound() {
        let samples = read(&bytes).unwrap();
        for length in 0..bytes.len() {
            for padded in [0, 3, 2000] {
                let mut part = bytes[..length].to_vec();
                part.resize(length + padded, 0);

                // The marker at the end may be missing.
                match read(&part) {
                    Ok(read) => {
                        let of = bytes.len();
                        assert!(
                            read == samples && length + 9 > of,
                            "{name} to {length} of {of}, {padded} zeros"
                        );
                    }
                    Err(Fault::Damaged(_)) => {}
                    Err(fault) => panic!("{name} to {length}: {fault}"),
                }
            }
        }
    }
}

#[test]
fn the_share_that_is_missing_is_told() {
    let bytes = speckled((64, 400), ExtendedColorType::L8);
    let half = &bytes[..bytes.len() / 2];
    let fault = read(half).unwrap_err().to_string();
    let share =
        fault.split_once(" % of its picture is missing").and_then(|(before, _)| before.rsplit(' ').next());
    let share: f64 = share.and_then(|share| share.parse().ok()).unwrap_or_else(|| panic!("{fault}"));
    assert!((share - 50.0).abs() < 12.0 && fault.contains("cut short"), "{fault}");

    // An end that was put behind half of the data.
    let fault = read(&[half, &[0, 0xff, 0xd9]].concat()).unwrap_err().to_string();
    assert!(fault.contains("break after") && fault.contains("too early"), "{fault}");
}

#[test]
fn no_scan_of_a_progressive_one_may_be_missing() {
    let is_marker = |pair: &[u8]| pair[0] == 0xff && matches!(pair[1], 0xc4 | 0xd9 | 0xda);
    let places: Vec<usize> =
        (0..PROGRESSIVE.len() - 1).filter(|at| is_marker(&PROGRESSIVE[*at..*at + 2])).collect();
    let mut scans = 0;
    for (index, from) in places.iter().enumerate().filter(|(_, at)| PROGRESSIVE[**at + 1] == 0xda) {
        let without = [&PROGRESSIVE[..*from], &PROGRESSIVE[places[index + 1]..]].concat();
        let is_last_of_its_band = read(&without).is_ok();
        // The chroma's only scan of a band may be left out by an encoder that finds nothing in it.
        assert!(!is_last_of_its_band, "{scans}");
        scans += 1;
    }
    assert!(scans > 5, "{scans}");
}

#[test]
fn damage_between_the_segments_is_found() {
    // The length of the second segment.
    for at in [SUBSAMPLED.len() - 2, 3, 22] {
        let mut bytes = SUBSAMPLED.to_vec();
        bytes[at] ^= 0x40;
        assert!(read(&bytes).is_err(), "{at}");
    }
    let doubled = [&RESTARTS[..2], &RESTARTS[20..]].concat();
    assert!(read(&doubled).is_ok(), "without its first segment, of an application");
}
