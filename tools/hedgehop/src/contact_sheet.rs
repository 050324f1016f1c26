//! A contact sheet: many frames small on one picture.

use std::path::{Path, PathBuf};

use hedgehop::{Error, Result};
use image::imageops::{self, FilterType};
use image::{ImageFormat, Rgb, RgbImage};

/// Pixels between pictures and around them.
const MARGIN: u32 = 8;
/// Width of a picture on the sheet, pixels.
const WIDTH: u32 = 320;
const BACKGROUND: Rgb<u8> = Rgb([24, 24, 26]);

/// The PNG of a sheet with `columns` pictures in a row, in the order of `frames` (at least one, all of one size).
pub fn png(frames: &[PathBuf], columns: u32) -> Result<Vec<u8>> {
    let pictures = frames.iter().map(|frame| thumbnail(frame)).collect::<Result<Vec<_>>>()?;
    let (width, height) = pictures.first().map_or((WIDTH, 1), RgbImage::dimensions);
    let columns = columns.clamp(1, (pictures.len() as u32).max(1));
    let rows = (pictures.len() as u32).div_ceil(columns);
    let (step_x, step_y) = (width + MARGIN, height + MARGIN);
    let mut sheet = RgbImage::from_pixel(MARGIN + columns * step_x, MARGIN + rows * step_y, BACKGROUND);
    for (index, picture) in (0..).zip(&pictures) {
        let (column, row) = (index % columns, index / columns);
        imageops::replace(
            &mut sheet,
            picture,
            i64::from(MARGIN + column * step_x),
            i64::from(MARGIN + row * step_y),
        );
    }
    let mut bytes = std::io::Cursor::new(Vec::new());
    sheet
        .write_to(&mut bytes, ImageFormat::Png)
        .map_err(|error| Error::Configuration(format!("cannot encode the contact sheet: {error}")))?;
    Ok(bytes.into_inner())
}

fn thumbnail(frame: &Path) -> Result<RgbImage> {
    let picture = image::open(frame)
        .map_err(|error| Error::invalid(frame, format!("{error}; render it again")))?
        .into_rgb8();
    let (width, height) = picture.dimensions();
    let small = (u64::from(height) * u64::from(WIDTH) / u64::from(width.max(1))).clamp(1, 4096) as u32;
    Ok(imageops::resize(&picture, WIDTH, small, FilterType::CatmullRom))
}

/// Indices of `wanted` out of `count` things, evenly spread, first and last included.
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
        let folder = tempfile::tempdir().unwrap();
        let frames: Vec<PathBuf> = (0..5_u8)
            .map(|shade| {
                let path = folder.path().join(format!("{shade}.png"));
                RgbImage::from_pixel(64, 36, Rgb([shade * 40, 0, 0])).save(&path).unwrap();
                path
            })
            .collect();
        let sheet = image::load_from_memory(&png(&frames, 3).unwrap()).unwrap().into_rgb8();
        assert_eq!(sheet.dimensions(), (3 * 328 + 8, 2 * 188 + 8));
        assert_eq!(sheet.get_pixel(8 + 328 + 100, 8 + 188 + 100), &Rgb([160, 0, 0]));
        assert_eq!(sheet.get_pixel(3, 3), &BACKGROUND);
    }
}
