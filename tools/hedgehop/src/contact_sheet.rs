//! A contact sheet: many frames small on one picture, each with its number below.

use image::imageops::{self, FilterType};
use image::{Rgb, RgbImage};

use crate::lettering;
use hedgehop::{Error, Result};

/// Pixels between pictures and around them.
const MARGIN: u32 = 8;
/// Pixels above and below a number.
const GAP: u32 = 4;
/// Width of a picture on the sheet unless told otherwise, pixels.
pub const WIDTH: u32 = 320;
/// Pixels of the largest sheet.
const MOST_PIXELS: u64 = 200_000_000;
/// Highest small picture, pixels.
const TALLEST: u64 = 4096;
const BACKGROUND: Rgb<u8> = Rgb([24, 24, 26]);
const INK: Rgb<u8> = Rgb([150, 150, 154]);

/// A picture on its way to a sheet.
#[derive(Debug, Clone)]
pub struct Entry {
    /// Text that is written below; letters that [`lettering`] has not are left out.
    pub label: String,
    pub picture: RgbImage,
}

impl Entry {
    /// A picture made small.
    pub fn new(label: impl Into<String>, picture: &RgbImage, width: u32) -> Self {
        let (from, height) = picture.dimensions();
        let small = (u64::from(height) * u64::from(width) / u64::from(from.max(1))).clamp(1, TALLEST) as u32;
        Self { label: label.into(), picture: imageops::resize(picture, width, small, FilterType::CatmullRom) }
    }
}

/// The sheet of `entries` of one `width`, with `columns` of them in a row.
///
/// # Errors
/// It would be too large.
pub fn sheet(entries: &[Entry], columns: u32, width: u32) -> Result<RgbImage> {
    let scale = if width < 200 { 1 } else { 2 };
    let tallest = entries.iter().map(|entry| entry.picture.height()).max().unwrap_or(1);
    let columns = columns.clamp(1, (entries.len() as u32).max(1));
    let rows = (entries.len() as u32).div_ceil(columns);
    let steps = [width + MARGIN, tallest + 2 * GAP + lettering::height(scale)];
    let size = [(columns, steps[0]), (rows, steps[1])]
        .map(|(count, step)| u64::from(MARGIN) + u64::from(count) * u64::from(step));
    if size[0] * size[1] > MOST_PIXELS {
        return Err(Error::Configuration(format!(
            "a sheet of {}x{} pixels is too large; give a smaller --width or --count",
            size[0], size[1]
        )));
    }

    // No side is longer than the product.
    let mut sheet = RgbImage::from_pixel(size[0] as u32, size[1] as u32, BACKGROUND);
    for (index, entry) in (0..).zip(entries) {
        let [left, top] = [(index % columns, steps[0]), (index / columns, steps[1])]
            .map(|(place, step)| i64::from(MARGIN) + i64::from(place) * i64::from(step));
        imageops::replace(&mut sheet, &entry.picture, left, top);
        let below = top + i64::from(entry.picture.height() + GAP);
        lettering::write(&mut sheet, &entry.label, [left, below], scale, INK);
    }

    Ok(sheet)
}

/// Returns the indices of `wanted` out of `count` pictures, evenly spread, first and last included.
pub fn spread(count: usize, wanted: usize) -> Vec<usize> {
    let wanted = wanted.min(count);
    match wanted {
        0 => Vec::new(),
        1 => vec![0],
        _ => (0..wanted).map(|i| i * (count - 1) / (wanted - 1)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sheet_shows_first_and_last() {
        assert_eq!(spread(100, 4), [0, 33, 66, 99]);
        assert_eq!(spread(2, 12), [0, 1]);
        assert_eq!(spread(0, 12), [0; 0]);
        assert_eq!(spread(5, 1), [0]);
    }

    #[test]
    fn a_sheet_holds_its_pictures_in_rows() {
        let entries: Vec<_> = (0..5_u8)
            .map(|shade| {
                let picture = RgbImage::from_pixel(64, 36, Rgb([shade * 40, 0, 0]));
                Entry::new(shade.to_string(), &picture, WIDTH)
            })
            .collect();
        let made = sheet(&entries, 3, WIDTH).unwrap();
        assert_eq!(made.dimensions(), (3 * 328 + 8, 2 * 202 + 8));
        assert_eq!(made.get_pixel(8 + 328 + 100, 8 + 202 + 100), &Rgb([160, 0, 0]));
        assert_eq!(made.get_pixel(3, 3), &BACKGROUND);
        // Below the first one stands its number.
        let label = (8..18).any(|x| made.get_pixel(x, 8 + 180 + 8) == &INK);
        assert!(label);
        let many = vec![entries[0].clone(); 4000];
        assert!(sheet(&many, 4, WIDTH).unwrap_err().to_string().contains("--count"));
    }
}
