//! Golden pictures as files, and differences from them.

use std::fs;
use std::path::Path;

use hedgehop::frame::Picture;

/// Codes per code that a difference is shown with.
pub const AMPLIFIED: u8 = 16;

/// Columns of grey between pictures that stand side by side.
const GAP: usize = 4;

/// Writes a PNG as small as it gets, without any text.
pub fn write(path: &Path, picture: &Picture) {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width, picture.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(png::Compression::High);
    encoder.write_header().unwrap().write_image_data(&picture.rgb).unwrap();
    fs::write(path, bytes).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}

/// How far a picture is from the expected one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// Mean absolute difference of codes.
    pub mean: f64,
    /// Share of the pixels of which a code is off by more than [`Distance::FAR`].
    pub far: f64,
    /// Column and row of the pixel whose three codes together are off by most.
    pub worst: [u32; 2],
    /// Codes by which that pixel is off.
    pub most: u8,
}

impl Distance {
    /// Codes that a pixel is far off by.
    pub const FAR: u8 = 12;

    /// Measures `found` against `expected`, of the same size.
    pub fn new(found: &Picture, expected: &Picture) -> Self {
        let off = |index: usize| found.rgb[index].abs_diff(expected.rgb[index]);
        let pixels = found.rgb.len() / 3;
        let of_pixel = |pixel: usize| (3 * pixel..3 * pixel + 3).map(off).max().unwrap_or(0);
        let sum_of =
            |pixel: usize| (3 * pixel..3 * pixel + 3).map(|index| u32::from(off(index))).sum::<u32>();
        let sum: u64 = (0..found.rgb.len()).map(|index| u64::from(off(index))).sum();
        let far = (0..pixels).filter(|pixel| of_pixel(*pixel) > Self::FAR).count();
        let worst = (0..pixels).max_by_key(|pixel| sum_of(*pixel)).unwrap_or(0);
        Self {
            mean: sum as f64 / found.rgb.len() as f64,
            far: far as f64 / pixels as f64,
            worst: [worst as u32 % found.width, worst as u32 / found.width],
            most: of_pixel(worst),
        }
    }
}

/// Puts what was expected, the difference, [`AMPLIFIED`], and what was found side by side.
pub fn side_by_side(expected: &Picture, found: &Picture) -> Picture {
    let amplified =
        found.rgb.iter().zip(&expected.rgb).map(|(a, b)| a.abs_diff(*b).saturating_mul(AMPLIFIED));
    let difference: Vec<u8> = amplified.collect();
    let row = 3 * found.width as usize;
    let mut rgb = Vec::new();
    for at in (0..found.rgb.len()).step_by(row) {
        rgb.extend_from_slice(&expected.rgb[at..at + row]);
        for part in [&difference, &found.rgb] {
            rgb.extend_from_slice(&[128; 3 * GAP]);
            rgb.extend_from_slice(&part[at..at + row]);
        }
    }
    Picture { width: 3 * found.width + 2 * GAP as u32, height: found.height, rgb }
}

/// Colour of a pixel as `#rrggbb`.
pub fn hex(picture: &Picture, [column, row]: [u32; 2]) -> String {
    let at = 3 * (row * picture.width + column) as usize;
    picture.rgb[at..at + 3].iter().fold("#".to_owned(), |hex, code| format!("{hex}{code:02x}"))
}
