//! Small TIFFs, written here byte by byte.

use std::path::PathBuf;

use super::tags::tag;
use crate::raster::{ImageryRaster, OpenOptions, Raster, RasterInfo, Role, Window, open};
use hedgehop_base::error::Result;

/// A value of a tag: type code and bytes, little-endian.
enum Value {
    Short(Vec<u16>),
    Long(Vec<u32>),
    Double(Vec<f64>),
    Text(&'static str),
    /// Offset (in the file) of data that is appended.
    Data(Vec<Vec<u8>>),
}

use Value::{Data, Double, Long, Short, Text};

/// A little-endian classic TIFF of several directories.
fn tiff(directories: Vec<Vec<(u16, Value)>>) -> Vec<u8> {
    let mut bytes = b"II\x2a\0\x08\0\0\0".to_vec();
    let count = directories.len();
    for (number, mut entries) in directories.into_iter().enumerate() {
        entries.sort_by_key(|entry| entry.0);
        let mut directory = (entries.len() as u16).to_le_bytes().to_vec();
        let end = bytes.len() + 2 + entries.len() * 12 + 4;
        let mut data = Vec::new();

        for (tag, value) in entries {
            let (kind, number, value) = match value {
                Short(values) => (3u16, values.len(), values.iter().flat_map(|v| v.to_le_bytes()).collect()),
                Long(values) => (4, values.len(), values.iter().flat_map(|v| v.to_le_bytes()).collect()),
                Double(values) => (12, values.len(), values.iter().flat_map(|v| v.to_le_bytes()).collect()),
                Text(text) => (2, text.len() + 1, [text.as_bytes(), b"\0"].concat()),
                Data(chunks) => {
                    let mut offsets = Vec::new();
                    for chunk in &chunks {
                        let offset = if chunk.is_empty() { 0 } else { (end + data.len()) as u32 };
                        offsets.extend(offset.to_le_bytes());
                        data.extend(chunk);
                    }
                    (4, chunks.len(), offsets)
                }
            };

            directory.extend(tag.to_le_bytes());
            directory.extend(kind.to_le_bytes());
            directory.extend((number as u32).to_le_bytes());
            if value.len() <= 4 {
                directory.extend(value.iter().chain(&[0; 4]).take(4));
            } else {
                directory.extend(((end + data.len()) as u32).to_le_bytes());
                data.extend(value);
            }
        }

        let next = if number + 1 < count { (end + data.len()) as u32 } else { 0 };
        directory.extend(next.to_le_bytes());
        bytes.extend(directory);
        bytes.extend(data);
    }

    bytes
}

/// A zlib stream of one stored block (RFC 1950, RFC 1951).
fn stored_deflate(bytes: &[u8]) -> Vec<u8> {
    let length = bytes.len() as u16;
    let mut stream = vec![0x78, 0x01, 0x01];
    stream.extend(length.to_le_bytes());
    stream.extend((!length).to_le_bytes());
    stream.extend(bytes);
    let (a, b) = bytes.iter().fold((1u32, 0u32), |(a, b), byte| {
        let a = (a + u32::from(*byte)) % 65_521;
        (a, (b + a) % 65_521)
    });
    stream.extend((b << 16 | a).to_be_bytes());
    stream
}

/// Strips of bytes, deflated or not.
fn image(size: (u32, u32), bands: u16, rows: u32, strips: Vec<Vec<u8>>) -> Vec<(u16, Value)> {
    vec![
        (tag::IMAGE_WIDTH, Long(vec![size.0])),
        (tag::IMAGE_LENGTH, Long(vec![size.1])),
        (tag::BITS_PER_SAMPLE, Short(vec![8; usize::from(bands)])),
        (tag::PHOTOMETRIC, Short(vec![1])),
        (tag::SAMPLES_PER_PIXEL, Short(vec![bands])),
        (tag::ROWS_PER_STRIP, Long(vec![rows])),
        (tag::STRIP_BYTE_COUNTS, Long(strips.iter().map(|strip| strip.len() as u32).collect())),
        (tag::STRIP_OFFSETS, Data(strips)),
    ]
}

fn set(entries: &mut Vec<(u16, Value)>, tag: u16, value: Value) {
    entries.retain(|entry| entry.0 != tag);
    entries.push((tag, value));
}

struct Written {
    _folder: tempfile::TempDir,
    path: PathBuf,
}

fn write(bytes: &[u8]) -> Written {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    std::fs::write(&path, bytes).unwrap();
    Written { _folder: folder, path }
}

fn read(bytes: &[u8], cache_bytes: u64) -> Result<(RasterInfo, Vec<f64>)> {
    let file = write(bytes);
    let raster = open(&file.path, &OpenOptions { cache_bytes, raw: None, classes: false })?;
    let info = raster.info().clone();
    let bands: Vec<u32> = (0..info.bands).collect();
    let mut samples = Vec::new();
    raster.read(Window { x: 0, y: 0, width: info.width, height: info.height }, &bands, &mut samples)?;
    Ok((info, samples))
}

#[test]
fn five_rgb_bands_with_predictor_stay_as_stored() {
    // Differences to the pixel before; two pixels.
    let mut entries = image((2, 1), 5, 1, vec![stored_deflate(&[1, 2, 3, 4, 5, 10, 10, 10, 10, 10])]);
    set(&mut entries, tag::COMPRESSION, Short(vec![8]));
    set(&mut entries, tag::PREDICTOR, Short(vec![2]));
    set(&mut entries, tag::PHOTOMETRIC, Short(vec![2]));
    set(&mut entries, tag::EXTRA_SAMPLES, Short(vec![0, 2]));
    let (info, samples) = read(&tiff(vec![entries]), 1 << 20).unwrap();
    assert_eq!(samples, [1.0, 2.0, 3.0, 4.0, 5.0, 11.0, 12.0, 13.0, 14.0, 15.0]);
    assert_eq!(info.alpha_band, Some(4));
}

/// Greys with a colour table: colours where they are a picture, values where they are not.
#[test]
fn a_colour_table_is_told() {
    let mut entries = image((2, 1), 1, 1, vec![vec![7, 8]]);
    set(&mut entries, tag::COLOR_MAP, Short(vec![0; 768]));
    let (info, samples) = read(&tiff(vec![entries]), 1 << 20).unwrap();
    assert_eq!((samples, info.described[0].role), (vec![7.0, 8.0], Role::Palette));
}

#[test]
fn white_is_zero_is_told_not_inverted() {
    for compression in [1, 8] {
        let strip = if compression == 1 { vec![7, 8] } else { stored_deflate(&[7, 8]) };
        let mut entries = image((2, 1), 1, 1, vec![strip]);
        set(&mut entries, tag::COMPRESSION, Short(vec![compression]));
        set(&mut entries, tag::PHOTOMETRIC, Short(vec![0]));
        let (info, samples) = read(&tiff(vec![entries]), 1 << 20).unwrap();
        assert_eq!(samples, [7.0, 8.0]);
        assert!(info.white_is_zero);
    }
}

#[test]
fn damage_to_samples_is_found_by_their_checksum() {
    let sound = stored_deflate(&[7, 8, 9, 10]);
    for byte in [7, 8, 10, 11, 14] {
        let mut strip = sound.clone();
        strip[byte] ^= 4;
        let mut entries = image((4, 1), 1, 1, vec![strip]);
        set(&mut entries, tag::COMPRESSION, Short(vec![8]));
        let error = read(&tiff(vec![entries]), 1 << 20).unwrap_err().to_string();
        assert!(error.contains("damaged, fetch it again"), "{byte}: {error}");
    }
}

#[test]
fn absent_strips_are_nodata() {
    let mut entries = image((2, 2), 1, 1, vec![vec![5, 6], vec![]]);
    set(&mut entries, tag::GDAL_NODATA, Text("9"));
    let (_, samples) = read(&tiff(vec![entries]), 1 << 20).unwrap();
    assert_eq!(samples, [5.0, 6.0, 9.0, 9.0]);
}

#[test]
fn place_by_scale_matrix_and_points() {
    let plain = || image((2, 2), 1, 2, vec![vec![1, 2, 3, 4]]);
    let geo = |entries| read(&tiff(vec![entries]), 1 << 20).unwrap().0.geo;
    assert_eq!(geo(plain()), None);

    let mut scale = plain();
    set(&mut scale, tag::MODEL_PIXEL_SCALE, Double(vec![2.0, 4.0, 0.0]));
    set(&mut scale, tag::MODEL_TIEPOINT, Double(vec![1.0, 1.0, 0.0, 102.0, 496.0, 0.0]));
    assert_eq!(geo(scale), Some([100.0, 2.0, 0.0, 500.0, 0.0, -4.0]));

    let mut matrix = plain();
    let m = vec![0.0, 2.0, 0.0, 100.0, 4.0, 0.0, 0.0, 500.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    set(&mut matrix, tag::MODEL_TRANSFORMATION, Double(m));
    assert_eq!(geo(matrix), Some([100.0, 0.0, 2.0, 500.0, 4.0, 0.0]));

    let mut points = plain();
    set(&mut points, tag::MODEL_PIXEL_SCALE, Double(vec![2.0, 4.0, 0.0]));
    set(&mut points, tag::MODEL_TIEPOINT, Double(vec![0.0, 0.0, 0.0, 100.0, 500.0, 0.0]));
    set(&mut points, tag::GEO_KEY_DIRECTORY, Short(vec![1, 1, 0, 1, 1025, 0, 1, 2]));
    assert_eq!(geo(points), Some([99.0, 2.0, 0.0, 502.0, 0.0, -4.0]));

    let mut nowhere = plain();
    set(&mut nowhere, tag::MODEL_PIXEL_SCALE, Double(vec![f64::NAN, 4.0, 0.0]));
    set(&mut nowhere, tag::MODEL_TIEPOINT, Double(vec![0.0, 0.0, 0.0, 100.0, 500.0, 0.0]));
    assert!(read(&tiff(vec![nowhere]), 1 << 20).is_err());
}

#[test]
fn a_mask_becomes_alpha() {
    // Ten pixels across take two bytes of bits; the third and the last are opaque.
    let colours = image((10, 1), 3, 1, vec![(0..30).collect()]);
    let mut mask = image((10, 1), 1, 1, vec![vec![0b0010_0000, 0b0100_0000]]);
    set(&mut mask, tag::BITS_PER_SAMPLE, Short(vec![1]));
    set(&mut mask, tag::PHOTOMETRIC, Short(vec![4]));
    set(&mut mask, tag::NEW_SUBFILE_TYPE, Long(vec![4]));
    let file = write(&tiff(vec![colours, mask]));
    let raster = open(&file.path, &OpenOptions::default()).unwrap();
    assert_eq!((raster.info().bands, raster.info().alpha_band), (4, Some(3)));
    let imagery = ImageryRaster::new(raster, None).unwrap();
    let mut pixels = Vec::new();
    imagery.read(Window { x: 1, y: 0, width: 9, height: 1 }, &mut pixels).unwrap();
    let opaque: Vec<_> = pixels.iter().map(|pixel| pixel[3] == 255).collect();
    assert_eq!(opaque, [false, true, false, false, false, false, false, false, true]);
    assert_eq!(pixels[1], [6, 7, 8, 255]);
}

#[test]
fn strips_beyond_the_cache() {
    let strip = vec![3u8; 60_000];
    // Uncompressed: read from where it lies, whatever its size.
    let (_, samples) = read(&tiff(vec![image((200, 300), 1, 300, vec![strip.clone()])]), 1000).unwrap();
    assert_eq!(samples, vec![3.0; 60_000]);
    let mut entries = image((200, 300), 1, 300, vec![stored_deflate(&strip)]);
    set(&mut entries, tag::COMPRESSION, Short(vec![8]));
    let error = read(&tiff(vec![entries]), 1000).unwrap_err().to_string();
    assert!(error.contains("--memory") && error.contains("TILED=YES"), "{error}");
}

#[test]
fn refusals_name_the_command() {
    let cases = [
        (tag::COMPRESSION, 7, "JPEG", "COMPRESS=DEFLATE"),
        (tag::COMPRESSION, 34887, "LERC", "COMPRESS=DEFLATE"),
        (tag::COMPRESSION, 50001, "WebP", "COMPRESS=DEFLATE"),
        (tag::COMPRESSION, 50002, "JPEG XL", "COMPRESS=DEFLATE"),
        (tag::PHOTOMETRIC, 3, "palette", "-expand rgb"),
        (tag::PHOTOMETRIC, 6, "YCbCr", "COMPRESS=DEFLATE"),
        (tag::BITS_PER_SAMPLE, 4, "4 bits", "gdal_translate"),
        (tag::SAMPLE_FORMAT, 6, "complex", "gdal_translate"),
        (tag::FILL_ORDER, 2, "reverse", "gdal_translate"),
    ];
    for (tag, value, what, command) in cases {
        let mut entries = image((2, 2), 1, 2, vec![vec![1, 2, 3, 4]]);
        set(&mut entries, tag, Short(vec![value]));
        let error = read(&tiff(vec![entries]), 1 << 20).unwrap_err().to_string();
        assert!(error.contains(what) && error.contains(command), "{error}");
    }
}

#[test]
fn threads_read_the_same() {
    let strips = (0..64u8).map(|row| stored_deflate(&[row; 100])).collect();
    let mut entries = image((100, 64), 1, 1, strips);
    set(&mut entries, tag::COMPRESSION, Short(vec![8]));
    let file = write(&tiff(vec![entries]));
    let raster: Box<dyn Raster> =
        open(&file.path, &OpenOptions { cache_bytes: 2048, raw: None, classes: false }).unwrap();

    std::thread::scope(|scope| {
        for thread in 0..4u32 {
            let raster = &raster;
            scope.spawn(move || {
                let mut samples = Vec::new();
                for step in 0..200u32 {
                    let y = (step * 7 + thread * 13) % 60;
                    raster.read(Window { x: 3, y, width: 90, height: 4 }, &[0], &mut samples).unwrap();
                    for (i, sample) in samples.iter().enumerate() {
                        assert_eq!(*sample, f64::from(y) + (i / 90) as f64);
                    }
                }
            });
        }
    });
}

/// 16-bit grey that grows eastward and southward: in strips, or in tiles if blocks are narrower than it is.
fn slope(size: (u32, u32), block: (u32, u32), is_deflated: bool) -> Vec<u8> {
    let is_tiled = block.0 < size.0;
    let chunk = |column: u32, row: u32| {
        // The last strip ends with the picture, tiles are whole.
        let end = if is_tiled { (row + 1) * block.1 } else { size.1.min((row + 1) * block.1) };
        let places = (row * block.1..end).flat_map(|y| (0..block.0).map(move |x| (column * block.0 + x, y)));
        let bytes: Vec<u8> = places.flat_map(|(x, y)| ((17 * x + 31 * y) as u16).to_le_bytes()).collect();
        if is_deflated { stored_deflate(&bytes) } else { bytes }
    };

    let (columns, rows) = (size.0.div_ceil(block.0), size.1.div_ceil(block.1));
    let places = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let chunks: Vec<Vec<u8>> = places.map(|(column, row)| chunk(column, row)).collect();
    let mut entries = image(size, 1, block.1, chunks);

    if is_tiled {
        for entry in &mut entries {
            entry.0 = match entry.0 {
                tag::STRIP_OFFSETS => tag::TILE_OFFSETS,
                tag::STRIP_BYTE_COUNTS => tag::TILE_BYTE_COUNTS,
                other => other,
            };
        }
        entries.retain(|entry| entry.0 != tag::ROWS_PER_STRIP);
        set(&mut entries, tag::TILE_WIDTH, Long(vec![block.0]));
        set(&mut entries, tag::TILE_LENGTH, Long(vec![block.1]));
    }

    set(&mut entries, tag::BITS_PER_SAMPLE, Short(vec![16]));
    set(&mut entries, tag::COMPRESSION, Short(vec![if is_deflated { 8 } else { 1 }]));
    tiff(vec![entries])
}

#[test]
fn strips_and_tiles_are_stretched_alike() {
    let size = (700, 900);
    let colours = |block: (u32, u32), is_deflated| {
        let file = write(&slope(size, block, is_deflated));
        let imagery = ImageryRaster::new(open(&file.path, &OpenOptions::default()).unwrap(), None).unwrap();
        let mut pixels = Vec::new();
        imagery.read(Window { x: 0, y: 0, width: size.0, height: size.1 }, &mut pixels).unwrap();
        let note = imagery.notes()[0].replace(&file.path.display().to_string(), "");
        (note, pixels)
    };

    let (note, pixels) = colours((700, 64), false);
    assert!(note.contains("stretched"), "{note}");

    // About 2 of 100 pixels are black, and 2 white.
    let share =
        |byte: u8| pixels.iter().filter(|pixel| pixel[0] == byte).count() as f64 / pixels.len() as f64;
    assert!([0, 255].into_iter().all(|byte| (0.001..0.05).contains(&share(byte))), "{note}");

    for (block, is_deflated) in
        [((700, 1), false), ((700, 900), false), ((700, 10), true), ((128, 64), false), ((256, 48), true)]
    {
        let (told, others) = colours(block, is_deflated);
        assert_eq!(told, note, "{block:?}");
        assert!(others == pixels, "{block:?}");
    }
}
