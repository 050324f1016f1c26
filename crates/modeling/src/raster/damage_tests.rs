//! Damaged rasters, some thousands: refused, told, or read as they were where there are checksums.

use std::ops::Range;
use std::path::Path;

use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use tiff::encoder::colortype::{Gray16, RGB8};
use tiff::encoder::{Compression, DeflateLevel, Predictor, TiffEncoder};

use crate::raster::{ElevationRaster, ImageryRaster, OpenOptions, Window, open};
use hedgehop_base::error::Result;
use hedgehop_testing::{Count, Damage};

const WIDTH: u32 = 48;
const HEIGHT: u32 = 40;

/// What a raster is taken for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Use {
    Elevation,
    Imagery,
}

/// Size and samples as bits, and the notes on them.
type Found = ((u32, u32), Vec<u64>, Vec<String>);

fn found(path: &Path, taken: Use) -> Result<Found> {
    let raster = open(path, &OpenOptions { cache_bytes: 16 << 20, ..OpenOptions::default() })?;
    let mut notes = raster.info().notes.clone();
    let (width, height) = (raster.info().width, raster.info().height);
    let window = Window { x: 0, y: 0, width: width.min(4 * WIDTH), height: height.min(4 * HEIGHT) };

    let samples = match taken {
        Use::Elevation => {
            let (raster, mut heights) = (ElevationRaster::new(raster, &[], 1.0)?, Vec::new());
            raster.read(window, &mut heights)?;
            notes.extend(raster.notes());
            heights.iter().map(|height| height.to_bits()).collect()
        }
        Use::Imagery => {
            let (raster, mut pixels) = (ImageryRaster::new(raster, None)?, Vec::new());
            raster.read(window, &mut pixels)?;
            notes.extend(raster.notes().iter().cloned());
            pixels.iter().map(|pixel| u64::from(u32::from_le_bytes(*pixel))).collect()
        }
    };

    Ok(((width, height), samples, notes))
}

/// Hills with some noise on them.
fn heights() -> Vec<u16> {
    let height = |x: u32, y: u32| 400 + x * y % 97 + (x * 31 + y * 17) % 5;
    (0..WIDTH * HEIGHT).map(|i| height(i % WIDTH, i / WIDTH) as u16).collect()
}

fn colours() -> Vec<u8> {
    (0..WIDTH * HEIGHT * 3).map(|i| (i % 3 * 40 + i / 3 % WIDTH * 3 + i % 7) as u8).collect()
}

fn png(taken: Use) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, WIDTH, HEIGHT);
    let samples = match taken {
        Use::Elevation => {
            encoder.set_color(png::ColorType::Grayscale);
            encoder.set_depth(png::BitDepth::Sixteen);
            encoder.set_trns(vec![1, 0x90]);
            heights().iter().flat_map(|height| height.to_be_bytes()).collect()
        }
        Use::Imagery => {
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_trns(vec![0, 40, 0, 81, 0, 122]);
            colours()
        }
    };

    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&samples).unwrap();
    writer.finish().unwrap();

    bytes
}

fn jpeg() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = JpegEncoder::new_with_quality(&mut bytes, 85);
    encoder.encode(&colours(), WIDTH, HEIGHT, ExtendedColorType::Rgb8).unwrap();
    bytes
}

fn tiff(taken: Use, compression: Compression) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let predictor = match compression {
        Compression::Uncompressed | Compression::Packbits => Predictor::None,
        _ => Predictor::Horizontal,
    };
    let encoder = TiffEncoder::new(&mut bytes).unwrap();
    let mut encoder = encoder.with_compression(compression).with_predictor(predictor);
    match taken {
        Use::Elevation => encoder.write_image::<Gray16>(WIDTH, HEIGHT, &heights()).unwrap(),
        Use::Imagery => encoder.write_image::<RGB8>(WIDTH, HEIGHT, &colours()).unwrap(),
    }
    bytes.into_inner()
}

/// Where the encoder puts a TIFF's chunks: behind the header, before the directory.
fn chunks(tiff: &[u8]) -> Range<usize> {
    8..u32::from_le_bytes([tiff[4], tiff[5], tiff[6], tiff[7]]) as usize
}

/// Damages copies of a file, and counts what they are read as.
fn count(name: &str, taken: Use, sound: &[u8], damage: &mut dyn FnMut() -> Vec<u8>, copies: usize) -> Count {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        found(&path, taken)
    };
    let sound = read(sound).unwrap();
    let mut count = Count::default();

    for _ in 0..copies {
        let copy = read(&damage());
        if let Err(error) = &copy {
            let told = error.to_string();
            assert!(told.contains(name) && !told.contains('\n'), "{told}");
        }
        // What a note says of it is told.
        count.add(copy.ok().filter(|copy| copy.2 == sound.2 || copy.1 == sound.1), &sound);
    }

    count.print(&format!("{taken:?}").to_lowercase(), name);
    count
}

#[test]
fn damage_of_pictures_with_checksums_is_never_taken_for_samples() {
    let mut damage = Damage(3);
    for taken in [Use::Elevation, Use::Imagery] {
        let sound = png(taken);
        let found = count("a.png", taken, &sound, &mut || damage.anywhere(&sound), 400);
        assert_eq!(found.silent, 0, "{taken:?}");
        assert!(found.told > 300, "{found}");

        // Directories of TIFFs have no checksum; deflated chunks have.
        let sound = tiff(taken, Compression::Deflate(DeflateLevel::Balanced));
        let found = count("deflate.tif", taken, &sound, &mut || damage.within(&sound, chunks(&sound)), 300);
        assert_eq!(found.silent, 0, "{taken:?}");
        assert!(found.told > 200, "{found}");
    }
}

#[test]
fn damage_is_told_where_the_decoder_can_know() {
    let mut damage = Damage(7);
    let sound = jpeg();
    let found = count("a.jpg", Use::Imagery, &sound, &mut || damage.anywhere(&sound), 300);
    assert!(found.told > 200, "{found}");
    for taken in [Use::Elevation, Use::Imagery] {
        for (name, compression) in [
            ("whole.tif", Compression::Deflate(DeflateLevel::Balanced)),
            ("lzw.tif", Compression::Lzw),
            ("packbits.tif", Compression::Packbits),
            ("plain.tif", Compression::Uncompressed),
        ] {
            let sound = tiff(taken, compression);
            let found = count(name, taken, &sound, &mut || damage.anywhere(&sound), 100);
            assert!(found.told > 30, "{name}: {found}");
        }
    }
}

#[test]
fn nothing_that_is_cut_off_is_taken_for_a_whole() {
    for (name, taken, sound) in [
        ("a.png", Use::Elevation, png(Use::Elevation)),
        ("a.jpg", Use::Imagery, jpeg()),
        ("lzw.tif", Use::Elevation, tiff(Use::Elevation, Compression::Lzw)),
        ("packbits.tif", Use::Imagery, tiff(Use::Imagery, Compression::Packbits)),
        ("plain.tif", Use::Imagery, tiff(Use::Imagery, Compression::Uncompressed)),
    ] {
        let mut length = 0;
        let step = sound.len().div_ceil(60);
        let mut cut = || {
            length += step;
            sound[..length.min(sound.len()) - step].to_vec()
        };
        let found = count(name, taken, &sound, &mut cut, 60);
        assert_eq!((found.told, found.silent), (60, 0), "{name}");
    }
}
