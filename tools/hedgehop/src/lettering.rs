//! Letters on pictures: numbers, units and a few marks, from dots.

use hedgehop::frame::hud::font::{ADVANCE, HEIGHT, WIDTH, rows};
use image::{Rgb, RgbImage};

/// Width of a text whose dots are `scale` pixels wide, pixels.
pub fn width(text: &str, scale: u32) -> u32 {
    ((text.chars().count() * ADVANCE).saturating_sub(ADVANCE - WIDTH)) as u32 * scale
}

/// Height of a line, pixels.
pub fn height(scale: u32) -> u32 {
    HEIGHT as u32 * scale
}

/// Writes a text with its upper left corner at a pixel, as far as it is on the picture. Of letters that there are not, the place stays empty.
pub fn write(picture: &mut RgbImage, text: &str, [left, top]: [i64; 2], scale: u32, colour: Rgb<u8>) {
    for (place, letter) in text.chars().enumerate() {
        let rows = rows(letter);
        let dots = (0..HEIGHT).flat_map(|row| (0..WIDTH).map(move |column| (column, row)));
        for (column, row) in dots.filter(|(column, row)| rows[*row] >> (WIDTH - 1 - column) & 1 == 1) {
            for (right, down) in (0..scale).flat_map(|down| (0..scale).map(move |right| (right, down))) {
                let x = left + i64::from((place * ADVANCE + column) as u32 * scale + right);
                let y = top + i64::from(row as u32 * scale + down);
                if let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y))
                    && let Some(pixel) = picture.get_pixel_mut_checked(x, y)
                {
                    *pixel = colour;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_are_as_large_as_they_say_and_stay_on_the_picture() {
        let (white, text) = (Rgb([255; 3]), "0123456789ABNdkmx.-| ");
        let mut picture = RgbImage::new(width(text, 2), height(2));
        write(&mut picture, text, [0, 0], 2, white);
        let has_ink = |x: u32| (0..height(2)).any(|y| *picture.get_pixel(x, y) == white);
        // Of the first letter both sides have dots, and the last is a space.
        assert!(has_ink(0) && has_ink(9) && !has_ink(10) && !has_ink(width(text, 2) - 3));
        for (index, letter) in text.chars().enumerate().filter(|(_, letter)| *letter != ' ') {
            let mut own = RgbImage::new(5, 7);
            write(&mut own, &letter.to_string(), [0, 0], 1, white);
            let first = index as u32 * 12;
            assert!((first..first + 10).any(has_ink), "{letter}");
            assert!(own.pixels().any(|pixel| *pixel == white), "{letter}");
        }
        for corner in [[-3, -5], [1000, 3], [3, 1000]] {
            write(&mut picture, "88", corner, 3, white);
        }
    }
}
